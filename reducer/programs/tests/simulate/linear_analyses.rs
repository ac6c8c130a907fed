//! Frequency responses, rests of free mechanisms and vibrations about a rest, from the command line.

use dcb_formats::dcb::read_superelement;
use dcb_formats::results::Results;

use dcb_samples::{SpatialBeam, spatial_beam};
use dcb_tests::lowest;

use crate::support::Folder;

/// A beam on two bushings; a force pulls at one of them.
const MOUNTED: &str = r#"{
  "dimension": 3, "units": {"length": "m", "mass": "kg", "time": "s"},
  "ground": {"points": {"left": [0, 0, 0], "right": [1, 0, 0]}},
  "bodies": {"beam": {"superelement": "beam.dcb.h5", "damping": {"modal": 0.01}}},
  "springs": {
    "left": {"bushing": {"a": "ground/left", "b": "beam/a", "translation": [1e5, 2e5, 3e5], "translation_damping": [60, 60, 60], "rotation": [100, 0, 0]}},
    "right": {"bushing": {"a": "ground/right", "b": "beam/b", "translation": [0, 2e5, 3e5]}}
  },
  "loads": {"pull": {"force": {"at": "beam/b", "components": [0, 1, 0]}}},
  "outputs": {"bearing": {"displacement": {"at": "beam/b"}}},
  "analysis": {"frequency_response": {"inputs": ["pull"], "frequencies": [10, 100, 4000], "random": {"pull": [[10, 4], [300, 4]]}}}
}"#;

fn mounted() -> Folder {
    let folder = Folder::empty();
    let beam = spatial_beam(&SpatialBeam::default());
    folder.store_superelement("beam.dcb.h5", &lowest(&beam, 6).superelement);
    folder.write("scene.json", MOUNTED);
    folder
}

#[test]
fn frequencies_beyond_the_file_are_told_with_both_numbers_or_refused() {
    let folder = mounted();
    let answer = folder.done("scene.json");
    let told = answer.stderr;
    assert!(
        told.contains("body \"beam\": its superelement is made for motions up to ")
            && told.contains("and the responses go up to 4000 Hz"),
        "{told}"
    );
    folder.refused(
        "scene.json --strict --force",
        &["frequencies", "made for motions up to", "4000 Hz"],
    );
    folder.write("low.json", MOUNTED.replace(", 4000]", "]"));
    folder.done("low.json --strict");
    folder.write(
        "rest.json",
        MOUNTED.replace(r#""analysis": {"#, r#""analysis": "static", "x": {"#),
    );
    folder.edit("rest.json", |scene| {
        scene.as_object_mut().unwrap().remove("x");
    });
    folder.refused(
        "rest.json --strict",
        &["--strict", "is for a frequency response"],
    );
}

#[test]
fn a_frequency_response_tells_the_damping_of_each_part() {
    let folder = mounted();
    let shown = folder.done("scene.json").stdout;
    assert!(
        shown.contains("damping of the undamped modes at rest") && shown.contains("beam"),
        "{shown}"
    );
    let heading = shown
        .lines()
        .find(|line| line.contains("frequency [Hz]") && line.contains("damping "))
        .unwrap();
    assert!(
        heading.contains("left") && !heading.contains("right"),
        "{heading}"
    );
    let summary = Results::open(folder.path("scene.h5"))
        .unwrap()
        .provenance("summary")
        .unwrap();
    let modes = summary["effective_damping"].as_array().unwrap();
    assert!(modes.len() >= 4, "{summary}");
    for mode in modes {
        let whole = mode["damping_ratio"].as_f64().unwrap();
        let parts = mode["shares"].as_array().unwrap().iter();
        let sum: f64 = parts
            .map(|part| part["damping_ratio"].as_f64().unwrap())
            .sum();
        assert!((sum - whole).abs() <= 1e-12 * whole.abs());
    }
    assert!(
        summary["random"][0]["error"].as_f64().unwrap() > 0.0,
        "{summary}"
    );
    let table = {
        folder.done("scene.json --csv response.csv --force");
        folder.read("response.csv")
    };
    assert!(
        table.contains("error of bearing.y by pull"),
        "{}",
        &table[..300]
    );
}

#[test]
fn a_stress_that_the_file_does_not_have_is_refused() {
    let folder = mounted();
    folder.write(
        "stress.json",
        MOUNTED.replace(
            r#"{"displacement": {"at": "beam/b"}}"#,
            r#"{"stress": {"body": "beam", "field": "fillet"}}"#,
        ),
    );
    folder.refused(
        "stress.json",
        &[
            "outputs.bearing",
            "has no stress field",
            "PART.stress.fillet.mtx",
        ],
    );
}

/// F at one end of the free beam along its axis: all of it accelerates by F / m.
#[test]
fn a_free_beam_accelerates_under_its_load() {
    let folder = mounted();
    folder.edit("scene.json", |scene| {
        let scene = scene.as_object_mut().unwrap();
        scene.remove("springs");
        scene["loads"]["pull"]["force"]["components"] = serde_json::json!([1000, 0, 0]);
        scene["analysis"] = serde_json::json!("inertia_relief");
    });
    let shown = folder.done("scene.json").stdout;
    assert!(
        shown.contains(
            "at rest in the frame that the loads accelerate along 6 motions without stiffness"
        ),
        "{shown}"
    );
    let results = Results::open(folder.path("scene.h5")).unwrap();
    let summary = results.provenance("summary").unwrap();
    let found = summary["accelerations"]["beam"]["origin_world"][0]
        .as_f64()
        .unwrap();
    let element = read_superelement(&folder.path("beam.dcb.h5")).unwrap();
    let expected = 1000.0 / element.inertia.mass;
    assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
    folder.write("held.json", MOUNTED);
    folder.edit("held.json", |scene| {
        scene["analysis"] = serde_json::json!("inertia_relief");
    });
    let answer = folder.run("held.json");
    answer.is_error(2, &["held.json", "use \"static\""]);
}
