//! Efforts of actuators: their derivatives by differences, their place in linearizations, and bodies that bend under them.

use dcb_formats::function::FunctionValue;
use dcb_runtime::Model;
use dcb_runtime::actuator::{Effort, EndStop, Friction, Integral, Limit, Servo};
use dcb_runtime::analysis::eigenmodes::Eigenmodes;
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::evaluation::Evaluation;
use dcb_runtime::{Mechanism, Scene};
use serde_json::{Value, json};

use super::parts::{Folder, number, rigid_scene, scene_text};

/// Effort by a coordinate and its rate.
type Law = Box<dyn Fn(f64, f64) -> Effort>;

/// All laws with their names.
fn laws() -> Vec<(&'static str, Law)> {
    let servo = |limit| Servo {
        proportional: 3.0,
        derivative: 0.4,
        integral: 2.0,
        limit,
        tracking_time: 0.7,
        sample: None,
    };
    let target = FunctionValue {
        value: 0.3,
        rate: -0.2,
        second_rate: 0.0,
    };
    let z = Integral {
        value: 0.1,
        rate: -0.3,
        elapsed: 0.05,
    };
    let of_servo = move |limit| {
        let servo = servo(limit);
        Box::new(move |e, rate| servo.effort(&target, e, rate, &z))
            as Box<dyn Fn(f64, f64) -> Effort>
    };
    let friction = Friction {
        coulomb: 1.0,
        at_rest: 1.6,
        stribeck_rate: 0.3,
        viscous: 0.2,
        regularization: 0.05,
    };
    let stop = EndStop {
        lower: -0.2,
        upper: 0.25,
        stiffness: 40.0,
        damping: 1.5,
        onset: 0.1,
    };
    vec![
        ("servo", of_servo(None)),
        ("hard", of_servo(Some(Limit::Hard(1.0)))),
        ("smooth", of_servo(Some(Limit::Smooth(1.0)))),
        ("friction", Box::new(move |_, rate| friction.effort(rate))),
        ("end stop", Box::new(move |e, rate| stop.effort(e, rate))),
    ]
}

#[test]
fn derivatives_of_efforts_are_those_of_differences() {
    let h = 1e-6;
    for (name, law) in laws() {
        for i in -20..=20 {
            for j in -20..=20 {
                let (e, rate) = (f64::from(i) * 0.0231, f64::from(j) * 0.0517);
                let found = law(e, rate);
                let by_value = (law(e + h, rate).force - law(e - h, rate).force) / (2.0 * h);
                let by_rate = (law(e, rate + h).force - law(e, rate - h).force) / (2.0 * h);
                // Each within a half: kinks of a hard limit are met by no point of this grid.
                assert!(
                    (found.by_value - by_value).abs() < 1e-6,
                    "{name} {e} {rate}"
                );
                assert!((found.by_rate - by_rate).abs() < 1e-6, "{name} {e} {rate}");
            }
        }
    }
}

#[test]
fn a_stop_never_pulls_and_its_heat_is_never_negative() {
    let stop = EndStop {
        lower: -0.2,
        upper: 0.25,
        stiffness: 40.0,
        damping: 15.0,
        onset: 0.1,
    };
    for i in -40..=40 {
        for j in -40..=40 {
            let (e, rate) = (f64::from(i) * 0.02, f64::from(j) * 0.1);
            let force = stop.effort(e, rate).force;
            assert!(force * (e - 0.02) <= 0.0);
            assert!(stop.dissipation(e, rate) >= 0.0);
            let h = 1e-6;
            let slope = (stop.potential(e + h) - stop.potential(e - h)) / (2.0 * h);
            // The force at rest is that of the spring.
            assert!((stop.effort(e, 0.0).force + slope).abs() < 1e-7, "{e}");
        }
    }
}

fn hinged(rest: Value) -> Value {
    let mut text = scene_text(
        3,
        json!({
            "bodies": {"wheel": {"rigid": {"mass": 1, "inertia": [2e-3, 2e-3, 2e-3], "points": {"axle": [0, 0, 0]}}}},
            "joints": {"axle": {"revolute": {"a": "ground", "b": "wheel/axle", "axis": [0, 0, 1]}}},
            "outputs": {"angle": {"joint_coordinate": {"joint": "axle"}}, "rate": {"joint_rate": {"joint": "axle"}}}
        }),
    );
    for (key, value) in rest.as_object().unwrap() {
        text[key] = value.clone();
    }
    text
}

fn modes(text: &Value) -> Eigenmodes {
    let scene = rigid_scene(text);
    let model = Model::load(&scene).unwrap();
    Eigenmodes::at(&model.system, &model.drawn).unwrap()
}

#[test]
fn vibrations_have_the_stiffness_and_damping_of_actuators() {
    let (p, d) = (0.8_f64, 0.01_f64);
    let omega = (p / 2e-3).sqrt();
    let ratio = d / (2.0 * (p * 2e-3).sqrt());
    let servo =
        json!({"servo": {"joint": "axle", "target": 0, "proportional": p, "derivative": d}});
    let viscous = json!({"friction": {"joint": "axle", "viscous": d}});
    let soft = json!({"servo": {"joint": "axle", "target": 0, "proportional": p}});
    let controlled = json!({"torque": {"joint": "axle", "controller": "law"}});
    let stop = json!({"end_stop": {"joint": "axle", "upper": -0.1, "stiffness": p, "damping": d}});
    let law = json!({"law": {"formula": format!("-{p}*angle - {d}*rate")}});
    for rest in [
        json!({"actuators": {"motor": servo}}),
        json!({"actuators": {"motor": soft, "bearing": viscous}}),
        json!({"actuators": {"motor": controlled}, "controllers": law}),
        json!({"actuators": {"stop": stop}}),
    ] {
        let found = modes(&hinged(rest.clone()));
        let mode = &found.modes[0];
        let damped = omega * (1.0 - ratio * ratio).sqrt() / std::f64::consts::TAU;
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-9;
        assert!(
            near(mode.frequency(), damped) || near(mode.frequency(), omega / std::f64::consts::TAU),
            "{rest} {}",
            mode.frequency()
        );
        assert!(
            (mode.damping_ratio() - ratio).abs() < 1e-9,
            "{rest} {}",
            mode.damping_ratio()
        );
    }
}

#[test]
fn what_has_no_linearization_is_refused() {
    for (key, more) in [
        ("sample", json!({"sample": 1e-3})),
        ("integral", json!({"integral": 1.0})),
    ] {
        let mut servo = json!({"joint": "axle", "target": 0, "proportional": 1});
        for (key, value) in more.as_object().unwrap() {
            servo[key] = value.clone();
        }
        let mut text = hinged(json!({"actuators": {"motor": {"servo": servo}}}));
        text["analysis"] = json!({"modes": {"count": 1, "at": "initial"}});
        let error =
            Scene::parse(&text.to_string(), std::path::Path::new("scene.json")).unwrap_err();
        assert!(
            error
                .to_string()
                .contains(&format!("actuators.motor.servo.{key}")),
            "{error}"
        );
    }
}

/// A flexible beam on a hub, both about z, and a second beam hinged to its end: everything in space.
fn flexible_arm(folder: &Folder, rest: Value) -> Scene {
    let mut text = scene_text(
        3,
        json!({
            "gravity": [0, -9.81, 0],
            "bodies": {
                "hub": {"rigid": {"mass": 0.2, "inertia": [1e-3, 1e-3, 1e-3], "points": {"axle": [0, 0, 0]}}},
                "upper": {"superelement": "beam.dcb.h5"},
                "fore": {"superelement": "beam.dcb.h5", "position": [0.3, 0, 0]}
            },
            "joints": {
                "shoulder": {"revolute": {"a": "ground", "b": "hub/axle", "axis": [0, 0, 1]}},
                "root": {"fixed": {"a": "hub/axle", "b": "upper/a"}},
                "elbow": {"revolute": {"a": "upper/b", "b": "fore/a", "axis": [0, 0.2, 1]}}
            },
            "outputs": {
                "angle": {"joint_coordinate": {"joint": "shoulder"}}, "rate": {"joint_rate": {"joint": "shoulder"}},
                "bend": {"joint_coordinate": {"joint": "elbow"}}, "bend_rate": {"joint_rate": {"joint": "elbow"}},
                "tip": {"position": {"at": "fore/b"}}, "tip_velocity": {"velocity": {"at": "fore/b"}},
                "torque": {"actuator_effort": {"actuator": "shoulder"}}
            }
        }),
    );
    for (key, value) in rest.as_object().unwrap() {
        text[key] = value.clone();
    }
    folder.scene(&text)
}

#[test]
fn flexible_arms_under_control_converge_with_the_second_order_and_keep_their_energy() {
    let folder = Folder::with_parts();
    let scene = flexible_arm(
        &folder,
        json!({
            "gravity": [0, 0, 0],
            "controllers": {"elbow": {"formula": "2*(0.5*angle - bend) - 0.02*bend_rate + 0.1*tanh(rate)"}},
            "actuators": {
                "shoulder": {"servo": {"joint": "shoulder", "target": {"smooth_step": {"to": 0.5, "duration": 0.06}},
                    "proportional": 30, "derivative": 0.3, "integral": 50}},
                "elbow": {"torque": {"joint": "elbow", "controller": "elbow"}},
                "bearing": {"friction": {"joint": "elbow", "coulomb": 0.01, "static": 0.015, "stribeck_rate": 1.0,
                    "regularization": 0.5, "viscous": 1e-3}}
            }
        }),
    );
    let end = 0.06;
    let run = |steps: u32| {
        let mut mechanism = Mechanism::start(&scene).unwrap();
        let mut lack = 0.0_f64;
        for _ in 0..steps {
            mechanism.step(end / f64::from(steps)).unwrap();
            lack = lack.max(mechanism.output("energy/balance").unwrap()[7].abs());
        }
        (mechanism.output("tip").unwrap().to_vec(), lack)
    };
    let runs: Vec<_> = [600, 1200, 2400, 9600].map(run).into_iter().collect();
    let exact = &runs[3].0;
    let error = |tip: &[f64]| {
        tip.iter()
            .zip(exact)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max)
    };
    let errors: Vec<f64> = runs[..3].iter().map(|(tip, _)| error(tip)).collect();
    for pair in errors.windows(2) {
        assert!((pair[0] / pair[1]).log2() > 1.8, "{errors:?}");
    }
    for pair in runs[..3].windows(2) {
        assert!(
            (pair[0].1 / pair[1].1).log2() > 1.7,
            "{:?}",
            runs.iter().map(|r| r.1).collect::<Vec<_>>()
        );
    }
}

#[test]
fn an_effort_on_flexible_bodies_is_opposite_on_both() {
    // Momentum about z: only the ground's reactions and gravity change it, and an effort in the elbow is none of them.
    let folder = Folder::with_parts();
    let mut scene = flexible_arm(
        &folder,
        json!({"actuators": {"shoulder": {"torque": {"joint": "elbow", "formula": "0.5*sin(60*t)"}}}}),
    );
    scene.gravity = None;
    scene.joints.swap_remove("shoulder");
    scene.outputs.swap_remove("angle");
    scene.outputs.swap_remove("rate");
    let model = Model::load(&scene).unwrap();
    let method = dcb_runtime::run::rule(&scene.integrator.unwrap());
    let (mut simulation, _) = Simulation::start(
        model.system,
        model.drawn,
        method,
        scene.redundant_constraints,
    )
    .unwrap();
    for _ in 0..400 {
        simulation.step(2e-4).unwrap();
    }
    let state = simulation.state().clone();
    let system = simulation.system().clone();
    let mut evaluation = Evaluation::of(&system);
    evaluation.refresh(&system, &state);
    let found = dcb_runtime::momentum::Momentum::of_all(&system, &state, &evaluation);
    let (linear, angular) = (found.linear, found.angular);
    let moving: f64 = state.velocities.iter().map(|v| v.abs()).fold(0.0, f64::max);
    assert!(moving > 0.5, "{moving}");
    assert!(
        linear.norm() < 1e-6 && angular.norm() < 1e-5,
        "{linear} {angular}"
    );
}

#[test]
fn a_sampled_controller_damps_a_flexible_arm_by_its_tip() {
    let folder = Folder::with_parts();
    let law =
        json!({"hold": {"formula": "-20*angle - 0.3*rate - 0.5*tip_velocity.y", "period": 1e-3}});
    let scene = flexible_arm(
        &folder,
        json!({
            "controllers": law,
            "actuators": {
                "shoulder": {"torque": {"joint": "shoulder", "controller": "hold"}},
                "elbow": {"servo": {"joint": "elbow", "target": 0, "proportional": 20, "derivative": 0.1}}
            }
        }),
    );
    let mut defects = Vec::new();
    for steps in [5, 10, 20] {
        let mut mechanism = Mechanism::start(&scene).unwrap();
        let mut lack = 0.0_f64;
        for _ in 0..60 * steps {
            mechanism.step(1e-3 / f64::from(steps)).unwrap();
            lack = lack.max(mechanism.output("energy/balance").unwrap()[7].abs());
        }
        assert!(number(&mut mechanism, "torque").is_finite());
        defects.push(lack);
    }
    assert!(defects[2] < defects[0], "{defects:?}");
    // Static compatibility, whose interfaces follow their forces: controllers follow with them.
    let scene = flexible_arm(
        &folder,
        json!({
            "compatibility": "static",
            "controllers": {"hold": {"formula": "-0.5*angle - 0.01*rate - 0.1*bend"}},
            "actuators": {
                "shoulder": {"torque": {"joint": "shoulder", "controller": "hold"}},
                "elbow": {"servo": {"joint": "elbow", "target": 0, "proportional": 0.1, "derivative": 1e-3}}
            }
        }),
    );
    let mut mechanism = Mechanism::start(&scene).unwrap();
    let mut most = 0;
    for _ in 0..300 {
        most = most.max(mechanism.step(2e-4).unwrap().iterations);
    }
    assert!(most <= 8, "{most}");
}
