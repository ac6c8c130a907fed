//! `plot`, `csv`, `show` and `schema`, on good files and on others.

use serde_json::{Value, json};

use super::support::{Folder, pendulum};

#[test]
fn results_become_pictures_tables_and_lists() {
    let folder = Folder::with(&pendulum(json!({})));
    folder.done("scene.json --csv direct.csv");
    assert_eq!(folder.done("plot scene.h5").stdout, "scene.svg\n");
    assert!(folder.read("scene.svg").contains("<svg"));
    assert_eq!(folder.done("csv scene.h5").stdout, "scene.csv\n");
    assert_eq!(folder.read("scene.csv"), folder.read("direct.csv"));
    assert!(
        folder
            .read("scene.csv")
            .starts_with("time [s],angle [rad]\n0.0,0.0\n")
    );
    assert_eq!(folder.read("scene.csv").lines().count(), 102);
    folder.refuses("plot scene.h5", &["scene.svg: exists already"]);
    folder.refuses("csv scene.h5", &["scene.csv: exists already"]);
    folder.done("csv scene.h5 reactions/hinge balance -o forces.csv");
    let header = folder.read("forces.csv");
    assert!(
        header.starts_with("time [s],reactions/hinge.fx [kg*m/s^2],"),
        "{header}"
    );
    let shown = folder.done("show scene.h5").stdout;
    assert!(
        shown.contains("101 rows, complete") && shown.contains("angle [rad]"),
        "{shown}"
    );
}

#[test]
fn other_files_are_refused_by_what_they_are() {
    let folder = Folder::slider_crank();
    folder.done("scene.json");
    for command in ["plot", "csv", "show"] {
        folder.refuses(
            &format!("{command} nothing.h5"),
            &["nothing.h5: cannot read"],
        );
        folder.refuses(
            &format!("{command} scene.json"),
            &["scene.json: isn't an HDF5 file"],
        );
        folder.refuses(
            &format!("{command} rod.dcb.h5"),
            &["rod.dcb.h5", "dcb-superelement", "dcb-results"],
        );
    }
    for command in ["plot", "csv"] {
        folder.refuses(
            &format!("{command} scene.h5 crank_angel"),
            &["crank_angel", "crank_angle"],
        );
    }
}

#[test]
fn the_schema_is_that_of_the_documentation() {
    let printed: Value = serde_json::from_str(&Folder::empty().done("schema").stdout).unwrap();
    let path =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/scene.schema.json");
    let documented: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    assert_eq!(printed, documented);
}

#[test]
fn a_closed_pipe_is_no_error() {
    let folder = Folder::with(&pendulum(json!({})));
    folder.done("scene.json");
    let mut child = folder
        .command("show scene.h5")
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
}
