//! Does `docs/scene-driven.md` show what `docs/data/scene_driven.jsonl` holds, and does that keep what is promised?
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use dcb_tests::scene_driven_page::{MARKERS, render};
use serde_json::Value;

fn docs(file: &str) -> String {
    std::fs::read_to_string(format!("{}/../docs/{file}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

#[test]
fn the_page_is_what_the_raw_lines_render_to() {
    let page = docs("scene-driven.md");
    let (_, rest) = page.split_once(MARKERS[0]).expect("the first marker");
    let (generated, _) = rest.split_once(MARKERS[1]).expect("the second marker");
    assert!(
        generated == render(&docs("data/scene_driven.jsonl")),
        "paste what `--example scene_driven` prints"
    );
}

#[test]
fn no_prepared_scene_is_further_off_than_its_tolerance() {
    let mut count = 0;
    for line in docs("data/scene_driven.jsonl").lines() {
        let line: Value = serde_json::from_str(line).unwrap();
        if let Some(tolerance) = line["tolerance"].as_f64() {
            let error = line["error"].as_f64().unwrap();
            assert!(error <= tolerance, "{line}");
            count += 1;
        }
    }
    assert!(count >= 6, "{count} rows");
}
