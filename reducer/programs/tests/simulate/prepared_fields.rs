//! `simulate prepare` of scenes that write displacement fields.

use std::fs;
use std::path::Path;

use dcb_formats::dcb::{SuperelementFile, read_superelement};
use dcb_tests::python;
use nalgebra::Vector3;
use serde_json::json;

use super::planar_scenes::{block, write_reduced};
use crate::support::{Folder, list, says};

/// A block in space that hangs on a hinge and is shaken at its end; its field is written twice.
fn shaken_block() -> Folder {
    let folder = Folder::with(&json!({
        "$schema": "/somewhere/scene.schema.json",
        "dimension": 3,
        "units": {"length": "m", "mass": "kg", "time": "s"},
        "gravity": [0, -9.81, 0],
        "bodies": {
            "block": {"superelement": "block.dcb.h5", "damping": {"modal": 0.02}},
            "base": {"superelement": "block.dcb.h5", "position": [0, -1, 0]}
        },
        "joints": {
            "hinge": {"revolute": {"a": "ground", "b": "block/left", "axis": [0, 0, 1]}},
            "clamp": {"fixed": {"a": "ground/base", "b": "base/left"}}
        },
        "ground": {"points": {"base": [0, -0.95, 0.03]}},
        "loads": {"push": {"force": {"at": "block/right", "components": [3e4, {"formula": "2e4*sin(1885*t)"}, 0]}}},
        "outputs": {"tip": {"position": {"at": "block/right"}}},
        "fields": [
            {"body": "block", "times": [1e-3, 2e-3, 4e-3], "directory": "seen"},
            {"body": "base", "every": 2e-3, "directory": "/nowhere/of/base"}
        ],
        "initial": {"hold": ["base"]},
        "integrator": {"generalized_alpha": {"step": 2e-5, "end": 4e-3}}
    }));
    write_reduced(&folder, &block(|_| false));
    folder
}

/// World displacements of a field as a VTU file has them: an array of vectors by its name.
fn displacement(path: &Path) -> Vec<Vector3<f64>> {
    const SCRIPT: &str = "
import json, sys, meshio
print(json.dumps(meshio.read(sys.argv[1]).point_data['displacement'].tolist()))";
    let rows: Vec<[f64; 3]> = serde_json::from_value(python::answer(SCRIPT, path)).unwrap();
    rows.into_iter().map(Vector3::from).collect()
}

/// Distance and size over all nodes.
fn apart(found: &Path, expected: &Path) -> (f64, f64) {
    let (found, expected) = (displacement(found), displacement(expected));
    assert_eq!(found.len(), expected.len());
    let distances = found
        .iter()
        .zip(&expected)
        .map(|(a, b)| (a - b).norm_squared());
    let sizes = expected.iter().map(|vector| vector.norm_squared());
    (distances.sum::<f64>().sqrt(), sizes.sum::<f64>().sqrt())
}

#[test]
fn a_prepared_scene_with_fields_runs_where_it_was_moved_to_and_shows_the_same() {
    let folder = shaken_block();
    let tolerance = 1e-2;
    let told = folder
        .done(&format!("prepare scene.json --tolerance {tolerance}"))
        .stdout;
    says!(told, "field of block");
    // The scene itself, with everything.
    folder.set_scene("fields/1/directory", "of base");
    folder.done("scene.json --model everything");

    // Somewhere else, without what it was made of.
    let elsewhere = Folder::empty();
    fs::rename(folder.path("scene.prepared"), elsewhere.path("moved")).unwrap();
    let whole = read_superelement(&folder.path("block.dcb.h5")).unwrap();
    fs::rename(folder.path("block.dcb.h5"), elsewhere.path("kept.dcb.h5")).unwrap();
    let here = folder.path("");
    let here = here.to_str().unwrap().trim_end_matches('/');
    let prepared = elsewhere.contents().into_iter();
    for (name, bytes) in prepared.filter(|(name, _)| name.starts_with("moved/")) {
        let bytes = bytes.unwrap_or_default();
        for text in [here, "/nowhere", "/somewhere"] {
            let mut parts = bytes.windows(text.len());
            assert!(
                !parts.any(|part| part == text.as_bytes()),
                "{name} has {text}"
            );
        }
    }
    let report = elsewhere.json("moved/report.json");
    for file in list(&report["files"]) {
        assert_eq!(file["from"], json!("../block.dcb.h5"));
    }
    let scene = elsewhere.json("moved/scene.json");
    assert_eq!(
        scene["outputs"].as_object().unwrap().len(),
        1,
        "{}",
        scene["outputs"]
    );
    elsewhere.done("moved/scene.json -o run.h5");

    // The field of the block is compared, as its outputs are.
    let (mut largest, mut size) = (0.0_f64, 0.0_f64);
    for number in 0..3 {
        let file = format!("seen/block_{number:06}.vtu");
        let moved = elsewhere.path(&format!("moved/{file}"));
        let (distance, scale) = apart(&moved, &folder.path(&file));
        (largest, size) = (largest.max(distance), size.max(scale));
    }
    println!("{largest:.2e} of {size:.2e}");
    assert!(size > 1e-6, "nothing deflects: {size:e}");
    assert!(largest < 2.0 * tolerance * size, "{largest:e} of {size:e}");
    assert!(elsewhere.path("moved/base").is_dir());
    // With fewer coordinates, and the shapes of all nodes.
    let names = scene["bodies"]["block"]["superelement"].as_str().unwrap();
    let small = SuperelementFile::open(elsewhere.path(&format!("moved/{names}"))).unwrap();
    assert_eq!(small.node_count(), Some(block(|_| false).mesh.node_count()));
    assert!(small.superelement().unwrap().mode_count() < whole.mode_count());
}

#[test]
fn a_scene_that_cannot_write_its_fields_is_not_prepared() {
    let folder = shaken_block();
    let whole = read_superelement(&folder.path("block.dcb.h5")).unwrap();
    folder.store_superelement("block.dcb.h5", &whole);
    folder
        .run("prepare scene.json")
        .is_error(2, &["fields[0].body", "needs nodal fields", "has none"]);
}
