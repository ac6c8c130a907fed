//! Vibrations and responses about a preloaded rest of a flexible part, and about a spin, from scenes.

use std::f64::consts::TAU;

use dcb_runtime::frequency::Solution;
use dcb_runtime::run::Report;
use dcb_samples::{SpatialBeam, spatial_beam};
use dcb_tests::dense::{dense, eigen};
use faer::linalg::solvers::Solve;
use faer::{Mat, c64};

use super::frequency::{report_of, responses};

const STIFFNESS: f64 = 5e4;
const FREE: f64 = 0.4;
const LOSS: f64 = 0.02;

/// A beam along x between two taut springs, drawn off its rest.
fn taut(analysis: &str) -> String {
    format!(
        r#"{{"dimension": 3, "units": {{"length": "m", "mass": "kg", "time": "s"}},
          "ground": {{"points": {{"left": [-0.5, 0, 0], "right": [1.5, 0, 0]}}}},
          "bodies": {{"beam": {{"superelement": "beam.dcb.h5", "position": [0.02, 0, 0]}}}},
          "springs": {{
            "left": {{"spring": {{"a": "ground/left", "b": "beam/a", "stiffness": {STIFFNESS}, "free_length": {FREE}}}}},
            "right": {{"spring": {{"a": "ground/right", "b": "beam/b", "stiffness": {STIFFNESS}, "free_length": {FREE}}}}}}},
          "loads": {{"push": {{"force": {{"at": "beam/b", "components": [0, 1, 0]}}}}}},
          "outputs": {{"tip": {{"displacement": {{"at": "beam/b"}}}}}},
          "analysis": {analysis}}}"#
    )
}

/// K with the springs and the tension's own stiffness, and M of the beam at its rest.
fn at_rest() -> [Mat<f64>; 2] {
    let shape = SpatialBeam::default();
    let component = spatial_beam(&shape);
    let (mut stiffness, mass) = (dense(&component.stiffness), dense(&component.mass));
    let n = stiffness.nrows();
    // The springs stretch the beam a little.
    let axial = shape.material.youngs_modulus * shape.section.area;
    let mut stretch = 0.0;
    let mut tension = 0.0;
    for _ in 0..20 {
        tension = STIFFNESS * (0.5 - 0.5 * stretch - FREE);
        stretch = tension / axial;
    }
    let spring = 0.5 - 0.5 * stretch;
    for end in [0, n - 6] {
        stiffness[(end, end)] += STIFFNESS;
        for axis in [1, 2] {
            stiffness[(end + axis, end + axis)] += tension / spring;
        }
    }
    // The pull at both ends turns the beam back as a whole.
    for axis in [1, 2] {
        let (a, b) = (axis, n - 6 + axis);
        for (i, j, sign) in [(a, a, 1.0), (b, b, 1.0), (a, b, -1.0), (b, a, -1.0)] {
            stiffness[(i, j)] += sign * tension;
        }
    }
    [stiffness, mass]
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let reduced = dcb_tests::lowest(&spatial_beam(&SpatialBeam::default()), 8);
    dcb_tests::write_bare(&folder.path().join("beam.dcb.h5"), &reduced.superelement);
    folder
}

/// Preload, then linearize, then modes: a scene's `"at": "static"`.
#[test]
fn a_taut_beam_vibrates_about_its_rest() {
    let folder = folder();
    let text = taut(r#"{"modes": {"count": 6, "at": "static"}}"#);
    let (Report::Modes(report), _) = report_of(folder.path(), &text).unwrap() else {
        panic!("another analysis")
    };
    let found: Vec<f64> = (report.modes.modes.iter())
        .map(|mode| mode.frequency())
        .filter(|frequency| *frequency > 1e-3)
        .collect();
    let [stiffness, mass] = at_rest();
    let (squares, axes) = eigen(&mass);
    let root = Mat::from_fn(squares.len(), squares.len(), |i, j| {
        axes[(i, j)] / squares[j].sqrt()
    });
    let expected = eigen(&(root.transpose() * stiffness * &root)).0;
    // It rolls freely.
    let expected: Vec<f64> = (expected.iter().skip(1).take(5))
        .map(|square| square.sqrt() / TAU)
        .collect();
    assert!(expected[0] > 1.0, "{expected:?}");
    for (found, expected) in found.iter().zip(&expected) {
        assert!(
            (found / expected - 1.0).abs() < 1e-4,
            "{found} and {expected}"
        );
    }
}

#[test]
fn a_taut_beam_answers_about_its_rest() {
    let folder = folder();
    let frequencies = [5.0, 20.0, 60.0];
    let text = taut(&format!(
        r#"{{"frequency_response": {{"at": "static", "inputs": ["push/1"], "damping": {{"structural": {LOSS}}}, "frequencies": {frequencies:?}}}}}"#
    ));
    let (report, read, _) = responses(folder.path(), &text).unwrap();
    let y = (read.outputs.iter())
        .position(|output| output.name == "tip.y")
        .unwrap();
    let [stiffness, mass] = at_rest();
    let n = stiffness.nrows();
    for (k, frequency) in frequencies.into_iter().enumerate() {
        let omega = TAU * frequency;
        let dynamic = Mat::from_fn(n, n, |i, j| {
            let k = stiffness[(i, j)];
            c64::new(k - omega * omega * mass[(i, j)], LOSS * k)
        });
        let force = Mat::from_fn(n, 1, |i, _| c64::new(f64::from(u8::from(i == n - 5)), 0.0));
        let expected = dynamic.partial_piv_lu().solve(&force)[(n - 5, 0)];
        let [re, im] = read.of(y, 0)[k];
        let off = (c64::new(re, im) - expected).norm() / expected.norm();
        assert!(off < 1e-3, "{frequency} Hz: {off:e}");
    }
    assert_ne!(report.solution, Solution::Direct);
}

/// A mass on equal springs that spins by Ω, in axes that move along: `½ (G(ω + Ω) + G(Ω − ω)*)` with `G(ν) = 1 / (k − m ν² + i c ν)`.
#[test]
fn a_spinning_mass_answers_in_axes_that_move_along() {
    let folder = tempfile::tempdir().unwrap();
    let (mass, stiffness, damping, spin) = (2.0, 800.0, 3.0, 12.0);
    let frequencies = [0.4, 1.2, 2.0, 5.0, 7.0];
    let text = format!(
        r#"{{"dimension": 3, "units": {{"length": "m", "mass": "kg", "time": "s"}},
          "ground": {{"points": {{"o": [0, 0, 0]}}}},
          "bodies": {{"mass": {{"rigid": {{"mass": {mass}, "inertia": [0.1, 0.1, 0.2], "points": {{"p": [0, 0, 0]}}}}, "angular_velocity": [0, 0, {spin}]}}}},
          "springs": {{"s": {{"bushing": {{"a": "ground/o", "b": "mass/p", "translation": [{stiffness}, {stiffness}, {stiffness}], "translation_damping": [{damping}, {damping}, {damping}]}}}}}},
          "loads": {{"push": {{"force": {{"at": "mass/p", "components": [1, 0, 0]}}}}}},
          "outputs": {{"place": {{"displacement": {{"at": "mass/p"}}}}}},
          "analysis": {{"frequency_response": {{"inputs": ["push/0"], "frequencies": {frequencies:?}}}}}}}"#
    );
    let (report, read, notes) = responses(folder.path(), &text).unwrap();
    assert_eq!(report.solution, Solution::Direct);
    assert!(report.damping.is_empty());
    assert!(
        notes
            .iter()
            .any(|note| note.contains("the mechanism moves here"))
    );
    let answer = |nu: f64| c64::new(1.0, 0.0) / c64::new(stiffness - mass * nu * nu, damping * nu);
    let x = (read.outputs.iter())
        .position(|output| output.name == "place.x")
        .unwrap();
    for (k, frequency) in frequencies.into_iter().enumerate() {
        let omega = TAU * frequency;
        let expected = (answer(omega + spin) + answer(spin - omega).conj()) * 0.5;
        let [re, im] = read.of(x, 0)[k];
        let off = (c64::new(re, im) - expected).norm() / expected.norm();
        assert!(off < 1e-6, "{frequency} Hz: {re} {im} and {expected}");
    }
}
