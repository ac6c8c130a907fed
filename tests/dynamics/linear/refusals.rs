//! Requests that can't be met: one clear message each.

use dcb_runtime::{LinearRequest, OperatingPoint, Scene, linearize};
use serde_json::{Value, json};

use super::support::pendulum;
use crate::scenes::parts::{Folder, rigid_scene, scene_text};

fn refused(scene: &Scene, request: LinearRequest, words: &[&str]) {
    let found = linearize(scene, OperatingPoint::Initial, &request, &mut ());
    let error = found.unwrap_err();
    let text = error.to_string();
    assert!(error.is_unusable_input(), "{text}");
    for word in words {
        assert!(text.contains(word), "{word:?} is not in {text:?}");
    }
}

fn inputs(names: &[&str]) -> LinearRequest {
    LinearRequest {
        inputs: names.iter().map(|name| (*name).to_owned()).collect(),
        ..LinearRequest::default()
    }
}

fn outputs(names: &[&str]) -> LinearRequest {
    LinearRequest {
        outputs: names.iter().map(|name| (*name).to_owned()).collect(),
        ..LinearRequest::default()
    }
}

fn order(order: usize) -> LinearRequest {
    LinearRequest {
        order: Some(order),
        ..LinearRequest::default()
    }
}

fn with(rest: Value) -> Scene {
    let mut text = pendulum(0.3, 1.0, 1.0);
    for (key, value) in rest.as_object().unwrap() {
        text[key] = value.clone();
    }
    rigid_scene(&text)
}

#[test]
fn names_that_are_not_there() {
    let scene = with(json!({}));
    refused(
        &scene,
        inputs(&["moter"]),
        &["inputs", "moter", "did you mean `motor`"],
    );
    refused(&scene, inputs(&["wind"]), &["wind", "there are: motor"]);
    refused(&scene, inputs(&["motor", "motor/0"]), &["twice"]);
    refused(&scene, outputs(&["angel"]), &["angel", "angle"]);
    refused(&scene, outputs(&["angle", "outputs/angle"]), &["twice"]);
    refused(
        &scene,
        outputs(&["energy/balance"]),
        &["energy/balance", "works"],
    );
    refused(&scene, outputs(&["integrator/steps"]), &["steps"]);
}

#[test]
fn scenes_without_inputs_outputs_or_motion() {
    refused(
        &with(json!({"loads": {}})),
        inputs(&[]),
        &["inputs", "no loads, no actuators and no drives"],
    );
    refused(
        &with(json!({"outputs": {}})),
        inputs(&[]),
        &["outputs", "reactions/JOINT"],
    );
    refused(
        &with(json!({"outputs": {"energy": "energy"}})),
        inputs(&[]),
        &["outputs"],
    );
    let held = with(
        json!({"joints": {"pivot": {"fixed": {"a": "ground", "b": "bob/pivot"}}},
        "outputs": {"tip": {"position": {"at": "bob/tip"}}}}),
    );
    refused(&held, inputs(&[]), &["can't move", "drive"]);
    let drive = |joint: &str| json!({"angle": {"joint": joint, "input": {"initial": 0.3}}});
    let driven = with(json!({"drives": {"turn": drive("pivot")}}));
    refused(&driven, inputs(&["motor"]), &["can't move"]);
    let hinge = json!({"revolute": {"a": "ground", "b": "bob/pivot"}});
    let twice = with(json!({"joints": {"pivot": hinge, "beside": hinge},
        "drives": {"turn": drive("pivot"), "again": drive("beside")}}));
    refused(
        &twice,
        inputs(&["turn"]),
        &["drives.turn", "hold what it drives"],
    );
}

#[test]
fn orders_that_cannot_be() {
    let scene = with(json!({}));
    refused(&scene, order(0), &["order", "from 1 to 2"]);
    refused(&scene, order(3), &["order", "is 3", "2 states"]);
    refused(&scene, order(1), &["none of the 2 poles decays", "damping"]);
    // Standing on its pivot with a damper: one pole grows, one decays.
    let mut standing = pendulum(std::f64::consts::PI, 1.0, 1.0);
    standing["springs"] =
        json!({"brake": {"torsion_spring": {"joint": "pivot", "damping": 0.4, "stiffness": 0}}});
    let unstable = rigid_scene(&standing);
    let small = linearize(&unstable, OperatingPoint::Initial, &order(1), &mut ());
    let small = small.unwrap().unwrap();
    assert!(small.order() == 1 && small.poles[0].is_unstable());
    let free = rigid_scene(&scene_text(
        2,
        json!({
            "bodies": {
                "a": {"rigid": {"mass": 1, "inertia": 1, "points": {"p": [0, 0]}}},
                "b": {"rigid": {"mass": 1, "inertia": 1, "points": {"p": [0, 0]}}, "position": [1, 0]}
            },
            "springs": {"tie": {"bushing": {"a": "a/p", "b": "b/p", "translation": [5, 5], "rotation": [5], "translation_damping": [1, 1], "rotation_damping": [1]}}},
            "loads": {"push": {"force": {"at": "a/p", "components": [1, 0]}}},
            "outputs": {"b": {"position": {"at": "b/p"}}}
        }),
    ));
    refused(&free, order(3), &["6 of the 12 poles", "give 6 or more"]);
}

#[test]
fn compatibilities_without_a_linearization() {
    let folder = Folder::with_parts();
    for compatibility in ["static", "weak"] {
        let scene = folder.scene(&scene_text(
            3,
            json!({
                "compatibility": compatibility, "allow_unstable_weak": true,
                "bodies": {"beam": {"superelement": "beam.dcb.h5"}},
                "joints": {"clamp": {"fixed": {"a": "ground", "b": "beam/a"}}},
                "loads": {"push": {"force": {"at": "beam/b", "components": [0, 0, 1]}}},
                "outputs": {"tip": {"displacement": {"at": "beam/b"}}}
            }),
        ));
        refused(&scene, inputs(&[]), &["beam", "use strong"]);
        let later = linearize(&scene, OperatingPoint::Time(0.01), &inputs(&[]), &mut ());
        assert!(later.unwrap_err().to_string().contains("use strong"));
    }
    let scene = with(json!({}));
    let never = linearize(&scene, OperatingPoint::Time(-1.0), &inputs(&[]), &mut ());
    assert!(never.unwrap_err().to_string().contains("time from zero on"));
}
