//! The slider-crank that the repository ships, from its scene file to its results file, against an independent history.

use std::path::PathBuf;

use dcb_formats::component_files::{ComponentFiles, Overrides, read_component};
use dcb_formats::dcb::SuperelementFile;
use dcb_formats::output::Replace;
use dcb_formats::results::Results;
use dcb_reducer::{Reduction, reduce};
use dcb_runtime::Scene;
use dcb_runtime::model::Model;
use dcb_runtime::run::{self, Profiling, Report, Target};

fn repository(path: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/..")).join(path)
}

/// Every 10° of the crank; `tests/data/reference/ref_planar.json`, 4 elements.
fn reference() -> Vec<f64> {
    let path = repository("tests/data/reference/ref_planar.json");
    let all: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    serde_json::from_value(all["deflection"]["4"]["defl"].clone()).unwrap()
}

#[test]
fn shipped_scene_follows_the_independent_history() {
    let scene = Scene::read(&repository("samples/slider-crank/scene.json")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let target = Target {
        fields_in: None,
        kept: Vec::new(),
        path: folder.path().join("results.h5"),
        replace: Replace::Refuse,
        options: serde_json::Value::Null,
        profiling: Profiling::Off,
    };
    let report = run::run(&scene, Model::load(&scene).unwrap(), &target, &mut ()).unwrap();
    let Report::Transient(report) = report else {
        panic!("{report:?}")
    };
    assert_eq!((report.steps, report.is_complete), (7200, true));
    let results = Results::open(&target.path).unwrap();
    let deflection = results.history("midpoint_deflection").unwrap();
    let expected = reference();
    // Recorded every degree.
    let found: Vec<f64> = (0..expected.len())
        .map(|k| deflection[(10 * k, 0)])
        .collect();
    let largest = expected.iter().fold(0.0, |most: f64, d| most.max(d.abs()));
    let error = found
        .iter()
        .zip(&expected)
        .fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
    assert!(error < 1e-3 * largest, "{:.2e}", error / largest);
}

/// The superelement beside the scene is the reduction of the component that is shipped.
#[test]
fn shipped_superelement_is_that_of_the_shipped_rod() {
    let files = ComponentFiles::beside(
        &repository("samples/data/rod/rod.mtx"),
        &Overrides::default(),
    )
    .unwrap();
    let component = read_component(&files, None).unwrap();
    let made = reduce(&component, &Reduction::lowest(5), &mut ()).unwrap();
    let shipped = SuperelementFile::open(repository("samples/slider-crank/rod.dcb.h5"))
        .unwrap()
        .superelement()
        .unwrap();
    let made = made.superelement;
    assert_eq!(shipped.residual.sigma_squared.len(), 4);
    let pairs = made
        .modes
        .eigenvalues
        .iter()
        .chain(&made.residual.sigma_squared)
        .zip(
            shipped
                .modes
                .eigenvalues
                .iter()
                .chain(&shipped.residual.sigma_squared),
        );
    for (made, shipped) in pairs {
        assert!((made / shipped - 1.0).abs() < 1e-9, "{made} {shipped}");
    }
    assert!((made.inertia.mass / shipped.inertia.mass - 1.0).abs() < 1e-12);
}
