//! Every kind of joint, in the plane and in space, between a rigid body and the ground and between a flexible and a rigid body.

use std::collections::BTreeSet;

use dcb_formats::scene::Joint;
use dcb_runtime::Mechanism;
use serde_json::{Value, json};

use super::balance::{assert_angular_impulse, assert_newton, watch_places};
use super::parts::{Folder, scene_text};

/// Number of kinds of joints.
const KINDS: usize = 11;

/// The kind of a joint, counted. A new kind doesn't compile until it is counted here, and then fails until it has an example.
fn kind(joint: &Joint) -> usize {
    match joint {
        Joint::Fixed(_) => 0,
        Joint::Revolute(_) => 1,
        Joint::Prismatic(_) => 2,
        Joint::Cylindrical(_) => 3,
        Joint::Universal(_) => 4,
        Joint::Spherical(_) => 5,
        Joint::Planar(_) => 6,
        Joint::PointOnLine(_) => 7,
        Joint::Distance(_) => 8,
        Joint::Gear(_) => 9,
        Joint::Rack(_) => KINDS - 1,
    }
}

/// One example: what a joint is called in JSON, its keys beside `a` and `b`, and how far apart its places are drawn.
struct Example {
    kind: &'static str,
    keys: Value,
    gap: [f64; 3],
}

fn example(kind: &'static str, keys: Value, gap: [f64; 3]) -> Example {
    Example { kind, keys, gap }
}

fn examples(dimension: u32) -> Vec<Example> {
    let none = [0.0; 3];
    if dimension == 2 {
        return vec![
            example("fixed", json!({}), none),
            example("revolute", json!({}), none),
            example("prismatic", json!({"axis": [2, 1]}), [0.04, 0.02, 0.0]),
            example("point_on_line", json!({"axis": [1, -3]}), none),
            example("distance", json!({}), [0.06, 0.02, 0.0]),
        ];
    }
    vec![
        example("fixed", json!({}), none),
        example("revolute", json!({"axis": [1, 2, 2]}), none),
        example("prismatic", json!({"axis": [0, 2, 1]}), [0.0, 0.04, 0.02]),
        example("cylindrical", json!({"axis": [3, 0, 1]}), [0.03, 0.0, 0.01]),
        example(
            "universal",
            json!({"axis": [0, 1, 0], "axis_b": [0, 0, 1]}),
            none,
        ),
        example("spherical", json!({}), none),
        example("planar", json!({"axis": [0, 0, 1]}), [0.02, -0.01, 0.0]),
        example("point_on_line", json!({"axis": [1, 1, 1]}), none),
        example("distance", json!({}), [0.06, 0.02, -0.03]),
    ]
}

/// What the block and the disturbance are in each dimension.
fn block(dimension: u32, position: [f64; 3]) -> Value {
    match dimension {
        2 => json!({
            "rigid": {"mass": 0.2, "inertia": 3e-4, "points": {"pin": [-0.05, 0.01], "tip": [0.06, 0.03]}},
            "position": &position[..2]
        }),
        _ => json!({
            "rigid": {
                "mass": 0.2, "inertia": [[2e-4, 3e-5, 0], [3e-5, 3e-4, -2e-5], [0, -2e-5, 4e-4]],
                "points": {"pin": [-0.05, 0.01, 0.02], "tip": [0.06, 0.03, -0.02]}
            },
            "position": position
        }),
    }
}

fn push(dimension: u32) -> Value {
    let all = [
        json!({"formula": "3*sin(60*t)^2"}),
        json!({"formula": "-2*sin(50*t)"}),
        json!({"polynomial": [0.5, 20]}),
    ];
    json!({"force": {"at": "block/tip", "components": &all[..dimension as usize]}})
}

fn gravity(dimension: u32) -> Value {
    json!(&[1.5, -9.81, -2.0][..dimension as usize])
}

/// The block held by the ground at a place that is turned in space.
fn on_the_ground(dimension: u32, of: &Example) -> Value {
    // The gap is drawn in the axes of the ground's point: in space a third of a turn about (1, 1, 1), x to y to z to x.
    let [x, y, z] = of.gap;
    let (turn, gap) = match dimension {
        2 => (json!(0), [x, y, z]),
        _ => (json!([0.5, 0.5, 0.5, 0.5]), [z, x, y]),
    };
    let place: [f64; 3] = std::array::from_fn(|i| [0.2, 0.1, -0.3][i] + gap[i]);
    let pin = [-0.05, 0.01, if dimension == 2 { 0.0 } else { 0.02 }];
    let position = std::array::from_fn(|i| place[i] - pin[i]);
    let mut joint = of.keys.clone();
    joint["a"] = json!("ground/mount");
    joint["b"] = json!("block/pin");
    if of.kind == "universal" {
        // The block is drawn parallel to the world, its z is the mount's y and its x the mount's z.
        joint["axis_b"] = json!([1, 0, 0]);
    }
    scene_text(
        dimension,
        json!({
            "gravity": gravity(dimension),
            "ground": {"points": {"mount": {"position": &[0.2, 0.1, -0.3][..dimension as usize], "orientation": turn}}},
            "bodies": {"block": block(dimension, position)},
            "joints": {"joint": {of.kind: joint}},
            "loads": {"push": push(dimension)},
        }),
    )
}

/// The block held by the free end of a clamped flexible beam.
fn on_the_beam(dimension: u32, of: &Example) -> Value {
    let pin = [-0.05, 0.01, if dimension == 2 { 0.0 } else { 0.02 }];
    let position = std::array::from_fn(|i| [0.3, 0.0, 0.0][i] + of.gap[i] - pin[i]);
    let mut joint = of.keys.clone();
    joint["a"] = json!("beam/b");
    joint["b"] = json!("block/pin");
    scene_text(
        dimension,
        json!({
            "gravity": gravity(dimension),
            "bodies": {
                "beam": {"superelement": file(dimension), "damping": {"modal": 0.01}},
                "block": block(dimension, position)
            },
            "joints": {
                "clamp": {"fixed": {"a": "ground", "b": "beam/a"}},
                "joint": {of.kind: joint}
            },
            "loads": {"push": push(dimension)},
        }),
    )
}

fn file(dimension: u32) -> &'static str {
    if dimension == 2 {
        "rod.dcb.h5"
    } else {
        "beam.dcb.h5"
    }
}

/// A wheel on the ground, the block on an axle or a guide, and a coupling between them; on the ground or at the end of the beam.
fn coupled(dimension: u32, kind: &str, on_beam: bool) -> Value {
    let d = dimension as usize;
    let place = [0.3, 0.0, 0.0];
    let carrier = if on_beam { "beam/b" } else { "ground/mount" };
    let pin = [-0.05, 0.01, if d == 2 { 0.0 } else { 0.02 }];
    let position = std::array::from_fn(|i| place[i] - pin[i]);
    let axle = |a: &str, b: &str| match d {
        2 => json!({"revolute": {"a": a, "b": b}}),
        _ => json!({"revolute": {"a": a, "b": b, "axis": [0, 0, 1]}}),
    };
    let inertia = if d == 2 {
        json!(1e-4)
    } else {
        json!([1e-4, 1e-4, 1e-4])
    };
    let mut bodies = json!({"block": block(dimension, position)});
    let mut joints = serde_json::Map::new();
    if on_beam {
        bodies["beam"] = json!({"superelement": file(dimension), "damping": {"modal": 0.01}});
        joints.insert(
            "clamp".into(),
            json!({"fixed": {"a": "ground", "b": "beam/a"}}),
        );
    }
    // The wheel's centre of mass is off its axle.
    bodies["wheel"] = json!({
        "rigid": {"mass": 0.1, "inertia": inertia, "center_of_mass": &[0.01, 0.02, 0.0][..d], "points": {"axle": &[0.0; 3][..d]}},
        "position": &[0.5, 0.1, 0.0][..d]
    });
    joints.insert("wheel".into(), axle("ground/axle", "wheel/axle"));
    if kind == "gear" {
        joints.insert("other".into(), axle(carrier, "block/pin"));
        joints.insert(
            "joint".into(),
            json!({"gear": {"first": "wheel", "second": "other", "ratio": -1.7}}),
        );
    } else {
        joints.insert(
            "slide".into(),
            json!({"prismatic": {"a": carrier, "b": "block/pin", "axis": &[1, 0, 0][..d]}}),
        );
        joints.insert(
            "joint".into(),
            json!({"rack": {"rotation": "wheel", "translation": "slide", "radius": 0.08}}),
        );
    }
    scene_text(
        dimension,
        json!({
            "gravity": gravity(dimension),
            "ground": {"points": {"mount": &place[..d], "axle": &[0.5, 0.1, 0.0][..d]}},
            "bodies": bodies, "joints": joints, "loads": {"push": push(dimension)},
        }),
    )
}

fn all() -> Vec<(String, u32, Value)> {
    let mut all = Vec::new();
    for dimension in [2, 3] {
        for of in examples(dimension) {
            all.push((
                format!("{} on the ground, {dimension}-D", of.kind),
                dimension,
                on_the_ground(dimension, &of),
            ));
            all.push((
                format!("{} on a beam, {dimension}-D", of.kind),
                dimension,
                on_the_beam(dimension, &of),
            ));
        }
        for kind in ["gear", "rack"] {
            all.push((
                format!("{kind} on the ground, {dimension}-D"),
                dimension,
                coupled(dimension, kind, false),
            ));
            all.push((
                format!("{kind} on a beam, {dimension}-D"),
                dimension,
                coupled(dimension, kind, true),
            ));
        }
    }
    all
}

#[test]
fn every_kind_has_an_example() {
    let folder = Folder::with_parts();
    let covered: BTreeSet<usize> = all()
        .iter()
        .map(|(_, _, text)| kind(&folder.scene(text).joints["joint"]))
        .collect();
    assert_eq!(covered, (0..KINDS).collect());
}

/// Time of the transients.
const END: f64 = 0.02;

/// The energy that the balance lacks at the end, and the largest that was stored.
fn energy_defect(mechanism: &mut Mechanism, steps: u32) -> (f64, f64) {
    let mut largest = 0.0_f64;
    let mut lacking = 0.0_f64;
    for _ in 0..steps {
        mechanism.step(END / f64::from(steps)).unwrap();
        let balance = mechanism.output("energy/balance").unwrap();
        largest = largest.max(balance[0] + balance[1]);
        lacking = lacking.max(balance[7].abs());
    }
    (lacking, largest)
}

#[test]
fn each_body_obeys_newton_and_the_energy_balance_is_of_second_order() {
    let folder = Folder::with_parts();
    for (what, _, text) in all() {
        let mut scene = folder.scene(&text);
        watch_places(&mut scene);
        let started = || Mechanism::start(&scene).unwrap();
        let mut coarse = started();
        let (first, _) = energy_defect(&mut coarse, 200);
        let mut fine = started();
        let (second, largest) = energy_defect(&mut fine, 400);
        assert!(
            second < 0.3 * first || second < 1e-8 * largest + 1e-13,
            "{what}: the energy balance lacks {first:.2e}, and {second:.2e} with half the step"
        );
        assert!(
            second < 1e-3 * largest + 1e-13,
            "{what}: lacks {second:.1e} of {largest:.1e}"
        );
        let drift = fine.output("constraints/drift").unwrap().to_vec();
        assert!(
            drift[0] < 1e-11 && drift[2] < 1e-10,
            "{what}: the constraints are open by {drift:?}"
        );
        for mechanism in [&mut coarse, &mut fine] {
            assert_newton(&scene, mechanism, &what);
        }
        assert_angular_impulse(&scene, &mut fine, END / 4000.0, &what);
    }
}
