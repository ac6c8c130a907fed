//! `reduce compare`.

use serde_json::json;

use crate::support::{Folder, says};

/// The number at the end of the line that starts so.
fn last_number(text: &str, start: &str) -> f64 {
    let line = text.lines().find(|line| line.starts_with(start));
    let line = line.unwrap_or_else(|| panic!("no line starts with {start}:\n{text}"));
    line.split_whitespace().last().unwrap().parse().unwrap()
}

#[test]
fn a_superelement_agrees_with_itself() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --modes 6");
    let shown = folder.done("compare rotor.dcb.h5 rotor.dcb.h5 -v");
    for start in [
        "mass",
        "centre x",
        "inertia zx",
        "F_res + kept",
        "F_res, largest",
    ] {
        assert_eq!(last_number(&shown, start), 0.0, "{shown}");
    }
    assert_eq!(shown.matches("1.000000 with").count(), 6, "{shown}");
}

#[test]
fn the_static_flexibility_does_not_depend_on_the_modes_kept() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --modes 4 -o few.dcb.h5");
    folder.done("rotor.mtx --modes 20 -o many.dcb.h5");
    let shown = folder.done("compare few.dcb.h5 many.dcb.h5 -v");
    assert!(last_number(&shown, "F_res + kept modes") < 1e-8, "{shown}");
    assert!(
        shown.contains("A keeps 4 modes, B 20") && !shown.contains("F_res, largest"),
        "{shown}"
    );
}

#[test]
fn parts_of_other_dimension_or_rows_are_told_apart() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --modes 3");
    let other = Folder::rod();
    other.done("rod.mtx");
    let path = other.path("rod.dcb.h5");
    folder.refused(
        &format!("compare rotor.dcb.h5 {}", path.display()),
        &["planar", "spatial"],
    );
    folder.set(
        "rotor.json",
        "component/interfaces",
        json!([{"name": "n", "kind": "nodes", "nodes": [3]}]),
    );
    folder.done("rotor.mtx --modes 3 -o node.dcb.h5");
    let shown = folder.done("compare rotor.dcb.h5 node.dcb.h5 -v");
    says!(shown, "A has 12 boundary rows, B 3");
    folder.refused("compare rotor.dcb.h5 nowhere.h5", &["nowhere.h5"]);
}
