//! Told errors of frequency responses against the whole mesh.

use std::f64::consts::TAU;

use dcb_formats::Component;
use dcb_samples::{SpatialBeam, spatial_beam};
use dcb_tests::dense::dense;
use faer::linalg::solvers::Solve;
use faer::{Mat, c64};

use super::frequency::responses;

const LOSS: f64 = 0.03;
const MOUNTS: [[f64; 3]; 2] = [[2e5, 3e5, 5e5], [4e5, 1e5, 2e5]];

/// Displacements of the last node by a force there, of the beam in its mounts at both ends.
fn whole(component: &Component, frequency: f64, direction: usize) -> [c64; 3] {
    let (stiffness, mass) = (dense(&component.stiffness), dense(&component.mass));
    let n = stiffness.nrows();
    let omega = TAU * frequency;
    let mounted = |i: usize| match i {
        0..3 => MOUNTS[0][i],
        _ if i >= n - 6 && i < n - 3 => MOUNTS[1][i + 6 - n],
        _ => 0.0,
    };
    let dynamic = Mat::from_fn(n, n, |i, j| {
        let spring = if i == j { mounted(i) } else { 0.0 };
        let k = stiffness[(i, j)] + spring;
        c64::new(k - omega * omega * mass[(i, j)], LOSS * k)
    });
    let force = Mat::from_fn(n, 1, |i, _| {
        c64::new(f64::from(u8::from(i == n - 6 + direction)), 0.0)
    });
    let moved = dynamic.partial_piv_lu().solve(&force);
    std::array::from_fn(|axis| moved[(n - 6 + axis, 0)])
}

/// With few modes: no peak is off by more than is told, and what is told isn't far above.
#[test]
fn errors_are_those_that_are_told() {
    let component = spatial_beam(&SpatialBeam {
        elements: 24,
        ..SpatialBeam::default()
    });
    let folder = tempfile::tempdir().unwrap();
    let mut told = Vec::new();
    for modes in [0, 2, 4, 6] {
        let reduced = dcb_tests::lowest(&component, modes);
        dcb_tests::write_bare(&folder.path().join("beam.dcb.h5"), &reduced.superelement);
        let mount = |end: &str, k: [f64; 3]| {
            format!(
                r#""{end}": {{"bushing": {{"a": "ground/{end}", "b": "beam/{end}", "translation": [{}, {}, {}]}}}}"#,
                k[0], k[1], k[2]
            )
        };
        let text = format!(
            r#"{{"dimension": 3, "units": {{"length": "m", "mass": "kg", "time": "s"}},
              "ground": {{"points": {{"a": [0, 0, 0], "b": [1, 0, 0]}}}},
              "bodies": {{"beam": {{"superelement": "beam.dcb.h5"}}}},
              "springs": {{{}, {}}},
              "loads": {{"push": {{"force": {{"at": "beam/b", "components": [0, 1, 1]}}}}}},
              "outputs": {{"tip": {{"displacement": {{"at": "beam/b"}}}}, "force": {{"spring_force": {{"spring": "a"}}}}}},
              "analysis": {{"frequency_response": {{"damping": {{"structural": {LOSS}}}, "inputs": ["push/1", "push/2"], "frequencies": {{"from": 5, "to": 900, "count": 300}}}}}}}}"#,
            mount("a", MOUNTS[0]),
            mount("b", MOUNTS[1])
        );
        let (report, read, _) = responses(folder.path(), &text).unwrap();
        // At any frequency too, as the file has it.
        for (input, direction) in [(0, 1), (1, 2)] {
            let name = ["tip.x", "tip.y", "tip.z"][direction];
            let place = read.outputs.iter().position(|output| output.name == name);
            let place = place.unwrap();
            let told = read.error_of(place, input).unwrap();
            for k in (0..told.len()).step_by(29) {
                let expected = whole(&component, read.frequency[k], direction)[direction];
                let [re, im] = read.of(place, input)[k];
                let error = (c64::new(re, im) - expected).norm();
                if told[k].is_finite() {
                    assert!(
                        error <= 1.05 * told[k] + 1e-7 * expected.norm(),
                        "{modes} modes, {} Hz: {error:e} told {:e}",
                        read.frequency[k],
                        told[k]
                    );
                }
            }
        }
        for peak in &report.peaks {
            let Some(axis) = ["tip.x", "tip.y", "tip.z"]
                .iter()
                .position(|name| *name == peak.output)
            else {
                assert_eq!(peak.error, None, "{}", peak.output);
                continue;
            };
            let direction = if peak.input == "push/1" { 1 } else { 2 };
            let expected = whole(&component, peak.frequency, direction)[axis];
            let phase = peak.phase.to_radians();
            let found = c64::new(peak.amplitude * phase.cos(), peak.amplitude * phase.sin());
            let error = (found - expected).norm() / expected.norm();
            if let Some(estimate) = peak.error {
                told.push((estimate, error));
                assert!(
                    error <= 1.05 * estimate + 1e-7,
                    "{modes} modes, {} Hz: {error:e} told {estimate:e}",
                    peak.frequency
                );
            }
        }
    }
    let seen: Vec<f64> = (told.iter())
        .filter(|(_, error)| *error > 1e-6)
        .map(|(estimate, error)| estimate / error)
        .collect();
    assert!(seen.len() >= 6, "{told:?}");
    let worst = seen.iter().copied().fold(0.0, f64::max);
    assert!(worst < 20.0, "{told:?}");
}

/// The root mean square under a random force, off by no more than is told.
#[test]
fn the_error_of_a_root_mean_square_is_told() {
    let component = spatial_beam(&SpatialBeam {
        elements: 12,
        ..SpatialBeam::default()
    });
    let folder = tempfile::tempdir().unwrap();
    let reduced = dcb_tests::lowest(&component, 4);
    dcb_tests::write_bare(&folder.path().join("beam.dcb.h5"), &reduced.superelement);
    let [left, right] = MOUNTS.map(|mount| format!("{mount:?}"));
    let text = format!(
        r#"{{"dimension": 3, "units": {{"length": "m", "mass": "kg", "time": "s"}},
          "ground": {{"points": {{"a": [0, 0, 0], "b": [1, 0, 0]}}}},
          "bodies": {{"beam": {{"superelement": "beam.dcb.h5"}}}},
          "springs": {{"a": {{"bushing": {{"a": "ground/a", "b": "beam/a", "translation": {left}}}}},
                       "b": {{"bushing": {{"a": "ground/b", "b": "beam/b", "translation": {right}}}}}}},
          "loads": {{"push": {{"force": {{"at": "beam/b", "components": [0, 0, 1]}}}}}},
          "outputs": {{"tip": {{"displacement": {{"at": "beam/b"}}}}}},
          "analysis": {{"frequency_response": {{"damping": {{"structural": {LOSS}}}, "inputs": ["push/2"],
            "frequencies": {{"from": 250, "to": 420, "count": 120, "spacing": "linear"}}, "random": {{"push/2": [[250, 1], [420, 1]]}}}}}}}}"#
    );
    let (report, read, _) = responses(folder.path(), &text).unwrap();
    let squares: Vec<f64> = (read.frequency.iter())
        .map(|frequency| whole(&component, *frequency, 2)[2].norm_sqr())
        .collect();
    let intervals = read.frequency.windows(2).zip(squares.windows(2));
    let square: f64 = intervals
        .map(|(f, s)| 0.5 * (s[0] + s[1]) * (f[1] - f[0]))
        .sum();
    let of_tip = report.random.iter().find(|output| output.name == "tip.z");
    let of_tip = of_tip.unwrap();
    let (off, told) = (
        (of_tip.rms / square.sqrt() - 1.0).abs(),
        of_tip.error.unwrap(),
    );
    assert!(off <= told && told < 0.3, "{off:e} told {told:e}");
    assert!(off > 1e-7, "{off:e}");
}

/// The beam as two superelements: each tells what its own modes leave out, and the sum is what both do.
#[test]
fn the_errors_of_two_bodies_are_told_together() {
    let half = |from: f64, to: f64| {
        spatial_beam(&SpatialBeam {
            elements: 6,
            start: [from, 0.0, 0.0],
            end: [to, 0.0, 0.0],
            ..SpatialBeam::default()
        })
    };
    let component = spatial_beam(&SpatialBeam {
        elements: 12,
        ..SpatialBeam::default()
    });
    let folder = tempfile::tempdir().unwrap();
    for (name, part, modes) in [("left", half(0.0, 0.5), 2), ("right", half(0.5, 1.0), 1)] {
        let element = dcb_tests::lowest(&part, modes).superelement;
        dcb_tests::write_bare(&folder.path().join(format!("{name}.dcb.h5")), &element);
    }
    let [left, right] = MOUNTS.map(|mount| format!("{mount:?}"));
    let text = format!(
        r#"{{"dimension": 3, "units": {{"length": "m", "mass": "kg", "time": "s"}},
          "ground": {{"points": {{"a": [0, 0, 0], "b": [1, 0, 0]}}}},
          "bodies": {{"left": {{"superelement": "left.dcb.h5"}}, "right": {{"superelement": "right.dcb.h5"}}}},
          "joints": {{"weld": {{"fixed": {{"a": "left/b", "b": "right/a"}}}}}},
          "springs": {{"a": {{"bushing": {{"a": "ground/a", "b": "left/a", "translation": {left}}}}},
                       "b": {{"bushing": {{"a": "ground/b", "b": "right/b", "translation": {right}}}}}}},
          "loads": {{"push": {{"force": {{"at": "right/b", "components": [0, 1, 1]}}}}}},
          "outputs": {{"tip": {{"displacement": {{"at": "right/b"}}}}}},
          "analysis": {{"frequency_response": {{"damping": {{"structural": {LOSS}}}, "inputs": ["push/1", "push/2"], "frequencies": {{"from": 5, "to": 500, "count": 40, "spacing": "linear"}}}}}}}}"#
    );
    let (_, read, _) = responses(folder.path(), &text).unwrap();
    let mut seen = 0.0_f64;
    for (input, direction) in [(0, 1), (1, 2)] {
        let name = ["tip.x", "tip.y", "tip.z"][direction];
        let place = read.outputs.iter().position(|output| output.name == name);
        let place = place.unwrap();
        let told = read.error_of(place, input).unwrap();
        for (k, frequency) in read.frequency.iter().enumerate() {
            let expected = whole(&component, *frequency, direction)[direction];
            let [re, im] = read.of(place, input)[k];
            let error = (c64::new(re, im) - expected).norm();
            seen = seen.max(error / expected.norm());
            assert!(
                error <= 1.05 * told[k] + 1e-7 * expected.norm(),
                "{frequency} Hz: {error:e} told {:e}",
                told[k]
            );
        }
    }
    assert!(seen > 1e-6, "{seen:e}");
}
