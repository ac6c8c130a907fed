//! `plot`, `csv`, `show` and `schema`, on good files and on others.

use serde_json::{Value, json};

use crate::scene_folder::pendulum;
use crate::support::{Folder, says, stored};

#[test]
fn results_become_pictures_tables_and_lists() {
    let folder = Folder::with(&pendulum(json!({})));
    folder.done("scene.json --csv direct.csv");
    assert_eq!(folder.done("plot scene.h5").stdout, "scene.svg\n");
    says!(folder.read("scene.svg"), "<svg");
    assert_eq!(folder.done("csv scene.h5").stdout, "scene.csv\n");
    assert_eq!(folder.read("scene.csv"), folder.read("direct.csv"));
    assert!(
        folder
            .read("scene.csv")
            .starts_with("time [s],angle [rad]\n0.0,0.0\n")
    );
    assert_eq!(folder.read("scene.csv").lines().count(), 102);
    folder.refused("csv scene.h5", &["scene.csv: exists already"]);
    // A picture can be drawn again.
    folder.done("plot scene.h5");
    folder.done("csv scene.h5 reactions/hinge balance -o forces.csv");
    // A name shows values, and a picture has to be SVG.
    let values = folder.done("show scene.h5 angle reactions/hinge.fx").stdout;
    says!(values, "smallest", "angle [rad]", "reactions/hinge.fx [N]");
    assert_eq!(values.lines().count(), 4, "{values}");
    folder.refused(
        "plot scene.h5 -o scene.png",
        &["--output", "plots are SVG", "scene.svg"],
    );
    assert!(!folder.path("scene.png").exists());
    let header = folder.read("forces.csv");
    assert!(
        header.starts_with("time [s],reactions/hinge.fx [N],"),
        "{header}"
    );
    let shown = folder.done("show scene.h5").stdout;
    says!(
        shown,
        "101 rows, complete",
        "angle [rad]",
        "reactions/hinge: fx fy [N], mz [N*m]"
    );
}

#[test]
fn other_files_are_refused_by_what_they_are() {
    let folder = Folder::slider_crank();
    folder.done("scene.json");
    for command in ["plot", "csv", "show"] {
        folder.refused_each(&[
            (
                &format!("{command} nothing.h5"),
                &["nothing.h5: cannot read"],
            ),
            (
                &format!("{command} scene.json"),
                &[
                    "scene.json: is a scene, expected results",
                    "simulate scene.json",
                ],
            ),
            (
                &format!("{command} rod.dcb.h5"),
                &["rod.dcb.h5: is a superelement, expected results"],
            ),
        ]);
    }
    for command in ["plot", "csv"] {
        folder.refused(
            &format!("{command} scene.h5 crank_angel"),
            &["crank_angel", "crank_angle"],
        );
    }
}

#[test]
fn the_schema_is_that_of_the_documentation() {
    let printed = Folder::empty().done("schema").stdout;
    let documented = std::fs::read_to_string(stored("docs/scene.schema.json")).unwrap();
    let parsed = |text: &str| serde_json::from_str::<Value>(text).unwrap();
    assert_eq!(parsed(&printed), parsed(&documented));
}

#[test]
fn a_closed_pipe_is_no_error() {
    let folder = Folder::with(&pendulum(json!({})));
    folder.done("scene.json");
    let mut child = folder.start("show scene.h5");
    drop(child.stdout.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
}
