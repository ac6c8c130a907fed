//! Rows and fields at the times asked.

use dcb_runtime::{Mechanism, Scene};
use serde_json::{Value, json};

use crate::scene_folder::pendulum;
use crate::support::Folder;

/// Times, and the angle and its rate there.
fn rows(scene: &Value) -> (Vec<f64>, Vec<[f64; 2]>) {
    let folder = Folder::with(scene);
    folder.done("scene.json");
    let results = folder.results();
    let (angle, rate) = (results.history("angle"), results.history("rate"));
    let (angle, rate) = (angle.unwrap(), rate.unwrap());
    let time = results.time().unwrap();
    let values = (0..time.len()).map(|row| [angle[(row, 0)], rate[(row, 0)]]);
    let values = values.collect();
    (time, values)
}

fn swinging(record: Value, step: f64, end: f64) -> Value {
    pendulum(json!({
        "outputs": {
            "angle": {"joint_coordinate": {"joint": "hinge"}},
            "rate": {"joint_rate": {"joint": "hinge"}},
            "hinge": {"reaction": {"joint": "hinge"}},
            "tip": {"acceleration": {"at": "bob/tip"}}
        },
        "record": record,
        "integrator": {"generalized_alpha": {"step": step, "end": end}}
    }))
}

/// All multiples of the interval, and the end.
fn asked(interval: f64, end: f64) -> Vec<f64> {
    let count = (end / interval * (1.0 + 1e-12)).floor() as usize;
    let mut times: Vec<f64> = (0..=count).map(|row| row as f64 * interval).collect();
    if end - times[count] > 1e-12 * end {
        times.push(end);
    }
    times
}

#[test]
fn a_hundred_thousand_steps_are_recorded_each_at_its_time() {
    let (time, values) = rows(&swinging(json!({"interval": 1e-3}), 1e-5, 1.0));
    let (same, of_steps) = rows(&swinging(json!({"every": 100}), 1e-5, 1.0));
    assert_eq!(time.len(), 1001);
    for (row, time) in time.iter().enumerate() {
        let asked = row as f64 * 1e-3;
        assert!(
            (time - asked).abs() <= 1e-15 * asked,
            "row {row}: {time:.17}"
        );
    }
    // Not beside it: what the step had.
    assert_eq!(time, same);
    for (row, (found, of_step)) in values.iter().zip(&of_steps).enumerate() {
        let apart = (found[0] - of_step[0]).abs() + (found[1] - of_step[1]).abs();
        assert!(apart < 1e-11, "row {row}: {found:?} {of_step:?}");
    }
}

#[test]
fn rows_are_at_the_times_asked_whatever_the_steps() {
    for (step, interval, end) in [
        (1e-4, 3e-4, 0.0999),
        (1e-3 / 3.0, 1e-3, 0.1),
        (1e-3, 1e-3, 0.1),
        (1e-3, 1e-2, 0.0955),
        // No multiples: between the ends of steps.
        (1e-3, 0.7e-3, 0.1),
        (1e-3, 1.5e-3, 0.0999),
        // Several rows in a step.
        (1e-3, 0.25e-3, 0.01),
        (1e-3, 0.3, 0.1),
    ] {
        let (time, _) = rows(&swinging(json!({"interval": interval}), step, end));
        let asked = asked(interval, end);
        assert_eq!(time.len(), asked.len(), "{step} {interval} {end}: {time:?}");
        for (found, asked) in time.iter().zip(&asked) {
            let apart = (found - asked).abs();
            assert!(
                apart <= 1e-12 * asked,
                "{step} {interval} {end}: {found}, asked for {asked}"
            );
        }
        assert_eq!(time.last(), Some(&end));
    }
}

/// Angle, rate, reaction and acceleration at all multiples of 1.3 ms, of which few are steps.
fn between(integrator: Value) -> Vec<[f64; 6]> {
    let mut scene = swinging(json!({"interval": 1.3e-3}), 1e-3, 0.4);
    scene["integrator"] = integrator;
    let folder = Folder::with(&scene);
    folder.done("scene.json");
    let results = folder.results();
    let time = results.time().unwrap();
    for (row, time) in time.iter().enumerate().take(time.len() - 1) {
        assert!(
            (time - row as f64 * 1.3e-3).abs() < 1e-15,
            "row {row}: {time}"
        );
    }
    let channel = |name: &str| results.history(name).unwrap();
    let (angle, rate) = (channel("angle"), channel("rate"));
    let (force, tip) = (channel("outputs/hinge"), channel("tip"));
    (0..time.len())
        .map(|row| {
            [
                angle[(row, 0)],
                rate[(row, 0)],
                force[(row, 0)],
                force[(row, 1)],
                tip[(row, 0)],
                tip[(row, 1)],
            ]
        })
        .collect()
}

/// Largest distance of each quantity.
fn apart(some: &[[f64; 6]], others: &[[f64; 6]]) -> [f64; 6] {
    assert_eq!(some.len(), others.len());
    std::array::from_fn(|at| {
        let pairs = some.iter().zip(others);
        pairs
            .map(|(a, b)| (a[at] - b[at]).abs())
            .fold(0.0, f64::max)
    })
}

#[test]
fn what_is_recorded_within_steps_is_of_second_order_as_the_steps_are() {
    let equal = |step: f64| json!({"generalized_alpha": {"step": step, "end": 0.4}});
    let exact = between(equal(2.6e-4));
    let coarse = apart(&between(equal(8e-3)), &exact);
    let fine = apart(&between(equal(4e-3)), &exact);
    println!("{coarse:?} {fine:?}");
    for at in 0..6 {
        let ratio = coarse[at] / fine[at];
        assert!(ratio > 2.8 && ratio < 5.0, "{coarse:?} {fine:?}");
    }
    let adaptive = json!({"generalized_alpha": {
        "step": 1e-4, "end": 0.4, "adaptive": {"tolerance": 1e-8, "minimum_step": 1e-9, "maximum_step": 0.1}
    }});
    let adaptive = apart(&between(adaptive), &exact);
    println!("{adaptive:?}");
    assert!(adaptive[0] < 1e-5 && adaptive[1] < 1e-4, "{adaptive:?}");
}

/// Within steps of radau, which are far longer than the interval, everything is as accurate as at their ends.
#[test]
fn what_is_recorded_within_steps_of_radau_is_as_accurate() {
    let radau = |tolerance: f64| json!({"radau": {"tolerance": tolerance, "end": 0.4}});
    let exact = between(radau(1e-11));
    for (tolerance, bound) in [(1e-5, 1e-4), (1e-8, 1e-6)] {
        let found = apart(&between(radau(tolerance)), &exact);
        println!("{found:?}");
        assert!(found[0] < bound && found[1] < 10.0 * bound, "{found:?}");
        // Relative to forces of some newtons and accelerations of gravity.
        let rest = found[2..].iter().copied().fold(0.0, f64::max);
        assert!(rest < 1000.0 * bound, "{found:?}");
    }
}

/// A row within the step that ends at a jump of a load, and one within the step after it.
#[test]
fn rows_beside_a_jump_are_those_of_its_two_sides() {
    let kicked = |integrator: Value| {
        let mut scene = swinging(json!({"interval": 1e-2}), 1e-3, 0.4);
        scene["integrator"] = integrator;
        let at = scene["bodies"]
            .as_object()
            .unwrap()
            .keys()
            .next()
            .unwrap()
            .clone();
        scene["bodies"][&at]["rigid"]["points"]["middle"] = json!([0, 0]);
        let torque = json!([{"formula": "if(t < 0.105, 0, 1)"}]);
        scene["loads"] =
            json!({"kick": {"torque": {"at": format!("{at}/middle"), "components": torque}}});
        let folder = Folder::with(&scene);
        folder.done("scene.json");
        let found = folder.results().history("angle").unwrap();
        (0..found.nrows())
            .map(|row| found[(row, 0)])
            .collect::<Vec<_>>()
    };
    let found = kicked(json!({"radau": {"tolerance": 1e-7, "end": 0.4}}));
    let exact = kicked(json!({"generalized_alpha": {"step": 5e-6, "end": 0.4}}));
    for (row, (found, exact)) in found.iter().zip(&exact).enumerate() {
        assert!((found - exact).abs() < 1e-5, "row {row}: {found} {exact}");
    }
}

#[test]
fn an_end_that_is_no_multiple_of_the_step_leaves_the_forces_as_they_are() {
    // Thirty steps but for 1 ns, which as a step of its own made a reaction of 2e5 of one of 3.
    for step in [0.1 / 30.0 - 3e-11, 0.0042] {
        let folder = Folder::with(&swinging(json!({"every": 1}), step, 0.1));
        folder.done("scene.json");
        let force = folder.results().history("outputs/hinge").unwrap();
        let last = force.nrows() - 1;
        let changes: Vec<f64> = (1..=last)
            .map(|row| (force[(row, 0)] - force[(row - 1, 0)]).abs())
            .collect();
        let usual = changes[last - 4];
        assert!(
            changes[last - 3..]
                .iter()
                .all(|change| *change < 1.5 * usual),
            "{step}: {changes:?}"
        );
    }
}

#[test]
fn a_kinematic_analysis_records_what_is_asked() {
    let scene = |record: Value| {
        let mut scene = swinging(record, 1e-2, 0.1);
        scene["analysis"] = json!("kinematic");
        scene["drives"] = json!({"motor": {"angle": {"joint": "hinge", "formula": "sin(20*t)"}}});
        scene
    };
    for (interval, count) in [(0.015, 8), (0.02, 6)] {
        let (time, values) = rows(&scene(json!({"interval": interval})));
        assert_eq!(time.len(), count, "{time:?}");
        for (time, [angle, rate]) in time.iter().zip(values) {
            assert!(
                (angle - (20.0 * time).sin()).abs() < 1e-12,
                "{angle} at {time}"
            );
            assert!(
                (rate - 20.0 * (20.0 * time).cos()).abs() < 1e-10,
                "{rate} at {time}"
            );
        }
    }
    assert_eq!(rows(&scene(json!({"every": 4}))).0, [0.0, 0.04, 0.08, 0.1]);
}

#[test]
fn a_control_loop_loses_no_time() {
    let text = swinging(json!({"every": 1}), 1e-5, 1.0).to_string();
    let scene = Scene::parse(&text, std::path::Path::new("scene.json")).unwrap();
    let mut mechanism = Mechanism::start(&scene).unwrap();
    for step in 1..=100_000_u32 {
        mechanism.step(1e-5).unwrap();
        let exact = f64::from(step) * 1e-5;
        let time = mechanism.time();
        assert!(
            (time - exact).abs() <= f64::EPSILON * exact,
            "{step}: {time:.17}"
        );
    }
    assert_eq!(mechanism.time(), 1.0);
}

#[test]
fn a_file_of_more_rows_than_anybody_waits_for_is_refused() {
    Folder::with(&swinging(json!({"interval": 1e-300}), 1e-3, 0.1)).refused(
        "scene.json",
        &[
            "record.interval: is 1e-300",
            "1e299 times",
            "expected at most 1e9",
        ],
    );
}

#[test]
fn fields_are_written_at_the_times_asked() {
    let folder = Folder::slider_crank();
    folder.set_scene(
        "fields",
        json!([{"body": "rod", "times": [0, 1e-4, 2.55e-4], "directory": "fields"}]),
    );
    folder.set_scene(
        "integrator/generalized_alpha",
        json!({"step": 1e-5, "end": 1e-3}),
    );
    folder.done("scene.json");
    let list = folder.read("fields/rod.pvd");
    let times: Vec<f64> = (list.split("timestep=\"").skip(1))
        .map(|rest| rest.split('"').next().unwrap().parse().unwrap())
        .collect();
    assert_eq!(times, [0.0, 1e-4, 2.55e-4]);
}
