//! Numbers that would be wrong without a word: forces of redundant constraints at short steps, angles beyond half a turn in a step.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::path::Path;

use dcb_runtime::mechanism::Mechanism;
use dcb_runtime::{Error, Scene};
use serde_json::{Value, json};

fn started(scene: &Value) -> Mechanism {
    let scene = Scene::parse(&scene.to_string(), Path::new("scene.json")).unwrap();
    Mechanism::start(&scene).unwrap()
}

fn units() -> Value {
    json!({"length": "m", "mass": "kg", "time": "s"})
}

/// Three equal parallel legs under a bar: one constraint too many. By symmetry the outer legs carry the same.
fn parallelogram() -> Value {
    let (cos, sin) = (0.5_f64.cos(), 0.5_f64.sin());
    let leg = |x: f64| {
        let points = json!({"o": [0, 0], "e": [1, 0]});
        let body = json!({"mass": 1, "inertia": 0.1, "center_of_mass": [0.5, 0], "points": points});
        json!({"rigid": body, "position": [x, 0], "orientation": 0.5})
    };
    let pin = |a: &str, b: &str| json!({"revolute": {"a": a, "b": b}});
    let bar = json!({"mass": 2, "inertia": 0.1, "center_of_mass": [1, 0], "points": {"p0": [0, 0], "p1": [1, 0], "p2": [2, 0]}});
    json!({
        "dimension": 2, "units": units(), "gravity": [0, -9.81],
        "ground": {"points": {"g0": [0, 0], "g1": [1, 0], "g2": [2, 0]}},
        "bodies": {"L0": leg(0.0), "L1": leg(1.0), "L2": leg(2.0), "bar": {"rigid": bar, "position": [cos, sin]}},
        "joints": {
            "g0": pin("ground/g0", "L0/o"), "b0": pin("L0/e", "bar/p0"),
            "g1": pin("ground/g1", "L1/o"), "b1": pin("L1/e", "bar/p1"),
            "g2": pin("ground/g2", "L2/o"), "b2": pin("L2/e", "bar/p2"),
        },
        "integrator": {"generalized_alpha": {"step": 1e-3, "end": 1}},
    })
}

#[test]
fn redundant_forces_do_not_depend_on_the_step() {
    let at = |step: f64| {
        let mut mechanism = started(&parallelogram());
        for _ in 0..(0.05 / step).round() as usize {
            mechanism.step(step).unwrap();
        }
        ["reactions/g0", "reactions/g1", "reactions/g2"]
            .map(|joint| mechanism.output(joint).unwrap()[0])
    };
    let long = at(1e-3);
    // Symmetry, and what stabilized index 2 gives.
    assert!((long[0] - long[2]).abs() < 0.02, "{long:?}");
    for step in [2e-4, 5e-5] {
        let short = at(step);
        for (long, short) in long.iter().zip(short) {
            assert!(
                (long - short).abs() < 0.02 * long.abs(),
                "{step}: {long} {short}"
            );
        }
    }
}

#[test]
fn more_than_half_a_turn_in_a_step_is_refused() {
    let rotor = json!({"mass": 1, "inertia": 0.1, "points": {"o": [0, 0]}});
    let scene = json!({
        "dimension": 2, "units": units(),
        "bodies": {"rotor": {"rigid": rotor, "angular_velocity": 4000}},
        "joints": {"axle": {"revolute": {"a": "ground", "b": "rotor/o"}}},
        "outputs": {"angle": {"joint_coordinate": {"joint": "axle"}}},
        "integrator": {"generalized_alpha": {"step": 1e-3, "end": 0.1}},
    });
    assert!(matches!(
        started(&scene).step(1e-3),
        Err(Error::LongTurn { .. })
    ));
    let mut mechanism = started(&scene);
    for _ in 0..1000 {
        mechanism.step(1e-4).unwrap();
    }
    let angle = mechanism.output("angle").unwrap()[0];
    assert!((angle - 400.0).abs() < 1e-6, "{angle}");
}
