//! Spatial scenes that are their own mirror image: motion out of the plane isn't integrated.

use faer::Mat;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use serde_json::{Value, json};

use super::planar_scenes::{block, write_reduced};
use crate::scene_folder::spatial;
use crate::support::{Folder, list, number, says};

/// Channels that have to be the same.
const CHANNELS: [&str; 8] = [
    "outputs/end",
    "outputs/slider",
    "outputs/turned",
    "reactions/axle",
    "reactions/wrist",
    "reactions/pin",
    "reactions/guide",
    "interface_forces/block/left",
];

/// A crank, the block as a connecting rod with a force at its end, and a slider on a soft bushing, all turned: the plane of motion is across `turn * z`.
fn slider_crank(turn: &UnitQuaternion<f64>) -> Value {
    let world = |local: [f64; 3]| <[f64; 3]>::from(turn * Vector3::from(local));
    let orientation = [turn.w, turn.i, turn.j, turn.k];
    let rigid = |mass: f64, points: Value| json!({"mass": mass, "inertia": [0.01, 0.02, 0.03], "points": points});
    let (height, depth, crank, rod) = (0.05, 0.03, 0.1, 0.4);
    spatial(json!({
        "gravity": world([0.0, -9.81, 0.0]),
        "ground": {"points": {
            "axle": {"position": world([0.0, height, depth]), "orientation": orientation},
            "guide": {"position": world([crank + rod, height, depth]), "orientation": orientation},
        }},
        "bodies": {
            "crank": {
                "rigid": rigid(2.0, json!({"axle": [0, 0, 0], "pin": [crank, 0, 0]})), "position": world([0.0, height, depth]),
                "orientation": orientation, "angular_velocity": world([0.0, 0.0, 30.0])
            },
            "block": {"superelement": "block.dcb.h5", "position": world([crank, 0.0, 0.0]), "orientation": orientation},
            "slider": {
                "rigid": rigid(1.0, json!({"pin": [0, 0, 0]})), "position": world([crank + rod, height, depth]), "orientation": orientation
            },
        },
        "joints": {
            "axle": {"revolute": {"a": "ground/axle", "b": "crank/axle", "axis": [0, 0, 1]}},
            "wrist": {"revolute": {"a": "crank/pin", "b": "block/left", "axis": [0, 0, 1]}},
            "pin": {"spherical": {"a": "block/right", "b": "slider/pin"}},
            "guide": {"prismatic": {"a": "ground/guide", "b": "slider/pin", "axis": [1, 0, 0]}},
        },
        "springs": {"stop": {"bushing": {
            "a": "ground/guide", "b": "slider/pin",
            "translation": [1e4, 0, 1e3], "rotation": [10, 0, 10],
        }}},
        "loads": {"push": {"force": {"at": "block/right", "components": world([0.0, 2e3, 0.0])}}},
        "outputs": {
            "end": {"position": {"at": "block/right"}},
            "slider": {"acceleration": {"at": "slider/pin"}},
            "turned": {"orientation": {"at": "block/right"}},
        },
        "record": {"every": 7},
        "integrator": {"generalized_alpha": {"step": 2e-4, "end": 0.1, "tolerance": 1e-10}}
    }))
}

fn histories(folder: &Folder, results: &str) -> Vec<Mat<f64>> {
    let results = folder.results_of(results);
    CHANNELS.map(|name| results.history(name).unwrap()).into()
}

#[test]
fn a_symmetric_mechanism_moves_in_its_plane_as_in_space() {
    let part = block(|_| false);
    // The plane is across z, turned in itself, and across x.
    let about_z = UnitQuaternion::from_euler_angles(0.0, 0.0, 0.7);
    let cyclic = UnitQuaternion::new_normalize(Quaternion::new(0.5, 0.5, 0.5, 0.5));
    for turn in [UnitQuaternion::identity(), about_z, cyclic] {
        let folder = Folder::with(&slider_crank(&turn));
        write_reduced(&folder, &part);
        // Nothing but the plane.
        let told = folder
            .done("scene.json -o plane.h5 --explain --tolerance 1e-13")
            .stdout;
        let all = folder
            .done("scene.json -o space.h5 --model everything --explain")
            .stdout;
        says!(
            told,
            "3 bodies, 19 degrees of freedom before their joints, 14 constraint and spring rows"
        );
        says!(
            all,
            "3 bodies, 40 degrees of freedom before their joints, 24 constraint and spring rows"
        );
        says!(told, "motion out of the plane across [");
        let found = histories(&folder, "plane.h5");
        let expected = histories(&folder, "space.h5");
        for ((name, found), expected) in CHANNELS.iter().zip(&found).zip(&expected) {
            let (apart, size) = ((found - expected).norm_max(), expected.norm_max());
            println!("{name}: {apart:.1e} of {size:.1e}");
            assert!(size > 1e-2, "{name}: nothing happens, {size:e}");
            assert!(apart < 2e-7 * size, "{name}: {apart:e} of {size:e}");
        }
        let left_out = folder.results_of("plane.h5");
        let left_out = &left_out.provenance("options").unwrap()["left_out"]["block"];
        says!(left_out.to_string(), "motion out of");
    }
}

#[test]
fn what_leaves_the_plane_is_integrated_in_space() {
    let explained = |folder: &Folder| folder.done("scene.json --force --explain").stdout;
    let turn = UnitQuaternion::identity();
    let folder = Folder::with(&slider_crank(&turn));
    write_reduced(&folder, &block(|_| false));
    folder.set_integrator("end", 1e-3);
    says!(explained(&folder), "motion out of the plane");
    // Axes of the world that aren't along the plane.
    folder.edit("scene.json", |scene| {
        *scene = slider_crank(&UnitQuaternion::from_euler_angles(0.3, -1.1, 2.0));
        scene["integrator"]["generalized_alpha"]["end"] = json!(1e-3);
    });
    let oblique = explained(&folder);
    assert!(!oblique.contains("motion out of the plane"), "{oblique}");
    says!(oblique, "that lead out of the plane across z");
    // A frame that isn't along it.
    folder.edit("scene.json", |scene| *scene = slider_crank(&turn));
    folder.edit("scene.json", |scene| {
        let tilted = UnitQuaternion::from_euler_angles(0.2, 0.0, 0.0);
        scene["bodies"]["slider"]["orientation"] = json!([tilted.w, tilted.i, tilted.j, tilted.k]);
        scene["bodies"]["slider"]["rigid"]["inertia"] = json!([0.01, 0.02, 0.02]);
    });
    assert!(!explained(&folder).contains("motion out of the plane"));
    folder.edit("scene.json", |scene| *scene = slider_crank(&turn));
    folder.set_integrator("end", 1e-3);
    folder.set_scene("loads/push/force/components", json!([0, 2e3, 1.0]));
    assert!(!explained(&folder).contains("motion out of the plane"));
    // Redundant constraints that are to be refused are those in space.
    folder.set_scene("loads/push/force/components", json!([0, 2e3, 0]));
    folder.set_scene("redundant_constraints", "refuse");
    folder
        .run("scene.json --force")
        .is_error(2, &["constraints are redundant", "wrist"]);
}

#[test]
fn oscillations_out_of_a_plane_of_symmetry_are_found() {
    let hinged = spatial(json!({
        "ground": {"points": {"wall": [0.0, 0.05, 0.03]}},
        "bodies": {"block": {"superelement": "block.dcb.h5"}},
        "joints": {"wall": {"fixed": {"a": "ground/wall", "b": "block/left"}}},
        "analysis": {"modes": {"count": 4}}
    }));
    let folder = Folder::with(&hinged);
    write_reduced(&folder, &block(|_| false));
    let frequencies = |words: &str| -> Vec<f64> {
        folder.done(words);
        let summary = folder.results().provenance("summary").unwrap();
        let modes = list(&summary["modes"]);
        let frequency = |mode: &Value| number(&mode["frequency"]);
        modes.iter().map(frequency).collect()
    };
    let all = frequencies("scene.json --model everything");
    let found = frequencies("scene.json --force");
    assert_eq!(all.len(), 4);
    for (found, expected) in found.iter().zip(&all) {
        assert!((found / expected - 1.0).abs() < 1e-4, "{found} {expected}");
    }
}
