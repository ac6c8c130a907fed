//! `simulate linearize`: what it prints and writes, and what it refuses.

use serde_json::{Value, json};

use crate::support::{Folder, says};

/// A hanging bar with a damped hinge and a torque to be set from outside.
fn pendulum(rest: Value) -> Folder {
    let mut scene = json!({
        "dimension": 2, "units": {"length": "m", "mass": "kg", "time": "s"}, "gravity": [0, -9.81],
        "bodies": {"bob": {"rigid": {"mass": 2, "inertia": 0.1, "points": {"pivot": [0, 0.5]}}, "position": [0, -0.5]}},
        "joints": {"hinge": {"revolute": {"a": "ground", "b": "bob/pivot"}}},
        "springs": {"brake": {"torsion_spring": {"joint": "hinge", "stiffness": 0, "damping": 0.3}}},
        "loads": {"motor": {"torque": {"at": "bob/pivot", "components": [{"input": {"initial": 0}}]}}},
        "outputs": {"angle": {"joint_coordinate": {"joint": "hinge"}}},
        "integrator": {"generalized_alpha": {"step": 1e-3, "end": 0.1}}
    });
    for (key, value) in rest.as_object().unwrap() {
        scene[key] = value.clone();
    }
    Folder::with(&scene)
}

#[test]
fn a_linear_system_is_told_and_written_in_each_format() {
    let folder = pendulum(json!({}));
    let told = folder.done("linearize scene.json --at static").stdout;
    // √(2 · 9.81 · 0.5 / 0.6) rad/s, and 0.3 / (2 · 0.6) of decay.
    says!(
        told,
        "2 states, 1 inputs, 1 outputs at t = 0 s",
        "-2.5000e-1",
        "motor [N*m], u0 = 0",
        "angle [rad], y0 = ",
        "scene.linear.h5"
    );
    for (name, start) in [
        ("system.h5", &b"\x89HDF"[..]),
        ("system.npz", b"PK"),
        ("system.mat", b"MATLAB 5.0"),
    ] {
        let command =
            format!("linearize scene.json --at 0.05 --outputs angle,reactions/hinge -o {name}");
        let told = folder.done(&command).stdout;
        says!(told, "4 outputs at t = 0.05 s", "reactions/hinge.fy");
        assert!(folder.bytes(name).starts_with(start), "{name}");
        folder.refused(&command, &[name, "exists already"]);
        let before = folder.bytes(name);
        folder.done(&format!("{command} --force"));
        // HDF5 leaves memory as it was between its objects.
        if !name.ends_with(".h5") {
            assert_eq!(before, folder.bytes(name), "{name}");
        }
    }
    // Drawn level, where gravity gives no stiffness: it hangs all the same.
    folder.edit("scene.json", |scene| {
        scene["bodies"]["bob"]["position"] = json!([0.5, 0]);
        scene["bodies"]["bob"]["orientation"] = json!(std::f64::consts::FRAC_PI_2);
    });
    says!(
        folder
            .done("linearize scene.json --at static --force")
            .stdout,
        "-2.5000e-1"
    );
    assert_eq!(
        folder.done("linearize scene.json -q -o quiet.npz").stdout,
        ""
    );
}

#[test]
fn what_cannot_be_is_refused_and_leaves_nothing() {
    let folder = pendulum(json!({}));
    let names = folder.names();
    folder.refused_each(&[
        (
            "linearize scene.json -o system.txt",
            &["system.txt", ".h5, .npz or .mat"],
        ),
        (
            "linearize scene.json -o nowhere/system.h5",
            &["nowhere", "doesn't exist"],
        ),
        ("linearize nothing.json", &["nothing.json"]),
        (
            "linearize scene.json --at later",
            &["later", "initial", "static"],
        ),
        ("linearize scene.json --at -1", &["-1", "from zero on"]),
        (
            "linearize scene.json --inputs moter",
            &["scene.json", "moter", "`motor`"],
        ),
        ("linearize scene.json --outputs angel", &["angel", "angle"]),
        ("linearize scene.json --order 3", &["order", "2 states"]),
        ("linearize scene.json --order 0", &["order"]),
    ]);
    assert_eq!(folder.names(), names);
    let bare = pendulum(json!({"outputs": {}}));
    bare.refused("linearize scene.json", &["outputs", "reactions/JOINT"]);
}

#[test]
fn a_rest_that_falls_over_and_a_motion_are_told() {
    let standing = pendulum(json!({
        "bodies": {"bob": {"rigid": {"mass": 2, "inertia": 0.1, "points": {"pivot": [0, -0.5]}}, "position": [0, 0.5]}}
    }));
    let answer = standing.done("linearize scene.json");
    says!(answer.stdout, "unstable");
    says!(answer.stderr, "--at static");
    // One pole grows and is kept, one decays.
    let told = standing
        .done("linearize scene.json --order 1 --force")
        .stdout;
    says!(told, "truncated from 2 states, of which 1 don't decay");
    let moving = pendulum(json!({
        "bodies": {"bob": {"rigid": {"mass": 2, "inertia": 0.1, "points": {"pivot": [-0.4, -0.3]}}, "position": [0.4, 0.3]}}
    }));
    says!(moving.done("linearize scene.json").stderr, "moves here");
    says!(
        moving
            .done("linearize scene.json --at static --force")
            .stdout,
        "y0 = -2.2142"
    );
}
