//! Bodies that nothing acts on: energy and angular momentum, an independent trajectory, and the rigid limit.

use crate::support::Part;
use crate::support::free::{FreeState, free_motion, integrate};
use dcb_runtime::FlexibleBody;
use dcb_samples::{Material, RodSection, SolidElement, box_block, planar_rod, reference_hexahedra};
use nalgebra::Vector3;

/// Absolute tolerances: attitude and spin by their own size, coordinates and rates by what the spin deflects.
fn tolerances(body: &FlexibleBody, spin: f64, relative: f64) -> Vec<f64> {
    let inertia = (body.inertia.mass()).sqrt();
    let (deflection, rate) = (
        spin * spin * inertia / body.stiffness[0],
        spin * spin * inertia / body.stiffness[0].sqrt(),
    );
    let n = body.coordinate_count();
    std::iter::repeat_n(relative, 4)
        .chain(std::iter::repeat_n(relative * spin, 3))
        .chain(std::iter::repeat_n(relative * deflection, n))
        .chain(std::iter::repeat_n(relative * rate, n))
        .collect()
}

fn advance(body: &FlexibleBody, state: &FreeState, duration: f64, scale: &[f64]) -> FreeState {
    let mut terms = dcb_runtime::InertiaTerms::for_coordinates(body.coordinate_count());
    let mut x = state.pack();
    integrate(
        |x, dx| free_motion(body, &mut terms, x, dx),
        &mut x,
        duration,
        scale,
    );
    FreeState::unpack(&x)
}

fn reference() -> serde_json::Value {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../tests/data/reference/ref_spatial.json"
    );
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn vectors(value: &serde_json::Value) -> Vec<Vec<f64>> {
    serde_json::from_value(value.clone()).unwrap()
}

/// Thirty nodes, six modes and six attachments, spun about the axis of middle inertia: tests/data/reference/ref_spatial.json,
/// `hex.free_spin`, an independent program with another integrator; its values have twelve digits.
#[test]
fn free_spin_follows_the_reference_and_conserves_energy_and_momentum() {
    let part = Part::reduced(reference_hexahedra(), 6);
    let body = &part.body;
    assert_eq!(body.coordinate_count(), 12);
    let reference = &reference()["hex"]["free_spin"];
    let times: Vec<f64> = serde_json::from_value(reference["t"].clone()).unwrap();
    let (spins, turns) = (
        vectors(&reference["omega_body"]),
        vectors(&reference["quat"]),
    );
    let mut state = FreeState::spinning(body, Vector3::from_column_slice(&spins[0]));
    let scale = tolerances(body, 20.0, 1e-11);
    let mut terms = part.terms();
    let (energy, momentum) = state.invariants(body, &mut terms);
    assert!((energy / reference["energy0"].as_f64().unwrap() - 1.0).abs() < 1e-12);
    for step in 1..times.len() {
        state = advance(body, &state, times[step] - times[step - 1], &scale);
        let spin_error = (state.spin - Vector3::from_column_slice(&spins[step])).norm();
        assert!(
            spin_error < 1e-9,
            "t = {}: spin is off by {spin_error:e} rad/s",
            times[step]
        );
        let q = &state.orientation;
        let turn_error = [q.w, q.i, q.j, q.k]
            .iter()
            .zip(&turns[step])
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        assert!(
            turn_error < 1e-10,
            "t = {}: attitude is off by {turn_error:e}",
            times[step]
        );
        let (now, turned) = state.invariants(body, &mut terms);
        assert!(
            (now / energy - 1.0).abs() < 1e-11,
            "energy drifted by {:e}",
            now / energy - 1.0
        );
        assert!(
            (turned - momentum).norm() < 1e-12 * momentum.norm(),
            "{:e}",
            (turned - momentum).norm()
        );
    }
}

#[test]
fn a_planar_rod_in_free_spin_conserves_energy_and_momentum() {
    let part = Part::reduced(planar_rod(4, &RodSection::default()), 3);
    let body = &part.body;
    let mut state = FreeState::spinning(body, Vector3::new(0.0, 0.0, 600.0));
    // Bent by a thirtieth of its length at the start, so that the second-order terms work.
    state.y[0] = 0.01 * body.inertia.mass().sqrt();
    state.y[1] = -0.003 * body.inertia.mass().sqrt();
    let mut terms = part.terms();
    let (energy, momentum) = state.invariants(body, &mut terms);
    let strain = body.strain_energy(&state.y);
    let end = advance(body, &state, 0.02, &tolerances(body, 600.0, 1e-12));
    let (now, turned) = end.invariants(body, &mut terms);
    assert!(
        (now - energy).abs() < 1e-8 * strain,
        "energy drifted by {:e} of the strain energy",
        (now - energy) / strain
    );
    assert!(
        (turned - momentum).norm() < 1e-9 * momentum.norm(),
        "{:e}",
        (turned - momentum).norm() / momentum.norm()
    );
    assert!(
        (end.spin.z - 600.0).abs() > 1e-3,
        "the deflection exchanges momentum with the spin"
    );
}

/// Euler's symmetric top: the spin across the axis of symmetry turns at (I_t - I_a) / I_t ω_a.
#[test]
fn without_coordinates_a_body_is_eulers_top() {
    let component = box_block(
        [2, 1, 1],
        [0.4, 0.1, 0.1],
        SolidElement::Hexahedron,
        &Material::SOFT,
    )
    .changed(|draft| draft.interfaces.clear())
    .unwrap();
    let part = Part::reduced(component, 0);
    let body = &part.body;
    assert_eq!(body.coordinate_count(), 0);
    let (along, across) = (30.0, 4.0);
    let state = FreeState::spinning(body, Vector3::new(along, across, 0.0));
    let scale = [vec![1e-12; 4], vec![1e-11; 3]].concat();
    let end = advance(body, &state, 0.7, &scale);
    // A box: I_a = m (b² + b²) / 12, I_t = m (a² + b²) / 12.
    let (axial, transverse) = (0.02, 0.17);
    let angle = (transverse - axial) / transverse * along * 0.7;
    let expected = Vector3::new(along, across * angle.cos(), -across * angle.sin());
    assert!(
        (end.spin - expected).norm() < 1e-8,
        "{} against {expected}",
        end.spin
    );
}

#[test]
fn a_stiffer_body_moves_more_like_a_rigid_one() {
    let flexible = Part::reduced(reference_hexahedra(), 4);
    let rigid_component = reference_hexahedra()
        .changed(|draft| draft.interfaces.clear())
        .unwrap();
    let rigid = Part::reduced(rigid_component, 0);
    let spin = Vector3::new(15.0, 20.0, 10.0);
    let scale = [vec![1e-12; 4], vec![1e-11; 3]].concat();
    let target = advance(
        &rigid.body,
        &FreeState::spinning(&rigid.body, spin),
        0.1,
        &scale,
    )
    .spin;
    let deviation = |factor: f64| {
        let mut body = flexible.body.clone();
        body.stiffness
            .iter_mut()
            .for_each(|stiffness| *stiffness *= factor);
        let end = advance(
            &body,
            &FreeState::spinning(&body, spin),
            0.1,
            &tolerances(&body, 20.0, 1e-9),
        );
        (end.spin - target).norm()
    };
    let (soft, stiff) = (deviation(1.0), deviation(64.0));
    // Deflections, and what they do to the inertia, are inverse to the stiffness; vibration phases spread the ratio.
    assert!(
        soft > 1e-4 && soft / stiff > 16.0 && soft / stiff < 400.0,
        "{soft:e} and {stiff:e}"
    );
}
