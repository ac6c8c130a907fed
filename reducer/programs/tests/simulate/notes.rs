//! Notes are said where they are true: not where forces, times or energies are nothing but rounding, and not instead of an error.

use dcb_formats::dcb::read_superelement;
use dcb_formats::results::{Outcome, Results};
use dcb_tests::python;
use serde_json::json;

use super::support::Folder;

/// The slider-crank at rest, without its motor, for a thousand steps of this size.
fn resting(step: f64) -> Folder {
    let folder = Folder::slider_crank();
    folder.edit("scene.json", |scene| {
        for (body, keys) in [
            ("crank", vec!["angular_velocity"]),
            ("rod", vec!["velocity", "angular_velocity"]),
        ] {
            let body = scene["bodies"][body].as_object_mut().unwrap();
            keys.iter().for_each(|key| drop(body.remove(*key)));
        }
        scene.as_object_mut().unwrap().remove("drives");
        scene["integrator"]["generalized_alpha"]["step"] = json!(step);
        scene["integrator"]["generalized_alpha"]["end"] = json!(1000.0 * step);
    });
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
            folder.edit("scene.json", |scene| {
                scene["loads"] =
                    json!({"push": {"force": {"at": "slider/pin", "components": [force, 0]}}});
            });
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
    let folder = Folder::with(&json!({
        "dimension": 3,
        "units": {"length": "m", "mass": "kg", "time": "s"},
        "gravity": [0.1, -0.2, -9.81],
        "bodies": {"bob": {"rigid": {"mass": 2, "inertia": [0.1, 0.1, 0.1], "points": {"top": [0.1, 0.2, 0.7]}},
                           "position": [0.9, 1.8, 2.3]}},
        "ground": {"points": {"pin": [1, 2, 3]}},
        "joints": {"hold": {"fixed": {"a": "bob/top", "b": "ground/pin"}}},
        "outputs": {"top": {"position": {"at": "bob/top"}}},
        "integrator": {"generalized_alpha": {"step": 1e-3, "end": 0.5}}
    }));
    says_nothing(&folder, "scene.json");
    // On springs it swings by rounding.
    folder.edit("scene.json", |scene| {
        scene["joints"] = json!({});
        scene["gravity"] = json!([0, 0, 0]);
        scene["springs"] = json!({"soft": {"bushing": {"a": "ground/pin", "b": "bob/top",
            "translation": [1e3, 1e3, 1e3], "rotation": [10, 10, 10]}}});
        scene["bodies"]["bob"]["angular_velocity"] = json!([1e-14, 0, 1e-14]);
    });
    says_nothing(&folder, "scene.json --force");
}

/// Ten steps of a motion whose period takes two hundred: nothing can be said of its frequency.
#[test]
fn a_run_shorter_than_a_period_says_nothing_of_frequencies() {
    let folder = Folder::slider_crank();
    folder.edit("scene.json", |scene| {
        scene["integrator"]["generalized_alpha"]["step"] = json!(2e-4);
        scene["integrator"]["generalized_alpha"]["end"] = json!(2e-3);
    });
    says_nothing(&folder, "scene.json --model everything");
}

/// The motor turns the crank while a second drive pushes the slider away.
fn contradicting() -> Folder {
    let folder = Folder::slider_crank();
    folder.edit("scene.json", |scene| {
        scene["drives"]["push"] = json!({"position": {"joint": "guide", "polynomial": [0, -20]}});
        scene["integrator"]["generalized_alpha"]["end"] = json!(0.01);
        scene["integrator"]["generalized_alpha"]["step"] = json!(5e-6);
    });
    folder
}

#[test]
fn drives_that_contradict_each_other_beyond_the_theory_are_an_error() {
    let folder = contradicting();
    for model in ["needed", "everything"] {
        let answer = folder.run(&format!("scene.json --force --model {model}"));
        answer.assert(
            1,
            &[
                "error: t = 2.",
                "\"motor\", \"push\" contradict each other",
                "body \"rod\" deflects by 0.1",
                "good to about 0.1",
                "leave one drive out",
            ],
        );
        let results = Results::open(folder.path("scene.h5")).unwrap();
        match results.outcome() {
            Outcome::Stopped {
                reason,
                time: Some(time),
            } => {
                assert!(reason.contains("contradict"), "{reason}");
                assert!(*time > 1e-3 && *time < 5e-3, "{time}");
            }
            other => panic!("{other:?}"),
        }
    }
    // As a reference of a study neither.
    folder
        .run("prepare scene.json --tolerance 1e-2")
        .assert(1, &["contradict each other"]);
}

#[test]
fn drives_that_fit_each_other_and_one_that_bends_a_lot_are_no_error() {
    // Both slider and crank at rest, held by drives that agree.
    let folder = contradicting();
    folder.edit("scene.json", |scene| {
        scene["drives"]["motor"]["angle"]["polynomial"] = json!([0]);
        scene["drives"]["push"]["position"]["polynomial"] = json!([0]);
        scene["bodies"]["crank"]["angular_velocity"] = json!(0);
        scene["bodies"]["rod"]["velocity"] = json!([0, 0]);
        scene["bodies"]["rod"]["angular_velocity"] = json!(0);
    });
    folder.done("scene.json --model everything");
    // One drive and a force that bends a beam by more than a tenth of its length: told, no error.
    let folder = Folder::beam(&json!({
        "dimension": 3,
        "units": {"length": "m", "mass": "kg", "time": "s"},
        "bodies": {"beam": {"superelement": "beam.dcb.h5"}},
        "joints": {"hinge": {"revolute": {"a": "ground", "b": "beam/a", "axis": [0, 0, 1]}}},
        "drives": {"motor": {"angle": {"joint": "hinge", "constant": 0}}},
        "loads": {"push": {"force": {"at": "beam/b", "components": [0, {"formula": "4e5*t"}, 0]}}},
        "integrator": {"generalized_alpha": {"step": 1e-4, "end": 0.02}}
    }));
    let answer = folder.run("scene.json --model everything");
    assert!(
        answer.stderr.contains("the theory is linear"),
        "{}",
        answer.stderr
    );
    assert!(!answer.stderr.contains("contradict"), "{}", answer.stderr);
}

/// Notes on fast motion come from all steps, however few are recorded.
#[test]
fn records_do_not_decide_what_is_told_of_fast_motion() {
    let scene = json!({
        "dimension": 3,
        "units": {"length": "m", "mass": "kg", "time": "s"},
        "bodies": {"beam": {"superelement": "beam.dcb.h5", "damping": {"modal": 0.1}}},
        "joints": {"clamp": {"fixed": {"a": "ground", "b": "beam/a"}}},
        "integrator": {"generalized_alpha": {"step": 1e-4, "end": 0.05}}
    });
    let folder = Folder::beam_with_modes(&scene, 6);
    let superelement = read_superelement(&folder.path("beam.dcb.h5")).unwrap();
    let omega = 2.0 * superelement.modes.first_omitted_eigenvalue.sqrt();
    let force = json!({"formula": format!("sin({omega:e}*t)*(1 - exp(-({omega:e}*t/60)^2))")});
    folder.edit("scene.json", |scene| {
        scene["loads"] = json!({"push": {"force": {"at": "beam/b", "components": [0, force, 0]}}});
        let step = 2e-2 / omega;
        scene["integrator"]["generalized_alpha"]["step"] = json!(step);
        scene["integrator"]["generalized_alpha"]["end"] = json!(12000.0 * step);
    });
    let told = |every: usize| {
        folder.edit("scene.json", |scene| {
            scene["record"] = json!({"every": every})
        });
        let stderr = folder.done("scene.json --force --model everything").stderr;
        let lines = stderr
            .lines()
            .filter(|line| line.contains("elastic energy"));
        lines.map(str::to_owned).collect::<Vec<_>>()
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
    let folder = Folder::beam(&json!({
        "dimension": 3,
        "units": {"length": "m", "mass": "kg", "time": "s"},
        "gravity": [0, -9.81, 0],
        "bodies": {"beam": {"superelement": "beam.dcb.h5"}},
        "joints": {"clamp": {"fixed": {"a": "ground", "b": "beam/a"}}},
        "loads": {"push": {"force": {"at": "beam/b", "components": [0, 1, 0]}}},
        "outputs": {"energies": "energy", "tip": {"displacement": {"at": "beam/b"}}},
        "analysis": "static"
    }));
    folder.done("scene.json --model everything");
    let results = Results::open(folder.path("scene.h5")).unwrap();
    for channel in ["energy/balance", "outputs/energies"] {
        let names: Vec<String> = results
            .channel(channel)
            .unwrap()
            .columns
            .iter()
            .map(|c| c.name.clone())
            .collect();
        assert_eq!(names, ["kinetic", "strain", "gravity", "springs"]);
        let energies = results.history(channel).unwrap();
        assert!(
            energies
                .col_iter()
                .flat_map(|c| c.iter().copied().collect::<Vec<_>>())
                .all(f64::is_finite)
        );
        assert_eq!((energies[(0, 0)], energies[(0, 3)]), (0.0, 0.0));
        assert!(energies[(0, 1)] > 0.0);
    }
    // Clapeyron: without gravity the strain energy is half of force times deflection.
    folder.edit("scene.json", |scene| {
        scene.as_object_mut().unwrap().remove("gravity");
    });
    folder.done("scene.json --force --model everything");
    let results = Results::open(folder.path("scene.h5")).unwrap();
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
    let folder = Folder::beam(&json!({
        "dimension": 3,
        "units": {"length": "m", "mass": "kg", "time": "s"},
        "bodies": {"beam": {"superelement": "beam.dcb.h5", "damping": {"modal": 0.01}}},
        "joints": {"clamp": {"fixed": {"a": "ground", "b": "beam/a"}}},
        "analysis": {"modes": {"count": 5}}
    }));
    let told = folder.done("scene.json --model everything").stdout;
    assert!(told.contains("frequency [Hz]"), "{told}");
    let results = Results::open(folder.path("scene.h5")).unwrap();
    let modes = results.modes().unwrap().unwrap();
    let summary = results.provenance("summary").unwrap();
    let listed = summary["modes"].as_array().unwrap();
    assert_eq!(modes.frequency.len(), 5);
    for (k, mode) in listed.iter().enumerate() {
        assert_eq!(mode["frequency"].as_f64().unwrap(), modes.frequency[k]);
        assert_eq!(
            mode["damping_ratio"].as_f64().unwrap(),
            modes.damping_ratio[k]
        );
        assert_eq!(mode["growth"].as_f64().unwrap(), modes.growth[k]);
    }
    let shown = folder.done("show scene.h5").stdout;
    assert!(
        shown.contains("5 modes: frequency [Hz], damping_ratio [1], growth [1/s]"),
        "{shown}"
    );
    folder.done("csv scene.h5");
    let table = folder.read("scene.csv");
    let mut lines = table.lines();
    assert_eq!(
        lines.next(),
        Some("mode [1],frequency [Hz],damping_ratio [1],growth [1/s]")
    );
    let first: Vec<f64> = lines
        .next()
        .unwrap()
        .split(',')
        .map(|n| n.parse().unwrap())
        .collect();
    assert_eq!(
        first,
        [
            1.0,
            modes.frequency[0],
            modes.damping_ratio[0],
            modes.growth[0]
        ]
    );
    assert_eq!(table.lines().count(), 6);
    folder.done("plot scene.h5");
    assert!(folder.read("scene.svg").contains("frequency [Hz]"));
    // h5py finds the same shapes as the summary has.
    const SCRIPT: &str = "
import h5py, json, sys
with h5py.File(sys.argv[1]) as file:
    shapes = file['modes/shapes/beam']
    print(json.dumps({'shapes': shapes[:].tolist(), 'columns': [str(c) for c in shapes.attrs['columns']], 'units': file['modes/frequency'].attrs['units']}))";
    let found = python::answer(SCRIPT, &folder.path("scene.h5"));
    assert_eq!(found["units"], json!("Hz"));
    assert_eq!(
        found["columns"].as_array().unwrap()[..7],
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
    let scene = json!({
        "dimension": 3,
        "units": {"length": "m", "mass": "kg", "time": "s"},
        "bodies": {"beam": {"superelement": "beam.dcb.h5", "damping": {"modal": 0.01}}},
        "joints": {"clamp": {"fixed": {"a": "ground", "b": "beam/a"}}},
        "outputs": {"tip": {"displacement": {"at": "beam/b"}}},
        "integrator": {"generalized_alpha": {"step": 1e-4, "end": 1e-3}}
    });
    let folder = Folder::beam(&scene);
    let told = folder.done("scene.json --model everything").stderr;
    assert!(
        told.contains("damping ratios of the lowest modes of the assembled mechanism: "),
        "{told}"
    );
    let summary = |folder: &Folder| {
        let results = Results::open(folder.path("scene.h5")).unwrap();
        let told = results.provenance("summary").unwrap()["effective_damping"].clone();
        told.as_array().unwrap().clone()
    };
    let modal = summary(&folder);
    assert_eq!(modal.len(), 4);
    // The modal analysis of the same scene has the same, from complex eigenvalues.
    folder.edit("scene.json", |scene| {
        scene["analysis"] = json!({"modes": {"count": 4}})
    });
    folder.done("scene.json -o modes.h5 --model everything");
    let results = Results::open(folder.path("modes.h5")).unwrap();
    let modes = results.modes().unwrap().unwrap();
    for (k, mode) in modal.iter().enumerate() {
        let (frequency, ratio) = (
            mode["frequency"].as_f64().unwrap(),
            mode["damping_ratio"].as_f64().unwrap(),
        );
        println!("{frequency} {ratio:e} {:e}", modes.damping_ratio[k]);
        assert!((frequency / modes.frequency[k] - 1.0).abs() < 1e-3);
        assert!((ratio / modes.damping_ratio[k] - 1.0).abs() < 2e-2);
    }
    assert!(modal[0]["damping_ratio"].as_f64().unwrap() < 0.5 * 0.01);
    folder.edit("scene.json", |scene| {
        scene["analysis"] = json!("transient");
        let f = modal[0]["frequency"].as_f64().unwrap();
        scene["bodies"]["beam"]["damping"] =
            json!({"rayleigh": [0, 0.02 / (std::f64::consts::PI * f)]});
    });
    folder.done("scene.json --force --model everything");
    let found = summary(&folder)[0]["damping_ratio"].as_f64().unwrap();
    assert!((found / 0.02 - 1.0).abs() < 2e-2, "{found}");
    // Nothing to say of an undamped beam.
    folder.edit("scene.json", |scene| {
        scene["bodies"]["beam"]
            .as_object_mut()
            .unwrap()
            .remove("damping");
    });
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
        folder.edit("scene.json", |scene| {
            scene["bodies"]["beam"]["damping"] = given
        });
        folder.refuses("scene.json --force", &texts);
    }
}
