//! Linear systems against the mechanism itself: consistent states beside the operating point, and motions over time.

use dcb_formats::TimeFunction;
use dcb_formats::function::Function;
use dcb_formats::scene::RedundantConstraints;
use dcb_runtime::analysis::eigenmodes::Eigenmodes;
use dcb_runtime::analysis::equilibrium::{EquilibriumSettings, find_equilibrium};
use dcb_runtime::initial::Starter;
use dcb_runtime::model::RecordedStep;
use dcb_runtime::system::evaluation::Evaluation;
use dcb_runtime::system::{ConnectionKind, Demand, State, System};
use dcb_runtime::{LinearSystem, Mechanism, Model, OperatingPoint, Scene};
use dcb_samples::PseudoRandom;
use nalgebra::{UnitQuaternion, Vector3};
use serde_json::json;

use super::support::{about, eigenvalues, step_response};
use crate::scenes::parts::{Folder, rigid_scene, scene_text};

/// A drawn state, moved at random.
struct Push {
    places: Vec<f64>,
    rates: Vec<f64>,
    inputs: Vec<f64>,
    drives: Vec<[f64; 3]>,
}

impl Push {
    fn random(system: &System, random: &mut PseudoRandom) -> Self {
        let mut numbers = |count: usize, scale: f64| -> Vec<f64> {
            (0..count).map(|_| scale * (random.number())).collect()
        };
        let n = system.velocity_count();
        let mut places = numbers(n, 1.0);
        let rates = numbers(n, 10.0);
        for body in &system.bodies {
            for (k, free) in body.free.iter().enumerate() {
                if !free {
                    places[body.velocities.start + k] = 0.0;
                }
            }
            for place in &mut places[body.velocities.start + 6..body.velocities.end] {
                *place *= 0.02;
            }
        }
        let rates = (rates.iter().zip(&places))
            .map(|(rate, place)| if *place == 0.0 { 0.0 } else { *rate })
            .collect();
        let drives = system.connections.iter();
        let count = drives.filter(|c| c.kind == ConnectionKind::Drive).count();
        Self {
            places,
            rates,
            inputs: numbers(system.inputs.len(), 5.0),
            drives: (0..count)
                .map(|_| numbers(3, 1.0).try_into().unwrap())
                .collect(),
        }
    }

    /// The mechanism and its consistent start, pushed so far.
    fn applied(&self, model: &Model, driven: bool, amount: f64) -> (System, State) {
        let (mut system, mut state) = (model.system.clone(), model.drawn.clone());
        if driven {
            let rows: Vec<usize> = (system.rows.iter())
                .filter_map(|row| match row.demand {
                    Demand::Follow(signal) => Some(signal),
                    _ => None,
                })
                .collect();
            for (signal, [place, rate, second]) in rows.iter().zip(&self.drives) {
                let before = system.signals[*signal].function.evaluate(0.0, 0.0);
                let function = Function::Polynomial(vec![
                    before.value + amount * place * 0.1,
                    before.rate + amount * rate,
                    0.5 * (before.second_rate + amount * second),
                ]);
                system.signals[*signal].function = TimeFunction::new(&function).unwrap();
            }
        }
        for (index, body) in system.bodies.iter().enumerate() {
            let own = &self.places[body.velocities.clone()];
            state.origins[index] += Vector3::from_column_slice(&own[..3]) * amount * 0.1;
            let turn = Vector3::from_column_slice(&own[3..6]) * amount;
            state.orientations[index] *= UnitQuaternion::new(turn);
            for (y, push) in state.coordinates[body.coordinates.clone()]
                .iter_mut()
                .zip(&own[6..])
            {
                *y += amount * push * 0.1;
            }
        }
        for (velocity, push) in state.velocities.iter_mut().zip(&self.rates) {
            *velocity += amount * push * 0.1;
        }
        for (input, push) in state.inputs.iter_mut().zip(&self.inputs) {
            *input += amount * push;
        }
        Starter::of(&system)
            .unwrap()
            .start(&mut state, RedundantConstraints::MinimumNorm)
            .unwrap();
        (system, state)
    }
}

/// x and x' of a state beside another, in the axes of the other's bodies.
fn variation(system: &System, at: &State, beside: &State) -> (Vec<f64>, Vec<f64>) {
    let n = system.velocity_count();
    let (mut x, mut x1) = (vec![0.0; n], vec![0.0; n]);
    for (index, body) in system.bodies.iter().enumerate() {
        let first = body.velocities.start;
        let axes = at.orientations[index];
        let place = axes.inverse() * (beside.origins[index] - at.origins[index]);
        let turn = (axes.inverse() * beside.orientations[index]).scaled_axis();
        let three = |values: &[f64], first: usize| {
            Vector3::new(values[first], values[first + 1], values[first + 2])
        };
        let change = |first: usize| three(&beside.velocities, first) - three(&at.velocities, first);
        let spin = three(&at.velocities, first + 3);
        let rate = axes.inverse() * change(first) - spin.cross(&place);
        let turning = change(first + 3) - spin.cross(&turn);
        for k in 0..3 {
            (x[first + k], x[first + 3 + k]) = (place[k], turn[k]);
            (x1[first + k], x1[first + 3 + k]) = (rate[k], turning[k]);
        }
        for k in 6..body.velocities.len() {
            let y = body.coordinates.start + k - 6;
            x[first + k] = beside.coordinates[y] - at.coordinates[y];
            x1[first + k] = beside.velocities[first + k] - at.velocities[first + k];
        }
    }
    (x, x1)
}

/// The place of a named coordinate in velocity arrays.
fn coordinate(system: &System, name: &str) -> usize {
    let (body, part) = name.split_once('/').unwrap();
    let body = system.bodies.iter().find(|b| b.name == body).unwrap();
    let frame = ["x", "y", "z", "rx", "ry", "rz"];
    let within = match frame.iter().position(|name| *name == part) {
        Some(place) => place,
        None => part.parse::<usize>().unwrap() + 5,
    };
    body.velocities.start + within
}

/// Outputs beside the start, of consistent nonlinear states, against C x + D u: the largest difference as a part of each output's change.
fn defect(scene: &Scene, inputs: &[&str], outputs: &[&str]) -> f64 {
    let linear = about(scene, OperatingPoint::Initial, inputs, outputs);
    let mut model = Model::load(scene).unwrap();
    let driven = linear
        .states
        .iter()
        .any(|state| state.name.starts_with("drives/"));
    let mut random = PseudoRandom::new(7);
    let mut largest = 0.0_f64;
    let channels = outputs
        .iter()
        .map(|name| model.recorder.columns(name).unwrap());
    let channels: Vec<_> = channels.collect();
    let columns: Vec<usize> = channels.iter().cloned().flatten().collect();
    let mut changes: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
    for _ in 0..4 {
        let push = Push::random(&model.system, &mut random);
        let (_, start) = push.applied(&model, driven, 0.0);
        let mut at = |amount: f64| -> (Vec<f64>, Vec<f64>) {
            let (system, state) = push.applied(&model, driven, amount);
            let (x, x1) = variation(&system, &start, &state);
            let half = linear.order() / 2;
            let mut known = vec![0.0; linear.order()];
            let mut drive = 0;
            for (k, variable) in linear.states[..half].iter().enumerate() {
                match variable.name.starts_with("drives/") {
                    false => {
                        let place = coordinate(&system, &variable.name);
                        (known[k], known[half + k]) = (x[place], x1[place]);
                    }
                    true => {
                        let [place, rate, _] = push.drives[drive];
                        (known[k], known[half + k]) = (amount * place * 0.1, amount * rate);
                        drive += 1;
                    }
                }
            }
            drive = 0;
            for (input, variable) in linear.inputs.iter().enumerate() {
                let is_drive =
                    driven && variable.unit.ends_with("/s^2") && !variable.unit.starts_with("kg");
                known.push(match is_drive {
                    true => {
                        drive += 1;
                        amount * push.drives[drive - 1][2]
                    }
                    false => amount * push.inputs[input],
                });
            }
            let mut evaluation = Evaluation::of(&system);
            let step = RecordedStep::at(&system, &state, &mut evaluation);
            let row = model.recorder.row(&step);
            (known, columns.iter().map(|column| row[*column]).collect())
        };
        let h = 2e-3;
        let points = [at(h), at(-h), at(2.0 * h), at(-2.0 * h)];
        let (known, rows): (Vec<_>, Vec<_>) = points.into_iter().unzip();
        let slope = |points: &[Vec<f64>]| -> Vec<f64> {
            (0..points[0].len())
                .map(|i| {
                    let value = |k: usize| points[k][i];
                    (8.0 * (value(0) - value(1)) - (value(2) - value(3))) / (12.0 * h)
                })
                .collect()
        };
        changes.push((slope(&known), slope(&rows)));
    }
    let n = linear.order();
    for i in 0..columns.len() {
        // What its channel changes by.
        let own = channels
            .iter()
            .find(|own| own.contains(&columns[i]))
            .unwrap();
        let scale = (0..columns.len())
            .filter(|k| own.contains(&columns[*k]))
            .flat_map(|k| changes.iter().map(move |(_, y)| y[k].abs()))
            .fold(0.0, f64::max);
        for (known, y) in &changes {
            let of_states: f64 = (0..n).map(|k| linear.c[(i, k)] * known[k]).sum();
            let of_inputs: f64 = (n..known.len())
                .map(|k| linear.d[(i, k - n)] * known[k])
                .sum();
            let off = (of_states + of_inputs - y[i]).abs() / scale;
            assert!(
                off < 1e-6,
                "{}: {} against {} of {scale:e}",
                linear.outputs[i].name,
                of_states + of_inputs,
                y[i]
            );
            largest = largest.max(off);
        }
    }
    largest
}

/// A slider-crank with a flexible rod, its crank turning, pushed by an input.
fn slider_crank(folder: &Folder, crank_drive: bool) -> Scene {
    let mut text = scene_text(
        2,
        json!({
            "gravity": [0, -9.81],
            "bodies": {
                "crank": {"rigid": {"mass": 0.3, "inertia": 1e-3, "points": {"axle": [0, 0], "pin": [0.1, 0]}}, "orientation": 0.7, "angular_velocity": 12},
                "rod": {"superelement": "rod.dcb.h5", "position": [0.0764842187, 0.0644217687], "orientation": -0.2164, "angular_velocity": -3, "velocity": [-0.77, 0.92]},
                "slider": {"rigid": {"mass": 0.5, "inertia": 1e-3, "points": {"pin": [0, 0]}}, "position": [0.37, 0]}
            },
            "joints": {
                "axle": {"revolute": {"a": "ground", "b": "crank/axle"}},
                "wrist": {"revolute": {"a": "crank/pin", "b": "rod/a"}},
                "pin": {"revolute": {"a": "rod/b", "b": "slider/pin"}},
                "guide": {"prismatic": {"a": "ground", "b": "slider/pin", "axis": [1, 0]}}
            },
            "springs": {"brake": {"torsion_spring": {"joint": "pin", "stiffness": 2, "damping": 0.05}}},
            "loads": {"push": {"force": {"at": "slider/pin", "components": [{"input": {"initial": -4}}, 0]}}},
            "outputs": {
                "slider": {"acceleration": {"at": "slider/pin"}}, "pin": {"velocity": {"at": "crank/pin"}},
                "angle": {"joint_coordinate": {"joint": "pin"}}, "modal": {"modal": {"body": "rod"}},
                "inside": {"reaction": {"joint": "pin", "axes": "first"}}
            }
        }),
    );
    if crank_drive {
        text["drives"] = json!({"motor": {"angle": {"joint": "axle", "polynomial": [0.7, 12, 5]}}});
    }
    folder.scene(&text)
}

#[test]
fn a_moving_slider_crank_is_linear_as_its_neighbours_say() {
    let folder = Folder::with_parts();
    let outputs = [
        "slider",
        "pin",
        "angle",
        "modal",
        "inside",
        "reactions/axle",
        "reactions/guide",
        "springs/brake",
        "interface_forces/rod/b",
    ];
    let scene = slider_crank(&folder, false);
    let free = defect(&scene, &["push"], &outputs);
    assert!(free < 1e-6, "{free:e}");
    let scene = slider_crank(&folder, true);
    let with_effort: Vec<&str> = outputs.iter().copied().chain(["drives/motor"]).collect();
    let driven = defect(&scene, &["push", "motor"], &with_effort);
    assert!(driven < 1e-6, "{driven:e}");
}

/// Two flexible beams on a turning hub in space with a follower force and gravity, all in motion.
fn arm(folder: &Folder, motion: f64) -> Scene {
    arm_pushed(folder, motion, 0.2 * motion)
}

/// The same with another torque of the motor.
fn arm_pushed(folder: &Folder, motion: f64, torque: f64) -> Scene {
    folder.scene(&scene_text(
        3,
        json!({
            "gravity": [0, 0, -9.81 * motion],
            "bodies": {
                "hub": {"rigid": {"mass": 0.4, "inertia": [1e-3, 2e-3, 1.5e-3], "points": {"axle": [0, 0, 0], "root": [0.05, 0, 0]}},
                    "angular_velocity": [0, 0, 6.0 * motion]},
                "upper": {"superelement": "beam.dcb.h5", "position": [0.05, 0, 0], "angular_velocity": [0, 0, 6.0 * motion], "velocity": [0, 0.3 * motion, 0]},
                "lower": {"superelement": "beam.dcb.h5", "position": [0.35, 0, 0], "orientation": [0.9238795, 0, 0.3826834, 0],
                    "angular_velocity": [0, 2.0 * motion, 6.0 * motion], "velocity": [0, 2.1 * motion, 0]}
            },
            "joints": {
                "axle": {"revolute": {"a": "ground", "b": "hub/axle", "axis": [0, 0, 1]}},
                "root": {"fixed": {"a": "hub/root", "b": "upper/a"}},
                "elbow": {"universal": {"a": "upper/b", "b": "lower/a", "axis": [0, 1, 0], "axis_b": [0, 0, 1]}}
            },
            "springs": {
                "shoulder": {"torsion_spring": {"joint": "axle", "stiffness": 30, "damping": 0.02}},
                "tendon": {"spring": {"a": "ground", "b": "lower/b", "stiffness": 200, "damping": 0.5}}
            },
            "loads": {
                "thrust": {"force": {"at": "lower/b", "axes": "follower", "components": [{"input": {"initial": motion}}, {"input": {"initial": 0.5 * motion}}, 0]}},
                "motor": {"torque": {"at": "hub/axle", "components": [0, 0, {"input": {"initial": torque}}]}}
            },
            "outputs": {
                "tip": {"position": {"at": "lower/b"}}, "tip_speed": {"velocity": {"at": "lower/b"}},
                "tip_acceleration": {"acceleration": {"at": "lower/b"}}, "turn": {"joint_coordinate": {"joint": "axle"}},
                "hub": {"angular_velocity": {"at": "hub/axle"}}
            }
        }),
    ))
}

const OF_ARM: [&str; 9] = [
    "tip",
    "tip_speed",
    "tip_acceleration",
    "turn",
    "hub",
    "reactions/axle",
    "reactions/elbow",
    "interface_forces/lower/b",
    "springs/tendon",
];

#[test]
fn a_moving_arm_in_space_is_linear_as_its_neighbours_say() {
    let folder = Folder::with_parts();
    for motion in [0.0, 1.0] {
        let found = defect(&arm(&folder, motion), &[], &OF_ARM);
        assert!(found < 1e-6, "{motion}: {found:e}");
    }
}

/// A parallelogram in space: revolute joints with parallel axes repeat what others hold.
fn parallelogram(speed: f64) -> serde_json::Value {
    let lever = |x: f64| {
        json!({"rigid": {"mass": 0.5, "inertia": [1e-3, 2e-3, 3e-3], "points": {"low": [0, -0.1, 0], "high": [0, 0.1, 0]}},
            "position": [x, 0.1, 0], "angular_velocity": [0, 0, speed], "velocity": [-0.1 * speed, 0, 0]})
    };
    let hinge = |a: &str, b: &str| json!({"revolute": {"a": a, "b": b, "axis": [0, 0, 1]}});
    scene_text(
        3,
        json!({
            "gravity": [0, -9.81, 0],
            "ground": {"points": {"left": [0, 0, 0], "right": [0.3, 0, 0]}},
            "bodies": {
                "left": lever(0.0), "right": lever(0.3),
                "coupler": {"rigid": {"mass": 1, "inertia": [1e-3, 4e-3, 5e-3], "points": {"left": [-0.15, 0, 0], "right": [0.15, 0, 0]}}, "position": [0.15, 0.2, 0], "velocity": [-0.2 * speed, 0, 0]}
            },
            "joints": {
                "a": hinge("ground/left", "left/low"), "b": hinge("ground/right", "right/low"),
                "c": hinge("left/high", "coupler/left"), "d": hinge("right/high", "coupler/right")
            },
            "springs": {"hold": {"torsion_spring": {"joint": "a", "stiffness": 8, "damping": 0.1}}},
            "loads": {"push": {"force": {"at": "coupler/left", "components": [{"input": {"initial": 0}}, 0, 0]}}},
            "outputs": {"angle": {"joint_coordinate": {"joint": "b"}}, "coupler": {"acceleration": {"at": "coupler/right"}}}
        }),
    )
}

/// One freedom: (2 (J + m r²) + M (2 r)²) φ'' + c φ' + (k - g (2 m r + 2 M r)) φ = -2 r F.
#[test]
fn a_closed_loop_with_redundant_constraints_has_its_one_freedom() {
    let scene = rigid_scene(&parallelogram(0.0));
    let system = about(&scene, OperatingPoint::Initial, &[], &[]);
    assert_eq!(system.order(), 2);
    let inertia = 2.0 * (3e-3 + 0.5 * 0.01) + 0.04;
    let stiffness = 8.0 - 9.81 * (2.0 * 0.5 * 0.1 + 0.2);
    let found = system.poles[1];
    let magnitude = f64::sqrt(stiffness / inertia);
    assert!(
        (found.magnitude() / magnitude - 1.0).abs() < 1e-10,
        "{found:?}"
    );
    assert!((found.growth + 0.1 / (2.0 * inertia)).abs() < 1e-10);
    assert!((system.d[(1, 0)] - 0.2 * 0.2 / inertia).abs() < 1e-9);
    for speed in [0.0, 3.0] {
        let scene = rigid_scene(&parallelogram(speed));
        let off = defect(&scene, &[], &["angle", "coupler", "springs/hold"]);
        assert!(off < 1e-6, "{speed}: {off:e}");
    }
}

/// The start of an arm at rest, without gravity: what a step of the motor's torque does in 0.05 s, nonlinear by amplitude, and linear.
#[test]
fn a_step_response_is_that_of_a_small_step() {
    let folder = Folder::with_parts();
    let scene = arm(&folder, 0.0);
    let outputs = ["tip", "turn", "reactions/axle"];
    let linear = about(&scene, OperatingPoint::Initial, &["motor"], &outputs);
    let expected = step_response(&linear, 0, 0.05);
    let run = |amplitude: f64, steps: u32| -> Vec<f64> {
        let mut mechanism = Mechanism::start(&arm_pushed(&folder, 0.0, amplitude)).unwrap();
        for _ in 0..steps {
            mechanism.step(0.05 / f64::from(steps)).unwrap();
        }
        let mut values = Vec::new();
        for name in outputs {
            values.extend_from_slice(mechanism.output(name).unwrap());
        }
        let at = linear.outputs.iter().map(|variable| variable.at);
        values
            .iter()
            .zip(at)
            .map(|(value, at)| (value - at) / amplitude)
            .collect()
    };
    let size = |values: &[f64]| {
        values[..4]
            .iter()
            .fold(0.0, |most: f64, x| most.max(x.abs()))
    };
    let off = |found: &[f64], expected: &[f64]| -> f64 {
        let difference: Vec<f64> = found.iter().zip(expected).map(|(a, b)| a - b).collect();
        size(&difference) / size(expected)
    };
    // What is beyond linear grows with the amplitude, at one length of steps.
    let (small, middle, large) = (run(0.01, 200), run(0.2, 200), run(0.4, 200));
    let (first, second) = (off(&middle, &small), off(&large, &small));
    assert!(first > 1e-5 && second / first > 1.7, "{first:e} {second:e}");
    // What is left of a small one falls with the square of the step.
    let (coarse, fine) = (off(&small, &expected), off(&run(0.01, 400), &expected));
    assert!(fine < 2e-3, "{coarse:e} {fine:e}");
    assert!(coarse / fine > 3.0, "{coarse:e} {fine:e}");
}

/// At a time of a motion, and where a program has stopped it.
#[test]
fn a_mechanism_is_linearized_where_it_is() {
    let folder = Folder::with_parts();
    let scene = arm(&folder, 1.0);
    let at_time = about(&scene, OperatingPoint::Time(0.02), &[], &OF_ARM);
    let mut mechanism = Mechanism::start(&scene).unwrap();
    for _ in 0..20 {
        mechanism.step(1e-3).unwrap();
    }
    let request = dcb_runtime::LinearRequest {
        outputs: OF_ARM.map(str::to_owned).to_vec(),
        ..Default::default()
    };
    let here: LinearSystem = mechanism.linearize(&request).unwrap();
    assert_eq!(here, at_time);
    assert!((here.time - 0.02).abs() < 1e-12);
    let tip = mechanism.output("tip").unwrap();
    assert!((tip[0] - here.outputs[0].at).abs() < 1e-12);
}

/// The eigenvalues of A, sorted into pairs, are those that the analysis of modes finds; at rest, under load, and in steady motion.
#[test]
fn poles_are_the_modes() {
    let folder = Folder::with_parts();
    let crank = folder.scene(&{
        let mut text = serde_json::to_value(slider_crank(&folder, false)).unwrap();
        for body in ["crank", "rod"] {
            text["bodies"][body]["angular_velocity"] = json!(0);
            text["bodies"][body]["velocity"] = json!([0, 0]);
        }
        text
    });
    for (scene, at) in [
        (arm(&folder, 0.0), OperatingPoint::Initial),
        (rigid_scene(&parallelogram(0.0)), OperatingPoint::Initial),
        (crank, OperatingPoint::Static),
    ] {
        let linear = about(&scene, at, &[], &[]);
        let Model {
            system, mut drawn, ..
        } = Model::load(&scene).unwrap();
        match at {
            OperatingPoint::Static => {
                find_equilibrium(&system, &mut drawn, &EquilibriumSettings::default()).unwrap();
            }
            _ => {
                let mut starter = Starter::of(&system).unwrap();
                starter
                    .start(&mut drawn, RedundantConstraints::MinimumNorm)
                    .unwrap();
            }
        }
        let modes = Eigenmodes::at(&system, &drawn).unwrap();
        assert_eq!(2 * modes.dof_count, linear.order());
        let found = eigenvalues(&linear);
        let fastest = found.last().map_or(0.0, |s| s[0].hypot(s[1]));
        for mode in &modes.modes {
            let size = mode.growth.hypot(mode.angular_frequency);
            let nearest = found
                .iter()
                .map(|s| (s[0] - mode.growth).hypot(s[1] - mode.angular_frequency))
                .fold(f64::INFINITY, f64::min);
            // What rounding does to eigenvalues of a matrix with such large ones, and to double ones.
            let rounding = if size == 0.0 { 1e-7 } else { 1e-12 };
            let allowed = 1e-9 * size + rounding * fastest;
            assert!(nearest < allowed, "{mode:?}: {nearest:e}");
        }
        for (pole, s) in linear.poles.iter().zip(modes.poles()) {
            let off = (pole.growth - s[0]).hypot(pole.angular_frequency.abs() - s[1].abs());
            assert!(off <= 1e-9 * pole.magnitude(), "{pole:?} {s:?}");
        }
    }
}
