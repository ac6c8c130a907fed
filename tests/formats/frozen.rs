//! Frozen files, read forever: a sample of every released format version, and superelements that `reduce` wrote with format 1.0, in
//! which every later version finds the mechanics of the reference data.

use std::path::{Path, PathBuf};

use dcb_formats::dcb::SuperelementFile;
use dcb_formats::superelement::FrameKind;
use dcb_tests::reference::{numbers, reference};
use dcb_tests::synthetic;
use serde_json::Value;

fn data(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("data")
        .join(path)
}

#[test]
fn the_planar_rod_of_format_1_0() {
    let file = SuperelementFile::open(data("frozen/rod-1.0.dcb.h5")).unwrap();
    assert_eq!(file.format_version().to_string(), "1.0");
    assert!(file.verify_digests().unwrap() > 20);
    let rod = file.superelement().unwrap();
    let expected = &reference("ref_planar.json")["invariants"]["4"];
    for (found, omega) in rod
        .modes
        .eigenvalues
        .iter()
        .zip(numbers(&expected["omega"]))
    {
        assert!(
            (found.sqrt() / omega - 1.0).abs() < 1e-9,
            "{found} against {omega}"
        );
    }
    assert_eq!(
        (
            rod.mode_count(),
            rod.boundary_row_count(),
            rod.residual.sigma_squared.len()
        ),
        (5, 4, 4)
    );
    let sigma = numbers(&expected["residual"]["5"]["sigma"]);
    for (found, sigma) in rod.residual.sigma_squared.iter().zip(sigma) {
        assert!(
            (found.sqrt() / sigma - 1.0).abs() < 1e-9,
            "{found} against {sigma}"
        );
    }
    let mass = expected["m"].as_f64().unwrap();
    assert!((rod.inertia.mass / mass - 1.0).abs() < 1e-12);
    assert_eq!(rod.frame_kind, FrameKind::MeanAxis);
    assert_eq!(file.recovery().unwrap().unwrap().dofs.len(), 15);
    assert_eq!(file.mesh().unwrap().unwrap().node_count(), 5);
}

#[test]
fn the_rotor_of_format_1_0() {
    let file = SuperelementFile::open(data("frozen/rotor-1.0.dcb.h5")).unwrap();
    assert!(file.verify_digests().unwrap() > 20);
    let rotor = file.superelement().unwrap();
    let cases = reference("reference.json");
    let case = cases
        .as_array()
        .unwrap()
        .iter()
        .find(|case| case["name"].as_str().unwrap().contains("Ansys"))
        .unwrap();
    for (eigenvalue, hertz) in rotor
        .modes
        .eigenvalues
        .iter()
        .zip(numbers(&case["freq_first10_elastic"]))
    {
        let found = eigenvalue.sqrt() / (2.0 * std::f64::consts::PI);
        assert!(
            (found / hertz - 1.0).abs() < 1e-8,
            "{found} against {hertz}"
        );
    }
    assert!((rotor.inertia.mass / case["mass"].as_f64().unwrap() - 1.0).abs() < 1e-12);
    assert_eq!(rotor.inertia.i1.len(), rotor.basis_count());
    assert_eq!(rotor.inertia.i2.len(), 6);
    assert_eq!(file.recovery().unwrap().unwrap().modes.nrows(), 345);
}

/// Whether a file still says what it said when it was frozen; later versions may have more to say.
fn read_as_then(name: &str) {
    let folder = data("frozen");
    let file = SuperelementFile::open(folder.join(format!("{name}.dcb.h5"))).unwrap();
    let json = std::fs::read_to_string(folder.join(format!("{name}.json"))).unwrap();
    let expected: Value = serde_json::from_str(&json).unwrap();
    // serde_json reads some numbers a digit off: both sides take the same way.
    let found = synthetic::summary(&file).unwrap().to_string();
    let found: Value = serde_json::from_str(&found).unwrap();
    let expected = expected.as_object().unwrap();
    assert!(expected.len() > 30, "{name}");
    for (key, value) in expected {
        assert_eq!(&found[key], value, "{name}: {key}");
    }
    file.verify_digests().unwrap();
}

#[test]
fn frozen_files_of_version_1_0_read_as_when_they_were_written() {
    read_as_then("planar-1.0");
    read_as_then("spatial-1.0");
}

#[test]
fn frozen_files_of_version_1_6_read_as_when_they_were_written() {
    read_as_then("planar-1.6");
    read_as_then("spatial-1.6");
}

#[test]
fn frozen_files_of_version_1_5_read_as_when_they_were_written() {
    read_as_then("planar-1.5");
    read_as_then("spatial-1.5");
}

#[test]
fn frozen_files_of_version_1_4_read_as_when_they_were_written() {
    read_as_then("planar-1.4");
    read_as_then("spatial-1.4");
}

#[test]
fn frozen_files_of_version_1_3_read_as_when_they_were_written() {
    read_as_then("planar-1.3");
    read_as_then("spatial-1.3");
}

#[test]
fn frozen_files_of_version_1_2_read_as_when_they_were_written() {
    read_as_then("planar-1.2");
    read_as_then("spatial-1.2");
}

#[test]
fn frozen_files_of_version_1_1_read_as_when_they_were_written() {
    read_as_then("planar-1.1");
    read_as_then("spatial-1.1");
}
