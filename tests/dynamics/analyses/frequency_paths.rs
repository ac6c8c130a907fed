//! What reaches outputs through which connection, against closed forms and the receptance of the receiver alone.

use std::f64::consts::TAU;

use dcb_formats::Component;
use dcb_formats::results::FrequencyResponses;
use dcb_samples::{SpatialBeam, spatial_beam};
use dcb_tests::dense::dense;
use faer::linalg::solvers::Solve;
use faer::{Mat, c64};

use super::frequency::{near, oscillator, responses};

fn of(read: &FrequencyResponses, output: &str, input: usize) -> Vec<c64> {
    let names = read.outputs.iter();
    let found = names.clone().position(|one| one.name == output);
    let place = found.unwrap_or_else(|| {
        panic!(
            "{output}: {:?}",
            names.map(|one| &one.name).collect::<Vec<_>>()
        )
    });
    let values = read.of(place, input).into_iter();
    values.map(|[re, im]| c64::new(re, im)).collect()
}

/// A source that is pushed, a receiver on a spring of its own, two mounts between them.
#[test]
fn two_mounts_share_what_comes_through() {
    let folder = tempfile::tempdir().unwrap();
    let (m1, m2, k2, c2) = (2.0, 5.0, 900.0, 3.0);
    let mounts = [(400.0, 2.0), (150.0, 7.0)];
    let mount = |(k, c): (f64, f64)| {
        format!(
            r#"{{"spring": {{"a": "source/p", "b": "receiver/p", "stiffness": {k}, "damping": {c}}}}}"#
        )
    };
    let text = format!(
        r#"{{"dimension": 2, "units": {{"length": "m", "mass": "kg", "time": "s"}},
          "ground": {{"points": {{"wall": [3, 0]}}}},
          "bodies": {{"source": {{"rigid": {{"mass": {m1}, "inertia": 1, "points": {{"p": [0, 0]}}}}}},
                     "receiver": {{"rigid": {{"mass": {m2}, "inertia": 1, "points": {{"p": [0, 0]}}}}, "position": [1, 0]}}}},
          "joints": {{"rail": {{"prismatic": {{"a": "ground", "b": "source/p", "axis": [1, 0]}}}},
                     "slide": {{"prismatic": {{"a": "ground/wall", "b": "receiver/p", "axis": [1, 0]}}}}}},
          "springs": {{"front": {}, "rear": {},
                      "own": {{"spring": {{"a": "receiver/p", "b": "ground/wall", "stiffness": {k2}, "damping": {c2}}}}}}},
          "loads": {{"push": {{"force": {{"at": "source/p", "components": [1, 0]}}}}}},
          "outputs": {{"there": {{"position": {{"at": "receiver/p"}}}}, "here": {{"position": {{"at": "source/p"}}}}}},
          "analysis": {{"frequency_response": {{"inputs": ["push/0"], "paths": ["front", "springs/rear"],
                       "frequencies": {{"from": 0.5, "to": 8, "count": 40}}}}}}}}"#,
        mount(mounts[0]),
        mount(mounts[1])
    );
    let (report, read, notes) = responses(folder.path(), &text).unwrap();
    assert!(notes.is_empty(), "{notes:?}");
    for (k, f) in read.frequency.iter().enumerate() {
        let omega = TAU * f;
        let z = |stiffness: f64, damping: f64| c64::new(stiffness, omega * damping);
        let inertia = |mass: f64| c64::new(mass * omega * omega, 0.0);
        let both = z(mounts[0].0 + mounts[1].0, mounts[0].1 + mounts[1].1);
        let receiver = z(k2, c2) - inertia(m2);
        let source = -inertia(m1);
        // (source + both) x1 − both x2 = 1, −both x1 + (receiver + both) x2 = 0
        let x1 = (receiver + both) / ((source + both) * (receiver + both) - both * both);
        let x2 = both * x1 / (receiver + both);
        for (name, (stiffness, damping)) in ["front", "springs/rear"].into_iter().zip(mounts) {
            let force = z(stiffness, damping) * (x1 - x2);
            let there = of(&read, &format!("there.x via {name}"), 0)[k];
            near([there.re, there.im], force / receiver, 1e-8);
            let here = of(&read, &format!("here.x via {name}"), 0)[k];
            near([here.re, here.im], -force / source, 1e-8);
        }
        let past = of(&read, "here.x past the paths", 0)[k];
        near([past.re, past.im], c64::new(1.0, 0.0) / source, 1e-8);
        let past = of(&read, "there.x past the paths", 0)[k].norm();
        assert!(past < 1e-12 * x2.norm(), "{past:e}");
    }
    let peak = report.peaks.iter().find(|peak| peak.output == "there.x");
    let shares = &peak.unwrap().paths;
    assert_eq!(shares.len(), 3);
    let sum: f64 = shares.iter().map(|(_, share)| share).sum();
    assert!((sum - 1.0).abs() < 1e-8, "{shares:?}");
}

/// A block that shakes a beam through a clamp and through a bushing: what comes through each is the receptance of the free beam times its force.
#[test]
fn a_joint_is_a_path_of_a_beam() {
    let component = spatial_beam(&SpatialBeam {
        elements: 6,
        ..SpatialBeam::default()
    });
    let folder = tempfile::tempdir().unwrap();
    let reduced = dcb_tests::lowest(&component, 1000);
    dcb_tests::write_bare(&folder.path().join("beam.dcb.h5"), &reduced.superelement);
    for (damping, eta) in [("", 0.0), (r#""damping": {"structural": 0.05},"#, 0.05)] {
        let text = format!(
            r#"{{"dimension": 3, "units": {{"length": "m", "mass": "kg", "time": "s"}},
              "ground": {{"points": {{"floor": [0.5, 0, 0]}}}},
              "bodies": {{
                "beam": {{"superelement": "beam.dcb.h5"}},
                "block": {{"rigid": {{"mass": 4, "inertia": [0.3, 0.4, 0.5], "points": {{"left": [-0.5, 0, 0], "middle": [0, 0, 0], "right": [0.5, 0, 0]}}}}, "position": [0.5, 0, 0]}}}},
              "joints": {{"clamp": {{"fixed": {{"a": "block/left", "b": "beam/a"}}}}}},
              "springs": {{
                "mount": {{"bushing": {{"a": "block/right", "b": "beam/b", "translation": [1e5, 2e5, 3e5], "translation_damping": [20, 30, 40]}}}},
                "floor": {{"bushing": {{"a": "ground/floor", "b": "block/middle", "translation": [1e4, 1e4, 1e4], "rotation": [1e3, 1e3, 1e3]}}}}}},
              "loads": {{"push": {{"force": {{"at": "block/middle", "components": [0, 1, 1]}}}}}},
              "outputs": {{"tip": {{"displacement": {{"at": "beam/b"}}}}}},
              "analysis": {{"frequency_response": {{{damping} "inputs": ["push/1", "push/2"], "outputs": ["tip", "reactions/clamp", "springs/mount"],
                           "paths": ["clamp", "mount"], "frequencies": [4.3, 31, 167, 300]}}}}}}"#
        );
        let (_, read, notes) = responses(folder.path(), &text).unwrap();
        assert!(notes.is_empty(), "{notes:?}");
        let named = |prefix: &str| -> Vec<String> {
            let outputs = read.outputs.iter().map(|one| one.name.clone());
            outputs
                .filter(|name| name.starts_with(prefix) && !name.contains(" "))
                .collect()
        };
        let (reaction, mount) = (named("reactions/clamp"), named("springs/mount"));
        assert_eq!((reaction.len(), mount.len()), (6, 3));
        for input in 0..2 {
            for (k, f) in read.frequency.iter().enumerate() {
                let free = free_receptance(&component, *f, eta);
                let values = |names: &[String], sign: f64| -> Vec<c64> {
                    let all = names.iter();
                    all.map(|name| of(&read, name, input)[k] * sign).collect()
                };
                // The reaction is on the block, the force of the bushing on the beam.
                for (path, place, forces) in [
                    ("clamp", 0, values(&reaction, -1.0)),
                    ("mount", 6, values(&mount, 1.0)),
                ] {
                    let expected: Vec<c64> = (0..3)
                        .map(|axis| {
                            let terms = forces.iter().enumerate();
                            terms
                                .map(|(i, force)| free[(6 + axis, place + i)] * *force)
                                .fold(c64::new(0.0, 0.0), |sum, one| sum + one)
                        })
                        .collect();
                    let size = expected.iter().map(|x| x.norm()).fold(0.0, f64::max);
                    for (axis, expected) in ["x", "y", "z"].into_iter().zip(expected) {
                        let found = of(&read, &format!("tip.{axis} via {path}"), input)[k];
                        let off = (found - expected).norm();
                        assert!(
                            off < 2e-6 * size,
                            "{path} {axis} {f}: {found:?} {expected:?}"
                        );
                    }
                }
                let past = of(&read, "tip.y past the paths", input)[k].norm();
                assert!(past < 1e-10 * of(&read, "tip.y via clamp", input)[k].norm());
            }
        }
    }
}

/// Motion of the twelve dofs at the ends by forces there, of the beam alone.
fn free_receptance(component: &Component, frequency: f64, eta: f64) -> Mat<c64> {
    let (stiffness, mass) = (dense(&component.stiffness), dense(&component.mass));
    let n = stiffness.nrows();
    let omega = TAU * frequency;
    let dynamic = Mat::from_fn(n, n, |i, j| {
        let k = stiffness[(i, j)];
        c64::new(k - omega * omega * mass[(i, j)], eta * k)
    });
    let place = |j: usize| if j < 6 { j } else { n - 12 + j };
    let forces = Mat::from_fn(n, 12, |i, j| {
        c64::new(f64::from(u8::from(i == place(j))), 0.0)
    });
    let moved = dynamic.partial_piv_lu().solve(&forces);
    Mat::from_fn(12, 12, |i, j| moved[(place(i), j)])
}

/// A bob hangs on its pin: the force that carries its weight turns with nothing, and the parts still add up.
#[test]
fn a_path_that_carries_a_weight() {
    let folder = tempfile::tempdir().unwrap();
    let (mass, inertia, arm, g) = (2.0, 0.1, 0.4, 9.81);
    let text = format!(
        r#"{{"dimension": 2, "units": {{"length": "m", "mass": "kg", "time": "s"}}, "gravity": [0, -{g}],
          "bodies": {{"bob": {{"rigid": {{"mass": {mass}, "inertia": {inertia}, "points": {{"top": [0, {arm}], "middle": [0, 0]}}}}, "position": [0, -{arm}]}}}},
          "joints": {{"pin": {{"revolute": {{"a": "ground", "b": "bob/top"}}}}}},
          "loads": {{"push": {{"force": {{"at": "bob/middle", "components": [1, 0]}}}}}},
          "outputs": {{"x": {{"position": {{"at": "bob/middle"}}}}}},
          "analysis": {{"frequency_response": {{"inputs": ["push/0"], "paths": ["pin"], "frequencies": [0.3, 2, 7]}}}}}}"#
    );
    let (_, read, notes) = responses(folder.path(), &text).unwrap();
    assert!(notes.is_empty(), "{notes:?}");
    for (k, f) in read.frequency.iter().enumerate() {
        let omega = TAU * f;
        let swings = arm * arm / (mass * g * arm - (inertia + mass * arm * arm) * omega * omega);
        let whole = of(&read, "x.x", 0)[k];
        near([whole.re, whole.im], c64::new(swings, 0.0), 1e-8);
        let past = -1.0 / (mass * omega * omega);
        let found = of(&read, "x.x past the paths", 0)[k];
        near([found.re, found.im], c64::new(past, 0.0), 1e-8);
        let through = of(&read, "x.x via pin", 0)[k];
        near([through.re, through.im], c64::new(swings - past, 0.0), 1e-7);
    }
}

#[test]
fn mistakes_in_paths_are_named() {
    let folder = tempfile::tempdir().unwrap();
    for (options, told) in [
        (
            r#""paths": ["mount"]"#,
            "there is no joint, spring or bushing \"mount\"",
        ),
        (
            r#""paths": ["spring", "spring"]"#,
            "\"spring\" is there twice",
        ),
        (
            r#""paths": ["shake"]"#,
            "there is no joint, spring or bushing",
        ),
        (
            r#""paths": ["spring"], "damping": {"assembled_modal": 0.01}"#,
            "can't be told with `assembled_modal`",
        ),
    ] {
        let text = oscillator(&format!(
            r#"{{"inputs": ["push/0"], "frequencies": [1], {options}}}"#
        ));
        let message = responses(folder.path(), &text).unwrap_err();
        assert!(message.contains(told), "{options}: {message}");
    }
}
