//! `reduce export`.

use dcb_formats::dcb::SuperelementFile;

use crate::support::{Folder, says, stored};

#[test]
fn every_target_is_one_command() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --modes 4");
    let targets = [
        ("npz", "rotor.npz"),
        ("simscape", "rotor.mat"),
        ("nastran", "rotor.bdf"),
        ("exudyn", "rotor.hdf5"),
        ("mbdyn", "rotor.fem"),
        ("sid", "rotor.SID_FEM"),
        ("gltf", "rotor.glb"),
    ];
    for (target, file) in targets {
        let shown = folder.done(&format!("export rotor.dcb.h5 --to {target}"));
        assert!(shown.starts_with(&format!("{file}: ")), "{shown}");
        assert!(shown.contains("left out  "), "{shown}");
        assert!(folder.size(file) > 1000);
    }
    let shown = folder.done("export rotor.dcb.h5 --to nastran --dialect op4 -o four.bdf");
    says!(shown, "four.bdf, four.op4: K and M of 22 coordinates");
    assert_eq!(
        folder.done("export rotor.dcb.h5 --to mbdyn --force --quiet"),
        ""
    );
}

#[test]
fn mistakes_are_told_and_write_nothing() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --modes 4");
    folder.done("rotor.mtx --modes 4 -o bare.dcb.h5 --without-fields");
    let planar = stored("samples/slider-crank/rod.dcb.h5");
    folder.write("rod.dcb.h5", std::fs::read(planar).unwrap());
    folder.write("rotor.fem", "mine");
    folder.refused_each(&[
        ("export rotor.dcb.h5", &["--to <TARGET>"]),
        (
            "export rotor.dcb.h5 --to adams",
            &["adams", "npz, simscape, nastran, exudyn, mbdyn, sid, gltf"],
        ),
        ("export rotor.mtx --to npz", &["rotor.mtx", "superelement"]),
        (
            "export none.dcb.h5 --to npz",
            &["none.dcb.h5", "cannot read"],
        ),
        (
            "export rotor.dcb.h5 --to mbdyn",
            &["rotor.fem: exists already; name another output with -o FILE"],
        ),
        (
            "export rod.dcb.h5 --to exudyn",
            &[
                "rod.dcb.h5: is the planar part",
                "`exudyn` takes spatial parts only",
            ],
        ),
        (
            "export bare.dcb.h5 --to gltf",
            &["bare.dcb.h5: has no nodal fields", "--without-fields"],
        ),
        (
            "export rotor.dcb.h5 --to npz --dialect op4",
            &["--dialect: \"op4\" is no form of `npz`"],
        ),
        (
            "export rotor.dcb.h5 --to nastran --dialect punch",
            &["has dmig and op4"],
        ),
        (
            "export rotor.dcb.h5 --to npz -o rotor.dcb.h5 --force",
            &["is the superelement that is exported"],
        ),
        (
            "export rotor.dcb.h5 --to npz -o nowhere/rotor.npz",
            &["the folder nowhere doesn't exist"],
        ),
        (
            "export rotor.dcb.h5 --to nastran --dialect op4 -o part.op4",
            &["is the name of the matrices"],
        ),
        (
            "export rotor.dcb.h5 --to sid --axes world",
            &["world", "body, component"],
        ),
    ]);
}

/// What Nastran gets comes back as a component with the same mass, place and frequencies; coordinates of no frame are internal rows.
#[test]
fn a_superelement_of_nastran_comes_back() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --modes 12");
    folder.done("export rotor.dcb.h5 --to nastran --axes component");
    folder.done("export rotor.dcb.h5 --to nastran --axes component --dialect op4 -o four.bdf");
    let modes = |name: &str| {
        let file = SuperelementFile::open(folder.path(name)).unwrap();
        file.superelement().unwrap()
    };
    let expected = modes("rotor.dcb.h5");
    for matrices in ["rotor.bdf --mesh rotor.bdf", "four.op4 --mesh four.bdf"] {
        let run = |command: &str| {
            let answer = folder.run(command);
            assert_eq!(answer.code, Some(0), "{answer:?}");
            answer.stdout
        };
        let shown = run(&format!(
            "import {matrices} --units m,kg,s -o back.mtx --force"
        ));
        says!(shown, "rows      30, 18 of them internal");
        let number = |label: &str, nth: usize| -> f64 {
            let line = shown.lines().find(|line| line.starts_with(label)).unwrap();
            line.split_whitespace().nth(nth).unwrap().parse().unwrap()
        };
        assert!((number("mass", 1) / expected.inertia.mass - 1.0).abs() < 1e-9);
        assert!(
            (number("centre", 3) - expected.origin[2]).abs() < 1e-8,
            "{shown}"
        );
        run("back.mtx --modes 8 --force");
        let found = modes("back.dcb.h5");
        assert_eq!(found.modes.eigenvalues.len(), 8);
        for (found, expected) in (found.modes.eigenvalues.iter()).zip(&expected.modes.eigenvalues) {
            assert!((found / expected - 1.0).abs() < 1e-8, "{found} {expected}");
        }
    }
}
