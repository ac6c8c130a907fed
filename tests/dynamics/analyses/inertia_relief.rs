//! Free mechanisms under load, and vibrations about preloaded rests, against closed forms and a motion that settled.

use std::sync::Arc;

use crate::support::Part;
use crate::support::mechanisms::{about_z, formula, linear, method, rigid};
use dcb_formats::mesh::Dimension;
use dcb_formats::scene::RedundantConstraints;
use dcb_runtime::analysis::eigenmodes::Eigenmodes;
use dcb_runtime::analysis::equilibrium::{EquilibriumSettings, find_equilibrium};
use dcb_runtime::analysis::inertia_relief::find_inertia_relief;
use dcb_runtime::integrator::Formulation;
use dcb_runtime::joint::{Fixed, JointKind};
use dcb_runtime::measure::{Elongation, Measure};
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::builder::{Drawn, SystemBuilder, Turning};
use dcb_runtime::system::evaluation::Evaluation;
use dcb_runtime::system::{LoadAxes, State, System};
use dcb_samples::{SpatialBeam, spatial_beam};
use nalgebra::{Matrix3, Vector3};

fn beam() -> SpatialBeam {
    SpatialBeam {
        elements: 4,
        ..SpatialBeam::default()
    }
}

/// Distance of two markers.
fn distance(system: &System, state: &State, markers: [usize; 2]) -> f64 {
    let mut evaluation = Evaluation::of(system);
    evaluation.place(system, state);
    let [a, b] = markers.map(|marker| evaluation.motions[marker].position);
    (b - a).norm()
}

/// A beam with all its modes that a force pulls at its end.
fn pulled(force: f64, ratio: f64) -> (System, State, [usize; 2], f64) {
    let mut body = Part::reduced(spatial_beam(&beam()), 24).body;
    body.damping.fill(ratio);
    let mass = body.inertia.mass();
    let mut builder = SystemBuilder::new(Dimension::Spatial, Vector3::zeros());
    let body = builder.body("bar", Arc::new(body), &Drawn::default());
    let ends = [0, 1].map(|end| builder.marker(body, end, Turning::Interface).unwrap());
    let along = (builder.frame(ends[1]).position - builder.frame(ends[0]).position).normalize();
    let force = (along * force).map(|part| builder.signal(formula(&format!("{part:e}"))));
    let force = [force.x, force.y, force.z].map(Some);
    builder.load("pull", ends[1], LoadAxes::World, force, [None; 3]);
    let (system, state) = builder.finish();
    (system, state, ends, mass)
}

/// The force in an accelerating bar grows from nothing to F: it stretches by F L / 2 E A, and its centre accelerates by F / m.
#[test]
fn a_free_bar_that_is_pulled_stretches_as_an_accelerating_bar() {
    let beam = beam();
    let stiffness = beam.material.youngs_modulus * beam.section.area;
    let force = 1e-5 * stiffness;
    let (system, mut state, ends, mass) = pulled(force, 0.0);
    let length = distance(&system, &state, ends);
    let settings = EquilibriumSettings::default();
    let report = find_inertia_relief(&system, &mut state, &settings).unwrap();
    assert_eq!(report.free_count, 6);
    let stretch = distance(&system, &state, ends) - length;
    let expected = force * length / (2.0 * stiffness);
    assert!(
        (stretch / expected - 1.0).abs() < 1e-4,
        "{stretch:e} {expected:e}"
    );
    let acceleration = Vector3::from_column_slice(&state.accelerations[..3]).norm();
    let defect = acceleration * mass / force - 1.0;
    assert!(defect.abs() < 1e-5, "{defect:e}");
    let turning = Vector3::from_column_slice(&state.accelerations[3..6]).norm();
    assert!(
        turning < 1e-5 * acceleration,
        "{turning:e} {acceleration:e}"
    );
}

/// With damping, the bar that was let go vibrates towards the same stretch and the same acceleration.
#[test]
fn a_motion_settles_where_inertia_relief_says() {
    let (system, drawn, ends, _) = pulled(1e3, 0.5);
    let mut state = drawn.clone();
    find_inertia_relief(&system, &mut state, &EquilibriumSettings::default()).unwrap();
    let still = distance(&system, &drawn, ends);
    let expected = distance(&system, &state, ends) - still;
    let (mut simulation, _) = Simulation::start(
        system,
        drawn,
        method(Formulation::Index3, 0.5),
        RedundantConstraints::MinimumNorm,
    )
    .unwrap();
    for _ in 0..400 {
        simulation.step(1e-4).unwrap();
    }
    let settled = simulation.state();
    let found = distance(simulation.system(), settled, ends) - still;
    assert!(
        (found / expected - 1.0).abs() < 1e-4,
        "{found:e} {expected:e}"
    );
    for k in 0..3 {
        let defect = (settled.accelerations[k] - state.accelerations[k]).abs();
        assert!(
            defect < 1e-5 * state.accelerations[0].abs().max(1.0),
            "{defect:e}"
        );
    }
}

/// A bar that is let go level from a hinge: its centre falls at 3/4 g and the hinge carries a quarter of its weight.
#[test]
fn a_hinged_bar_is_let_go() {
    let gravity = 9.81;
    let body = Part::reduced(spatial_beam(&beam()), 6).body;
    let weight = body.inertia.mass() * gravity;
    let mut builder = SystemBuilder::new(Dimension::Spatial, Vector3::new(0.0, -gravity, 0.0));
    let body = builder.body("bar", Arc::new(body), &Drawn::default());
    let end = builder.marker(body, 0, Turning::Interface).unwrap();
    let place = builder.frame(end).position;
    let ground = builder.ground(place, Matrix3::identity());
    let hinge = builder.joint("hinge", ground, end, &about_z()).unwrap();
    let (system, mut state) = builder.finish();
    let report = find_inertia_relief(&system, &mut state, &EquilibriumSettings::default()).unwrap();
    assert_eq!(report.free_count, 1);
    let found = state.accelerations[1] / gravity;
    assert!((found + 0.75).abs() < 1e-2, "{found}");
    let rows = system.connections[hinge.connection].rows.clone();
    let largest = rows.map(|row| state.forces[row].abs()).fold(0.0, f64::max);
    assert!(
        (largest / weight - 0.25).abs() < 1e-2,
        "{largest:e} {weight:e}"
    );
}

#[test]
fn a_held_mechanism_has_no_inertia_relief() {
    let body = Part::reduced(spatial_beam(&beam()), 6).body;
    let mut builder = SystemBuilder::new(Dimension::Spatial, Vector3::zeros());
    let body = builder.body("bar", Arc::new(body), &Drawn::default());
    let end = builder.marker(body, 0, Turning::Interface).unwrap();
    let place = builder.frame(end).position;
    let ground = builder.ground(place, Matrix3::identity());
    let clamp = JointKind::Fixed(Fixed);
    builder.joint("clamp", ground, end, &clamp).unwrap();
    let (system, mut state) = builder.finish();
    let found = find_inertia_relief(&system, &mut state, &EquilibriumSettings::default());
    assert!(found.unwrap_err().to_string().contains("use \"static\""));
}

/// A mass between two taut springs, drawn off its rest: sideways ω² = 2 T / (m L) comes from the preload alone, along it 2 k / m.
#[test]
fn preload_is_in_the_stiffness_about_the_rest() {
    let (mass, stiffness, free, half) = (2.0, 1e4, 0.9, 1.0);
    let body = rigid(
        Dimension::Spatial,
        mass,
        Vector3::repeat(0.1),
        &[Vector3::zeros()],
    );
    let mut builder = SystemBuilder::new(Dimension::Spatial, Vector3::zeros());
    let drawn = Drawn {
        position: Vector3::new(0.3, 0.0, 0.0),
        ..Drawn::default()
    };
    let body = builder.body("mass", body, &drawn);
    let center = builder.marker(body, 0, Turning::Interface).unwrap();
    for (name, x) in [("left", -half), ("right", half)] {
        let wall = builder.ground(Vector3::new(x, 0.0, 0.0), Matrix3::identity());
        let line = Measure::Elongation(Elongation { length: half });
        builder.spring(name, wall, center, [(line, linear(free, stiffness, 0.0))]);
    }
    let (system, mut state) = builder.finish();
    find_equilibrium(&system, &mut state, &EquilibriumSettings::default()).unwrap();
    assert!(state.origins[0].norm() < 1e-9);
    let modes = Eigenmodes::at(&system, &state).unwrap();
    let tension = stiffness * (half - free);
    let across = (2.0 * tension / (mass * half)).sqrt();
    let along = (2.0 * stiffness / mass).sqrt();
    let found: Vec<f64> = (modes.modes.iter())
        .map(|mode| mode.angular_frequency)
        .filter(|omega| *omega > 0.0)
        .collect();
    assert_eq!(found.len(), 3);
    for (found, expected) in found.iter().zip([across, across, along]) {
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
    }
}
