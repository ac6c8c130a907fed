//! `reduce export`.

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
            &["rotor.fem: exists already; use --force"],
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
