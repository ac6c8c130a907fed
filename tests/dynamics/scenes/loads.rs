//! Forces, torques and gravity on free bodies: impulse and momentum.

use nalgebra::{UnitQuaternion, Vector3};
use serde_json::{Value, json};

use super::parts::{number, run, scene_text, started};

const MASS: f64 = 0.7;

fn free(dimension: u32, rest: Value) -> Value {
    let d = dimension as usize;
    let inertia = match dimension {
        2 => json!(3e-3),
        _ => json!([2e-3, 2e-3, 3e-3]),
    };
    let mut text = scene_text(
        dimension,
        json!({
            "bodies": {"block": {"rigid": {"mass": MASS, "inertia": inertia, "points": {"center": &[0.0; 3][..d]}}}},
            "outputs": {
                "position": {"position": {"at": "block/center"}},
                "velocity": {"velocity": {"at": "block/center"}},
                "spin": {"angular_velocity": {"at": "block/center"}}
            }
        }),
    );
    for (key, value) in rest.as_object().unwrap() {
        text[key] = value.clone();
    }
    text
}

#[test]
fn gravity_alone_is_free_fall() {
    for dimension in [2_usize, 3] {
        let mut text = free(
            dimension as u32,
            json!({"gravity": &[0.5, -9.81, 1.0][..dimension]}),
        );
        text["bodies"]["block"]["velocity"] = json!(&[3.0, 1.0, -2.0][..dimension]);
        let mut mechanism = started(&text);
        run(&mut mechanism, 0.5, 50);
        let found = mechanism.output("position").unwrap();
        for axis in 0..dimension {
            let (g, v) = ([0.5, -9.81, 1.0][axis], [3.0, 1.0, -2.0][axis]);
            let fallen = v * 0.5 + 0.125 * g;
            assert!(
                (found[axis] - fallen).abs() < 1e-12,
                "{found:?}, {fallen} along {axis}"
            );
        }
    }
}

#[test]
fn the_impulse_of_a_force_is_the_momentum() {
    // A half wave of 0.2 s and 5 N has the impulse 2 · 5 · 0.2 / π.
    let text = free(
        2,
        json!({"loads": {"blow": {"force": {"at": "block/center", "components": [{"harmonic": {"amplitude": 5, "angular_frequency": std::f64::consts::PI / 0.2}}, -1]}}}}),
    );
    let mut mechanism = started(&text);
    run(&mut mechanism, 0.2, 400);
    let found = mechanism.output("velocity").unwrap().to_vec();
    let impulse = 2.0 / std::f64::consts::PI;
    assert!(
        (MASS * found[0] - impulse).abs() < 1e-5 * impulse,
        "{found:?}"
    );
    assert!((MASS * found[1] + 0.2).abs() < 1e-12, "{found:?}");
    let work = mechanism.output("energy/balance").unwrap()[5];
    let energy = 0.5 * MASS * (found[0] * found[0] + found[1] * found[1]);
    assert!(
        (work - energy).abs() < 1e-5 * energy,
        "{work} of work, {energy} of energy"
    );
}

#[test]
fn a_follower_force_turns_with_its_body() {
    let mut text = free(
        2,
        json!({"loads": {"jet": {"force": {"at": "block/center", "axes": "follower", "components": [2, 0]}}}}),
    );
    text["bodies"]["block"]["angular_velocity"] = json!(6);
    let mut mechanism = started(&text);
    run(&mut mechanism, 0.7, 1400);
    let v = mechanism.output("velocity").unwrap();
    let (size, angle) = (2.0 / (MASS * 6.0), 6.0 * 0.7_f64);
    let expected = [size * angle.sin(), size * (1.0 - angle.cos())];
    assert!(
        (v[0] - expected[0]).abs() < 1e-5 && (v[1] - expected[1]).abs() < 1e-5,
        "{v:?}, expected {expected:?}"
    );
}

#[test]
fn a_torque_spins_its_body_up() {
    let text = free(
        2,
        json!({"loads": {"torque": {"torque": {"at": "block/center", "components": [{"polynomial": [0.01, 0.3]}]}}}}),
    );
    let mut mechanism = started(&text);
    run(&mut mechanism, 0.4, 400);
    let spin = (0.01 * 0.4 + 0.15 * 0.16) / 3e-3;
    let found = number(&mut mechanism, "spin");
    assert!(
        (found - spin).abs() < 1e-6 * spin,
        "{found}, expected {spin}"
    );
}

#[test]
fn a_torque_in_space_changes_the_angular_momentum_in_world_axes() {
    for axes in ["world", "follower"] {
        let mut text = free(
            3,
            json!({"loads": {"torque": {"torque": {"at": "block/center", "axes": axes, "components": [0, 0.02, {"formula": "0.03*cos(8*t)"}]}}}}),
        );
        // Spun about the axis of symmetry and drawn turned.
        let turn = UnitQuaternion::from_euler_angles(0.4, -0.8, 1.1);
        text["bodies"]["block"]["orientation"] = json!([turn.w, turn.i, turn.j, turn.k]);
        text["bodies"]["block"]["angular_velocity"] =
            json!(<[f64; 3]>::from(turn * Vector3::z() * 9.0));
        let mut mechanism = started(&text);
        let momentum = |mechanism: &dcb_runtime::Mechanism| {
            let state = mechanism.simulation().state();
            let spin = Vector3::from_column_slice(&state.velocities[3..6]);
            state.orientations[0] * spin.component_mul(&Vector3::new(2e-3, 2e-3, 3e-3))
        };
        let torque = |mechanism: &dcb_runtime::Mechanism| {
            let given = Vector3::new(0.0, 0.02, 0.03 * (8.0 * mechanism.time()).cos());
            match axes {
                "world" => given,
                _ => mechanism.simulation().state().orientations[0] * given,
            }
        };
        let start = momentum(&mechanism);
        let (mut impulse, mut before) = (Vector3::zeros(), torque(&mechanism));
        for _ in 0..600 {
            mechanism.step(1e-3).unwrap();
            let now = torque(&mechanism);
            impulse += (before + now) * 0.5e-3;
            before = now;
        }
        let gained = momentum(&mechanism) - start;
        assert!(
            (gained - impulse).norm() < 1e-5 * start.norm(),
            "{axes}: gained {gained:?} by {impulse:?}"
        );
    }
}
