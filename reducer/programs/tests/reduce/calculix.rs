//! From a deck to a moving mechanism, with CalculiX itself (`apt-get install calculix-ccx`).

use std::process::Command;

use dcb_formats::dcb::SuperelementFile;
use serde_json::json;

use crate::support::{Folder, has_all, stored};

/// `ccx` writes the matrices, `reduce` the superelement, `simulate` swings it about its foot.
#[test]
#[ignore = "needs ccx: cargo test --release -p dcb-programs --test reduce -- --ignored a_deck_moves"]
fn a_deck_moves() {
    let folder = Folder::exchange(&["calculix/bracket.inp"]);
    let at_folder = |program: &str, arguments: &[&str]| {
        let output = Command::new(program)
            .args(arguments)
            .current_dir(folder.path("."))
            .output()
            .unwrap_or_else(|error| panic!("{program}: {error}"));
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        let complained = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status, said, complained)
    };
    // It ends with a status of its own once the matrices are stored.
    at_folder("ccx", &["bracket"]);
    for ending in ["sti", "mas", "dof"] {
        let recorded =
            std::fs::read(stored("tests/data/exchange/calculix").join(format!("bracket.{ending}")))
                .unwrap();
        assert!(
            folder.bytes(&format!("bracket.{ending}")) == recorded,
            "{ending}: another version of CalculiX?"
        );
    }
    let answer = folder.run("bracket.sti --units mm,t,s --modes 10");
    assert_eq!(answer.code, Some(0), "{answer:?}");
    has_all(
        &answer.stdout,
        &["240 degrees of freedom reduced to 10 modes"],
    );

    let file = SuperelementFile::open(folder.path("bracket.dcb.h5")).unwrap();
    let element = file.superelement().unwrap();
    let foot = element
        .interfaces
        .iter()
        .position(|one| one.name == "FOOT")
        .unwrap();
    let hinge: Vec<f64> = (0..3)
        .map(|axis| element.origin[axis] + element.interfaces[foot].position[axis])
        .collect();
    let scene = json!({
        "dimension": 3,
        "units": {"length": "mm", "mass": "t", "time": "s"},
        "gravity": [0.0, 0.0, -9810.0],
        "ground": {"points": {"hinge": hinge}},
        "bodies": {"bracket": {"superelement": "bracket.dcb.h5"}},
        "joints": {"hinge": {"revolute": {"a": "ground/hinge", "b": "bracket/FOOT", "axis": [0.0, 1.0, 0.0]}}},
        "outputs": {"tip": {"position": {"at": "bracket/TIP"}}},
        "integrator": {"generalized_alpha": {"step": 1e-4, "end": 0.1}}
    });
    folder.write("scene.json", scene.to_string());
    let simulate = env!("CARGO_BIN_EXE_simulate");
    let (status, said, complained) = at_folder(simulate, &["scene.json"]);
    assert!(status.success(), "{complained}");
    has_all(&said, &["1 superelement file", "energy balance"]);
    at_folder(simulate, &["csv", "scene.h5"]);
    let table = folder.read("scene.csv");
    let heights: Vec<f64> = table
        .lines()
        .skip(1)
        .filter_map(|line| line.rsplit(',').next()?.parse().ok())
        .collect();
    let (first, last) = (heights[0], heights[heights.len() - 1]);
    assert!((first - last).abs() > 1.0, "{first} {last}");
}
