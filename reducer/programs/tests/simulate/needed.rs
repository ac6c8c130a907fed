//! Contents that a run leaves out of its superelements, and `simulate prepare`.

use dcb_formats::dcb::read_superelement;
use dcb_samples::hard::thin_plate;
use serde_json::{Value, json};

use crate::planar_scenes::write_reduced;
use crate::scene_folder::spatial;
use crate::support::{Folder, list, number, says};

/// A beam on a hinge about z that falls in the x-y plane, damped so that what the start excites dies.
fn falling_beam() -> Folder {
    let scene = spatial(json!({
        "gravity": [0, -9.81, 0],
        "bodies": {"beam": {"superelement": "beam.dcb.h5", "damping": {"modal": 0.05}}},
        "joints": {"hinge": {"revolute": {"a": "ground", "b": "beam/a", "axis": [0, 0, 1]}}},
        "outputs": {"tip": {"position": {"at": "beam/b"}}, "angle": {"joint_coordinate": {"joint": "hinge"}}},
        "integrator": {"generalized_alpha": {"step": 1e-4, "end": 0.2, "rho_infinity": 0.8}}
    }));
    Folder::beam_with_modes(&scene, 12)
}

/// Largest difference of two runs in an output, relative to its range in the second.
fn apart(folder: &Folder, runs: [&str; 2], name: &str) -> f64 {
    let history = |run| folder.results_of(run).history(&format!("outputs/{name}"));
    let [a, b] = runs.map(|run| history(run).unwrap());
    assert_eq!((a.nrows(), a.ncols()), (b.nrows(), b.ncols()));
    let ranges = b.col_iter().map(|column| {
        let most = column.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        most - column.iter().copied().fold(f64::INFINITY, f64::min)
    });
    let range = ranges.map(|range| range * range).sum::<f64>().sqrt();
    let apart = &a - &b;
    let distances = apart.row_iter().map(|row| row.norm_l2());
    distances.fold(0.0, f64::max) / range
}

#[test]
fn a_run_carries_what_its_scene_needs_and_says_what_it_leaves_out() {
    let folder = falling_beam();
    let told = folder
        .done("scene.json -o needed.h5 --explain --tolerance 1e-3")
        .stdout;
    says!(
        told,
        "body \"beam\":",
        "without interface \"pair\": nothing acts on it or looks at it",
        "without interface \"bare\": nothing acts on it or looks at it",
        "without interface \"watched\": nothing acts on it or looks at it",
        "without attachments of interface \"b\": nothing acts on it"
    );
    let short = folder.done("scene.json -o short.h5").stdout;
    says!(short, "--explain lists them");
    let all = folder
        .done("scene.json -o all.h5 --model everything --explain")
        .stdout;
    assert!(!all.contains("without"), "{all}");
    let dofs = |told: &str| -> usize {
        let words: Vec<&str> = told.split_whitespace().collect();
        let at = words.iter().position(|word| *word == "freedom").unwrap();
        words[at - 3].parse().unwrap()
    };
    assert!(dofs(&told) + 12 < dofs(&all), "{told}{all}");
    for output in ["tip", "angle"] {
        let found = apart(&folder, ["needed.h5", "all.h5"], output);
        assert!(found < 1e-4, "{output}: {found:e}");
    }
    let results = folder.results_of("needed.h5");
    let left_out = &results.provenance("options").unwrap()["left_out"]["beam"];
    assert!(left_out.as_array().unwrap().len() > 3, "{left_out}");
}

#[test]
fn a_body_that_nothing_moves_is_rigid() {
    let folder = falling_beam();
    folder.set_scene(
        "bodies/base",
        json!({"superelement": "beam.dcb.h5", "position": [0, 3, 0]}),
    );
    folder.set_scene(
        "joints/clamp",
        json!({"fixed": {"a": "ground/base", "b": "base/a"}}),
    );
    folder.set_scene("ground", json!({"points": {"base": [0, 3, 0]}}));
    let told = folder.done("scene.json -o needed.h5 --explain").stdout;
    says!(told, "body \"base\":\n  without all deflection");
}

#[test]
fn tolerances_are_positive_and_below_one() {
    let folder = falling_beam();
    folder.refused_each(&[
        ("scene.json --tolerance 0", &["--tolerance", "is 0"]),
        ("scene.json --tolerance -1", &["--tolerance", "is -1"]),
        ("prepare scene.json --tolerance 1", &["--tolerance", "is 1"]),
    ]);
}

/// The slider-crank for one turn, every step recorded.
fn one_turn() -> Folder {
    let folder = Folder::one_turn();
    folder.set_scene("record", json!({"every": 16}));
    folder
}

fn report(folder: &Folder, name: &str) -> Value {
    folder.json(&format!("{name}/report.json"))
}

#[test]
fn a_prepared_scene_keeps_its_outputs_with_fewer_coordinates() {
    let folder = one_turn();
    folder.done("scene.json -o all.h5 --model everything");
    let mut fewest = usize::MAX;
    for (name, tolerance) in [("fine", 1e-3), ("coarse", 3e-2)] {
        let told = folder
            .done(&format!(
                "prepare scene.json --tolerance {tolerance} -o {name}"
            ))
            .stdout;
        says!(told, "elastic coordinates are enough");
        folder.done(&format!(
            "{name}/scene.json -o {name}.h5 --model everything"
        ));
        let report = report(&folder, name);
        let claimed = number(&report["error"]);
        assert!(claimed <= tolerance, "{claimed:e}");
        for output in ["midpoint_deflection", "crank_angle", "slider_position"] {
            let found = apart(&folder, [&format!("{name}.h5"), "all.h5"], output);
            assert!(
                found <= 1.01 * claimed + 1e-9,
                "{name} {output}: {found:e}, {claimed:e}"
            );
        }
        let small = read_superelement(&folder.path(&format!("{name}/rod.dcb.h5"))).unwrap();
        let kept = small.mode_count() + small.residual.sigma_squared.len();
        assert_eq!(report["coordinates"], json!(kept));
        let scene = folder.json(&format!("{name}/scene.json"));
        let order = scene["bodies"]["rod"]["inertia_change"].as_str();
        assert_eq!(order.is_some(), report["inertia_change"]["rod"].is_string());
        assert!(tolerance < 1e-2 || order.is_some(), "{scene}");
        assert!(kept < fewest, "{kept} with {tolerance}");
        fewest = kept;
        let sizes = &report["files"][0];
        assert!(
            sizes["size"].as_u64() < sizes["of_size"].as_u64(),
            "{sizes}"
        );
    }
}

/// Steps of generalized alpha become longer where radau can't integrate, the compatibility being static.
#[test]
fn longer_steps_stay_within_the_tolerance() {
    let folder = one_turn();
    folder.set_scene("compatibility", json!("static"));
    folder.done("scene.json -o all.h5 --model everything");
    let told = folder
        .done("prepare scene.json --tolerance 2e-2 --adapt-integrator -o longer")
        .stdout;
    says!(told, "integrator: generalized_alpha, steps of");
    let report = report(&folder, "longer");
    let step = number(&report["integrator"]["generalized_alpha"]["step"]);
    let steps = step / 1.163_552_834_662_886_4e-5;
    assert!(steps > 1.5 && steps < 16.5, "{steps}");
    folder.done("longer/scene.json -o longer.h5 --model everything");
    let found = apart(&folder, ["longer.h5", "all.h5"], "midpoint_deflection");
    assert!(found <= 2e-2, "{found:e}");
}

/// Radau takes over from generalized alpha where it takes less time for the tolerance; rows stay where they were.
#[test]
fn radau_takes_over_where_it_is_faster() {
    let folder = one_turn();
    let mut bodies = folder.json("scene.json")["bodies"].clone();
    bodies["rod"]["damping"] = json!({"modal": 0.02});
    folder.set_scene("bodies", bodies);
    let integrator = json!({"generalized_alpha": {"step": 3e-6, "end": 0.042}});
    folder.set_scene("integrator", integrator);
    folder.set_scene("record", json!({"every": 40}));
    folder.done("scene.json -o all.h5 --model everything");
    let told = folder
        .done("prepare scene.json --tolerance 1e-4 --adapt-integrator -o faster")
        .stdout;
    says!(told, "integrator: radau, accuracy");
    folder.done("faster/scene.json -o faster.h5 --model everything");
    let claimed = number(&report(&folder, "faster")["error"]);
    for output in ["midpoint_deflection", "crank_angle", "slider_position"] {
        let found = apart(&folder, ["faster.h5", "all.h5"], output);
        assert!(found <= 1e-4, "{output}: {found:e}");
        assert!(
            found <= 1.1 * claimed + 1e-9,
            "{output}: {found:e} {claimed:e}"
        );
    }
    let [all, faster] = ["all.h5", "faster.h5"].map(|name| {
        let summary = folder.results_of(name).provenance("summary").unwrap();
        number(&summary["newton_iterations"])
    });
    assert!(20.0 * faster < all, "{faster} {all}");
}

/// A scene that is integrated by accuracy is prepared as one by steps is, and keeps its integrator.
#[test]
fn scenes_by_accuracy_are_prepared_too() {
    let folder = one_turn();
    let integrator = json!({"radau": {"tolerance": 1e-7, "end": 0.042}});
    folder.set_scene("integrator", integrator);
    folder.set_scene("record", json!({"interval": 0.001}));
    folder.done("scene.json -o all.h5 --model everything");
    folder.done("prepare scene.json --tolerance 2e-2 --adapt-integrator -o small");
    let claimed = number(&report(&folder, "small")["error"]);
    folder.done("small/scene.json -o small.h5 --model everything");
    let found = apart(&folder, ["small.h5", "all.h5"], "midpoint_deflection");
    assert!(claimed <= 2e-2 && found <= 2e-2, "{claimed:e} {found:e}");
    let kept = folder.json("small/scene.json");
    let tolerance = number(&kept["integrator"]["radau"]["tolerance"]);
    assert!(tolerance > 1e-7, "{tolerance:e}");
}

/// The frequency that a scene by accuracy gives limits what is carried, as a step does, and the run tells of nothing beyond it.
#[test]
fn a_highest_frequency_leaves_faster_modes_out() {
    let folder = one_turn();
    folder.set_scene("record", json!({"interval": 0.001}));
    let set = |radau| folder.set_scene("integrator", json!({"radau": radau}));
    set(json!({"tolerance": 1e-5, "end": 0.042}));
    let everything = folder.done("scene.json -o all.h5 --explain").stdout;
    assert!(everything.contains("everything is carried"), "{everything}");
    set(json!({"tolerance": 1e-5, "end": 0.042, "highest_frequency": 800}));
    let fewer = folder.done("scene.json -o fewer.h5 --explain").stdout;
    assert!(
        fewer
            .contains("the scene wants motion up to 800.0 Hz (integrator.radau.highest_frequency)"),
        "{fewer}"
    );
    assert!(fewer.contains("without modes"), "{fewer}");
    let found = apart(&folder, ["fewer.h5", "all.h5"], "midpoint_deflection");
    assert!(found > 1e-9 && found < 2e-2, "{found:e}");
}

#[test]
fn preparations_that_cannot_be_made_are_refused() {
    let folder = one_turn();
    folder.set_scene("compatibility", "weak");
    folder
        .run("prepare scene.json")
        .is_error(2, &["compatibility", "weak"]);
    folder.set_scene("compatibility", "strong");
    folder.done("prepare scene.json --end 0.002");
    folder
        .run("prepare scene.json --end 0.002")
        .is_error(2, &["scene.json", "exists"]);
    folder.done("prepare scene.json --end 0.002 --force");
    // The scene itself keeps its end.
    let prepared = folder.json("scene.prepared/scene.json");
    assert_eq!(
        prepared["integrator"]["generalized_alpha"]["end"],
        json!(0.042)
    );
    folder.write("rod.mtx", "no matrix");
    folder
        .run("prepare scene.json --force --reduce ./nobody")
        .is_error(2, &["nobody", "cannot run"]);
}

/// Parts of one name from two folders stay two parts.
#[test]
fn parts_of_one_name_get_names_of_their_own() {
    let folder = Folder::slider_crank();
    std::fs::create_dir(folder.path("other")).unwrap();
    std::fs::copy(folder.path("rod.dcb.h5"), folder.path("other/rod.dcb.h5")).unwrap();
    folder.edit("scene.json", |scene| {
        scene["bodies"]["pointer hand"] =
            json!({"superelement": "other/rod.dcb.h5", "modes": 4, "position": [0, 1]});
        scene["joints"]["hinge"] =
            json!({"revolute": {"a": "ground/above", "b": "pointer hand/a"}});
        scene["ground"] = json!({"points": {"above": [0, 1]}});
        scene["gravity"] = json!([0, -9.81]);
        scene["outputs"]["hand"] = json!({"position": {"at": "pointer hand/b"}});
    });
    folder.done("prepare scene.json --tolerance 1e-2 -o small");
    let scene = folder.json("small/scene.json");
    let file = |body: &str| {
        scene["bodies"][body]["superelement"]
            .as_str()
            .unwrap()
            .to_owned()
    };
    assert_eq!(
        [file("rod"), file("pointer hand")],
        ["rod-rod.dcb.h5", "rod-pointer_hand.dcb.h5"]
    );
    let report = folder.json("small/report.json");
    for (file, of) in list(&report["files"])
        .iter()
        .zip(["../other/rod.dcb.h5", "../rod.dcb.h5"])
    {
        assert_eq!(file["from"], of);
        assert!(
            folder
                .path("small")
                .join(file["file"].as_str().unwrap())
                .is_file()
        );
    }
    folder.done("small/scene.json");
}

/// A thin plate in free flight that spins: no force acts on its interfaces, and yet it is their attachments that the centrifugal forces stretch.
#[test]
fn a_spinning_body_keeps_what_answers_to_its_spin() {
    let plate = thin_plate();
    let corner = plate.mesh.node_count() - 1;
    for integrator in [
        json!({"generalized_alpha": {"step": 1e-5, "end": 2e-3, "rho_infinity": 0.8}}),
        json!({"radau": {"tolerance": 1e-5, "end": 2e-3}}),
    ] {
        let scene = spatial(json!({
            "bodies": {"block": {
                "superelement": "block.dcb.h5",
                "damping": {"modal": 0.2},
                "angular_velocity": [10, 5, 200]
            }},
            "outputs": {"corner": {"node_displacement": {"body": "block", "node": corner}}},
            "record": {"interval": 1e-4},
            "integrator": integrator
        }));
        let folder = Folder::with(&scene);
        write_reduced(&folder, &plate);
        folder.done("scene.json -o all.h5 --model everything");
        let told = folder.done("scene.json -o needed.h5 --explain").stdout;
        let found = apart(&folder, ["needed.h5", "all.h5"], "corner");
        assert!(found < 1e-3, "{found:e}: {told}");
    }
}
