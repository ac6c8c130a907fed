//! Balanced truncation: the bound holds at every frequency, what doesn't decay is kept, and units change nothing.

use dcb_runtime::{LinearRequest, LinearSystem, OperatingPoint, Scene, linearize};
use dcb_samples::{UnitScale, in_units};
use serde_json::{Value, json};

use super::support::{about, eigenvalues, place, response};
use crate::scenes::parts::{Folder, scene_text, soft_beam, store};

fn truncated(scene: &Scene, order: usize) -> LinearSystem {
    let request = LinearRequest {
        order: Some(order),
        ..LinearRequest::default()
    };
    linearize(scene, OperatingPoint::Initial, &request, &mut ())
        .unwrap()
        .unwrap()
}

/// A damped flexible beam, clamped, hinged or free, with a force across its tip and a torque there.
fn beam(folder: &Folder, rest: Value) -> Scene {
    let mut text = scene_text(
        3,
        json!({
            "bodies": {"beam": {"superelement": "beam.dcb.h5", "damping": {"rayleigh": [0.5, 2e-5]}}},
            "loads": {
                "push": {"force": {"at": "beam/b", "components": [0, 0, {"input": {"initial": 0}}]}},
                "twist": {"torque": {"at": "beam/b", "components": [0, 0, {"input": {"initial": 0}}]}}
            },
            "outputs": {"tip": {"displacement": {"at": "beam/b"}}, "speed": {"angular_velocity": {"at": "beam/b"}}, "acceleration": {"acceleration": {"at": "beam/b"}}}
        }),
    );
    for (key, value) in rest.as_object().unwrap() {
        text[key] = value.clone();
    }
    folder.scene(&text)
}

fn frequencies() -> impl Iterator<Item = f64> {
    (0..120).map(|k| 10_f64.powf(-1.0 + 0.06 * f64::from(k)))
}

/// The largest error as a part of its bound.
fn share_of_bound(full: &LinearSystem, small: &LinearSystem) -> f64 {
    let bounds = &small.truncation.as_ref().unwrap().bounds;
    let mut largest = 0.0_f64;
    for omega in frequencies() {
        let ((a, b), (c, d)) = (response(full, omega), response(small, omega));
        for i in 0..a.nrows() {
            for j in 0..a.ncols() {
                let error = (a[(i, j)] - c[(i, j)]).hypot(b[(i, j)] - d[(i, j)]);
                // Rounding of the two responses is no error of the truncation.
                let rounding = 1e-11 * a[(i, j)].hypot(b[(i, j)]);
                largest = largest.max((error - rounding).max(0.0) / bounds[(i, j)]);
            }
        }
    }
    largest
}

#[test]
fn the_error_stays_within_its_bound_and_comes_near_it() {
    let folder = Folder::with_parts();
    let scene = beam(
        &folder,
        json!({"joints": {"clamp": {"fixed": {"a": "ground", "b": "beam/a"}}}}),
    );
    let full = about(&scene, OperatingPoint::Initial, &[], &[]);
    let mut before = f64::INFINITY;
    for order in [2, 4, 6, 8] {
        let small = truncated(&scene, order);
        assert_eq!(small.order(), order);
        let truncation = small.truncation.as_ref().unwrap();
        assert_eq!(
            (truncation.full_order, truncation.kept_apart),
            (full.order(), 0)
        );
        assert!(truncation.bound < before);
        before = truncation.bound;
        let share = share_of_bound(&full, &small);
        assert!(share <= 1.0, "{order}: {share}");
        // A bound that says nothing would be far away.
        assert!(share > 1e-3, "{order}: {share}");
        assert!(small.poles.iter().all(|pole| pole.is_stable()));
        for (pole, found) in small.poles.iter().zip(eigenvalues(&small)) {
            assert!((pole.growth - found[0]).abs() < 1e-9 * pole.magnitude());
        }
        assert_eq!(small.d, full.d);
    }
    assert_eq!(truncated(&scene, full.order()), full);
}

#[test]
fn what_does_not_decay_is_kept() {
    let folder = Folder::with_parts();
    for (rest, kept) in [
        // Free in space: twelve zeros, of which Rayleigh's alpha damps the rigid motions not.
        (json!({}), 12),
        // Turned by a drive that is an input.
        (
            json!({"joints": {"axle": {"revolute": {"a": "ground", "b": "beam/a", "axis": [0, 1, 0]}}},
                "drives": {"motor": {"angle": {"joint": "axle", "input": {"initial": 0}}}}}),
            2,
        ),
        // Standing on its root in gravity, it falls: one pole grows, and its partner decays.
        (
            json!({"gravity": [9.81, 0, 0], "initial": {"allow_gap": 0.4}, "joints": {"axle": {"revolute": {"a": "ground", "b": "beam/b", "axis": [0, 1, 0]}}}}),
            1,
        ),
    ] {
        let scene = beam(&folder, rest.clone());
        let full = about(&scene, OperatingPoint::Initial, &[], &[]);
        let small = truncated(&scene, kept + 4);
        let truncation = small.truncation.as_ref().unwrap();
        assert_eq!(
            (truncation.kept_apart, small.order()),
            (kept, kept + 4),
            "{rest}"
        );
        let decays = |system: &LinearSystem| -> Vec<f64> {
            let kept = system.poles.iter().filter(|pole| !pole.is_stable());
            kept.map(|pole| pole.growth).collect()
        };
        assert_eq!(decays(&full), decays(&small), "{rest}");
        let share = share_of_bound(&full, &small);
        assert!(share <= 1.0, "{rest}: {share}");
    }
}

/// The same part in metres and in millimetres: every number with its unit, poles and the truncation without.
#[test]
fn units_change_numbers_and_nothing_else() {
    let clamp = json!({"joints": {"clamp": {"fixed": {"a": "ground", "b": "beam/a"}}}});
    let folder = Folder::with_parts();
    let metres = beam(&folder, clamp.clone());
    let other = tempfile::tempdir().unwrap();
    let part = in_units(&soft_beam(), &UnitScale::mm_t_s());
    store(&part, &other.path().join("beam.dcb.h5"));
    let mut text = serde_json::to_value(&metres).unwrap();
    text["units"] = json!({"length": "mm", "mass": "t", "time": "s"});
    let millimetres = Scene::parse(&text.to_string(), &other.path().join("scene.json")).unwrap();
    let (one, two) = (
        about(&metres, OperatingPoint::Initial, &[], &[]),
        about(&millimetres, OperatingPoint::Initial, &[], &[]),
    );
    for (a, b) in one.poles.iter().zip(&two.poles) {
        assert!(
            (a.growth - b.growth).abs() < 1e-9 * a.magnitude(),
            "{a:?} {b:?}"
        );
        assert!((a.angular_frequency - b.angular_frequency).abs() < 1e-9 * a.magnitude());
    }
    // m/N against mm/N, and rad/(N·m) against rad/(N·mm).
    let tip = place(&one.outputs, "tip.z");
    let speed = place(&one.outputs, "speed.z");
    for omega in [0.0, 3.0, 100.0, 3000.0] {
        let ((a, b), (c, d)) = (response(&one, omega), response(&two, omega));
        for (i, j, factor) in [(tip, 0, 1e3), (speed, 1, 1e-3)] {
            let size = a[(i, j)].hypot(b[(i, j)]) * factor;
            let off = (a[(i, j)] * factor - c[(i, j)]).hypot(b[(i, j)] * factor - d[(i, j)]);
            assert!(off <= 1e-8 * size, "{omega} {i} {j}: {off:e} of {size:e}");
        }
    }
    let (one, two) = (truncated(&metres, 6), truncated(&millimetres, 6));
    let [first, second] = [&one, &two].map(|system| system.truncation.as_ref().unwrap());
    assert!(
        (first.bound / second.bound - 1.0).abs() < 1e-6,
        "{first:?} {second:?}"
    );
    assert!((first.bounds[(tip, 0)] * 1e3 / second.bounds[(tip, 0)] - 1.0).abs() < 1e-6);
}
