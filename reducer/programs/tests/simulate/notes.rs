//! Notes are said where they are true: not where forces, times or energies are nothing but rounding, and not instead of an error.

use dcb_formats::dcb::read_superelement;
use dcb_tests::python;
use serde_json::json;

use crate::scene_folder::spatial;
use crate::support::{Folder, list, number, says};

/// The slider-crank at rest, without its motor, for a thousand steps of this size.
fn resting(step: f64) -> Folder {
    let folder = Folder::slider_crank();
    for key in [
        "crank/angular_velocity",
        "rod/velocity",
        "rod/angular_velocity",
    ] {
        folder.unset("scene.json", &format!("bodies/{key}"));
    }
    folder.unset("scene.json", "drives");
    folder.set_integrator("step", step);
    folder.set_integrator("end", 1000.0 * step);
    folder
}

/// Defects of a run without notes.
#[track_caller]
fn says_nothing(folder: &Folder, words: &str) {
    let answer = folder.done(words);
    for text in ["rounding of positions", "energy balance lacks", "are wrong"] {
        assert!(!answer.stderr.contains(text), "{}", answer.stderr);
    }
}

#[test]
fn nothing_is_told_of_forces_and_energies_that_are_rounding() {
    for force in [
        None,
        Some(json!(1e-9)),
        Some(json!({"formula": "1e-6*t^3"})),
    ] {
        let folder = resting(1e-6);
        if let Some(force) = &force {
            folder.set_scene(
                "loads",
                json!({"push": {"force": {"at": "slider/pin", "components": [force, 0]}}}),
            );
        }
        says_nothing(&folder, "scene.json --model everything");
        if force.is_none() {
            let summary = folder.done("scene.json --force --model everything").stdout;
            assert!(!summary.contains("energy balance"), "{summary}");
        }
    }
}

/// A bob in space that hangs at rest: its energies are rounding, and those of gravity are as large as that of its height.
#[test]
fn a_spatial_body_at_rest_lacks_no_energy() {
    let folder = Folder::with(&spatial(json!({
        "gravity": [0.1, -0.2, -9.81],
        "bodies": {"bob": {"rigid": {"mass": 2, "inertia": [0.1, 0.1, 0.1], "points": {"top": [0.1, 0.2, 0.7]}},
                           "position": [0.9, 1.8, 2.3]}},
        "ground": {"points": {"pin": [1, 2, 3]}},
        "joints": {"hold": {"fixed": {"a": "bob/top", "b": "ground/pin"}}},
        "outputs": {"top": {"position": {"at": "bob/top"}}},
        "integrator": {"generalized_alpha": {"step": 1e-3, "end": 0.5}}
    })));
    says_nothing(&folder, "scene.json");
    // On springs it swings by rounding.
    folder.set_scene("joints", json!({}));
    folder.set_scene("gravity", json!([0, 0, 0]));
    folder.set_scene(
        "springs",
        json!({"soft": {"bushing": {"a": "ground/pin", "b": "bob/top",
            "translation": [1e3, 1e3, 1e3], "rotation": [10, 10, 10]}}}),
    );
    folder.set_scene("bodies/bob/angular_velocity", json!([1e-14, 0, 1e-14]));
    says_nothing(&folder, "scene.json --force");
}

/// Ten steps of a motion whose period takes two hundred: nothing can be said of its frequency.
#[test]
fn a_run_shorter_than_a_period_says_nothing_of_frequencies() {
    let folder = Folder::slider_crank();
    folder.set_integrator("step", 2e-4);
    folder.set_integrator("end", 2e-3);
    says_nothing(&folder, "scene.json --model everything");
}

/// The motor turns the crank while a second drive pushes the slider away.
fn contradicting() -> Folder {
    let folder = Folder::slider_crank();
    folder.set_scene(
        "drives/push",
        json!({"position": {"joint": "guide", "polynomial": [0, -20]}}),
    );
    folder.set_integrator("end", 0.01);
    folder.set_integrator("step", 5e-6);
    folder
}

#[test]
fn drives_that_contradict_each_other_beyond_the_theory_are_an_error() {
    let folder = contradicting();
    for model in ["needed", "everything"] {
        let answer = folder.run(&format!("scene.json --force --model {model}"));
        answer.is_error(
            1,
            &[
                "error: t = 2.",
                "\"motor\", \"push\" contradict each other",
                "body \"rod\" deflects by 0.1",
                "good to about 0.1",
                "leave one drive out",
            ],
        );
        let (reason, time, _) = folder.stopped();
        says!(reason, "contradict");
        assert!((1e-3..5e-3).contains(&time.unwrap()), "{time:?}");
    }
    // As a reference of a study neither.
    folder
        .run("prepare scene.json --tolerance 1e-2")
        .is_error(1, &["contradict each other"]);
}

#[test]
fn drives_that_fit_each_other_and_one_that_bends_a_lot_are_no_error() {
    // Both slider and crank at rest, held by drives that agree.
    let folder = contradicting();
    folder.set_scene("drives/motor/angle/polynomial", json!([0]));
    folder.set_scene("drives/push/position/polynomial", json!([0]));
    folder.set_scene("bodies/crank/angular_velocity", 0);
    folder.set_scene("bodies/rod/velocity", json!([0, 0]));
    folder.set_scene("bodies/rod/angular_velocity", 0);
    folder.done("scene.json --model everything");
    // One drive and a force that bends a beam by more than a tenth of its length: told, no error.
    let folder = Folder::beam(&spatial(json!({
        "bodies": {"beam": {"superelement": "beam.dcb.h5"}},
        "joints": {"hinge": {"revolute": {"a": "ground", "b": "beam/a", "axis": [0, 0, 1]}}},
        "drives": {"motor": {"angle": {"joint": "hinge", "constant": 0}}},
        "loads": {"push": {"force": {"at": "beam/b", "components": [0, {"formula": "4e5*t"}, 0]}}},
        "integrator": {"generalized_alpha": {"step": 1e-4, "end": 0.02}}
    })));
    let answer = folder.run("scene.json --model everything");
    says!(answer.stderr, "the theory is linear");
    assert!(!answer.stderr.contains("contradict"), "{}", answer.stderr);
}

/// Notes on fast motion come from all steps, however few are recorded.
#[test]
fn records_do_not_decide_what_is_told_of_fast_motion() {
    let scene = spatial(json!({
        "bodies": {"beam": {"superelement": "beam.dcb.h5", "damping": {"modal": 0.1}}},
        "joints": {"clamp": {"fixed": {"a": "ground", "b": "beam/a"}}},
        "integrator": {"generalized_alpha": {"step": 1e-4, "end": 0.05}}
    }));
    let folder = Folder::beam_with_modes(&scene, 6);
    let superelement = read_superelement(&folder.path("beam.dcb.h5")).unwrap();
    let omega = 2.0 * superelement.modes.first_omitted_eigenvalue.sqrt();
    let force = json!({"formula": format!("sin({omega:e}*t)*(1 - exp(-({omega:e}*t/60)^2))")});
    let push = json!({"force": {"at": "beam/b", "components": [0, force, 0]}});
    folder.set_scene("loads/push", push);
    folder.set_integrator("step", 2e-2 / omega);
    folder.set_integrator("end", 240.0 / omega);
    let told = |every: usize| {
        folder.set_scene("record", json!({"every": every}));
        let stderr = folder.done("scene.json --force --model everything").stderr;
        let told = |line: &&str| line.contains("elastic energy");
        stderr
            .lines()
            .filter(told)
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    let all = told(7);
    println!("{all:?}");
    assert_eq!(all.len(), 1);
    // Three records, of about 38 periods.
    for every in [500, 4000] {
        assert_eq!(told(every), all, "every {every} steps");
    }
}

#[test]
fn a_state_of_rest_has_its_energies_and_no_works() {
    let folder = Folder::beam(&spatial(json!({
        "gravity": [0, -9.81, 0],
        "bodies": {"beam": {"superelement": "beam.dcb.h5"}},
        "joints": {"clamp": {"fixed": {"a": "ground", "b": "beam/a"}}},
        "loads": {"push": {"force": {"at": "beam/b", "components": [0, 1, 0]}}},
        "outputs": {"energies": "energy", "tip": {"displacement": {"at": "beam/b"}}},
        "analysis": "static"
    })));
    folder.done("scene.json --model everything");
    let results = folder.results();
    for channel in ["energy/balance", "outputs/energies"] {
        let columns = &results.channel(channel).unwrap().columns;
        let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
        assert_eq!(names, ["kinetic", "strain", "gravity", "springs"]);
        let energies = results.history(channel).unwrap();
        assert!(energies.is_all_finite());
        assert_eq!((energies[(0, 0)], energies[(0, 3)]), (0.0, 0.0));
        assert!(energies[(0, 1)] > 0.0);
    }
    // Clapeyron: without gravity the strain energy is half of force times deflection.
    folder.unset("scene.json", "gravity");
    folder.done("scene.json --force --model everything");
    let results = folder.results();
    let strain = results.history("energy/balance").unwrap()[(0, 1)];
    let tip = results.history("outputs/tip").unwrap()[(0, 1)];
    assert!(
        (strain / (0.5 * tip) - 1.0).abs() < 1e-5,
        "{strain:e} {tip:e}"
    );
}

/// Shapes, frequencies and damping stand as datasets, and the commands show them.
#[test]
fn modes_stand_in_the_file_as_numbers() {
    let folder = Folder::beam(&spatial(json!({
        "bodies": {"beam": {"superelement": "beam.dcb.h5", "damping": {"modal": 0.01}}},
        "joints": {"clamp": {"fixed": {"a": "ground", "b": "beam/a"}}},
        "analysis": {"modes": {"count": 5}}
    })));
    let told = folder.done("scene.json --model everything").stdout;
    says!(told, "frequency [Hz]");
    let results = folder.results();
    let modes = results.modes().unwrap().unwrap();
    let summary = results.provenance("summary").unwrap();
    let listed = list(&summary["modes"]);
    assert_eq!(modes.frequency.len(), 5);
    for (k, mode) in listed.iter().enumerate() {
        assert_eq!(number(&mode["frequency"]), modes.frequency[k]);
        assert_eq!(number(&mode["damping_ratio"]), modes.damping_ratio[k]);
        assert_eq!(number(&mode["growth"]), modes.growth[k]);
    }
    let shown = folder.done("show scene.h5").stdout;
    says!(
        shown,
        "5 modes: frequency [Hz], damping_ratio [1], growth [1/s], angular frequency [rad/s]"
    );
    folder.done("csv scene.h5 frequency -o frequency.csv");
    let table = folder.read("frequency.csv");
    assert_eq!(table.lines().next(), Some("mode [1],frequency [Hz]"));
    folder.done("csv scene.h5");
    let table = folder.read("scene.csv");
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(
        lines[0],
        "mode [1],frequency [Hz],damping_ratio [1],growth [1/s]"
    );
    let first: Vec<f64> = lines[1].split(',').map(|n| n.parse().unwrap()).collect();
    assert_eq!(first[..2], [1.0, modes.frequency[0]]);
    assert_eq!(first[2..], [modes.damping_ratio[0], modes.growth[0]]);
    assert_eq!(lines.len(), 6);
    folder.done("plot scene.h5");
    says!(folder.read("scene.svg"), "frequency [Hz]");
    // h5py finds the same shapes as the summary has.
    const SCRIPT: &str = "
import h5py, json, sys
with h5py.File(sys.argv[1]) as file:
    shapes = file['modes/shapes/beam']
    print(json.dumps({'shapes': shapes[:].tolist(), 'columns': [str(c) for c in shapes.attrs['columns']], 'units': file['modes/frequency'].attrs['units']}))";
    let found = python::answer(SCRIPT, &folder.path("scene.h5"));
    assert_eq!(found["units"], json!("Hz"));
    assert_eq!(
        list(&found["columns"])[..7],
        ["x", "y", "z", "rx", "ry", "rz", "1"].map(|name| json!(name))
    );
    for (k, mode) in listed.iter().enumerate() {
        assert_eq!(found["shapes"][k][0], mode["bodies"]["beam"]["in_phase"]);
        assert_eq!(found["shapes"][k][1], mode["bodies"]["beam"]["behind"]);
    }
}

/// A beam of free modes with one per cent, clamped: what is left is said, and stands in the file.
#[test]
fn a_run_says_the_damping_of_the_assembled_mechanism() {
    let scene = spatial(json!({
        "bodies": {"beam": {"superelement": "beam.dcb.h5", "damping": {"modal": 0.01}}},
        "joints": {"clamp": {"fixed": {"a": "ground", "b": "beam/a"}}},
        "outputs": {"tip": {"displacement": {"at": "beam/b"}}},
        "integrator": {"generalized_alpha": {"step": 1e-4, "end": 1e-3}}
    }));
    let folder = Folder::beam(&scene);
    let told = folder.done("scene.json --model everything").stderr;
    says!(
        told,
        "damping ratios of the lowest modes of the assembled mechanism: "
    );
    let summary = |folder: &Folder| {
        let summary = folder.results().provenance("summary").unwrap();
        list(&summary["effective_damping"]).clone()
    };
    let modal = summary(&folder);
    assert_eq!(modal.len(), 4);
    // The modal analysis of the same scene has the same, from complex eigenvalues.
    folder.set_scene("analysis", json!({"modes": {"count": 4}}));
    folder.done("scene.json -o modes.h5 --model everything");
    let results = folder.results_of("modes.h5");
    let modes = results.modes().unwrap().unwrap();
    for (k, mode) in modal.iter().enumerate() {
        let (frequency, ratio) = (number(&mode["frequency"]), number(&mode["damping_ratio"]));
        println!("{frequency} {ratio:e} {:e}", modes.damping_ratio[k]);
        assert!((frequency / modes.frequency[k] - 1.0).abs() < 1e-3);
        assert!((ratio / modes.damping_ratio[k] - 1.0).abs() < 2e-2);
    }
    assert!(number(&modal[0]["damping_ratio"]) < 0.5 * 0.01);
    folder.set_scene("analysis", "transient");
    let beta = 0.02 / (std::f64::consts::PI * number(&modal[0]["frequency"]));
    folder.set_scene("bodies/beam/damping", json!({"rayleigh": [0, beta]}));
    folder.done("scene.json --force --model everything");
    let found = summary(&folder)[0]["damping_ratio"].as_f64().unwrap();
    assert!((found / 0.02 - 1.0).abs() < 2e-2, "{found}");
    // Nothing to say of an undamped beam.
    folder.unset("scene.json", "bodies/beam/damping");
    let told = folder.done("scene.json --force --model everything").stderr;
    assert!(!told.contains("damping ratios"), "{told}");
    for (given, texts) in [
        (
            json!({"rayleigh": [0, -1]}),
            ["bodies.beam.damping.rayleigh", "has the factor -1"],
        ),
        (
            json!({"rayleigh": {"frequencies": [1, 10], "ratios": [0.5, 0.01]}}),
            ["bodies.beam.damping.rayleigh", "needs beta = -"],
        ),
        (
            json!({"rayleigh": {"frequencies": [1, 10]}}),
            ["scene.json", "expected [alpha, beta]"],
        ),
    ] {
        folder.set_scene("bodies/beam/damping", given);
        folder.refused("scene.json --force", &texts);
    }
}
