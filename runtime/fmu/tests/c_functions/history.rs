//! The motion of a unit is that of a whole run, or of the same mechanism stepped in Rust.

use std::path::Path;

use dcb_fmu::{Status, fmi3Reset, fmi3Terminate};
use dcb_formats::results::Results;
use dcb_runtime::{Mechanism, Scene};

use crate::importer::Importer;
use crate::support::{Folder, arm, arm_scene, slider_crank};

/// Names of the numbers of a results file's outputs, and their values row by row.
fn recorded(results: &Results) -> (Vec<String>, Vec<Vec<f64>>) {
    let (mut names, mut rows) = (Vec::new(), vec![Vec::new(); results.step_count()]);
    let outputs = results.channels().iter();
    for channel in outputs.filter(|channel| channel.path.starts_with("outputs/")) {
        let values = results.history(&channel.path).unwrap();
        names.extend(channel.columns.iter().map(|column| channel.label(column)));
        for (index, row) in rows.iter_mut().enumerate() {
            row.extend((0..values.ncols()).map(|column| values[(index, column)]));
        }
    }
    (names, rows)
}

/// The largest difference of any output from a whole run, of its largest value.
fn against_run(folder: &Folder, every: usize, length: f64) -> f64 {
    let (names, rows) = recorded(&folder.results());
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let unit = Importer::started(&folder.unpacked("unit"));
    let mut differences = vec![0.0_f64; names.len()];
    let mut largest = vec![0.0_f64; names.len()];
    assert!(rows.len() / every > 20);
    for (index, row) in rows.iter().step_by(every).enumerate() {
        if index > 0 {
            unit.go(length, index - 1..index);
        }
        for (column, value) in unit.get_all(&names).into_iter().enumerate() {
            differences[column] = differences[column].max((value - row[column]).abs());
            largest[column] = largest[column].max(row[column].abs());
        }
    }
    assert_eq!(unsafe { fmi3Terminate(unit.instance) }, Status::Ok);
    let relative = differences.iter().zip(largest);
    relative
        .map(|(off, of)| off / of.max(f64::MIN_POSITIVE))
        .fold(0.0, f64::max)
}

/// Two superelements with one file name, nodal fields of one node, gravity, a formula.
#[test]
fn a_spatial_unit_moves_as_a_whole_run_does() {
    let folder = arm();
    let off = against_run(&folder, 1, 1e-3);
    assert!(off < 1e-12, "{off:e}");
    let off = against_run(&folder, 7, 7e-3);
    assert!(off < 1e-12, "seven inner steps: {off:e}");
}

#[test]
fn a_planar_unit_moves_as_a_whole_run_does() {
    let step = 1.1635528346628864e-5;
    let off = against_run(&slider_crank(), 1, 10.0 * step);
    assert!(off < 1e-12, "{off:e}");
}

/// A single communication step: an adaptive run has no other points to end its steps at.
#[test]
fn an_adaptive_unit_takes_the_steps_of_a_whole_run() {
    let folder = arm();
    let mut scene = arm_scene();
    scene["integrator"]["generalized_alpha"]["adaptive"] =
        serde_json::json!({"tolerance": 1e-5, "minimum_step": 1e-6, "maximum_step": 5e-3});
    folder.write_scene(&scene);
    let (names, rows) = recorded(&folder.results());
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let last = rows.last().unwrap();
    assert!(rows.len() > 20 && rows.len() != 201, "{}", rows.len());
    let unit = Importer::started(&folder.unpacked("unit"));
    let (status, reached) = unit.step(0.0, 0.2);
    assert_eq!((status, reached), (Status::Ok, 0.2));
    assert_eq!(&unit.get_all(&names), last);
    // Points between cut steps short: the same motion within the tolerance.
    let other = Importer::started(&folder.unpacked("other"));
    other.go(0.2 / 13.0, 0..13);
    let off = (other.get("tip.z") - unit.get("tip.z")).abs();
    assert!(off < 1e-3 && off > 0.0, "{off:e}");
}

fn mechanism(folder: &Folder) -> Mechanism {
    Mechanism::start(&Scene::read(&folder.path("scene.json")).unwrap()).unwrap()
}

/// Communication steps of 2.5 inner steps are divided into three equal ones; then a whole multiple follows from a point off the grid.
#[test]
fn other_communication_steps_are_divided_evenly() {
    let folder = arm();
    let mut same = mechanism(&folder);
    let unit = Importer::started(&folder.unpacked("unit"));
    let length = 2.5e-3;
    for index in 0..9 {
        unit.go(length, index..index + 1);
        // From a point of the grid and from one between.
        for _ in 0..3 {
            same.step(length / 3.0).unwrap();
        }
        let expected = same.output("tip").unwrap()[2];
        let off = (unit.get("tip.z") - expected).abs();
        assert!(off < 1e-12, "{off:e} at {index}");
    }
    assert_eq!(unit.step(9.0 * length, 2e-3).0, Status::Ok);
    for _ in 0..2 {
        same.step(1e-3).unwrap();
    }
    let off = (unit.get("tip.z") - same.output("tip").unwrap()[2]).abs();
    assert!(off < 1e-12, "{off:e}");
    assert_eq!(unit.get("time"), 9.0 * length + 2e-3);
}

/// Proportional and differential control, sampled every two steps and held: around the unit, and around the mechanism in Rust.
#[test]
fn a_controlled_unit_moves_as_a_controlled_mechanism() {
    let folder = arm();
    let mut same = mechanism(&folder);
    let unit = Importer::started(&folder.unpacked("unit"));
    let law = |angle: f64, rate: f64| -80.0 * (angle + 0.1) - 12.0 * rate;
    let mut largest: f64 = 0.0;
    for index in 0..100 {
        let torque = law(unit.get("angle"), unit.get("rate"));
        unit.must_set("motor", torque);
        unit.must_set("gust/0", 0.01 * torque);
        assert_eq!(unit.get("motor"), torque);
        let expected = law(
            same.output("angle").unwrap()[0],
            same.output("rate").unwrap()[0],
        );
        same.set_input("motor", expected).unwrap();
        same.set_input("gust/0", 0.01 * expected).unwrap();
        largest = largest.max(expected.abs());
        assert!((torque - expected).abs() < 1e-12 * largest, "{index}");
        unit.go(2e-3, index..index + 1);
        for _ in 0..2 {
            same.step(1e-3).unwrap();
        }
        let expected = same.output("tip").unwrap();
        let found = unit.get_all(&["tip.x", "tip.y", "tip.z"]);
        for (found, expected) in found.iter().zip(expected) {
            assert!(
                (found - expected).abs() < 1e-12,
                "{index}: {found} {expected}"
            );
        }
    }
    assert!(largest > 5.0);
}

/// Parameters are the numbers of the scene; inputs have start values; a reset brings both back.
#[test]
fn parameters_are_those_of_the_scene() {
    let folder = arm();
    let unpacked = folder.unpacked("unit");
    let text = std::fs::read_to_string(folder.path("scene.json")).unwrap();
    let changed = [
        ("gravity.x", 1.5, "[0,0,-9.81]", "[1.5,0,-9.81]"),
        ("damping.upper", 0.2, "{\"modal\":0.01}", "{\"modal\":0.2}"),
        ("constants.push", 30.0, "{\"push\":3.0}", "{\"push\":30.0}"),
        ("integrator.step", 2e-3, "\"step\":0.001", "\"step\":0.002"),
        ("gust/2", 7.0, "\"initial\":0.5", "\"initial\":7.0"),
    ];
    let motion = |unit: &Importer| {
        unit.go(4e-3, 0..10);
        unit.get_all(&["tip.x", "tip.y", "tip.z", "middle.z", "pull.fx"])
    };
    let unit = Importer::of(&unpacked);
    unit.start();
    let usual = motion(&unit);
    for (name, value, from, to) in changed {
        assert_eq!(unsafe { fmi3Reset(unit.instance) }, Status::Ok);
        let before = unit.get(name);
        unit.must_set(name, value);
        assert_eq!(unit.get(name), value);
        unit.start();
        let found = motion(&unit);
        assert!(text.contains(from), "{from} in {text}");
        let scene = Scene::parse(&text.replace(from, to), Path::new("other.json")).unwrap();
        let scene = Scene {
            directory: folder.path("scene.json").parent().unwrap().to_owned(),
            ..scene
        };
        let mut same = Mechanism::start(&scene).unwrap();
        let step = scene.integrator.unwrap().step;
        for _ in 0..(0.04 / step).round() as usize {
            same.step(step).unwrap();
        }
        let mut expected = same.output("tip").unwrap().to_vec();
        expected.push(same.output("middle").unwrap()[2]);
        expected.push(same.output("pull").unwrap()[0]);
        assert_eq!(found, expected, "{name}");
        assert_ne!(found, usual, "{name}");
        assert_eq!(unsafe { fmi3Reset(unit.instance) }, Status::Ok);
        assert_eq!(unit.get(name), before, "{name} after a reset");
        unit.start();
        assert_eq!(motion(&unit), usual, "{name} after a reset");
    }
}

/// What follows from start values can be asked for before the motion begins.
#[test]
fn the_start_is_known_in_initialization_mode() {
    let folder = arm();
    let unit = Importer::of(&folder.unpacked("unit"));
    assert_eq!(unit.enter(0.0), Status::Ok);
    // Horizontal links at rest: the tip is 1.6 m out, and the elbow carries part of the lower link's weight.
    let usual = unit.get("pull.fz");
    assert!((unit.get("tip.x") - 1.6).abs() < 1e-9);
    unit.must_set("gravity.z", 0.0);
    unit.must_set("gust/2", 0.0);
    let without = unit.get("pull.fz");
    assert!(without.abs() < 1e-9 * usual.abs(), "{without:e} {usual:e}");
    assert_eq!(unit.exit(), Status::Ok);
    assert_eq!(unit.get("energy_defect"), 0.0);
}

/// Instances know nothing of each other: side by side in threads they move as one alone.
#[test]
fn instances_in_threads_move_as_one_alone() {
    let folder = arm();
    let unpacked = &folder.unpacked("unit");
    let run = |torque: f64| {
        let unit = Importer::started(unpacked);
        unit.must_set("motor", torque);
        unit.go(2e-3, 0..50);
        unit.get_all(&["tip.x", "tip.z", "angle"])
    };
    let alone: Vec<_> = (0..4).map(|index| run(f64::from(index))).collect();
    let together: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4)
            .map(|index| scope.spawn(move || run(f64::from(index))))
            .collect();
        threads
            .into_iter()
            .map(|thread| thread.join().unwrap())
            .collect()
    });
    assert_eq!(alone, together);
    assert_ne!(alone[0], alone[1]);
}
