//! Mechanisms that can't be put together, or whose constraints repeat or contradict each other.

use serde_json::{Value, json};

use crate::scene_folder::{pendulum, planar, spatial};
use crate::support::{Folder, list, number, says};

/// A parallel four-bar linkage in space with four revolute joints about z: one freedom where Grübler counts minus two.
fn four_bar(rest: Value) -> Value {
    let bar = |length: f64, position: [f64; 3]| {
        json!({
            "rigid": {"mass": 1, "inertia": [0.01, 0.01, 0.01], "center_of_mass": [length / 2.0, 0, 0], "points": {"a": [0, 0, 0], "b": [length, 0, 0]}},
            "position": position
        })
    };
    let upright = json!([0.5_f64.sqrt(), 0, 0, 0.5_f64.sqrt()]);
    let mut bodies = json!({"crank": bar(0.2, [0.0; 3]), "rocker": bar(0.2, [0.5, 0.0, 0.0]), "coupler": bar(0.5, [0.0, 0.2, 0.0])});
    for name in ["crank", "rocker"] {
        bodies[name]["orientation"] = upright.clone();
    }
    let pin = |a: &str, b: &str| json!({"revolute": {"a": a, "b": b, "axis": [0, 0, 1]}});
    let mut scene = spatial(json!({
        "gravity": [3, -9.81, 0],
        "ground": {"points": {"right": [0.5, 0, 0]}},
        "bodies": bodies,
        "joints": {
            "axle": pin("ground", "crank/a"), "knee": pin("crank/b", "coupler/a"),
            "elbow": pin("coupler/b", "rocker/b"), "foot": pin("ground/right", "rocker/a")
        },
        "outputs": {"left": {"joint_coordinate": {"joint": "axle"}}, "right": {"joint_coordinate": {"joint": "foot"}}},
        "integrator": {"generalized_alpha": {"step": 1e-3, "end": 0.1}}
    }));
    for (key, value) in rest.as_object().unwrap() {
        scene[key] = value.clone();
    }
    scene
}

#[test]
fn an_impossible_assembly_names_a_joint_that_stays_open() {
    // Two pins 0.5 apart can't both be on the ground's points 0.7 apart.
    let scene = pendulum(json!({
        "ground": {"points": {"far": [0.7, 0]}},
        "joints": {
            "near": {"revolute": {"a": "ground", "b": "bob/pin"}},
            "far": {"revolute": {"a": "ground/far", "b": "bob/tip"}}
        },
        "outputs": {}
    }));
    let folder = Folder::with(&scene);
    let answer = folder.run("scene.json");
    answer.is_error(
        1,
        &[
            "can't be closed",
            "open by",
            "check the positions, lengths and drives",
        ],
    );
    assert!(
        answer.stderr.contains("\"near\"") || answer.stderr.contains("\"far\""),
        "{}",
        answer.stderr
    );
    let (reason, time, rows) = folder.stopped();
    says!(reason, "can't be closed");
    assert_eq!((time, rows), (None, 0));
}

#[test]
fn redundant_constraints_are_told_or_refused_by_name() {
    let folder = Folder::with(&four_bar(json!({})));
    let answer = folder.done("scene.json");
    says!(answer.stderr, "redundant constraint");
    let summary = folder.results().provenance("summary").unwrap();
    let told = list(&summary["redundant_constraints"]);
    // Four times five constraints on three times six degrees of freedom leave one.
    assert_eq!(folder.redundant(), 20 - 17, "{summary}");
    let names = ["axle", "knee", "elbow", "foot"];
    assert!(
        told.iter()
            .all(|joint| names.contains(&joint["joint"].as_str().unwrap()))
    );
    // Minimum norm or not, both cranks turn alike.
    let results = folder.results();
    let (left, right) = (
        results.history("left").unwrap(),
        results.history("right").unwrap(),
    );
    let last = left.nrows() - 1;
    assert!(left[(last, 0)].abs() > 0.01);
    assert!((left[(last, 0)] - right[(last, 0)]).abs() < 1e-9);
    let folder = Folder::with(&four_bar(json!({"redundant_constraints": "refuse"})));
    let answer = folder.run("scene.json");
    answer.is_error(2, &["constraints are redundant", "minimum-norm"]);
    assert!(
        names.iter().any(|name| answer.stderr.contains(name)),
        "{}",
        answer.stderr
    );
}

#[test]
fn redundant_forces_are_shared_out_where_they_are_recorded_and_cost_no_factors_elsewhere() {
    let run = |every: usize| {
        let folder = Folder::with(&four_bar(json!({"record": {"every": every}})));
        folder.done("scene.json");
        folder
    };
    let (all, some) = (run(1), run(20));
    let updates = |folder: &Folder| -> f64 {
        let summary = folder.results().provenance("summary").unwrap();
        let count = |name: &str| number(&summary[name]);
        count("jacobian_updates") / count("steps")
    };
    assert!(updates(&all) >= 1.0, "{}", updates(&all));
    assert!(updates(&some) < 0.5, "{}", updates(&some));
    for channel in ["left", "right", "reactions/axle", "reactions/foot"] {
        let (every, few) = (
            all.results().history(channel).unwrap(),
            some.results().history(channel).unwrap(),
        );
        let largest = (0..every.nrows())
            .flat_map(|row| (0..every.ncols()).map(move |column| (row, column)))
            .fold(0.0_f64, |most, place| most.max(every[place].abs()));
        assert!(few.nrows() == 6 && largest > 0.0, "{channel}");
        for row in 0..few.nrows() {
            for column in 0..few.ncols() {
                let apart = (few[(row, column)] - every[(20 * row, column)]).abs();
                assert!(
                    apart < 1e-5 * largest,
                    "{channel} {row} {column}: {apart:e} of {largest:e}"
                );
            }
        }
    }
}

#[test]
fn drives_that_contradict_each_other_later_are_told_when_they_do() {
    // Both cranks of the linkage turn alike: the second drive repeats the first until it leaves it.
    let right = |function: Value| {
        let mut motion = function;
        motion["joint"] = json!("foot");
        json!({"left": {"angle": {"joint": "axle", "polynomial": [0, 0.5]}}, "right": {"angle": motion}})
    };
    let agreeing = Folder::with(&four_bar(
        json!({"drives": right(json!({"polynomial": [0, 0.5]}))}),
    ));
    agreeing.done("scene.json");
    let table = json!({"table": {"times": [0, 0.05, 0.06, 1], "values": [0, 0.025, 0.031, 0.5], "interpolation": "linear"}});
    let folder = Folder::with(&four_bar(json!({"drives": right(table)})));
    let answer = folder.run("scene.json");
    answer.is_error(
        1,
        &[
            "drives \"left\", \"right\" contradict each other",
            "m to follow them",
        ],
    );
    let (reason, time, rows) = folder.stopped();
    says!(reason, "contradict each other");
    assert!((time.unwrap() - 0.05).abs() < 2e-3, "{time:?}");
    assert_eq!(rows, (time.unwrap() / 1e-3).round() as usize + 1);
}

#[test]
fn a_dead_centre_is_passed_and_told() {
    // Crank and rod of equal length: at a quarter turn the slider is over the axle and could stay there.
    let scene = planar(json!({
        "bodies": {
            "crank": {"rigid": {"mass": 1, "inertia": 0.01, "points": {"axle": [0, 0], "pin": [0.2, 0]}}},
            "rod": {"rigid": {"mass": 1, "inertia": 0.01, "center_of_mass": [0.1, 0], "points": {"a": [0, 0], "b": [0.2, 0]}}, "position": [0.2, 0]},
            "slider": {"rigid": {"mass": 1, "inertia": 0.01, "points": {"pin": [0, 0]}}, "position": [0.4, 0]}
        },
        "joints": {
            "axle": {"revolute": {"a": "ground", "b": "crank/axle"}},
            "wrist": {"revolute": {"a": "crank/pin", "b": "rod/a"}},
            "pin": {"revolute": {"a": "rod/b", "b": "slider/pin"}},
            "guide": {"prismatic": {"a": "ground", "b": "slider/pin", "axis": [1, 0]}}
        },
        "drives": {"motor": {"angle": {"joint": "axle", "polynomial": [0, 1]}}},
        "outputs": {"slider": {"position": {"at": "slider/pin"}}},
        "integrator": {"generalized_alpha": {"step": 0.01, "end": 3.0}}
    }));
    let folder = Folder::with(&scene);
    // Steps that meet the dead centre to the last digit, and steps that come close.
    let mut times = Vec::new();
    for step in [std::f64::consts::PI / 400.0, 1e-3, 1e-4] {
        folder.done(&format!("scene.json --force --step {step}"));
        let results = folder.results();
        let events = results.events().unwrap();
        let told = events
            .iter()
            .filter(|event| event.message.contains("dead centre"));
        times.extend(told.map(|event| event.time));
        let slider = results.history("slider").unwrap();
        let last = slider[(slider.nrows() - 1, 0)];
        // It goes through to the other side.
        assert!((last - 0.4 * 3.0_f64.cos()).abs() < 1e-10, "{last}");
    }
    // Rounding decides which of them notice it.
    assert!(!times.is_empty());
    for time in times {
        assert!((time - std::f64::consts::FRAC_PI_2).abs() < 2e-3, "{time}");
    }
}

/// A door on so many hinges in a row between it and its frame.
fn door(hinges: usize) -> Value {
    let points = |x: f64| -> Value {
        let place = |i: usize| json!([x, 0, 2.0 * (i as f64 + 0.5) / hinges as f64 - 1.0]);
        (0..hinges)
            .map(|i| (format!("p{i}"), place(i)))
            .collect::<serde_json::Map<_, _>>()
            .into()
    };
    let mut frame = points(0.0);
    frame["foot"] = json!([0, 0, -1]);
    let hinge = |i: usize| {
        let hinge = json!({"revolute": {"a": format!("frame/p{i}"), "b": format!("door/p{i}"), "axis": [0, 0, 1]}});
        (format!("hinge{i}"), hinge)
    };
    let mut joints: serde_json::Map<_, _> = (0..hinges).map(hinge).collect();
    joints.insert(
        "floor".into(),
        json!({"fixed": {"a": "ground", "b": "frame/foot"}}),
    );
    spatial(json!({
        "gravity": [0, 3, -9.81],
        "ground": {"points": {"foot": [0, 0, -1]}},
        "bodies": {
            "frame": {"rigid": {"mass": 5, "inertia": [2, 2, 1], "points": frame}},
            "door": {"rigid": {"mass": 20, "inertia": [6, 8, 2], "points": points(-0.5)}, "position": [0.5, 0, 0]}
        },
        "joints": joints,
        "outputs": {"angle": {"joint_coordinate": {"joint": "hinge0"}}},
        "integrator": {"generalized_alpha": {"step": 1e-3, "end": 0.02}}
    }))
}

/// The door turns alike on few hinges and on many, which carry it together; the frame has too many rows to be eliminated.
#[test]
fn a_door_on_many_hinges_turns_as_on_one() {
    let run = |hinges: usize| {
        let mut scene = door(hinges);
        scene["joints"]["floor"]["fixed"]["a"] = json!("ground/foot");
        let folder = Folder::with(&scene);
        folder.done("scene.json");
        let results = folder.results();
        let angle = results.history("angle").unwrap();
        let last = angle.nrows() - 1;
        let mut force = [0.0; 3];
        for i in 0..hinges {
            let one = results.history(&format!("reactions/hinge{i}")).unwrap();
            for (k, sum) in force.iter_mut().enumerate() {
                *sum += one[(last, k)];
            }
        }
        assert_eq!(folder.redundant(), 5 * (hinges as u64 - 1));
        (angle[(last, 0)], force)
    };
    let (angle, force) = run(1);
    assert!(angle.abs() > 1e-4, "{angle}");
    // Two: one body touches 16 rows. Five: a basis. Thirty: many directions, and bodies among the unknowns.
    for hinges in [2, 5, 30] {
        let (other, sum) = run(hinges);
        assert!(
            (other / angle - 1.0).abs() < 1e-9,
            "{hinges}: {other} {angle}"
        );
        for (sum, force) in sum.iter().zip(&force) {
            assert!(
                (sum - force).abs() < 1e-6 * 200.0,
                "{hinges}: {sum} {force}"
            );
        }
    }
}
