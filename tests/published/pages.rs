//! Do the pages of `docs/` show what the raw lines in `docs/data` hold, and do these keep what is promised?

use std::collections::BTreeMap;

use dcb_tests::hard::dynamics::weak_form_map::{FULL, cells, measure};
use dcb_tests::pages::{
    accuracy, campbell, damping, error_estimate, exchange, fuzzing, hard_cases, html_pages,
    large_file, machine, motion, python, random_response, read_matrices, scene_driven,
    scene_reduction, speed_against_error, stability, stress,
};
use serde_json::Value;

/// One test for each part of a page, and for the pictures that belong to it.
macro_rules! tests {
    ($($test:ident: $page:path, $assertion:ident;)+) => {
        $(
            #[test]
            fn $test() {
                $page.$assertion();
            }
        )+
    };
}

tests! {
    accuracy_is_shown: accuracy::PAGE, assert_shown;
    motion_is_shown: motion::PAGE, assert_shown;
    motion_is_drawn: motion::PAGE, assert_drawn;
    hard_cases_are_shown: hard_cases::PAGE, assert_shown;
    stability_is_shown: stability::PAGE, assert_shown;
    stability_is_drawn: stability::PAGE, assert_drawn;
    stability_rules_are_shown: stability::RULES, assert_shown;
    error_estimate_is_shown: error_estimate::PAGE, assert_shown;
    speed_against_error_is_shown: speed_against_error::PAGE, assert_shown;
    speed_against_error_is_drawn: speed_against_error::PAGE, assert_drawn;
    scene_driven_is_shown: scene_driven::PAGE, assert_shown;
    scene_reduction_is_shown: scene_reduction::PAGE, assert_shown;
    large_file_is_shown: large_file::PAGE, assert_shown;
    formats_read_are_shown: exchange::READ, assert_shown;
    formats_written_are_shown: exchange::WRITTEN, assert_shown;
    reading_speed_is_shown: read_matrices::PAGE, assert_shown;
    cost_of_python_is_shown: python::COST, assert_shown;
    loops_in_python_are_shown: python::LOOP, assert_shown;
    fuzzing_is_shown: fuzzing::PAGE, assert_shown;
    html_pages_are_shown: html_pages::PAGE, assert_shown;
    machine_is_shown: machine::ASSEMBLY, assert_shown;
    responses_of_the_machine_are_shown: machine::RESPONSES, assert_shown;
    stress_is_shown: stress::PAGE, assert_shown;
    whirl_is_shown: campbell::PAGE, assert_shown;
    damping_is_shown: damping::PAGE, assert_shown;
    random_responses_are_shown: random_response::PAGE, assert_shown;
}

#[test]
fn python_costs_what_is_promised() {
    let lines = python::COST.lines();
    let most = |kind: &str, of: &dyn Fn(&Value) -> f64| {
        let own = lines.iter().filter(|line| line["kind"] == kind);
        own.map(of).fold(0.0, f64::max)
    };
    let number = |value: &Value| value.as_f64().unwrap();
    let added =
        |line: &Value| number(&line["nanoseconds_by_calls"]) - number(&line["nanoseconds_inside"]);
    let memory =
        |line: &Value| number(&line["package"]["memory"]) / number(&line["program"]["memory"]);
    assert!(lines.len() >= 6);
    assert!(most("step", &added) < 1000.0);
    assert!(most("reduction", &memory) < 1.1);
}

/// 5 MB, 30 pictures a second, nothing that axe finds.
#[test]
fn html_pages_keep_what_is_promised() {
    let lines = html_pages::PAGE.lines();
    assert!(lines.iter().any(|line| line["page"] == "large.html"));
    for line in &lines {
        assert!(line["bytes"].as_f64().unwrap() < 5e6, "{line}");
        assert!(line["fps"].as_f64().unwrap() >= 30.0, "{line}");
        for findings in ["violations", "errors", "failed"] {
            assert_eq!(line[findings].as_array().unwrap().len(), 0, "{line}");
        }
    }
}

#[test]
fn accuracy_is_within_its_bounds() {
    assert!(accuracy::PAGE.rendered().lines().count() < 100);
    let lines = accuracy::PAGE.lines();
    assert_eq!(lines[0]["kind"], "machine");
    for line in lines {
        if let Some(bound) = line["bound"].as_f64() {
            // NaN is written as null.
            let error = line["relative_error"].as_f64();
            assert!(error.is_some_and(|error| error <= bound), "{line}");
        }
        assert!(
            line["equal"] != false && line["identical"] != false,
            "{line}"
        );
    }
}

#[test]
fn motion_is_within_its_bounds() {
    let lines = motion::PAGE.lines();
    assert_eq!(lines[0]["kind"], "machine");
    for line in lines {
        for prefix in ["", "classical_", "slider_", "static_"] {
            if let Some(bound) = line[format!("{prefix}bound")].as_f64() {
                // NaN is written as null.
                let error = line[format!("{prefix}error")].as_f64();
                assert!(error.is_some_and(|error| error <= bound), "{line}");
            }
        }
    }
}

#[test]
fn hard_cases_are_within_their_bounds() {
    let lines = hard_cases::PAGE.lines();
    assert_eq!(lines[0]["kind"], "machine");
    assert!(lines.len() > 20);
    for line in &lines[1..] {
        match line["bound"].as_f64() {
            // NaN is written as null.
            Some(bound) => {
                let error = line["error"].as_f64();
                assert!(error.is_some_and(|error| error <= bound), "{line}");
            }
            None => {
                let ours = line["ours"].as_str().unwrap();
                assert!(ours.contains("refused") || ours.contains("told"), "{line}");
            }
        }
    }
}

#[test]
fn formats_are_read_and_written_to_their_digits() {
    let lines = exchange::READ.lines();
    let of = |kind: &str| lines.iter().filter(|line| line["kind"] == kind).count();
    assert_eq!((of("matrix"), of("real"), of("mesh")), (20, 6, 7));
    for line in &lines {
        let number = |key: &str| line[key].as_f64().unwrap_or(f64::INFINITY);
        let is_punched = line["format"] == "Nastran DMIG, large fields";
        match line["kind"].as_str().unwrap() {
            "matrix" if is_punched => assert!(number("stiffness_error") < 1e-10, "{line}"),
            "matrix" => {
                assert_eq!(
                    (number("stiffness_error"), number("mass_error")),
                    (0.0, 0.0),
                    "{line}"
                );
            }
            "real" => assert!(number("frequency_error") < 1e-7, "{line}"),
            "mesh" => assert!(number("point_error") < 1e-12, "{line}"),
            "export" => assert!(number("error") < 1e-6, "{line}"),
            "client" => assert!(line["held"] != false, "{line}"),
            _ => {}
        }
    }
}

#[test]
fn readers_were_fuzzed_without_a_finding() {
    let lines = fuzzing::PAGE.lines();
    let mut inputs: BTreeMap<&str, f64> = BTreeMap::new();
    for line in &lines {
        *inputs.entry(line["target"].as_str().unwrap()).or_default() +=
            line["inputs"].as_f64().unwrap();
        assert!(line["slowest_s"].as_f64().unwrap() < 20.0, "{line}");
        assert!(line["peak_mb"].as_f64().unwrap() < 1000.0, "{line}");
    }
    for binary in ["matlab5", "matlab73", "numpy", "op4_binary", "petsc"] {
        assert!(inputs[binary] >= 1e6, "{binary}");
    }
    for reader in [
        "coordinate",
        "dmig",
        "dof_table",
        "harwell_boeing",
        "matrix_input",
        "mesh_abaqus",
        "mesh_gmsh",
        "mesh_nastran",
        "mesh_universal",
        "mesh_vtu",
        "op4_text",
        "substructure",
    ] {
        assert!(inputs[reader] >= 1e7, "{reader}");
    }
}

#[test]
fn stability_criterion_holds_in_every_cell() {
    let raw = stability::PAGE.raw();
    assert!(raw.lines().next().unwrap().contains("\"machine\""));
    let cells = cells(&raw);
    assert_eq!(
        cells.len(),
        FULL.steps.len() * FULL.radii.len() * FULL.modes.len()
    );
    for cell in cells {
        assert!(!cell.contradicts(), "{cell:?}");
    }
}

/// `cargo test --release -p dcb-tests --test published pages::stability -- --ignored`
#[test]
#[ignore = "364 runs of up to 20000 steps"]
fn stability_map_comes_out_again() {
    for (now, then) in measure(&FULL).iter().zip(cells(&stability::PAGE.raw())) {
        assert_eq!(
            (now.steps, now.radius, now.modes),
            (then.steps, then.radius, then.modes)
        );
        assert_eq!(now.is_stable(), then.is_stable(), "{now:?}, {then:?}");
    }
}

#[test]
fn scene_reduction_has_true_errors_below_bounds_and_these_below_tolerances() {
    for line in scene_reduction::PAGE.lines() {
        let [error, bound, tolerance] =
            ["true_error", "bound", "tolerance"].map(|key| line[key].as_f64().unwrap());
        assert!(error <= bound && bound <= tolerance, "{line}");
    }
}

/// Scenes that were measured, each prepared in six ways.
const SCENES: usize = 3;

#[test]
fn scene_driven_at_a_thousandth_is_three_times_as_fast_as_with_modes_counted_by_hand() {
    let lines = scene_driven::PAGE.lines();
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

#[test]
fn scene_driven_is_no_further_off_than_its_tolerance() {
    let lines = scene_driven::PAGE.lines();
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

#[test]
fn large_file_costs_a_scene_of_two_interfaces_no_more_than_a_small_one() {
    let lines = large_file::PAGE.lines();
    let number = |file: &str, key: &str| {
        let is_wanted = |line: &&Value| {
            line["scene"] == "two interfaces" && line["file"] == file && line["cache"] == "warm"
        };
        lines.iter().find(is_wanted).unwrap()[key].as_f64().unwrap()
    };
    assert!(number("large", "file_bytes") > 2e9);
    let more = number("large", "bytes_read") - number("small", "bytes_read");
    assert!(more < 1e5, "{more} bytes more than of the small file");
    let more = number("large", "seconds") - number("small", "seconds");
    assert!(more < 0.01, "{more} s more than with the small file");
}
