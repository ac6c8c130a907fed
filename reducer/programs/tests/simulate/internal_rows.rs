//! A scene with a part that has rows belonging to no node: it moves, and its nodes go to VTK files.

use dcb_formats::dcb::Contents;
use dcb_tests::lowest;
use dcb_tests::parts::with_internal_rows;
use serde_json::json;

use crate::support::Folder;

#[test]
fn a_plate_with_incompatible_modes_swings_and_is_shown() {
    let component = with_internal_rows("plate");
    let reduced = lowest(&component, 6);
    let folder = Folder::empty();
    let contents = Contents {
        superelement: &reduced.superelement,
        recovery: Some(&reduced.recovery),
        mesh: Some(&component.mesh),
    };
    folder.store_contents("plate.dcb.h5", &contents);
    let scene = json!({
        "dimension": 3,
        "units": {"length": "mm", "mass": "t", "time": "s"},
        "gravity": [0, 0, -9810],
        "bodies": {"plate": {"superelement": "plate.dcb.h5"}},
        "joints": {"hinge": {"revolute": {"a": "ground", "b": "plate/left", "axis": [0, 1, 0]}}},
        "outputs": {"tip": {"position": {"at": "plate/right"}}, "corner": {"node_displacement": {"body": "plate", "node": 29}}},
        "fields": [{"body": "plate", "times": [0, 0.01], "directory": "fields"}],
        "integrator": {"generalized_alpha": {"step": 1e-4, "end": 0.02, "rho_infinity": 0.6}}
    });
    folder.write("scene.json", scene.to_string());
    folder.done("scene.json");
    for file in ["fields/plate_000000.vtu", "fields/plate_000001.vtu"] {
        let text = folder.read(file);
        assert!(
            text.contains("NumberOfPoints=\"30\" NumberOfCells=\"8\""),
            "{file}"
        );
        assert!(text.contains("Name=\"displacement\""), "{file}");
    }
}
