//! `simulate study` of a scene that integrates to an accuracy.

use dcb_formats::scene::Scene;
use serde_json::{Value, json};

use crate::support::{Folder, list, number, says};

/// The slider-crank over one turn, by radau.
fn by_accuracy() -> Folder {
    let folder = Folder::one_turn();
    let end = Scene::read(&folder.path("scene.json"))
        .unwrap()
        .integrator
        .unwrap()
        .end;
    folder.set_scene(
        "integrator",
        json!({"radau": {"tolerance": 1e-4, "end": end}}),
    );
    folder
}

#[test]
fn accuracies_are_studied_as_steps_are() {
    let folder = by_accuracy();
    let command = "study scene.json --modes 1,all --accuracy 1e-2,1e-4,1e-6 --outputs midpoint_deflection,slider_position";
    let said = folder.done(command).stdout;
    says!(
        said,
        "6 rows, 6 of them stable",
        "accuracies ",
        "accuracy 1.0e-"
    );
    let study = folder.json("scene.study/study.json");
    let rows = list(&study["rows"]);
    let of = |modes: &str, accuracy: f64| -> &Value {
        let mut found = rows.iter().filter(|row| {
            row["modes"] == json!(modes)
                && row["options"]["integrator"]["radau"]["tolerance"] == json!(accuracy)
        });
        found.next().unwrap()
    };
    // With all modes the accuracy is what errs, and errors are of its size.
    let errors = [1e-2, 1e-4, 1e-6].map(|accuracy| number(&of("all", accuracy)["error_measured"]));
    assert!(
        errors[0] > 2.0 * errors[1] && errors[1] > 2.0 * errors[2],
        "{errors:?}"
    );
    assert!(errors[2] < 1e-4, "{errors:?}");
    // With one mode it doesn't help.
    let few = [1e-4, 1e-6].map(|accuracy| number(&of("1", accuracy)["error_measured"]));
    assert!(few[1] > 0.5 * few[0] && few[1] > errors[2], "{few:?}");
    // Steps are those that were made, more for a finer accuracy.
    let speed = |accuracy| {
        let row = of("all", accuracy);
        number(&row["steps_per_second"]) * number(&row["seconds_per_time"])
    };
    assert!(speed(1e-6) > speed(1e-2), "{rows:?}");
    let table = folder.read("scene.study/study.csv");
    assert!(
        table.starts_with("row,modes,compatibility,accuracy [1],"),
        "{table}"
    );
    assert!(
        folder
            .read("scene.study/report.html")
            .contains("e is the scene's accuracy")
    );
    // Nothing is run again.
    assert!(
        folder
            .done(command)
            .stdout
            .contains("6 rows, 6 of them stable")
    );
}

#[test]
fn steps_and_accuracies_belong_to_their_integrators() {
    let folder = by_accuracy();
    folder.refused_each(&[
        (
            "study scene.json --step 1e-5",
            &["--step", "radau", "--accuracy"],
        ),
        (
            "study scene.json --accuracy 2",
            &["radau.tolerance", "as changed by the command line", "is 2"],
        ),
        (
            "study scene.json --rho-infinity 0.8",
            &["--rho-infinity", "radau"],
        ),
    ]);
    Folder::one_turn().refused(
        "study scene.json --accuracy 1e-4",
        &["--accuracy", "belongs to radau", "--step"],
    );
}
