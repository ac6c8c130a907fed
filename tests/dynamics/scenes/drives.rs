//! Drives: the coordinate follows its function, and the power of the drive is what the energy grows by.

use std::path::Path;

use dcb_runtime::{Mechanism, Scene};
use serde_json::{Value, json};

use super::parts::{number, rigid_scene, scene_text, started};

/// A body on one joint of the ground, driven.
fn driven(joint: Value, drive: Value) -> Value {
    let kind = joint.as_object().unwrap().keys().next().unwrap().clone();
    let name = "joint";
    let mut scene = scene_text(
        2,
        json!({
            "gravity": [0.3, -9.81],
            "bodies": {"block": {
                "rigid": {"mass": 0.4, "inertia": 2e-3, "center_of_mass": [0.1, 0.03], "points": {"pin": [0, 0]}},
                "position": [if kind == "distance" { 0.5 } else { 0.0 }, 0.0]
            }},
            // A constant angle may be far from the drawing.
            "initial": {"allow_gap": 0.3},
            "joints": {"joint": joint},
            "drives": {"motor": drive},
            "outputs": {
                "coordinate": {"joint_coordinate": {"joint": name}},
                "rate": {"joint_rate": {"joint": name}}
            }
        }),
    );
    if kind == "distance" {
        // Keeps the rest of the motion simple: the block can't turn or leave the line.
        scene["joints"]["guide"] =
            json!({"prismatic": {"a": "ground", "b": "block/pin", "axis": [1, 0]}});
    }
    scene
}

/// A drive, and the coordinate that it asks for.
type Case = (Value, Value, fn(f64) -> f64);

fn cases() -> Vec<Case> {
    let hinge = || json!({"revolute": {"a": "ground", "b": "block/pin"}});
    let slide = || json!({"prismatic": {"a": "ground", "b": "block/pin", "axis": [1, 1]}});
    let rod = || json!({"distance": {"a": "ground", "b": "block/pin"}});
    let of = |kind: &str, function: Value| {
        let mut motion = function;
        motion["joint"] = json!("joint");
        json!({kind: motion})
    };
    vec![
        (hinge(), of("angle", json!({"constant": 0.7})), |_| 0.7),
        // Several turns.
        (
            hinge(),
            of("angle", json!({"polynomial": [0.5, 30, 4]})),
            |t| 0.5 + t * (30.0 + 4.0 * t),
        ),
        (
            hinge(),
            of(
                "angle",
                json!({"harmonic": {"amplitude": 0.8, "angular_frequency": 9, "phase": 0.2, "offset": -0.1}}),
            ),
            |t| -0.1 + 0.8 * (9.0 * t + 0.2).sin(),
        ),
        // A natural spline through three points of a line is the line.
        (
            hinge(),
            of(
                "angle",
                json!({"table": {"times": [0, 0.4, 2], "values": [1, 1.8, 5], "interpolation": "spline"}}),
            ),
            |t| 1.0 + 2.0 * t,
        ),
        (
            slide(),
            of("position", json!({"formula": "0.2*sin(3*t)^2"})),
            |t| 0.2 * (3.0 * t).sin().powi(2),
        ),
        (
            slide(),
            of(
                "speed",
                json!({"harmonic": {"amplitude": 2, "angular_frequency": 5}}),
            ),
            |t| 0.4 * (1.0 - (5.0 * t).cos()),
        ),
        (
            slide(),
            of(
                "speed",
                json!({"table": {"times": [0, 1], "values": [0, 3], "interpolation": "linear"}}),
            ),
            |t| 1.5 * t * t,
        ),
        (hinge(), of("speed", json!({"formula": "exp(-2*t)"})), |t| {
            0.5 * (1.0 - (-2.0 * t).exp())
        }),
        (hinge(), of("speed", json!({"constant": -12})), |t| {
            -12.0 * t
        }),
        (
            rod(),
            of("position", json!({"polynomial": [0.5, 0, 0.3]})),
            |t| 0.5 + 0.3 * t * t,
        ),
        (rod(), of("speed", json!({"polynomial": [0, 0.6]})), |t| {
            0.5 + 0.3 * t * t
        }),
    ]
}

/// Runs to `t` = 0.8; the largest defect of the balance on the way.
fn run(mechanism: &mut Mechanism, steps: u32, coordinate: fn(f64) -> f64, what: &Value) -> f64 {
    let mut lacking = 0.0_f64;
    for _ in 0..steps {
        let step = mechanism.step(0.8 / f64::from(steps));
        assert!(step.is_ok(), "{what}: {step:?}");
        let t = mechanism.time();
        let (found, asked) = (number(mechanism, "coordinate"), coordinate(t));
        assert!(
            (found - asked).abs() < 1e-9,
            "{what}: {found} at {t}, asked for {asked}"
        );
        lacking = lacking.max(mechanism.output("energy/balance").unwrap()[7].abs());
    }
    lacking
}

#[test]
fn coordinates_follow_their_functions_and_drives_pay_for_the_energy() {
    for (joint, drive, coordinate) in cases() {
        let text = driven(joint, drive.clone());
        let coarse = run(&mut started(&text), 400, coordinate, &drive);
        let fine = run(&mut started(&text), 800, coordinate, &drive);
        assert!(
            fine < 0.3 * coarse || fine < 1e-9,
            "{drive}: the balance lacks {coarse:.2e}, and {fine:.2e} with half the step"
        );
    }
}

#[test]
fn the_moment_of_a_drive_carries_weight_and_inertia() {
    // A pendulum that is swung: M = (J + m c²) φ'' + m g c cos φ, about the pin.
    let text = driven(
        json!({"revolute": {"a": "ground", "b": "block/pin"}}),
        json!({"angle": {"joint": "joint", "polynomial": [0, 0, 3]}}),
    );
    let mut mechanism = started(&text);
    super::parts::run(&mut mechanism, 0.5, 500);
    let angle: f64 = 3.0 * 0.25;
    let (sine, cosine) = angle.sin_cos();
    let (mass, c, d) = (0.4, 0.1, 0.03);
    let inertia = 2e-3 + mass * (c * c + d * d);
    let arm = (c * cosine - d * sine, c * sine + d * cosine);
    let moment = inertia * 6.0 - mass * (arm.0 * -9.81 - arm.1 * 0.3);
    let found = number(&mut mechanism, "drives/motor");
    assert!(
        (found - moment).abs() < 1e-4 * moment.abs(),
        "{found}, expected {moment}"
    );
    let rate = number(&mut mechanism, "rate");
    assert!((rate - 3.0).abs() < 1e-6, "the rate is {rate}");
}

#[test]
fn constants_of_the_scene_are_known_to_all_its_formulas() {
    let refusal = |text: &Value| {
        let read = Scene::parse(&text.to_string(), Path::new("scene.json"));
        read.map(|_| ()).unwrap_err().to_string()
    };
    let mut text = driven(
        json!({"revolute": {"a": "ground", "b": "block/pin"}}),
        json!({"angle": {"joint": "joint", "formula": "swing*sin(omega*t)"}}),
    );
    text["constants"] = json!({"swing": 0.8, "omega": 9});
    text["loads"] = json!({"wind": {"force": {
        "at": "block/pin", "components": [{"formula": "omega*swing"}, 0]
    }}});
    let mut mechanism = started(&text);
    super::parts::run(&mut mechanism, 0.5, 50);
    let (found, asked) = (
        number(&mut mechanism, "coordinate"),
        0.8 * (9.0 * 0.5_f64).sin(),
    );
    assert!((found - asked).abs() < 1e-9, "{found}, asked for {asked}");
    // A scene as text has them still.
    let again = serde_json::to_value(rigid_scene(&text)).unwrap();
    assert_eq!(again["constants"], json!({"swing": 0.8, "omega": 9.0}));
    for (name, value, says) in [
        ("t", json!(1), "is the time"),
        ("pi", json!(3), "is a constant already"),
        ("sin", json!(1), "is a function of formulas"),
        ("2x", json!(1), "is no name"),
    ] {
        let mut wrong = text.clone();
        wrong["constants"][name] = value;
        let refused = refusal(&wrong);
        assert!(
            refused.contains(&format!("constants.{name}")) && refused.contains(says),
            "{refused}"
        );
    }
    text["constants"].as_object_mut().unwrap().remove("swing");
    let refused = refusal(&text);
    assert!(
        refused.contains("swing") && refused.contains("omega"),
        "{refused}"
    );
}
