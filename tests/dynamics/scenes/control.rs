//! A program in charge: inputs between steps, saving and restoring, and what it can't ask for.

use dcb_runtime::{Error, Mechanism};
use serde_json::json;

use dcb_samples::{SpatialBeam, spatial_beam};

use super::parts::{Folder, number, scene_text, started, store};

/// A block hinged to a flexible rod on a hub that turns on the ground, with a torque on the hub to be set from outside.
fn mechanism(folder: &Folder) -> Mechanism {
    let scene = folder.scene(&scene_text(
        2,
        json!({
            "gravity": [0, -9.81],
            "bodies": {
                "hub": {"rigid": {"mass": 0.2, "inertia": 1e-3, "points": {"axle": [0, 0]}}},
                "rod": {"superelement": "rod.dcb.h5"},
                "block": {"rigid": {"mass": 0.1, "inertia": 1e-4, "points": {"pin": [0, 0.01]}}, "position": [0.3, -0.01]}
            },
            "joints": {
                "shoulder": {"revolute": {"a": "ground", "b": "hub/axle"}},
                "root": {"fixed": {"a": "hub/axle", "b": "rod/a"}},
                "wrist": {"revolute": {"a": "rod/b", "b": "block/pin"}}
            },
            "loads": {"motor": {"torque": {"at": "hub/axle", "components": [{"input": {"initial": 0}}]}}},
            "outputs": {
                "angle": {"joint_coordinate": {"joint": "shoulder"}}, "rate": {"joint_rate": {"joint": "shoulder"}},
                "tip": {"orientation": {"at": "rod/b"}}
            }
        }),
    ));
    Mechanism::start(&scene).unwrap()
}

/// A proportional and differential law about the drawn placement, for some steps.
fn control(mechanism: &mut Mechanism, steps: usize) {
    for _ in 0..steps {
        let (angle, rate) = (number(mechanism, "angle"), number(mechanism, "rate"));
        mechanism
            .set_input("motor", 0.9 - 6.0 * angle - 0.2 * rate)
            .unwrap();
        mechanism.step(1e-4).unwrap();
    }
}

/// What is set between steps acts from then on, in full: as a controller inside the scene that samples at the same times.
#[test]
fn a_law_around_the_mechanism_is_the_sampled_controller_within() {
    let folder = Folder::with_parts();
    let scene = |motor: serde_json::Value, controllers: serde_json::Value| {
        let text = scene_text(
            2,
            json!({
                "gravity": [0, -9.81],
                "integrator": {"generalized_alpha": {"step": 1e-4, "end": 1}},
                "bodies": {
                    "hub": {"rigid": {"mass": 0.2, "inertia": 1e-3, "points": {"axle": [0, 0]}}},
                    "rod": {"superelement": "rod.dcb.h5"}
                },
                "joints": {
                    "shoulder": {"revolute": {"a": "ground", "b": "hub/axle"}},
                    "root": {"fixed": {"a": "hub/axle", "b": "rod/a"}}
                },
                "actuators": {"motor": {"torque": motor}},
                "controllers": controllers,
                "outputs": {
                    "angle": {"joint_coordinate": {"joint": "shoulder"}}, "rate": {"joint_rate": {"joint": "shoulder"}},
                    "tip": {"position": {"at": "rod/b"}}
                }
            }),
        );
        Mechanism::start(&folder.scene(&text)).unwrap()
    };
    let (step, every) = (1e-4, 5);
    let mut within = scene(
        json!({"joint": "shoulder", "controller": "law"}),
        json!({"law": {"formula": "0.9 - 6*angle - 0.2*rate", "period": step * f64::from(every)}}),
    );
    let mut around = scene(
        json!({"joint": "shoulder", "input": {"initial": 0}}),
        json!({}),
    );
    let mut largest: f64 = 0.0;
    for count in 0..500 {
        if count % every == 0 {
            let law = 0.9 - 6.0 * number(&mut around, "angle") - 0.2 * number(&mut around, "rate");
            around.set_input("motor", law).unwrap();
        }
        around.step(step).unwrap();
        within.step(step).unwrap();
        // Where the controller within samples, forces are those behind the jump already.
        let forces = ((count + 1) % every != 0).then_some("reactions/shoulder");
        for name in ["angle", "rate", "tip"].into_iter().chain(forces) {
            let expected = within.output(name).unwrap().to_vec();
            let found = around.output(name).unwrap();
            let size = expected
                .iter()
                .fold(1.0, |most: f64, one| most.max(one.abs()));
            for (found, expected) in found.iter().zip(&expected) {
                assert!(
                    (found - expected).abs() < 1e-6 * size,
                    "{count} {name}: {found} {expected}"
                );
            }
        }
        largest = largest.max(number(&mut within, "angle").abs());
    }
    assert!(largest > 1e-3, "{largest}");
    let balance = |mechanism: &mut Mechanism| mechanism.output("energy/balance").unwrap().to_vec();
    let (found, expected) = (balance(&mut around), balance(&mut within));
    for (found, expected) in found.iter().zip(&expected) {
        assert!((found - expected).abs() < 1e-9, "{found} {expected}");
    }
}

/// Torques that jump at every sample make no motion ring that the steps are too long for: steel links, of which most periods are shorter than a step.
#[test]
fn sampled_torques_on_stiff_links_need_no_short_steps() {
    let folder = Folder::with_parts();
    store(
        &spatial_beam(&SpatialBeam::default()),
        &folder.place.path().join("link.dcb.h5"),
    );
    let scene = folder.scene(&scene_text(
        3,
        json!({
            "gravity": [0, 0, -9.81],
            "bodies": {"upper": {"superelement": "link.dcb.h5"}, "lower": {"superelement": "link.dcb.h5", "position": [1, 0, 0]}},
            "joints": {
                "shoulder": {"revolute": {"a": "ground", "b": "upper/a", "axis": [0, 1, 0]}},
                "elbow": {"universal": {"a": "upper/b", "b": "lower/a", "axis": [0, 1, 0], "axis_b": [0, 0, 1]}}
            },
            "actuators": {"motor": {"torque": {"joint": "shoulder", "controller": "law"}}},
            "controllers": {"law": {"formula": "-40*(angle + 0.1) - 4*rate", "period": 2e-3}},
            "outputs": {"angle": {"joint_coordinate": {"joint": "shoulder"}}, "rate": {"joint_rate": {"joint": "shoulder"}}}
        }),
    ));
    let mut arm = Mechanism::start(&scene).unwrap();
    let mut energies = Vec::new();
    for _ in 0..300 {
        arm.step(1e-3).unwrap();
        energies.push(arm.output("energy/balance").unwrap().to_vec());
    }
    let most = energies
        .iter()
        .flatten()
        .fold(0.0, |most: f64, one| most.max(one.abs()));
    let defect = energies.last().unwrap().last().unwrap().abs();
    assert!(most > 1.0 && defect < 2e-2 * most, "{defect} of {most}");
}

#[test]
fn a_restored_run_goes_on_to_the_last_bit() {
    let folder = Folder::with_parts();
    let mut one = mechanism(&folder);
    control(&mut one, 150);
    let saved = one.save();
    control(&mut one, 200);
    // Back in the same mechanism, and on in one that has only been started.
    let state = one.simulation().state().clone();
    let outputs = ["tip", "energy/balance", "reactions/wrist"];
    let values = outputs.map(|name| one.output(name).unwrap().to_vec());
    one.restore(&saved).unwrap();
    assert!((one.time() - 0.015).abs() < 1e-12);
    control(&mut one, 200);
    let mut other = mechanism(&folder);
    other.restore(&saved).unwrap();
    control(&mut other, 200);
    for mechanism in [&mut one, &mut other] {
        assert_eq!(mechanism.simulation().state(), &state);
        for (name, values) in outputs.iter().zip(&values) {
            assert_eq!(mechanism.output(name).unwrap(), values, "{name}");
        }
    }
}

/// In space too, from any number of steps on: nothing of the steps before is left in what solves for the next.
#[test]
fn a_restored_run_in_space_goes_on_to_the_last_bit() {
    let folder = Folder::with_parts();
    let scene = folder.scene(&scene_text(
        3,
        json!({
            "gravity": [0, 0, -9.81],
            "bodies": {"upper": {"superelement": "beam.dcb.h5"}, "lower": {"superelement": "beam.dcb.h5", "position": [0.3, 0, 0]}},
            "joints": {
                "shoulder": {"revolute": {"a": "ground", "b": "upper/a", "axis": [0, 1, 0]}},
                "elbow": {"universal": {"a": "upper/b", "b": "lower/a", "axis": [0, 1, 0], "axis_b": [0, 0, 1]}}
            }
        }),
    ));
    for before in 3..30 {
        let mut arm = Mechanism::start(&scene).unwrap();
        let go = |arm: &mut Mechanism, steps: usize| {
            for _ in 0..steps {
                arm.step(5e-4).unwrap();
            }
        };
        go(&mut arm, before);
        let saved = arm.save();
        go(&mut arm, 20);
        let state = arm.simulation().state().clone();
        arm.restore(&saved).unwrap();
        go(&mut arm, 20);
        assert_eq!(arm.simulation().state(), &state, "after {before} steps");
    }
}

/// A program may take any step after any other: rounding of a short one isn't enlarged by a long one behind it.
#[test]
fn a_much_longer_step_has_the_forces_of_the_motion() {
    let scene = scene_text(
        2,
        json!({
            "gravity": [0, -9.81],
            "bodies": {"bob": {"rigid": {"mass": 1, "inertia": 1e-6, "points": {"pivot": [-0.5, 0]}}, "position": [0.5, 0]}},
            "joints": {"hinge": {"revolute": {"a": "ground", "b": "bob/pivot"}}},
            "outputs": {"angle": {"joint_coordinate": {"joint": "hinge"}}, "force": {"reaction": {"joint": "hinge"}}}
        }),
    );
    for (short, count) in [(1e-4, 2000), (1e-5, 20_000), (1e-6, 20_000), (1e-6, 60_000)] {
        for long in [10.0, 100.0, 1000.0].map(|growth| growth * short) {
            if long > 1e-3 {
                continue;
            }
            let mut bob = started(&scene);
            for _ in 0..count {
                bob.step(short).unwrap();
            }
            bob.step(long).unwrap();
            let angle = number(&mut bob, "angle");
            let force = bob.output("force").unwrap();
            let found = force[0].hypot(force[1]);
            // m (r ω² + g sin) along the bar, with r ω² = 2 g sin of energy; m g cos is the motion's.
            let expected = 3.0 * 9.81 * angle.sin().abs();
            assert!(
                (found / expected - 1.0).abs() < 2e-3,
                "{short:e} {count} {long:e}: {found} {expected}"
            );
        }
    }
}

#[test]
fn reading_outputs_changes_nothing() {
    let folder = Folder::with_parts();
    let (mut watched, mut alone) = (mechanism(&folder), mechanism(&folder));
    for _ in 0..50 {
        for mechanism in [&mut watched, &mut alone] {
            mechanism.set_input("motor", 0.3).unwrap();
            mechanism.step(2e-4).unwrap();
        }
        watched.output("energy/balance").unwrap();
        watched.output("reactions/wrist").unwrap();
    }
    assert_eq!(watched.simulation().state(), alone.simulation().state());
}

#[test]
fn a_controller_holds_the_arm_up() {
    let folder = Folder::with_parts();
    let mut mechanism = mechanism(&folder);
    control(&mut mechanism, 20000);
    // Statics: the torque carries the weight of rod and block; the arm hangs a little lower than drawn.
    let (angle, rate) = (
        number(&mut mechanism, "angle"),
        number(&mut mechanism, "rate"),
    );
    let torque = 0.9 - 6.0 * angle - 0.2 * rate;
    assert!(rate.abs() < 0.05 && angle.abs() < 0.2, "{angle}, {rate}");
    let rod = 1000.0 * std::f64::consts::PI * 0.015_f64.powi(2) * 0.3;
    let weight = 9.81 * (rod * 0.15 + 0.1 * 0.3);
    assert!(
        (torque - weight).abs() < 0.1 * weight,
        "{torque}, expected about {weight}"
    );
}

#[test]
fn what_cannot_be_meant_is_refused_and_leaves_the_motion_alone() {
    let folder = Folder::with_parts();
    let mut arm = mechanism(&folder);
    control(&mut arm, 3);
    let before = arm.simulation().state().clone();
    for step in [0.0, -1e-3, f64::NAN, f64::INFINITY] {
        assert!(
            matches!(arm.step(step), Err(Error::BadNumber { .. })),
            "{step}"
        );
    }
    let error = arm.set_input("motor", f64::NAN).unwrap_err();
    assert!(
        error.to_string().contains("input \"motor\" is NaN"),
        "{error}"
    );
    let error = arm.set_input("engine", 1.0).unwrap_err();
    assert!(error.to_string().contains("known are motor"), "{error}");
    let error = arm.output("agle").unwrap_err();
    assert!(
        error.to_string().contains("did you mean `angle`?"),
        "{error}"
    );
    let mut block = started(&scene_text(
        2,
        json!({"bodies": {"block": {"rigid": {"mass": 1, "inertia": 1, "points": {}}}}}),
    ));
    let error = arm.restore(&block.save()).unwrap_err();
    assert!(matches!(error, Error::ForeignSnapshot), "{error}");
    assert_eq!(arm.simulation().state(), &before);
    // A step that fails leaves the motion where it was, and a smaller one goes on from there.
    arm.set_input("motor", 1e300).unwrap();
    assert!(arm.step(1e-3).is_err());
    arm.set_input("motor", 0.0).unwrap();
    assert_eq!(arm.time(), before.time);
    arm.step(1e-4).unwrap();
}

/// The examples are programs that run to their end.
#[test]
fn the_examples_run() {
    super::mechanism_in_rust::main().unwrap();
    super::control_loop::main().unwrap();
}
