//! The rotor of example 5.9.1 of Friswell, Penny, Garvey and Lees, "Dynamics of Rotating Machines" (2010), at 4000 rev/min against published values.

use std::f64::consts::TAU;

use dcb_runtime::whirl::Whirl;
use dcb_samples::spatial_beam::{BeamSection, BeamTheory};
use dcb_samples::{Material, SpatialBeam, shaft, spatial_beam};
use dcb_tests::lowest;

use super::whirl::{request, rotor_of_the_book, whirl_of};

/// rad/s, as the documentation of ROSS prints them for this example (petrobras/ross, docs/examples/example_05_09_01.rst): six Timoshenko elements with rotary inertia and
/// gyroscopic moments. Backward and forward in turn.
const PUBLISHED: [f64; 6] = [
    -85.389467,
    87.7958637,
    -251.78460413,
    294.71333087,
    -600.17936195,
    827.07536193,
];
const DENSITY: f64 = 7810.0;
const DIAMETER: f64 = 0.05;
const WIDTH: f64 = 0.07;

/// Mass, polar and diametral inertia of a disk on the shaft.
fn disk(outer: f64) -> [f64; 3] {
    let area = std::f64::consts::PI * (outer * outer - DIAMETER * DIAMETER) / 4.0;
    let mass = DENSITY * WIDTH * area;
    let polar = mass * (outer * outer + DIAMETER * DIAMETER) / 8.0;
    [mass, polar, 0.5 * polar + mass * WIDTH * WIDTH / 12.0]
}

/// Within what a shaft of beam nodes has of its own gyroscopic moment only when it tilts as a whole (docs/rotors.md).
#[test]
fn the_rotor_of_the_book_whirls_as_published() {
    let folder = tempfile::tempdir().unwrap();
    let (young, shear) = (211e9, 81.2e9);
    let poisson = young / (2.0 * shear) - 1.0;
    let beam = spatial_beam(&SpatialBeam {
        elements: 6,
        end: [1.5, 0.0, 0.0],
        section: BeamSection {
            shear_factor: 6.0 * (1.0 + poisson) / (7.0 + 6.0 * poisson),
            ..BeamSection::round(DIAMETER)
        },
        material: Material {
            youngs_modulus: young,
            poisson_ratio: poisson,
            density: DENSITY,
        },
        theory: BeamTheory::Timoshenko,
        ..SpatialBeam::default()
    });
    let beam = beam.changed(|draft| draft.interfaces = shaft(6).interfaces.clone());
    let element = lowest(&beam.unwrap(), 20).superelement;
    dcb_tests::write_bare(&folder.path().join("shaft.dcb.h5"), &element);
    let scene = rotor_of_the_book([disk(0.28), disk(0.35)]);
    let speed = 4000.0 * TAU / 60.0;
    let found = whirl_of(&scene, folder.path(), &request(&[0.5 * speed, speed], &[])).unwrap();
    let across = found.points[1].modes.iter();
    let across: Vec<f64> = across
        .filter(|mode| mode.whirl == Whirl::Across)
        .map(|mode| TAU * mode.frequency)
        .collect();
    for (found, expected) in across.iter().zip(PUBLISHED) {
        assert!(
            (found / expected - 1.0).abs() < 1e-3,
            "{across:?} {PUBLISHED:?}"
        );
    }
}
