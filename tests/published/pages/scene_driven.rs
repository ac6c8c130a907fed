//! Does `docs/scene-driven.md` show what `docs/data/scene_driven.jsonl` and `scene_reduction.jsonl` hold, and do they keep what is promised?

use std::collections::BTreeMap;

use dcb_tests::pages::{scene_driven, scene_reduction};
use dcb_tests::raw_lines::raw_lines;

fn docs(file: &str) -> String {
    std::fs::read_to_string(format!("{}/../docs/{file}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn assert_shows(markers: [&str; 2], expected: &str) {
    let page = docs("scene-driven.md");
    let (_, rest) = page.split_once(markers[0]).expect("the first marker");
    let (generated, _) = rest.split_once(markers[1]).expect("the second marker");
    assert!(
        generated == expected,
        "paste what `--example scene_driven` prints:\n{expected}"
    );
}

#[test]
fn the_page_is_what_the_raw_lines_render_to() {
    use scene_driven::{MARKERS, render};
    assert_shows(MARKERS, &render(&docs("data/scene_driven.jsonl")));
}

#[test]
fn bounds_and_true_errors_are_what_their_lines_render_to() {
    use scene_reduction::{MARKERS, render};
    assert_shows(MARKERS, &render(&docs("data/scene_reduction.jsonl")));
}

#[test]
fn true_errors_are_below_bounds_and_these_below_tolerances() {
    for line in raw_lines(&docs("data/scene_reduction.jsonl")) {
        let [error, bound, tolerance] =
            ["true_error", "bound", "tolerance"].map(|key| line[key].as_f64().unwrap());
        assert!(error <= bound && bound <= tolerance, "{line}");
    }
}

#[test]
fn at_a_thousandth_prepared_scenes_are_three_times_as_fast_as_with_modes_counted_by_hand() {
    let lines = raw_lines(&docs("data/scene_driven.jsonl"));
    let rows = scene_driven::rows(&lines);
    let adapted = rows.iter().filter(|row| {
        row.tolerance() == Some(1e-3) && row.prepared["row"] == "scene-driven, adapted"
    });
    let mut count = 0;
    for row in adapted {
        let by_hand = rows.iter().find(|other| {
            other.prepared["scene"] == row.prepared["scene"] && other.prepared["row"] == "20 modes"
        });
        let gain = by_hand.unwrap().seconds_per_second() / row.seconds_per_second();
        assert!(gain >= 3.0, "{}: {gain}", row.prepared["scene"]);
        count += 1;
    }
    assert_eq!(count, SCENES);
}

/// Scenes that were measured, each prepared in six ways.
const SCENES: usize = 3;

#[test]
fn no_prepared_scene_is_further_off_than_its_tolerance() {
    let lines = raw_lines(&docs("data/scene_driven.jsonl"));
    let rows = scene_driven::rows(&lines);
    let prepared = rows.iter().filter_map(|row| Some((row, row.tolerance()?)));
    let mut scenes = BTreeMap::new();
    for (row, tolerance) in prepared {
        assert!(
            row.error() <= tolerance,
            "{}: {:e}",
            row.prepared,
            row.error()
        );
        *scenes
            .entry(row.prepared["scene"].as_str().unwrap())
            .or_insert(0) += 1;
    }
    assert!(
        scenes.len() >= SCENES && scenes.values().all(|count| *count == 6),
        "{scenes:?}"
    );
}
