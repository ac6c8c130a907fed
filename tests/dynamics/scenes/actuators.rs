//! Actuators on joints, against closed forms: what a coordinate does under an effort, and where the energy goes.

use dcb_runtime::integrator::adaptive::{AdaptiveStep, StepSize};
use dcb_runtime::simulation::Simulation;
use dcb_runtime::{Mechanism, Model};
use serde_json::{Value, json};

use super::parts::{number, rigid_scene, scene_text, started};

const MASS: f64 = 0.5;
const INERTIA: f64 = 2e-3;

/// A block on a slide or a hinge of the ground, without gravity; `rest` is added.
fn block(dimension: u32, joint: &str, rest: &Value) -> Value {
    let d = dimension as usize;
    let inertia = match dimension {
        2 => json!(INERTIA),
        _ => json!([1.3 * INERTIA, 1.2 * INERTIA, INERTIA]),
    };
    let axis = match joint {
        "prismatic" => Some(&[1.0, 0.0, 0.0][..d]),
        _ => (d == 3).then_some(&[0.0, 0.0, 1.0][..]),
    };
    let mut held = json!({"a": "ground", "b": "block/pin"});
    if let Some(axis) = axis {
        held["axis"] = json!(axis);
    }
    let mut text = scene_text(
        dimension,
        json!({
            "bodies": {"block": {
                "rigid": {"mass": MASS, "inertia": inertia, "points": {"pin": &[0.0; 3][..d]}}
            }},
            "joints": {"joint": {joint: held}},
            "outputs": {
                "q": {"joint_coordinate": {"joint": "joint"}}, "rate": {"joint_rate": {"joint": "joint"}},
                "effort": {"actuator_effort": {"actuator": "motor"}}
            }
        }),
    );
    for (key, value) in rest.as_object().unwrap() {
        text[key] = value.clone();
    }
    text
}

fn motor(actuator: Value) -> Value {
    json!({"actuators": {"motor": actuator}})
}

/// Defect of the energy balance by the largest work or stored energy at a time.
fn imbalance(mechanism: &mut Mechanism) -> f64 {
    let [defect, largest] = balance(mechanism);
    defect / largest
}

/// Defect of the energy balance, and the largest work or stored energy.
fn balance(mechanism: &mut Mechanism) -> [f64; 2] {
    let values = mechanism.output("energy/balance").unwrap();
    let (defect, rest) = values.split_last().unwrap();
    let largest = rest
        .iter()
        .fold(0.0_f64, |most, value| most.max(value.abs()));
    [defect.abs(), largest]
}

#[test]
fn a_step_of_torque_turns_by_half_its_acceleration_times_the_time_squared() {
    for dimension in [2, 3] {
        for (joint, kind, inertia) in [
            ("revolute", "torque", INERTIA),
            ("prismatic", "force", MASS),
        ] {
            let actuator = json!({kind: {"joint": "joint", "constant": 0.03}});
            let mut mechanism = started(&block(dimension, joint, &motor(actuator)));
            for _ in 0..200 {
                mechanism.step(1e-3).unwrap();
            }
            let expected = 0.5 * 0.03 / inertia * 0.2 * 0.2;
            let found = number(&mut mechanism, "q");
            assert!(
                (found / expected - 1.0).abs() < 1e-10,
                "{joint} {found} {expected}"
            );
            assert_eq!(number(&mut mechanism, "effort"), 0.03);
            assert!(imbalance(&mut mechanism) < 1e-10);
        }
    }
}

#[test]
fn an_input_is_the_effort() {
    let actuator = json!({"torque": {"joint": "joint", "input": {"initial": 0.0}}});
    let mut mechanism = started(&block(2, "revolute", &motor(actuator)));
    mechanism.step(1e-3).unwrap();
    assert_eq!(number(&mut mechanism, "rate"), 0.0);
    mechanism.set_input("motor", 0.5).unwrap();
    mechanism.step(1e-3).unwrap();
    assert_eq!(number(&mut mechanism, "effort"), 0.5);
}

#[test]
fn a_servo_without_integral_is_a_damped_oscillator() {
    let (p, d) = (0.8, 0.01);
    let omega = (p / INERTIA).sqrt();
    let zeta = d / (2.0 * (p * INERTIA).sqrt());
    let damped = omega * (1.0 - zeta * zeta).sqrt();
    let end = 0.3;
    let mut errors = Vec::new();
    for steps in [300, 600, 1200] {
        let servo =
            json!({"servo": {"joint": "joint", "target": 0.4, "proportional": p, "derivative": d}});
        let mut mechanism = started(&block(3, "revolute", &motor(servo)));
        let (mut worst, mut lack) = (0.0_f64, 0.0_f64);
        for _ in 0..steps {
            mechanism.step(end / f64::from(steps)).unwrap();
            let t = mechanism.time();
            let swing = (damped * t).cos() + zeta * omega / damped * (damped * t).sin();
            let expected = 0.4 * (1.0 - (-zeta * omega * t).exp() * swing);
            worst = worst.max((number(&mut mechanism, "q") - expected).abs());
            lack = lack.max(balance(&mut mechanism)[0]);
        }
        errors.push([worst, lack]);
    }
    for pair in errors.windows(2) {
        for (coarse, fine) in pair[0].iter().zip(pair[1]) {
            let order = (coarse / fine).log2();
            assert!(order > 1.9, "{errors:?}");
        }
    }
    assert!(errors[2][0] < 1e-4, "{errors:?}");
}

#[test]
fn dry_friction_stops_a_block_where_its_energy_is_spent() {
    let (coulomb, speed) = (2.0, 1.5);
    let friction =
        json!({"friction": {"joint": "joint", "coulomb": coulomb, "regularization": 1e-5}});
    let mut text = block(2, "prismatic", &motor(friction));
    text["bodies"]["block"]["velocity"] = json!([speed, 0]);
    let mut mechanism = started(&text);
    let deceleration = coulomb / MASS;
    let stop = speed / deceleration;
    let step = 1e-4;
    let mut stopped = None;
    while mechanism.time() < 1.2 * stop {
        mechanism.step(step).unwrap();
        if stopped.is_none() && number(&mut mechanism, "rate") < 1e-3 * speed {
            stopped = Some(mechanism.time());
        }
    }
    let distance = number(&mut mechanism, "q");
    let expected = 0.5 * speed * speed / deceleration;
    assert!(
        (distance / expected - 1.0).abs() < 1e-4,
        "{distance} {expected}"
    );
    assert!(
        (stopped.unwrap() - stop).abs() < 2e-3 * stop,
        "{stopped:?} {stop}"
    );
    assert!(imbalance(&mut mechanism) < 1e-4);
    // It sticks.
    assert!(number(&mut mechanism, "rate").abs() < 1e-9);
    let dissipated = mechanism.output("energy/balance").unwrap()[6];
    assert!((dissipated / (0.5 * MASS * speed * speed) - 1.0).abs() < 1e-4);
}

#[test]
fn viscous_friction_slows_exponentially() {
    let friction = json!({"friction": {"joint": "joint", "viscous": 4.0}});
    let mut text = block(3, "prismatic", &motor(friction));
    text["bodies"]["block"]["velocity"] = json!([1.5, 0, 0]);
    let mut mechanism = started(&text);
    for _ in 0..1000 {
        mechanism.step(2e-4).unwrap();
    }
    let expected = 1.5 * (-4.0 / MASS * 0.2_f64).exp();
    let found = number(&mut mechanism, "rate");
    assert!((found / expected - 1.0).abs() < 1e-5, "{found} {expected}");
}

/// The restitution of a linear spring with a damper that never pulls: the contact ends where the force is zero.
fn restitution(zeta: f64) -> f64 {
    let root = (1.0 - zeta * zeta).sqrt();
    // Force zero: k x + c x' = 0, first after the contact begins.
    let angle = (2.0 * zeta * root).atan2(2.0 * zeta * zeta - 1.0);
    (-zeta / root * angle).exp()
}

#[test]
fn a_block_bounces_off_an_end_stop_as_a_spring_and_damper_that_never_pull() {
    // Schwager and Poeschel, Granular Matter 9 (2007), equation 23.
    let (stiffness, zeta, speed, way) = (2000.0, 0.2, 1.0, 0.01);
    let damping = 2.0 * zeta * (stiffness * MASS).sqrt();
    let stop = json!({"end_stop": {"joint": "joint", "upper": way, "stiffness": stiffness, "damping": damping}});
    let mut text = block(2, "prismatic", &motor(stop));
    text["bodies"]["block"]["velocity"] = json!([speed, 0]);
    let mut mechanism = started(&text);
    for _ in 0..12000 {
        mechanism.step(1e-5).unwrap();
        let effort = number(&mut mechanism, "effort");
        assert!(effort <= 1e-6, "{effort:e} at {}", mechanism.time());
    }
    let found = -number(&mut mechanism, "rate") / speed;
    assert!(
        (found / restitution(zeta) - 1.0).abs() < 1e-3,
        "{found} {}",
        restitution(zeta)
    );
    let contacts = mechanism.simulation().contacts();
    assert_eq!(contacts.len(), 1);
    assert!(
        (contacts[0].time - way / speed).abs() < 1e-9,
        "{contacts:?}"
    );
    assert!((contacts[0].rate - speed).abs() < 1e-2);
    assert!(imbalance(&mut mechanism) < 1e-3);
    // Without a damper nothing is lost.
    text["actuators"]["motor"]["end_stop"]["damping"] = json!(0);
    text["actuators"]["motor"]["end_stop"]["lower"] = json!(-way);
    text["actuators"]["motor"]["end_stop"]["onset"] = json!(2e-3);
    let mut mechanism = started(&text);
    for _ in 0..20000 {
        mechanism.step(1e-5).unwrap();
    }
    let contacts = mechanism.simulation().contacts();
    assert!(contacts.len() >= 2, "{contacts:?}");
    assert_eq!(contacts[1].end.name(), "lower");
    assert!((contacts[1].rate + speed).abs() < 1e-4, "{contacts:?}");
}

#[test]
fn a_servo_at_its_limit_accelerates_and_brakes_with_it() {
    // Bang-bang: with great gains the effort is at one limit up to the line p d + k d' = 0, and then at the other along it.
    let (limit, target) = (0.05, 1.0);
    for saturation in ["hard", "smooth"] {
        let servo = json!({"servo": {
            "joint": "joint", "target": target, "proportional": 400, "derivative": 60, "limit": limit, "saturation": saturation
        }});
        let mut mechanism = started(&block(2, "revolute", &motor(servo)));
        let acceleration = limit / INERTIA;
        // The rate at which p d = k q' is met: q = a t²/2, q' = a t.
        let k = 60.0 / 400.0;
        let meets = -k + (k * k + 2.0 * target / acceleration).sqrt();
        let steps = 1000;
        let (mut worst, mut most) = (0.0_f64, 0.0_f64);
        for _ in 0..steps {
            mechanism.step(0.98 * meets / f64::from(steps)).unwrap();
            let t = mechanism.time();
            worst = worst.max((number(&mut mechanism, "q") - 0.5 * acceleration * t * t).abs());
            assert!(number(&mut mechanism, "effort") <= limit);
            most = most.max(balance(&mut mechanism)[1]);
        }
        assert!(worst < 1e-9, "{saturation} {worst:e}");
        // It slides along the line to the target.
        for _ in 0..4000 {
            mechanism.step(1e-3).unwrap();
            assert!(number(&mut mechanism, "effort").abs() <= limit);
        }
        assert!((number(&mut mechanism, "q") - target).abs() < 1e-8);
        let [defect, _] = balance(&mut mechanism);
        assert!(defect < 1e-3 * most, "{defect:e} {most:e}");
    }
}

#[test]
fn a_sampled_servo_is_a_difference_equation() {
    let (p, d, i, target, period) = (0.8, 0.02, 3.0, 0.4, 5e-3);
    let servo = json!({"servo": {
        "joint": "joint", "target": target, "proportional": p, "derivative": d, "integral": i, "sample": period
    }});
    let text = block(3, "revolute", &motor(servo));
    let run_with = |steps: u32| {
        let mut mechanism = started(&text);
        let (mut q, mut v, mut z) = (0.0_f64, 0.0_f64, 0.0_f64);
        let mut worst = 0.0_f64;
        for _ in 0..100 {
            let u = p * (target - q) - d * v + i * z;
            z += period * (target - q);
            for _ in 0..steps {
                mechanism.step(period / f64::from(steps)).unwrap();
            }
            let a = u / INERTIA;
            q += period * v + 0.5 * period * period * a;
            v += period * a;
            worst = worst.max((number(&mut mechanism, "q") - q).abs());
        }
        assert!(imbalance(&mut mechanism) < 1e-9);
        worst
    };
    for steps in [1, 5] {
        let worst = run_with(steps);
        assert!(worst < 1e-10, "{steps}: {worst:e}");
    }
    let mut mechanism = started(&text);
    mechanism.step(4e-3).unwrap();
    let refused = mechanism.step(2e-3).unwrap_err().to_string();
    assert!(refused.contains("would pass the sample"), "{refused}");
}

#[test]
fn an_integral_takes_away_what_a_constant_load_leaves_and_does_not_wind_up() {
    let servo = |more: Value| {
        let mut servo = json!({"joint": "joint", "target": 0.4, "proportional": 0.8, "derivative": 0.03, "integral": 4.0});
        for (key, value) in more.as_object().unwrap() {
            servo[key] = value.clone();
        }
        json!({
            "actuators": {"motor": {"servo": servo}},
            "loads": {"brake": {"torque": {"at": "block/pin", "components": [-0.05]}}}
        })
    };
    for more in [
        json!({}),
        json!({"limit": 0.08}),
        json!({"limit": 0.08, "saturation": "smooth"}),
    ] {
        let mut mechanism = started(&block(2, "revolute", &servo(more.clone())));
        let mut most = 0.0_f64;
        for _ in 0..12000 {
            mechanism.step(1e-3).unwrap();
            most = most.max(number(&mut mechanism, "q"));
        }
        assert!((number(&mut mechanism, "q") - 0.4).abs() < 1e-6, "{more}");
        assert!(
            (number(&mut mechanism, "effort") - 0.05).abs() < 1e-6,
            "{more}"
        );
        assert!(most < 0.75, "{more} {most}");
    }
}

#[test]
fn a_restored_servo_goes_on_to_the_last_bit() {
    let rest = json!({"actuators": {
        "motor": {"servo": {"joint": "joint", "target": 0.4, "proportional": 0.8, "derivative": 0.03, "integral": 4.0, "limit": 0.05}},
        "sampled": {"servo": {"joint": "joint", "target": 0.1, "proportional": 0.2, "integral": 1.0, "sample": 0.01}},
        "stop": {"end_stop": {"joint": "joint", "upper": 0.2, "stiffness": 20, "damping": 0.05, "onset": 0.01}},
        "bearing": {"friction": {"joint": "joint", "coulomb": 1e-3, "static": 2e-3, "stribeck_rate": 0.1, "regularization": 1e-2}}
    }});
    let mut one = started(&block(2, "revolute", &rest));
    let advance = |mechanism: &mut Mechanism| {
        for _ in 0..333 {
            mechanism.step(1e-3).unwrap();
        }
    };
    advance(&mut one);
    let saved = one.save();
    advance(&mut one);
    let state = one.simulation().state().clone();
    let mut other = started(&block(2, "revolute", &rest));
    other.restore(&saved).unwrap();
    advance(&mut other);
    assert_eq!(other.simulation().state(), &state);
    assert!(one.simulation().state().memory.iter().any(|x| *x != 0.0));
}

#[test]
fn units_change_nothing() {
    // Metres, kilograms and seconds, and millimetres, tonnes and milliseconds.
    let run_in = |length: f64, mass: f64, time: f64| {
        let force = mass * length / (time * time);
        let mut text = block(
            2,
            "prismatic",
            &json!({"actuators": {
                "motor": {"servo": {"joint": "joint", "target": 0.4 * length, "proportional": 30.0 * force / length,
                    "derivative": 2.0 * force * time / length, "integral": 20.0 * force / (length * time), "limit": 3.0 * force}},
                "rail": {"friction": {"joint": "joint", "coulomb": 0.2 * force, "static": 0.5 * force, "stribeck_rate": 0.05 * length / time,
                    "regularization": 1e-3 * length / time, "viscous": 0.3 * force * time / length}},
                "stop": {"end_stop": {"joint": "joint", "upper": 0.42 * length, "stiffness": 2e3 * force / length,
                    "damping": 5.0 * force * time / length, "onset": 1e-3 * length}}
            }}),
        );
        text["bodies"]["block"]["rigid"]["mass"] = json!(MASS * mass);
        text["bodies"]["block"]["rigid"]["inertia"] = json!(INERTIA * mass * length * length);
        let mut mechanism = started(&text);
        for _ in 0..2000 {
            mechanism.step(1e-3 * time).unwrap();
        }
        let energy = mechanism.output("energy/balance").unwrap()[6] / (force * length);
        (
            number(&mut mechanism, "q") / length,
            number(&mut mechanism, "effort") / force,
            energy,
        )
    };
    let (si, small) = (run_in(1.0, 1.0, 1.0), run_in(1e3, 1e-3, 1e3));
    for (a, b) in [(si.0, small.0), (si.1, small.1), (si.2, small.2)] {
        assert!((a - b).abs() < 1e-6 * a.abs().max(1e-2), "{si:?} {small:?}");
    }
}

#[test]
fn adaptive_steps_end_at_samples() {
    let servo = json!({"servo": {"joint": "joint", "target": 0.4, "proportional": 0.8, "derivative": 0.02, "sample": 0.013}});
    let mut text = block(2, "revolute", &motor(servo));
    text["integrator"] = json!({"generalized_alpha": {"step": 1e-3, "end": 0.26,
        "adaptive": {"tolerance": 1e-6, "minimum_step": 1e-9, "maximum_step": 0.1}}});
    let scene = rigid_scene(&text);
    let integrator = scene.integrator.unwrap();
    let model = Model::load(&scene).unwrap();
    let (mut simulation, _) = Simulation::start(
        model.system,
        model.drawn,
        dcb_runtime::run::rule(&integrator),
        scene.redundant_constraints,
    )
    .unwrap();
    let mut size = StepSize::new(AdaptiveStep {
        tolerance: 1e-6,
        first: 1e-3,
        smallest: 1e-9,
        largest: 0.1,
    });
    let mut times = Vec::new();
    simulation
        .advance_to(0.26, &mut size, &mut |state| times.push(state.time))
        .unwrap();
    for k in 1..=20 {
        let sample = f64::from(k) * 0.013;
        assert!(
            times.iter().any(|time| (time - sample).abs() < 1e-12),
            "{sample}"
        );
    }
    let (mut angle, mut rate) = (0.0_f64, 0.0_f64);
    for _ in 0..20 {
        let a = (0.8 * (0.4 - angle) - 0.02 * rate) / INERTIA;
        angle += 0.013 * rate + 0.5 * 0.013 * 0.013 * a;
        rate += 0.013 * a;
    }
    let row = simulation.system().actuators[0].row;
    let found = simulation.evaluation().values[row];
    assert!((found - angle).abs() < 1e-9, "{found} {angle}");
}

#[test]
fn a_continuous_controller_is_a_servo_written_as_a_formula() {
    let servo = json!({"servo": {"joint": "joint", "target": 0.4, "proportional": 0.8, "derivative": 0.01}});
    let formula = json!({
        "constants": {"goal": 0.4},
        "controllers": {"law": {"formula": "0.8*(goal - q) - 0.01*rate"}},
        "actuators": {"motor": {"torque": {"joint": "joint", "controller": "law"}}}
    });
    let mut one = started(&block(3, "revolute", &motor(servo)));
    let mut other = started(&block(3, "revolute", &formula));
    for _ in 0..400 {
        one.step(1e-3).unwrap();
        other.step(1e-3).unwrap();
        let (a, b) = (number(&mut one, "q"), number(&mut other, "q"));
        assert!((a - b).abs() < 1e-8, "{a} {b}");
    }
    assert!(balance(&mut other)[0] < 1e-3 * balance(&mut other)[1].max(1e-2));
}

/// Two blocks on slides of the ground; the force on one follows the other.
fn coupled(gain: f64, formula: &str) -> Value {
    let block = |y: f64| json!({"rigid": {"mass": MASS, "inertia": INERTIA, "points": {"pin": [0, 0]}}, "position": [0, y]});
    let slide =
        |home: &str, body: &str| json!({"prismatic": {"a": home, "b": body, "axis": [1, 0]}});
    let of = |joint: &str| json!({"joint": joint});
    let mut second = block(0.1);
    second["velocity"] = json!([1.0, 0.0]);
    scene_text(
        2,
        json!({
            "ground": {"points": {"up": [0, 0.1]}},
            "constants": {"k": gain},
            "bodies": {"one": block(0.0), "two": second},
            "joints": {"first": slide("ground", "one/pin"), "second": slide("ground/up", "two/pin")},
            "controllers": {"law": {"formula": formula}},
            "actuators": {
                "motor": {"force": {"joint": "first", "controller": "law"}},
                "spring": {"servo": {"joint": "second", "target": 0, "proportional": gain}}
            },
            "outputs": {
                "q": {"joint_coordinate": of("first")}, "rate": {"joint_rate": of("first")},
                "p": {"joint_coordinate": of("second")}, "p_rate": {"joint_rate": of("second")}
            }
        }),
    )
}

#[test]
fn a_stiff_controller_that_follows_another_joint_converges_as_newton_does() {
    // The first follows the second, u = 3 k (p - q) - c q', so stiff that an iteration without the coupling would diverge.
    let gain = 4e5;
    let text = coupled(gain, "3*k*(p - q) - 900*rate");
    let mut mechanism = started(&text);
    let mut worst = 0;
    for _ in 0..2000 {
        worst = worst.max(mechanism.step(1e-3).unwrap().iterations);
    }
    assert!(worst <= 4, "{worst}");
    // The unsymmetric equations of both, by their own exponential: x' = A x with 0.1 of the step.
    let mut x = [0.0, 0.0, 0.0, 1.0];
    let soft = coupled(400.0, "3*k*(p - q) - 20*rate");
    let mut mechanism = started(&soft);
    let rate = |x: &[f64; 4]| {
        let u = 3.0 * 400.0 * (x[2] - x[0]) - 20.0 * x[1];
        [x[1], u / MASS, x[3], -400.0 * x[2] / MASS]
    };
    for _ in 0..1000 {
        mechanism.step(2e-4).unwrap();
        for _ in 0..2 {
            let h = 1e-4;
            let at = |k: &[f64; 4], part: f64| std::array::from_fn(|i| x[i] + part * h * k[i]);
            let a = rate(&x);
            let b = rate(&at(&a, 0.5));
            let c = rate(&at(&b, 0.5));
            let d = rate(&at(&c, 1.0));
            x = std::array::from_fn(|i| x[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
        }
    }
    for (name, expected) in [("q", x[0]), ("rate", x[1]), ("p", x[2])] {
        let found = number(&mut mechanism, name);
        assert!(
            (found - expected).abs() < 2e-4 * x[1].abs().max(0.1),
            "{name} {found} {expected}"
        );
    }
}

#[test]
fn a_sampled_controller_uses_any_output_and_components() {
    let period = 4e-3;
    let rest = json!({
        "outputs": {
            "q": {"joint_coordinate": {"joint": "joint"}},
            "the place": {"position": {"at": "block/pin"}},
            "fast": {"velocity": {"at": "block/pin"}},
            "effort": {"actuator_effort": {"actuator": "motor"}}
        },
        "controllers": {"law": {"formula": "30*(0.2 - 'the place'.x) - 2*fast.x + 0.1*effort + t", "period": period}},
        "actuators": {"motor": {"force": {"joint": "joint", "controller": "law"}}}
    });
    let mut mechanism = started(&block(3, "prismatic", &rest));
    let (mut q, mut v, mut u) = (0.0_f64, 0.0_f64, 0.0_f64);
    for k in 0..100 {
        u = 30.0 * (0.2 - q) - 2.0 * v + 0.1 * u + f64::from(k) * period;
        for _ in 0..2 {
            mechanism.step(0.5 * period).unwrap();
        }
        q += period * v + 0.5 * period * period * u / MASS;
        v += period * u / MASS;
        let found = number(&mut mechanism, "q");
        assert!((found - q).abs() < 1e-10, "{k} {found} {q}");
    }
    let saved = mechanism.save();
    for _ in 0..10 {
        mechanism.step(0.5 * period).unwrap();
    }
    let state = mechanism.simulation().state().clone();
    mechanism.restore(&saved).unwrap();
    for _ in 0..10 {
        mechanism.step(0.5 * period).unwrap();
    }
    assert_eq!(mechanism.simulation().state(), &state);
}

#[test]
fn mistakes_in_actuators_are_named() {
    let refused = |rest: Value, says: &str| {
        let text = block(2, "revolute", &rest);
        let scene =
            dcb_runtime::Scene::parse(&text.to_string(), std::path::Path::new("scene.json"));
        let error = match scene.map_err(dcb_runtime::Error::from) {
            Err(error) => error.to_string(),
            Ok(scene) => Mechanism::start(&scene).err().unwrap().to_string(),
        };
        assert!(error.contains(says), "{error}\nnot: {says}");
    };
    let servo = |more: Value| {
        let mut servo = json!({"joint": "joint", "target": 0, "proportional": 1});
        for (key, value) in more.as_object().unwrap() {
            servo[key] = value.clone();
        }
        motor(json!({"servo": servo}))
    };
    let torque = |rest: Value| motor(json!({"torque": rest}));
    refused(
        torque(json!({"joint": "jiont", "constant": 1})),
        "did you mean `joint`?",
    );
    refused(
        motor(json!({"force": {"joint": "joint", "constant": 1}})),
        "has no translation",
    );
    refused(
        torque(json!({"joint": "joint", "constant": 1, "formula": "t"})),
        "one function is expected",
    );
    refused(
        servo(json!({"limit": 0})),
        "actuators.motor.servo.limit: is 0, expected a positive number",
    );
    refused(servo(json!({"gain": 0})), "unknown field `gain`");
    refused(servo(json!({"proportional": -1})), "expected a number >= 0");
    refused(
        servo(json!({"sample": 0.0015})),
        "no multiple of the step of 0.001",
    );
    refused(servo(json!({"proportional": 0})), "has no gain");
    let friction = |rest: Value| motor(json!({"friction": rest}));
    refused(
        friction(json!({"joint": "joint", "coulomb": -1})),
        "coulomb: is -1",
    );
    refused(
        friction(json!({"joint": "joint", "coulomb": 1})),
        "regularization: is missing",
    );
    refused(
        friction(json!({"joint": "joint", "coulomb": 1, "static": 0.5, "regularization": 1})),
        "less than coulomb",
    );
    let stop = |rest: Value| motor(json!({"end_stop": rest}));
    refused(
        stop(json!({"joint": "joint", "stiffness": 1})),
        "neither lower nor upper",
    );
    refused(
        stop(json!({"joint": "joint", "stiffness": 1, "lower": 1, "upper": 0})),
        "not above lower",
    );
    let law = |formula: &str, period: Value| {
        let mut rest = motor(json!({"torque": {"joint": "joint", "controller": "law"}}));
        rest["controllers"] = json!({"law": {"formula": formula}});
        if !period.is_null() {
            rest["controllers"]["law"]["period"] = period;
        }
        rest["outputs"] = json!({
            "q": {"joint_coordinate": {"joint": "joint"}}, "place": {"position": {"at": "block/pin"}},
            "effort": {"actuator_effort": {"actuator": "motor"}}
        });
        rest
    };
    refused(law("-qq", Value::Null), "`qq` is not known");
    refused(
        law("-place.x", Value::Null),
        "add for example \"period\": 1e-3",
    );
    refused(law("-place", json!(1e-3)), "has the components x, y");
    refused(
        law("-place.z", json!(1e-3)),
        "no component \"z\": it has x, y",
    );
    refused(
        law("-q.x", json!(1e-3)),
        "is one number and has no components",
    );
    refused(law("-q", json!(-1)), "expected a positive number");
    refused(
        torque(json!({"joint": "joint", "controller": "none"})),
        "no controller is called \"none\"",
    );
    let drive = json!({"drives": {"motor": {"angle": {"joint": "joint", "controller": "law"}}}, "outputs": {}});
    refused(drive, "is no function of time");
}

#[test]
fn what_the_page_shows_of_actuators_runs() {
    let page = include_str!("../../../docs/scene.md");
    let fragments = page.split("```json\n").skip(1);
    let fragment = fragments
        .map(|rest| rest.split("```").next().unwrap())
        .find(|fragment| fragment.contains("\"controllers\""))
        .unwrap();
    let mut text = block(3, "revolute", &json!({}));
    let own = text["bodies"]["block"].clone();
    text["bodies"] = json!({"wheel": own});
    text["bodies"]["wheel"]["rigid"]["points"] = json!({"axle": [0, 0, 0]});
    text["joints"] =
        json!({"axle": {"revolute": {"a": "ground", "b": "wheel/axle", "axis": [0, 0, 1]}}});
    let shown: Value = serde_json::from_str(&format!("{{{fragment}}}")).unwrap();
    for (key, value) in shown.as_object().unwrap() {
        text[key] = value.clone();
    }
    let mut mechanism = started(&text);
    for _ in 0..1000 {
        mechanism.step(1e-3).unwrap();
    }
    assert!((number(&mut mechanism, "angle") - 0.38).abs() < 0.05);
    assert!(number(&mut mechanism, "effort").is_finite());
}

#[test]
fn stick_and_slip_are_those_of_an_independent_integration() {
    // tests/benches/peers/stribeck.py: SciPy's Radau, relative tolerance 1e-11.
    let peer = [
        (0.5, 0.0001810744),
        (1.0, 0.0178601324),
        (1.5, 0.1313974329),
        (2.0, 0.1317584444),
        (2.5, 0.2039802890),
        (3.0, 0.2628447015),
    ];
    let text = |dimension| {
        let mut text = block(
            dimension,
            "prismatic",
            &json!({"actuators": {
                "motor": {"servo": {"joint": "joint", "target": {"polynomial": [0, 0.1]}, "proportional": 40}},
                "belt": {"friction": {"joint": "joint", "coulomb": 2, "static": 3, "stribeck_rate": 0.05, "regularization": 1e-3}}
            }}),
        );
        text["bodies"]["block"]["rigid"]["mass"] = json!(1);
        text
    };
    let worst = |dimension, steps: u32| {
        let mut mechanism = started(&text(dimension));
        let mut worst = 0.0_f64;
        for (_, place) in peer {
            for _ in 0..steps {
                mechanism.step(0.5 / f64::from(steps)).unwrap();
            }
            worst = worst.max((number(&mut mechanism, "q") - place).abs());
        }
        let [defect, most] = balance(&mut mechanism);
        assert!(defect < 1e-3 * most, "{defect:e} {most:e}");
        worst
    };
    let (coarse, fine) = (worst(2, 2500), worst(3, 5000));
    assert!(fine < 2e-5, "{coarse:e} {fine:e}");
    assert!(fine < 0.35 * coarse, "{coarse:e} {fine:e}");
}

#[test]
fn the_shipped_crank_comes_to_its_goal() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../samples/controlled-crank/scene.json");
    let scene = dcb_runtime::Scene::read(&path).unwrap();
    let mut mechanism = Mechanism::start(&scene).unwrap();
    for _ in 0..10000 {
        mechanism.step(1e-4).unwrap();
        assert!(number(&mut mechanism, "torque").abs() <= 2.0 + 1e-12);
    }
    // Where friction lets it rest.
    let way = number(&mut mechanism, "way");
    assert!((way + 0.25).abs() < 0.02, "{way}");
    assert!(number(&mut mechanism, "slider_speed").abs() < 2e-3);
}
