//! The damping that a run tells of its assembled mechanism, against complex eigenvalues of the unreduced part.

use std::sync::Arc;

use crate::support::Part;
use crate::support::mechanisms::rigid;
use dcb_formats::mesh::Dimension;
use dcb_runtime::FlexibleBody;
use dcb_runtime::analysis::effective_damping::effective_damping;
use dcb_runtime::joint::{Fixed, JointKind};
use dcb_runtime::system::builder::{Drawn, SystemBuilder, Turning};
use dcb_runtime::system::{State, System};
use dcb_samples::{SpatialBeam, spatial_beam};
use dcb_tests::dense::dense;
use faer::Mat;
use faer::linalg::solvers::Solve;
use nalgebra::{Matrix3, Vector3};

/// A beam with every mode, so that nothing is left to attachments.
fn beam() -> Part {
    let beam = SpatialBeam {
        elements: 4,
        ..SpatialBeam::default()
    };
    Part::reduced(spatial_beam(&beam), 24)
}

/// The body clamped to the ground at its first interface.
fn clamped(body: &Arc<FlexibleBody>) -> (System, State) {
    let mut builder = SystemBuilder::new(Dimension::Spatial, Vector3::zeros());
    let beam = builder.body("beam", body.clone(), &Drawn::default());
    let end = builder.marker(beam, 0, Turning::Interface).unwrap();
    let place = builder.frame(end).position;
    let ground = builder.ground(place, Matrix3::identity());
    let fixed = JointKind::Fixed(Fixed);
    builder.joint("clamp", ground, end, &fixed).unwrap();
    builder.finish()
}

/// Frequencies and ratios of `(s² M + s C + K) x = 0`, lowest first.
fn complex_modes(mass: &Mat<f64>, damping: &Mat<f64>, stiffness: &Mat<f64>) -> Vec<(f64, f64)> {
    let n = mass.nrows();
    let lu = mass.partial_piv_lu();
    let (by_rate, by_place) = (lu.solve(damping), lu.solve(stiffness));
    let first_order = Mat::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
        (true, true) => 0.0,
        (true, false) => f64::from(u8::from(j - n == i)),
        (false, true) => -by_place[(i - n, j)],
        (false, false) => -by_rate[(i - n, j - n)],
    });
    let values = first_order.eigenvalues().unwrap();
    let mut modes: Vec<(f64, f64)> = values
        .iter()
        .filter(|s| s.im > 0.0)
        .map(|s| {
            let size = s.re.hypot(s.im);
            (size / std::f64::consts::TAU, -s.re / size)
        })
        .collect();
    modes.sort_by(|a, b| a.0.total_cmp(&b.0));
    modes
}

/// M, C and K of the clamped part in nodal coordinates, C by modal ratios of the free part or by factors.
fn of_cantilever(part: &Part, c: impl Fn(&Mat<f64>, &Mat<f64>) -> Mat<f64>) -> [Mat<f64>; 3] {
    let (mass, stiffness) = (
        dense(&part.component.mass),
        dense(&part.component.stiffness),
    );
    let damping = c(&mass, &stiffness);
    let held = part.component.interfaces[0].nodes[0];
    let dofs = part.component.dofs.nodal_dofs();
    let free: Vec<usize> = (0..dofs.len()).filter(|i| dofs[*i].node != held).collect();
    [mass, damping, stiffness]
        .map(|matrix| Mat::from_fn(free.len(), free.len(), |i, j| matrix[(free[i], free[j])]))
}

#[test]
fn modal_ratios_of_a_free_beam_are_small_where_it_is_clamped_as_complex_eigenvalues_say() {
    let part = beam();
    let ratio = 0.01;
    let mut body = part.body.clone();
    body.damping.fill(ratio);
    let (system, state) = clamped(&Arc::new(body));
    let found = effective_damping(&system, &state);
    // C = M Φ 2ζΩ Φᵀ M over all elastic modes of the free part.
    let modes = &part.reduced.recovery.modes;
    let omega: Vec<f64> = part.body.stiffness.iter().map(|k| k.sqrt()).collect();
    let [mass, damping, stiffness] = of_cantilever(&part, |mass, _| {
        let carried = mass * modes;
        let scaled = Mat::from_fn(carried.nrows(), carried.ncols(), |i, k| {
            2.0 * ratio * omega[k] * carried[(i, k)]
        });
        scaled * carried.transpose()
    });
    let expected = complex_modes(&mass, &damping, &stiffness);
    assert_eq!(found.len(), 4);
    for (mode, (frequency, expected)) in found.iter().zip(&expected) {
        println!(
            "{:.4e} Hz: {:.6e}, {expected:.6e}",
            mode.frequency, mode.ratio
        );
        assert!((mode.frequency / frequency - 1.0).abs() < 1e-3);
        assert!((mode.ratio / expected - 1.0).abs() < 1e-2);
    }
    // Far less than what was given.
    assert!(found[0].ratio < 0.3 * ratio, "{found:?}");
}

#[test]
fn rayleigh_factors_keep_their_ratios_in_the_assembly() {
    let part = beam();
    let first = part.body.stiffness[0].sqrt();
    let (alpha, beta) = (0.01 * first, 0.01 / first);
    let mut body = part.body.clone();
    for (own, stiffness) in body.damping.iter_mut().zip(&part.body.stiffness) {
        let omega = stiffness.sqrt();
        *own = 0.5 * (alpha / omega + beta * omega);
    }
    let (system, state) = clamped(&Arc::new(body));
    for mode in effective_damping(&system, &state) {
        // alpha doesn't damp the motion of the frame, which is part of the mode: beta alone is exact.
        let omega = std::f64::consts::TAU * mode.frequency;
        let (least, most) = (0.5 * beta * omega, 0.5 * (alpha / omega + beta * omega));
        assert!(
            mode.ratio >= 0.999 * least && mode.ratio <= 1.001 * most,
            "{mode:?} {least} {most}"
        );
    }
    let mut body = part.body.clone();
    for (own, stiffness) in body.damping.iter_mut().zip(&part.body.stiffness) {
        *own = 0.5 * beta * stiffness.sqrt();
    }
    let (system, state) = clamped(&Arc::new(body));
    let [mass, damping, stiffness] =
        of_cantilever(&part, |_, stiffness| faer::Scale(beta) * stiffness);
    let expected = complex_modes(&mass, &damping, &stiffness);
    let found = effective_damping(&system, &state);
    assert_eq!(found.len(), 4);
    for (mode, (frequency, ratio)) in found.iter().zip(expected) {
        assert!((mode.frequency / frequency - 1.0).abs() < 1e-3);
        assert!((mode.ratio / ratio - 1.0).abs() < 1e-3, "{mode:?} {ratio}");
    }
}

/// A free part has the ratios that were given, an undamped one none: there is nothing to tell. Nor of a large system.
#[test]
fn nothing_is_told_where_nothing_differs() {
    let part = beam();
    let (system, state) = clamped(&Arc::new(part.body.clone()));
    assert!(effective_damping(&system, &state).is_empty(), "undamped");
    let mut body = part.body.clone();
    body.damping.fill(0.01);
    let body = Arc::new(body);
    let mut builder = SystemBuilder::new(Dimension::Spatial, Vector3::zeros());
    builder.body("beam", body.clone(), &Drawn::default());
    let (system, state) = builder.finish();
    assert!(effective_damping(&system, &state).is_empty(), "free");
    let mut builder = SystemBuilder::new(Dimension::Spatial, Vector3::zeros());
    for index in 0..12 {
        let beam = builder.body(&format!("beam {index}"), body.clone(), &Drawn::default());
        let end = builder.marker(beam, 0, Turning::Interface).unwrap();
        let ground = builder.ground(builder.frame(end).position, Matrix3::identity());
        builder
            .joint("clamp", ground, end, &JointKind::Fixed(Fixed))
            .unwrap();
    }
    let (system, state) = builder.finish();
    assert!(effective_damping(&system, &state).is_empty(), "large");
    let bob = rigid(
        Dimension::Spatial,
        1.0,
        Vector3::repeat(0.1),
        &[Vector3::zeros()],
    );
    let mut builder = SystemBuilder::new(Dimension::Spatial, Vector3::zeros());
    builder.body("bob", bob, &Drawn::default());
    let (system, state) = builder.finish();
    assert!(effective_damping(&system, &state).is_empty(), "rigid");
}
