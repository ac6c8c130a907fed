//! Rigid bodies, springs, bushings and held places, against closed forms.

use dcb_formats::superelement::FrameKind;
use dcb_samples::spatial_beam::{SpatialBeam, spatial_beam};
use dcb_samples::{Material, spatial_beam::BeamSection};
use dcb_tests::lowest;

use crate::{loaded, put_together};

const UNITS: &str = r#""units": {"length": "m", "mass": "kg", "time": "s"}"#;

#[test]
fn two_masses_on_a_spring() {
    let (m, n, k, c) = (2.0, 3.0, 450.0, 1.2);
    let text = format!(
        r#"{{"dimension": 3, {UNITS},
          "bodies": {{
            "m": {{"rigid": {{"mass": {m}, "inertia": [0.1, 0.1, 0.1], "points": {{"p": [0, 0, 0]}}}}}},
            "n": {{"rigid": {{"mass": {n}, "inertia": [0.2, 0.2, 0.2], "points": {{"p": [0, 0, 0], "q": [0.1, 0, 0]}}}}, "position": [0, 0, 0]}}}},
          "springs": {{"mount": {{"bushing": {{"a": "m/p", "b": "n/p", "translation": [{k}, 1e3, 2e3], "rotation": [10, 20, 30],
                     "translation_damping": [{c}, 0, 0]}}}}}},
          "interfaces": {{"q": "n/q"}}}}"#
    );
    let found = put_together(&text, vec![None, None], 6)
        .unwrap()
        .superelement;
    let reduced = |a: f64, b: f64| a * b / (a + b);
    let (mass, inertia) = (reduced(m, n), reduced(0.1, 0.2));
    let mut expected = [
        k / mass,
        1e3 / mass,
        2e3 / mass,
        10.0 / inertia,
        20.0 / inertia,
        30.0 / inertia,
    ];
    expected.sort_by(f64::total_cmp);
    for (a, b) in found.modes.eigenvalues.iter().zip(expected) {
        assert!((a / b - 1.0).abs() < 1e-12, "{a} and {b}");
    }
    let of_x = found
        .modes
        .eigenvalues
        .iter()
        .position(|square| (square / (k / mass) - 1.0).abs() < 1e-9)
        .unwrap();
    let ratio = 0.5 * c / (k * mass).sqrt();
    assert!((found.modes.damping[of_x] / ratio - 1.0).abs() < 1e-12);
    assert!((found.inertia.mass - m - n).abs() < 1e-12);
}

/// A tip mass on a clamped beam: Rayleigh's frequency equation, and the static deflection under a tip force.
#[test]
fn a_clamped_beam_with_a_tip_mass() {
    let (length, tip) = (1.0, 3.0);
    let section = BeamSection::rectangle(0.02, 0.03);
    let beam = spatial_beam(&SpatialBeam {
        elements: 24,
        section,
        ..SpatialBeam::default()
    });
    let reduced = lowest(&beam, 20);
    let text = format!(
        r#"{{"dimension": 3, {UNITS},
          "bodies": {{"beam": {{"superelement": "beam.dcb.h5"}},
                     "tip": {{"rigid": {{"mass": {tip}, "inertia": [0, 0, 0], "points": {{"p": [0, 0, 0]}}}}, "position": [{length}, 0, 0]}}}},
          "joints": {{"clamp": {{"fixed": {{"a": "ground", "b": "beam/a"}}}}, "weld": {{"spherical": {{"a": "tip/p", "b": "beam/b"}}}}}},
          "interfaces": {{"end": "beam/b"}}}}"#
    );
    let found = put_together(&text, vec![loaded(&beam, reduced, "beam"), None], 4)
        .unwrap()
        .superelement;
    assert_eq!(found.frame_kind, FrameKind::Given);
    // 1 + cos β cosh β = μ β (sin β cosh β − cos β sinh β), μ = tip / (ρ A L)
    let steel = Material::STEEL;
    let (area, bending) = (0.02 * 0.03, 0.02 * 0.03_f64.powi(3) / 12.0);
    let weak = 0.03 * 0.02_f64.powi(3) / 12.0;
    let line = steel.density * area;
    let mu = tip / (line * length);
    let equation =
        |b: f64| 1.0 + b.cos() * b.cosh() - mu * b * (b.sin() * b.cosh() - b.cos() * b.sinh());
    let (mut low, mut high) = (0.1, 1.875);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if equation(middle) > 0.0 {
            low = middle
        } else {
            high = middle
        }
    }
    let square =
        |inertia: f64| low.powi(4) * steel.youngs_modulus * inertia / (line * length.powi(4));
    for (found, inertia) in found
        .modes
        .eigenvalues
        .iter()
        .zip([weak.min(bending), weak.max(bending)])
    {
        assert!(
            (found / square(inertia) - 1.0).abs() < 1e-5,
            "{found} and {}",
            square(inertia)
        );
    }
    // u = F L³ / (3 E I) with all modes and the residual part.
    let flexibility = |row: usize| -> f64 {
        let modes: f64 = (0..found.mode_count())
            .map(|k| found.modes.interface_shapes[(row, k)].powi(2) / found.modes.eigenvalues[k])
            .sum();
        modes + found.residual.flexibility[(row, row)]
    };
    let stiff = |inertia: f64| length.powi(3) / (3.0 * steel.youngs_modulus * inertia);
    let mut own = [flexibility(1), flexibility(2)];
    let mut expected = [stiff(bending), stiff(weak)];
    own.sort_by(f64::total_cmp);
    expected.sort_by(f64::total_cmp);
    for (a, b) in own.into_iter().zip(expected) {
        assert!((a / b - 1.0).abs() < 1e-9, "{a:e} and {b:e}");
    }
}

/// Three fixed joints between two rigid bodies hold what one does.
#[test]
fn redundant_joints_are_named_and_change_nothing() {
    let joint =
        |name: &str| format!(r#""{name}": {{"fixed": {{"a": "m/{name}", "b": "n/{name}"}}}}"#);
    let body = |mass: f64| {
        format!(
            r#"{{"rigid": {{"mass": {mass}, "inertia": [0.1, 0.1, 0.1], "points": {{"p": [0.3, 0, 0], "q": [0, 0.3, 0]}}}}}}"#
        )
    };
    let text = |joints: String| {
        format!(
            r#"{{"dimension": 3, {UNITS}, "bodies": {{"m": {}, "n": {}, "o": {}}}, "joints": {{{joints}}},
              "springs": {{"s": {{"bushing": {{"a": "m/p", "b": "o/p", "translation": [1, 2, 3], "rotation": [1, 2, 3]}}}}}},
              "interfaces": {{"p": "o/p"}}}}"#,
            body(1.0),
            body(2.0),
            body(4.0)
        )
    };
    let once = put_together(&text(joint("p")), vec![None, None, None], 6).unwrap();
    let twice = put_together(
        &text(format!("{}, {}", joint("p"), joint("q"))),
        vec![None, None, None],
        6,
    )
    .unwrap();
    assert!(once.report.redundant.is_empty());
    assert_eq!(twice.report.redundant.len(), 6);
    for row in &twice.report.redundant {
        assert!(row.starts_with("p: ") || row.starts_with("q: "), "{row}");
    }
    let warnings = twice.report.warnings();
    assert!(
        warnings[0].starts_with("6 joint rows hold what others hold already, and change nothing: ")
            && warnings[0].ends_with("and 2 more"),
        "{warnings:?}"
    );
    for (a, b) in once
        .superelement
        .modes
        .eigenvalues
        .iter()
        .zip(&twice.superelement.modes.eigenvalues)
    {
        assert!((a / b - 1.0).abs() < 1e-10);
    }
}

/// Two rods whose directions differ by 1e-8 nearly hold the same.
#[test]
fn nearly_redundant_joints_are_named() {
    let points = r#""points": {"p": [0.3, 0, 0], "q": [0.3, 1e-8, 0], "r": [0, 0, 0.2]}"#;
    let text = format!(
        r#"{{"dimension": 3, {UNITS},
          "bodies": {{"m": {{"rigid": {{"mass": 1, "inertia": [0.1, 0.1, 0.1], {points}}}}},
                     "n": {{"rigid": {{"mass": 2, "inertia": [0.1, 0.1, 0.1], "points": {{"o": [0.8, 0.1, 0], "r": [0, 0, 0.2]}}}}}}}},
          "joints": {{"one": {{"distance": {{"a": "m/p", "b": "n/o"}}}}, "two": {{"distance": {{"a": "m/q", "b": "n/o"}}}}}},
          "springs": {{"s": {{"bushing": {{"a": "m/r", "b": "n/r", "translation": [1, 2, 3], "rotation": [1, 2, 3]}}}}}},
          "interfaces": {{"r": "n/r"}}}}"#
    );
    let found = put_together(&text, vec![None, None], 6).unwrap();
    assert!(found.report.redundant.is_empty());
    let near = &found.report.nearly_redundant;
    assert_eq!(near.len(), 1, "{near:?}");
    assert!(near[0] == "one: distance" || near[0] == "two: distance");
    let warnings = found.report.warnings();
    assert!(
        warnings
            .iter()
            .any(|warning| warning.starts_with("1 joint rows nearly hold")
                && warning.contains(&near[0])),
        "{warnings:?}"
    );
}
