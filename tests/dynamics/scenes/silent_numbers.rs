//! Numbers that would be wrong without a word: forces of redundant constraints at short steps, angles beyond half a turn in a step.

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

/// A spatial slider-crank, its rod on joints of these kinds.
fn slider_crank(wrist: Value, pin: Value) -> Value {
    let rigid = |mass: f64, points: Value| json!({"mass": mass, "inertia": [0.01, 0.02, 0.03], "points": points});
    let across = json!([0, 0, 1]);
    json!({
        "dimension": 3, "units": units(), "gravity": [0, -9.81, 0],
        "bodies": {
            "crank": {"rigid": rigid(2.0, json!({"axle": [0, 0, 0], "pin": [0.1, 0, 0]})), "angular_velocity": [0, 0, 30]},
            "rod": {"rigid": rigid(1.5, json!({"left": [0, 0, 0], "right": [0.4, 0, 0]})), "position": [0.1, 0, 0]},
            "slider": {"rigid": rigid(1.0, json!({"pin": [0, 0, 0]})), "position": [0.5, 0, 0]},
        },
        "ground": {"points": {"guide": [0.5, 0, 0]}},
        "joints": {
            "axle": {"revolute": {"a": "ground", "b": "crank/axle", "axis": across}},
            "wrist": wrist, "pin": pin,
            "guide": {"prismatic": {"a": "ground/guide", "b": "slider/pin", "axis": [1, 0, 0]}},
        },
        "outputs": {"slider": {"acceleration": {"at": "slider/pin"}}},
        "integrator": {"generalized_alpha": {"step": 1e-3, "end": 1}},
    })
}

#[test]
fn redundant_constraints_leave_the_accelerations_alone() {
    let revolute = |a: &str, b: &str| json!({"revolute": {"a": a, "b": b, "axis": [0, 0, 1]}});
    let universal = json!({"universal": {"a": "rod/right", "b": "slider/pin", "axis": [0, 0, 1], "axis_b": [0, 1, 0]}});
    let spherical = json!({"spherical": {"a": "crank/pin", "b": "rod/left"}});
    for step in [1e-4, 1e-5] {
        let redundant = slider_crank(
            revolute("crank/pin", "rod/left"),
            revolute("rod/right", "slider/pin"),
        );
        let minimal = slider_crank(spherical.clone(), universal.clone());
        let mut both = [redundant, minimal].map(|scene| started(&scene));
        let (mut furthest, mut largest) = (0.0_f64, 0.0_f64);
        for _ in 0..500 {
            let [found, expected] = both.each_mut().map(|mechanism| {
                mechanism.step(step).unwrap();
                mechanism.output("slider").unwrap()[0]
            });
            furthest = furthest.max((found - expected).abs());
            largest = largest.max(expected.abs());
        }
        println!("{step:e}: {furthest:.1e} of {largest:.1e}");
        assert!(
            furthest < 1e-4 * largest,
            "{step:e}: {furthest:e} of {largest:e}"
        );
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
