//! Springs, torsion springs, bushings and dampers against oscillators and equilibria in closed form.

use std::f64::consts::{PI, TAU};

use serde_json::{Value, json};

use super::parts::{number, run, scene_text, started};

const MASS: f64 = 0.5;
const INERTIA: f64 = 2e-3;

/// A block with its centre at the pin, 0.4 from the ground's origin along x.
fn block(dimension: u32, rest: Value) -> Value {
    let d = dimension as usize;
    let inertia = match dimension {
        2 => json!(INERTIA),
        _ => json!([INERTIA, 1.2 * INERTIA, 1.5 * INERTIA]),
    };
    let mut text = scene_text(
        dimension,
        json!({
            "ground": {"points": {"home": &[0.4, 0.0, 0.0][..d]}},
            "bodies": {"block": {
                "rigid": {"mass": MASS, "inertia": inertia, "points": {"pin": &[0.0; 3][..d]}},
                "position": &[0.4, 0.0, 0.0][..d]
            }},
            "outputs": {
                "position": {"position": {"at": "block/pin"}},
                "velocity": {"velocity": {"at": "block/pin"}},
                "orientation": {"orientation": {"at": "block/pin"}}
            }
        }),
    );
    for (key, value) in rest.as_object().unwrap() {
        text[key] = value.clone();
    }
    text
}

fn slide() -> Value {
    json!({"slide": {"prismatic": {"a": "ground/home", "b": "block/pin", "axis": [1, 0]}}})
}

fn hinge() -> Value {
    json!({"hinge": {"revolute": {"a": "ground/home", "b": "block/pin"}}})
}

#[test]
fn a_spring_swings_at_the_root_of_stiffness_by_mass() {
    let text = block(
        2,
        json!({"joints": slide(), "springs": {"spring": {"spring": {"a": "ground", "b": "block/pin", "stiffness": 80, "free_length": 0.3}}}}),
    );
    let mut mechanism = started(&text);
    let omega = (80.0 / MASS).sqrt();
    for _ in 0..1000 {
        mechanism.step(1e-3).unwrap();
        let x = 0.3 + 0.1 * (omega * mechanism.time()).cos();
        let found = number(&mut mechanism, "position");
        assert!(
            (found - x).abs() < 5e-5,
            "{found} at {}, expected {x}",
            mechanism.time()
        );
        // Force conjugate to the length, on the second body: it pulls back.
        let force = number(&mut mechanism, "springs/spring");
        assert!(
            (force + 80.0 * (found - 0.3)).abs() < 1e-8,
            "the force is {force}"
        );
    }
}

#[test]
fn a_torsion_spring_swings_at_the_root_of_stiffness_by_inertia() {
    let text = block(
        2,
        json!({"joints": hinge(), "springs": {"spring": {"torsion_spring": {"joint": "hinge", "stiffness": 0.5, "free_angle": 0.6}}}}),
    );
    let mut mechanism = started(&text);
    let omega = (0.5 / INERTIA).sqrt();
    for _ in 0..1000 {
        mechanism.step(5e-4).unwrap();
        let angle = 0.6 * (1.0 - (omega * mechanism.time()).cos());
        let found = number(&mut mechanism, "orientation");
        assert!((found - angle).abs() < 2e-4, "{found}, expected {angle}");
    }
}

#[test]
fn a_bushing_has_a_frequency_in_each_direction() {
    let (k, c) = ([50.0, 90.0, 200.0], [0.4, 0.7, 1.1]);
    let mut text = block(
        3,
        json!({"springs": {"bushing": {"bushing": {"a": "ground/home", "b": "block/pin", "translation": k, "rotation": c}}}}),
    );
    let (velocity, spin) = ([0.3, -0.2, 0.5], [0.0, 0.0, 2e-3]);
    text["bodies"]["block"]["velocity"] = json!(velocity);
    text["bodies"]["block"]["angular_velocity"] = json!(spin);
    let mut mechanism = started(&text);
    for _ in 0..500 {
        mechanism.step(1e-3).unwrap();
    }
    let time = mechanism.time();
    let found = mechanism.output("position").unwrap().to_vec();
    for axis in 0..3 {
        let omega = (k[axis] / MASS).sqrt();
        let x = [0.4, 0.0, 0.0][axis] + velocity[axis] / omega * (omega * time).sin();
        assert!(
            (found[axis] - x).abs() < 2e-4 * velocity[axis].abs(),
            "{found:?}, {x} along {axis}"
        );
    }
    let omega = (c[2] / (1.5 * INERTIA)).sqrt();
    let angle = spin[2] / omega * (omega * time).sin();
    let z = mechanism.output("orientation").unwrap()[3];
    assert!(
        (2.0 * z - angle).abs() < 1e-3 * spin[2] / omega,
        "{z}, expected half of {angle}"
    );
}

#[test]
fn a_bushing_of_two_slopes_needs_half_a_period_of_each() {
    let table = json!([[-1, -40], [0, 0], [1, 160]]);
    let mut text = block(
        2,
        json!({"springs": {"bushing": {"bushing": {"a": "ground/home", "b": "block/pin", "translation": [table, 1]}}}}),
    );
    text["bodies"]["block"]["velocity"] = json!([0.9, 0]);
    let mut mechanism = started(&text);
    let half = |stiffness: f64| PI * (MASS / stiffness).sqrt();
    run(&mut mechanism, half(160.0), 1000);
    let back = mechanism.output("velocity").unwrap()[0];
    assert!((number(&mut mechanism, "position") - 0.4).abs() < 1e-5 && (back + 0.9).abs() < 1e-5);
    run(&mut mechanism, half(40.0), 1000);
    let forth = mechanism.output("velocity").unwrap()[0];
    assert!((number(&mut mechanism, "position") - 0.4).abs() < 2e-5 && (forth - 0.9).abs() < 2e-5);
}

#[test]
fn damped_springs_come_to_rest_under_the_weight() {
    let cases = [
        json!({"spring": {"a": "ground", "b": "block/pin", "stiffness": 200, "damping": 10}}),
        json!({"bushing": {"a": "ground/home", "b": "block/pin", "translation": [200, 900], "translation_damping": [10, 30], "rotation": [5], "rotation_damping": [0.1]}}),
        json!({"bushing": {"a": "ground/home", "b": "block/pin", "translation": [[[-2, -400], [3, 600]], 1], "translation_damping": [[[-1, -10], [0, 0], [1, 10]], 1], "rotation": [5], "rotation_damping": [0.1]}}),
    ];
    for spring in cases {
        let text = block(
            2,
            json!({"gravity": [9.81, 0], "joints": slide(), "springs": {"spring": spring}}),
        );
        let mut mechanism = started(&text);
        run(&mut mechanism, 3.0, 3000);
        let sag = number(&mut mechanism, "position") - 0.4;
        assert!(
            (sag - MASS * 9.81 / 200.0).abs() < 1e-9,
            "{spring}: sags by {sag}"
        );
        let balance = mechanism.output("energy/balance").unwrap();
        // Half of the work of gravity is stored, the other half is heat.
        let heat = 0.5 * MASS * 9.81 * sag;
        assert!(
            (balance[6] - heat).abs() < 1e-4 * heat,
            "{spring}: {} of heat",
            balance[6]
        );
    }
}

#[test]
fn a_damper_alone_eats_the_motion() {
    let text = |damper: Value| {
        let mut text = block(2, json!({"joints": slide(), "springs": {"damper": damper}}));
        text["bodies"]["block"]["velocity"] = json!([2, 0]);
        started(&text)
    };
    let mut mechanism = text(json!({"spring": {"a": "ground", "b": "block/pin", "damping": 1.5}}));
    run(&mut mechanism, 0.3, 300);
    let speed = 2.0 * (-1.5 * 0.3 / MASS).exp();
    let found = number(&mut mechanism, "velocity");
    assert!((found - speed).abs() < 1e-5, "{found}, expected {speed}");
    let heat = mechanism.output("energy/balance").unwrap()[6];
    let lost = 0.5 * MASS * (4.0 - speed * speed);
    assert!(
        (heat - lost).abs() < 1e-5 * lost,
        "{heat} of heat, {lost} of motion"
    );
}

#[test]
fn a_torsion_damper_eats_the_spin() {
    let mut text = block(
        2,
        json!({"joints": hinge(), "springs": {"damper": {"torsion_spring": {"joint": "hinge", "damping": [[-100, -1], [0, 0], [100, 1]]}}}}),
    );
    text["bodies"]["block"]["angular_velocity"] = json!(20);
    text["outputs"]["spin"] = json!({"angular_velocity": {"at": "block/pin"}});
    let mut mechanism = started(&text);
    run(&mut mechanism, 0.2, 400);
    let spin = 20.0 * (-0.01 * 0.2 / INERTIA).exp();
    let found = number(&mut mechanism, "spin");
    assert!(
        (found - spin).abs() < 1e-5 * spin,
        "{found}, expected {spin}"
    );
}

#[test]
fn orientations_count_their_turns_however_rarely_they_are_read() {
    let mut text = block(2, json!({"joints": hinge()}));
    text["bodies"]["block"]["angular_velocity"] = json!(3.0 * TAU);
    let mut mechanism = started(&text);
    run(&mut mechanism, 2.0, 200);
    let angle = number(&mut mechanism, "orientation");
    assert!((angle - 6.0 * TAU).abs() < 1e-9, "{angle} after six turns");
}
