//! Options of the command line in place of the scene's.

use serde_json::json;

use crate::scene_folder::pendulum;
use crate::support::{Folder, says};

#[test]
fn without_arguments_the_usage_is_told() {
    let folder = Folder::empty();
    folder.refused_each(&[
        ("", &["SCENE.json", "Usage: simulate"]),
        ("scene.json --spet 1", &["--spet", "Usage: simulate"]),
        ("scene.json --step fast", &["--step", "fast"]),
    ]);
}

#[test]
fn help_names_every_command_option_and_exit_status() {
    let folder = Folder::empty();
    let help = folder.done("--help").stdout;
    says!(
        help,
        "SCENE.json",
        "--output",
        "--step",
        "--end",
        "--rho-infinity",
        "--compatibility",
        "--force",
        "--csv",
        "--quiet",
        "plot",
        "csv",
        "show",
        "schema",
        "0 done, 1 numerical failure, 2 unusable input, 130 interrupted"
    );
    assert!(folder.done("--version").stdout.starts_with("simulate "));
}

#[test]
fn numbers_override_the_scene_and_are_recorded() {
    let folder = Folder::with(&pendulum(json!({})));
    folder.done("scene.json --step 0.002 --end 0.05 --rho-infinity 0.5 --compatibility static");
    let results = folder.results();
    let time = results.time().unwrap();
    assert_eq!(time.len(), 26);
    assert!((time[1] - 0.002).abs() < 1e-15 && (time[25] - 0.05).abs() < 1e-15);
    let options = results.provenance("options").unwrap();
    assert_eq!(options["rho_infinity"], json!(0.5));
    assert_eq!(options["compatibility"], json!("static"));
    let scene = results.provenance("scene").unwrap();
    assert_eq!(
        scene["integrator"]["generalized_alpha"]["rho_infinity"],
        json!(0.5)
    );
}

#[test]
fn overrides_are_checked_like_the_scene() {
    let folder = Folder::with(&pendulum(json!({})));
    let changed = "as changed by the command line";
    folder.refused_each(&[
        ("scene.json --step 0", &["--step: is 0"]),
        ("scene.json --step NaN", &["--step: is NaN"]),
        ("scene.json --end -1", &["--end: is -1"]),
        (
            "scene.json --rho-infinity 2",
            &["rho_infinity", changed, "from 0 to 1"],
        ),
        (
            "scene.json --rho-infinity 1",
            &["rho_infinity", changed, "stabilized-index-2"],
        ),
        (
            "scene.json --compatibility loose",
            &["loose", "strong", "static", "weak"],
        ),
    ]);
}

#[test]
fn options_that_have_nothing_to_change_are_refused() {
    let hht = json!({"integrator": {"hht": {"step": 1e-3, "end": 0.1}}});
    Folder::with(&pendulum(hht))
        .refused("scene.json --rho-infinity 0.5", &["--rho-infinity", "hht"]);
}
