//! Scenes that can't be used: where, what was found, what would be right.

use serde_json::{Value, json};

use crate::scene_folder::pendulum;
use crate::support::{Folder, says};

#[test]
fn a_missing_scene_is_named() {
    Folder::empty().refused("machine.json", &["machine.json: cannot read: No such file"]);
}

#[test]
fn broken_json_and_unknown_keys_have_a_line_and_a_column() {
    let folder = Folder::empty();
    folder.write("scene.json", "{\n  \"dimension\": 2,\n  \"units\": {\n");
    folder.refused("scene.json", &["scene.json:4: column", "object"]);
    let text = serde_json::to_string_pretty(&pendulum(json!({}))).unwrap();
    folder.write("scene.json", text.replace("\"inertia\"", "\"inertai\""));
    let line = text
        .lines()
        .position(|line| line.contains("\"inertia\""))
        .unwrap()
        + 1;
    folder.refused(
        "scene.json",
        &[
            &format!("scene.json:{line}: column"),
            "inertai",
            "`inertia`",
        ],
    );
    folder.write("scene.json", text.replace("\"gravity\"", "\"gravtiy\""));
    folder.refused("scene.json", &["gravtiy", "`gravity`", "column"]);
    folder.write("scene.json", text.replace("\"revolute\"", "\"revolut\""));
    folder.refused("scene.json", &["revolut", "`revolute`", "column"]);
}

#[test]
fn hostile_json_is_refused_and_not_swallowed() {
    let folder = Folder::empty();
    let deep = format!("{{\"bodies\": {}", "[".repeat(200_000));
    let bomb = format!(
        "{{\"dimension\": 2, \"gravity\": [{}1e999]}}",
        "0,".repeat(100_000)
    );
    for text in [
        deep.as_str(),
        bomb.as_str(),
        "",
        "[]",
        "null",
        "\u{0}",
        "{\"dimension\": 4}",
    ] {
        folder.write("scene.json", text);
        folder.refused("scene.json", &["error: scene.json"]);
    }
    folder.write("scene.json", [0xff, 0xfe, 0x00]);
    folder.refused("scene.json", &["not UTF-8"]);
    std::fs::create_dir(folder.path("folder")).unwrap();
    folder.refused("folder", &["folder: cannot read"]);
}

/// Changes of the pendulum at a place that the message names, and what else it says.
#[test]
fn what_does_not_fit_is_told_with_its_path_of_keys() {
    let cases: &[(&str, Value, &[&str])] = &[
        (
            "joints.hinge.revolute.b",
            json!("ground/pin"),
            &["point of the ground", "\"pin\""],
        ),
        (
            "joints.hinge.revolute",
            json!({"a": "bob/tip", "b": "bob/pin"}),
            &[
                "joints.hinge.revolute.b",
                "is on \"bob\" like \"bob/tip\"",
                "another body",
            ],
        ),
        (
            "joints.hinge.revolute.b",
            json!("bob/pni"),
            &["\"pni\"", "`pin`"],
        ),
        (
            "joints.hinge.revolute.b",
            json!("bbo/pin"),
            &["\"bbo\"", "`bob`"],
        ),
        (
            "joints.hinge",
            json!({"prismatic": {"a": "ground", "b": "bob/pin", "axis": [0, 0]}}),
            &["joints.hinge.prismatic.axis", "length zero"],
        ),
        (
            "joints.hinge",
            json!({"prismatic": {"a": "ground", "b": "bob/pin"}}),
            &[
                "joints.hinge.prismatic.axis",
                "is missing",
                "\"axis\": [1, 0]",
            ],
        ),
        (
            "joints.hinge",
            json!({"universal": {"a": "ground", "b": "bob/pin", "axis": [1, 0], "axis_b": [0, 1]}}),
            &["joints.hinge.universal", "planar", "use revolute"],
        ),
        ("bodies.bob.rigid.mass", json!(-1), &["is -1", "positive"]),
        (
            "bodies.bob.position",
            json!([0, 0, 0]),
            &["has 3 components, expected 2"],
        ),
        (
            "outputs.angle.joint_coordinate.joint",
            json!("hing"),
            &["\"hing\"", "`hinge`"],
        ),
        (
            "integrator.generalized_alpha.step",
            json!(0),
            &["is 0", "positive"],
        ),
        ("integrator", Value::Null, &["is missing", "\"step\""]),
        (
            "initial",
            json!({"hold": ["bib"]}),
            &["initial.hold[0]", "\"bib\"", "`bob`"],
        ),
        (
            "loads",
            json!({"pull": {"force": {"at": "bob/tip", "components": [{"formula": "2*(t"}, 0]}}}),
            &["loads.pull.force.components[0]"],
        ),
        (
            "loads",
            json!({"pull": {"force": {"at": "bob/tip", "components": [{"formula": "1/t"}, 0]}}}),
            &["loads.pull.force.components[0]", "at t = 0", "finite"],
        ),
        (
            "springs",
            json!({"s": {"spring": {"a": "ground", "b": "bob/pin", "stiffness": 1}}}),
            &["springs.s.spring", "coincide", "bushing"],
        ),
        (
            "drives",
            json!({"motor": {"position": {"joint": "hinge", "constant": 0}}}),
            &["drives.motor.position.joint", "no translation", "prismatic"],
        ),
    ];
    for (place, value, texts) in cases {
        let folder = Folder::with(&pendulum(json!({})));
        let keys = place.replace('.', "/");
        match value.is_null() {
            true => folder.unset("scene.json", &keys),
            false => folder.set_scene(&keys, value),
        }
        let message = folder.refused("scene.json", texts);
        says!(message, "scene.json: ", place);
    }
}

/// Slips of people who are new to it: what is in the way, and what to write in its place.
#[test]
fn frequent_slips_are_answered_with_what_to_write() {
    let folder = Folder::slider_crank();
    let slips: [(&str, Value, &[&str]); 7] = [
        (
            "outputs/slider_position",
            json!("position"),
            &["write {\"position\": {\"at\": \"rod/a\"}}"],
        ),
        (
            "joints/axle/revolute/b",
            json!("crank"),
            &["\"crank\" names a body", "crank/axle, crank/pin"],
        ),
        (
            "joints/wrist/revolute/b",
            json!("rod"),
            &["\"rod\" names a body", "rod/INTERFACE", "rod.dcb.h5"],
        ),
        (
            "drives/motor",
            json!({"torque": {"joint": "axle", "constant": 1}}),
            &["`torque`", "`actuators`"],
        ),
        (
            "integrator",
            json!({"step": 1e-4}),
            &["{\"generalized_alpha\": {\"step\": ...}}"],
        ),
        (
            "integrator/generalized_alpha/end",
            json!("1 s"),
            &["expected a number, without quotes and without a unit"],
        ),
        (
            "bodies/rod/superelement",
            json!("rodd.dcb.h5"),
            &[
                "scene.json: bodies.rod.superelement",
                "did you mean rod.dcb.h5?",
                "`reduce rodd.mtx`",
            ],
        ),
    ];
    let sound = folder.read("scene.json");
    for (place, value, says) in slips {
        folder.set_scene(place, value);
        folder.refused("scene.json", says);
        folder.write("scene.json", &sound);
    }
    folder.refused_each(&[
        ("scene.json --end -1", &["--end: is -1"]),
        (
            "rod.dcb.h5",
            &["rod.dcb.h5: is an HDF5 file", "simulate init rod.dcb.h5"],
        ),
        ("anmate scene.h5", &["did you mean `animate`?"]),
        ("animate scene.json", &["is a scene, expected results"]),
    ]);
    folder.write(
        "part.mtx",
        "%%MatrixMarket matrix coordinate real symmetric\n",
    );
    folder.refused(
        "part.mtx",
        &["is a matrix, not a scene", "`reduce part.mtx`"],
    );
    folder.write("part.json", r#"{"points": [[0, 0]], "component": {}}"#);
    folder.refused("part.json", &["describes a component, not a scene"]);
}

#[test]
fn a_record_longer_than_the_run_is_told() {
    let folder = Folder::with(&pendulum(json!({"record": {"interval": 100}})));
    let told = folder.done("scene.json").stderr;
    says!(told, "record.interval is 100 s, longer than the run");
}
