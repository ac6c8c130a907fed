//! Centre of mass, momenta, frames of bodies and motions of nodes, against Newton and Euler and differences over time.

use dcb_demand::SuperelementFiles;
use dcb_demand::pruning::{DEFAULT_TOLERANCE, Pruning};
use dcb_runtime::Mechanism;
use dcb_runtime::model::Model;
use serde_json::{Value, json};

use crate::scenes::parts::{Folder, rigid_scene, scene_text, started};

/// Values of outputs after every step.
struct History {
    step: f64,
    rows: Vec<Vec<Vec<f64>>>,
}

impl History {
    fn of(mechanism: &mut Mechanism, names: &[&str], step: f64, steps: usize) -> Self {
        let mut rows = Vec::new();
        for index in 0..=steps {
            if index > 0 {
                mechanism.step(step).unwrap();
            }
            let row = names.iter();
            rows.push(
                row.map(|name| mechanism.output(name).unwrap().to_vec())
                    .collect(),
            );
        }
        Self { step, rows }
    }

    fn at(&self, row: usize, output: usize) -> &[f64] {
        &self.rows[row][output]
    }

    /// Largest difference between one output and the rate of another by central differences, and the largest rate.
    fn rate_error(&self, of: usize, rate: usize) -> (f64, f64) {
        let (mut error, mut largest) = (0.0_f64, 0.0_f64);
        for row in 1..self.rows.len() - 1 {
            let (before, after) = (self.at(row - 1, of), self.at(row + 1, of));
            for (axis, known) in self.at(row, rate).iter().enumerate() {
                let found = (after[axis] - before[axis]) / (2.0 * self.step);
                error = error.max((found - known).abs());
                largest = largest.max(known.abs());
            }
        }
        (error, largest)
    }
}

fn beam(rest: Value) -> Value {
    let mut text = scene_text(
        3,
        json!({
            "gravity": [0.3, 0, -9.81],
            "bodies": {"beam": {"superelement": "beam.dcb.h5", "position": [0.2, 0.1, 1], "velocity": [1, 2, 3], "angular_velocity": [4, 9, -6]}},
            "outputs": {
                "center": {"center_of_mass": {"body": "beam"}},
                "p": {"momentum": {}},
                "spin": {"angular_momentum": {"body": "beam", "about": "center_of_mass"}},
                "about origin": {"angular_momentum": {}},
                "about point": {"angular_momentum": {"about": [1, -2, 0.5]}},
                "node": {"node_position": {"body": "beam", "node": 1}},
                "node speed": {"node_velocity": {"body": "beam", "node": 1}},
                "node acceleration": {"node_acceleration": {"body": "beam", "node": 1}}
            },
            "integrator": {"generalized_alpha": {"step": 1e-4, "end": 1, "rho_infinity": 0.9}}
        }),
    );
    for (key, value) in rest.as_object().unwrap() {
        text[key] = value.clone();
    }
    text
}

/// A beam as soft as rubber, thrown with a spin that bends it.
#[test]
fn a_thrown_body_falls_on_a_parabola_and_keeps_its_spin() {
    let folder = Folder::with_parts();
    let mut mechanism = Mechanism::start(&folder.scene(&beam(json!({})))).unwrap();
    let mass = mechanism.simulation().system().bodies[0]
        .flexible
        .inertia
        .mass();
    let names = ["center", "p", "spin", "about origin", "about point"];
    let history = History::of(&mut mechanism, &names, 1e-4, 1000);
    let (g, first) = ([0.3, 0.0, -9.81], history.at(0, 0).to_vec());
    let start = history.at(0, 1).to_vec();
    for row in [1, 400, 1000] {
        let t = 1e-4 * row as f64;
        for axis in 0..3 {
            let speed = start[axis] / mass;
            let fallen = first[axis] + speed * t + 0.5 * g[axis] * t * t;
            let center = history.at(row, 0)[axis];
            assert!(
                (center - fallen).abs() < 1e-9,
                "{row} {axis}: {center} {fallen}"
            );
            let gained = history.at(row, 1)[axis] - start[axis] - mass * g[axis] * t;
            assert!(gained.abs() < 1e-9 * mass * 10.0, "{row} {axis}: {gained}");
        }
        // Constant up to what the integrator does with a body that turns.
        let (spin, before) = (history.at(row, 2), history.at(0, 2));
        let size: f64 = before.iter().map(|h| h * h).sum::<f64>().sqrt();
        let change = (0..3).map(|axis| (spin[axis] - before[axis]).abs());
        assert!(
            change.fold(0.0, f64::max) < 2e-6 * size,
            "{spin:?} {before:?}"
        );
        // H about o is H about c, and (c - o) × p.
        let (c, p) = (history.at(row, 0), history.at(row, 1));
        for (output, o) in [(3, [0.0; 3]), (4, [1.0, -2.0, 0.5])] {
            let arm = nalgebra::Vector3::from_fn(|axis, _| c[axis] - o[axis]);
            let moved = arm.cross(&nalgebra::Vector3::from_column_slice(p));
            for axis in 0..3 {
                let found = history.at(row, output)[axis];
                assert!((found - spin[axis] - moved[axis]).abs() < 1e-12 * 10.0);
            }
        }
    }
}

#[test]
fn velocities_of_nodes_are_rates_of_their_positions() {
    let folder = Folder::with_parts();
    let rod = |compatibility: &str| {
        scene_text(
            2,
            json!({
                "gravity": [0, -9.81],
                "bodies": {"rod": {"superelement": "rod.dcb.h5", "angular_velocity": 20}},
                "joints": {"pin": {"revolute": {"a": "ground", "b": "rod/a"}}},
                "springs": {"tie": {"spring": {"a": "ground/hook", "b": "rod/b", "stiffness": 300, "free_length": 0.3}}},
                "ground": {"points": {"hook": [0.1, 0.5]}},
                "compatibility": compatibility,
                "outputs": {
                    "node": {"node_position": {"body": "rod", "node": 1}},
                    "node speed": {"node_velocity": {"body": "rod", "node": 1}},
                    "node acceleration": {"node_acceleration": {"body": "rod", "node": 1}}
                },
                "integrator": {"generalized_alpha": {"step": 2e-5, "end": 1, "rho_infinity": 0.8}}
            }),
        )
    };
    // Largest errors of velocity and acceleration, by the largest velocity and acceleration, of 1.2 ms after 4 ms.
    let errors = |text: &Value, h: f64| {
        let mut mechanism = Mechanism::start(&folder.scene(text)).unwrap();
        for _ in 0..(4e-3 / h) as usize {
            mechanism.step(h).unwrap();
        }
        let names = ["node", "node speed", "node acceleration"];
        let history = History::of(&mut mechanism, &names, h, (1.2e-3 / h) as usize);
        [(0, 1), (1, 2)].map(|(of, rate)| {
            let (error, largest) = history.rate_error(of, rate);
            assert!(largest > 1.0, "{largest}");
            error / largest
        })
    };
    for text in [beam(json!({})), rod("strong")] {
        let [velocity, acceleration] = errors(&text, 1e-5);
        assert!(velocity < 1e-3, "{text}: {velocity}");
        assert!(acceleration < 1e-3, "{text}: {acceleration}");
    }
    // Rates of what forces deflect at once come from the integrator's history. In much shorter steps the tolerance of its iteration is
    // larger than their second differences.
    for h in [2e-5, 1e-5] {
        let [velocity, acceleration] = errors(&rod("static"), h);
        assert!(velocity < 1e-3, "{h}: {velocity}");
        assert!(acceleration < 2e-2, "{h}: {acceleration}");
    }
}

fn pendulum(lengths: f64, masses: f64, times: f64, units: [&str; 3]) -> Value {
    let (l, m, t) = (lengths, masses, times);
    let inertia = m * l * l;
    json!({
        "dimension": 2,
        "units": {"length": units[0], "mass": units[1], "time": units[2]},
        "gravity": [0, -9.81 * l / t / t],
        "bodies": {
            "upper": {"rigid": {"mass": 0.7 * m, "inertia": 3e-3 * inertia, "center_of_mass": [0.1 * l, 0.02 * l],
                "points": {"top": [0, 0], "end": [0.2 * l, 0]}}},
            "lower": {"rigid": {"mass": 0.3 * m, "inertia": 1e-3 * inertia, "points": {"top": [0, 0]}}, "position": [0.2 * l, 0],
                "angular_velocity": 30.0 / t}
        },
        "joints": {
            "pivot": {"revolute": {"a": "ground", "b": "upper/top"}},
            "elbow": {"revolute": {"a": "upper/end", "b": "lower/top"}}
        },
        "loads": {"push": {"force": {"at": "upper/end", "components": [{"formula": format!("{}*sin({}*t)", 2.0 * m * l / t / t, 9.0 / t)}, 0]}}},
        "outputs": {
            "upper p": {"momentum": {"body": "upper"}}, "lower p": {"momentum": {"body": "lower"}}, "p": {"momentum": {}},
            "upper h": {"angular_momentum": {"body": "upper"}}, "lower h": {"angular_momentum": {"body": "lower"}}, "h": {"angular_momentum": {}},
            "center": {"center_of_mass": {}},
            "frame": {"body_position": {"body": "upper"}}, "frame speed": {"body_velocity": {"body": "upper"}},
            "turn": {"body_orientation": {"body": "lower"}}, "point turn": {"orientation": {"at": "lower/top"}},
            "rate": {"body_angular_velocity": {"body": "lower"}}, "point rate": {"angular_velocity": {"at": "lower/top"}},
            "end": {"position": {"at": "upper/end"}}, "pivot force": {"reaction": {"joint": "pivot"}}
        },
        "integrator": {"generalized_alpha": {"step": 1e-3 * t, "end": 1.0 * t}}
    })
}

const PENDULUM: [&str; 15] = [
    "upper p",
    "lower p",
    "p",
    "upper h",
    "lower h",
    "h",
    "center",
    "frame",
    "frame speed",
    "turn",
    "point turn",
    "rate",
    "point rate",
    "end",
    "pivot force",
];

#[test]
fn momenta_add_up_and_change_by_the_forces_from_outside() {
    let mut mechanism = started(&pendulum(1.0, 1.0, 1.0, ["m", "kg", "s"]));
    let h = 1e-3;
    let history = History::of(&mut mechanism, &PENDULUM, h, 600);
    let weight = |row: usize| {
        let push = 2.0 * (9.0 * h * row as f64).sin();
        let (end, center) = (history.at(row, 13), history.at(row, 6));
        let pivot = history.at(row, 14);
        // The joint pushes the ground, its first body, with the reaction.
        let force = [push - pivot[0], -9.81 - pivot[1]];
        (force, -9.81 * center[0] - push * end[1])
    };
    for row in [0, 37, 600] {
        for axis in 0..2 {
            let sum = history.at(row, 0)[axis] + history.at(row, 1)[axis];
            assert!((history.at(row, 2)[axis] - sum).abs() < 1e-13);
        }
        let sum = history.at(row, 3)[0] + history.at(row, 4)[0];
        assert!((history.at(row, 5)[0] - sum).abs() < 1e-13);
    }
    // By Simpson's rule over pairs of steps.
    let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
    for row in (0..598).step_by(2) {
        let [a, b, c] = [row, row + 1, row + 2].map(weight);
        for axis in 0..2 {
            let impulse = h / 3.0 * (a.0[axis] + 4.0 * b.0[axis] + c.0[axis]);
            let gained = history.at(row + 2, 2)[axis] - history.at(row, 2)[axis];
            worst = worst.max((gained - impulse).abs());
            largest = largest.max(gained.abs());
        }
        let impulse = h / 3.0 * (a.1 + 4.0 * b.1 + c.1);
        let gained = history.at(row + 2, 5)[0] - history.at(row, 5)[0];
        worst = worst.max((gained - impulse).abs());
    }
    assert!(worst < 1e-3 * largest, "{worst} of {largest}");
    // Frames and points of a rigid body turn together, past half a turn too.
    let last = history.rows.len() - 1;
    assert!(history.at(last, 9)[0] > 6.0);
    for row in 0..=last {
        for (frame, point) in [(9, 10), (11, 12)] {
            let (a, b) = (history.at(row, frame)[0], history.at(row, point)[0]);
            assert!((a - b).abs() < 1e-12 * (1.0 + b.abs()), "{row}: {a} {b}");
        }
    }
    let (error, speed) = history.rate_error(7, 8);
    assert!(error < 1e-3 * speed, "{error} of {speed}");
}

#[test]
fn momenta_are_the_same_in_other_units() {
    let mut history = [
        (1.0, 1.0, 1.0, ["m", "kg", "s"]),
        (1e3, 1e-3, 1e3, ["mm", "t", "ms"]),
    ]
    .map(|(l, m, t, units)| {
        let mut mechanism = started(&pendulum(l, m, t, units));
        History::of(&mut mechanism, &PENDULUM, 1e-3 * t, 100)
    });
    let [si, other] = &mut history;
    let (l, m, t) = (1e3, 1e-3, 1e3);
    for (output, unit) in [
        (2, m * l / t),
        (5, m * l * l / t),
        (6, l),
        (8, l / t),
        (11, 1.0 / t),
    ] {
        for (a, b) in si.at(100, output).iter().zip(other.at(100, output)) {
            let size = a.abs().max(1e-3);
            assert!((b / unit - a).abs() < 1e-9 * size, "{output}: {a} {b}");
        }
    }
    let scene = rigid_scene(&pendulum(l, m, t, ["mm", "t", "ms"]));
    let model = dcb_runtime::model::Model::load(&scene).unwrap();
    let unit = |path: &str| {
        let mut channels = model.recorder.channels().iter();
        let found = channels.find(|channel| channel.path == path).unwrap();
        found.columns[0].unit.clone()
    };
    assert_eq!(unit("outputs/p"), "t*mm/ms");
    assert_eq!(unit("outputs/h"), "t*mm^2/ms");
}

#[test]
fn a_frame_in_space_turns_as_a_point_of_its_body() {
    let mut mechanism = started(&scene_text(
        3,
        json!({
            "bodies": {"top": {"rigid": {"mass": 1, "inertia": [0.02, 0.03, 0.04], "points": {"p": [0.1, 0, 0]}}, "angular_velocity": [3, -7, 5]}},
            "outputs": {
                "frame": {"body_orientation": {"body": "top"}}, "point": {"orientation": {"at": "top/p"}},
                "rate": {"body_angular_velocity": {"body": "top"}}, "point rate": {"angular_velocity": {"at": "top/p"}}
            }
        }),
    ));
    let names = ["frame", "point", "rate", "point rate"];
    let history = History::of(&mut mechanism, &names, 1e-3, 500);
    for row in [0, 250, 500] {
        let (frame, point) = (history.at(row, 0), history.at(row, 1));
        let same: f64 = frame.iter().zip(point).map(|(a, b)| a * b).sum();
        assert!((same.abs() - 1.0).abs() < 1e-12, "{frame:?} {point:?}");
        for (a, b) in history.at(row, 2).iter().zip(history.at(row, 3)) {
            assert!((a - b).abs() < 1e-12 * 10.0);
        }
    }
}

/// What a scene needs of a part that nothing holds is little, and its momenta are those of the whole part.
#[test]
fn momenta_are_those_of_the_whole_part_whatever_is_left_out() {
    let folder = Folder::with_parts();
    let mut text = beam(json!({}));
    text["outputs"] = json!({"p": {"momentum": {}}, "h": {"angular_momentum": {"body": "beam"}}, "turn": {"body_orientation": {"body": "beam"}}});
    let scene = folder.scene(&text);
    let open = SuperelementFiles::default();
    let pruning = Pruning::of(&scene, &open, DEFAULT_TOLERANCE).unwrap();
    let narrowed = Model::load_narrowed(&pruning.applied_to(&scene), &open).unwrap();
    let ends = [Model::load(&scene).unwrap(), narrowed].map(|model| {
        let mut mechanism =
            Mechanism::start_model(&scene, &scene.integrator.unwrap(), model).unwrap();
        let names = ["p", "h", "turn"];
        let history = History::of(&mut mechanism, &names, 1e-4, 500);
        history.rows[500].concat()
    });
    for (whole, narrow) in ends[0].iter().zip(&ends[1]) {
        assert!((whole - narrow).abs() < 1e-2, "{ends:?}");
    }
}
