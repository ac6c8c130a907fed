//! Whether a run is told that its steps are too long: where the answer is wrong, and not where it is right.

use std::f64::consts::TAU;

use crate::support::Part as Body;
use crate::support::mechanisms::{about_z, formula, linear, method, rigid, with_stiffness};
use dcb_formats::mesh::Dimension;
use dcb_formats::scene::RedundantConstraints;
use dcb_formats::scene::Scheme;
use dcb_runtime::Error;
use dcb_runtime::integrator::Formulation;
use dcb_runtime::integrator::resolution::Part;
use dcb_runtime::measure::{Displacement, Measure};
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::builder::{Drawn, SystemBuilder, Turning};
use dcb_runtime::system::{LoadAxes, State, System};
use dcb_samples::{RodSection, planar_rod};
use nalgebra::{Matrix3, Vector3};

/// A block of 1 kg on a spring of this frequency, 0.1 m from rest, with a force on it.
fn block(omega: f64, force: &str) -> (System, State) {
    let body = rigid(
        Dimension::Planar,
        1.0,
        Vector3::repeat(0.1),
        &[Vector3::zeros()],
    );
    let mut builder = SystemBuilder::new(Dimension::Planar, Vector3::zeros());
    let drawn = Drawn {
        position: Vector3::new(0.1, 0.0, 0.0),
        ..Drawn::default()
    };
    let block = builder.body("block", body, &drawn);
    let center = builder.marker(block, 0, Turning::Interface).unwrap();
    let ground = builder.ground(Vector3::zeros(), Matrix3::identity());
    let along = Measure::Displacement(Displacement {
        direction: Vector3::x_axis(),
    });
    builder.spring(
        "spring",
        ground,
        center,
        [(along, linear(0.0, omega * omega, 0.0))],
    );
    let push = builder.signal(formula(force));
    builder.load(
        "push",
        center,
        LoadAxes::World,
        [Some(push), None, None],
        [None; 3],
    );
    builder.finish()
}

fn started((system, state): (System, State), radius: f64) -> Simulation {
    let method = method(Formulation::Index3, radius);
    Simulation::start(system, state, method, RedundantConstraints::MinimumNorm)
        .unwrap()
        .0
}

fn stepped(mut simulation: Simulation, step: f64, count: usize) -> Simulation {
    for _ in 0..count {
        simulation.step(step).unwrap();
    }
    simulation
}

/// What a step leaves of an infinitely stiff motion, by which the patience with a ringing goes.
#[test]
fn spectral_radii_are_those_asked_for() {
    for radius in [0.0, 0.3, 0.8, 1.0] {
        let found = Scheme::generalized_alpha(radius).spectral_radius();
        assert!((found - radius).abs() < 1e-14, "{found}");
    }
    for alpha in [-1.0 / 3.0, -0.1, 0.0] {
        let found = Scheme::hht(alpha).spectral_radius();
        assert!((found - (1.0 + alpha) / (1.0 - alpha)).abs() < 1e-14);
    }
}

#[test]
fn steps_in_a_period_are_counted() {
    for steps in [6.0, 8.0, 12.0] {
        let omega = 30.0;
        let step = TAU / omega / steps;
        let simulation = stepped(started(block(omega, "0"), 0.8), step, 200);
        let told = simulation.resolution().told();
        assert_eq!(told.len(), 1, "{told:?}");
        assert_eq!((told[0].body, told[0].part), (0, Part::Place));
        // What the integrator makes of the motion has the period that is told.
        let found = told[0].steps_per_period;
        assert!((found / steps - 1.0).abs() < 0.35, "{found} for {steps}");
        assert!((told[0].advised_step() / (TAU / omega / 50.0) - 1.0).abs() < 0.35);
    }
    for steps in [25.0, 50.0, 100.0] {
        let simulation = stepped(started(block(30.0, "0"), 0.8), TAU / 30.0 / steps, 400);
        assert!(simulation.resolution().told().is_empty(), "{steps}");
    }
}

#[test]
fn a_motion_that_nothing_is_followed_of_is_an_error() {
    let omega = 30.0;
    let mut simulation = started(block(omega, "0"), 0.8);
    let step = TAU / omega / 4.0;
    let error = (0..100).find_map(|_| simulation.step(step).err()).unwrap();
    match &error {
        Error::StepTooLong { body, advised, .. } => {
            assert_eq!(body, "block");
            assert!(*advised < 0.5 * step, "{advised}");
        }
        other => panic!("{other}"),
    }
    assert!(!error.is_unusable_input());
}

/// A block in rest on a stiff spring that follows a slow force, and one whose start rings out.
#[test]
fn stiff_motions_that_follow_or_ring_out_are_not_told() {
    for start in [0.0, 0.1] {
        let (system, mut state) = block(1e4, "1e6*sin(3*t)");
        state.origins[0].x = start;
        let simulation = stepped(started((system, state), 0.8), 1e-2, 500);
        let told = simulation.resolution().told();
        assert!(told.is_empty(), "from {start}: {told:?}");
    }
}

#[test]
fn a_jump_of_a_load_is_not_told() {
    let simulation = stepped(
        started(block(3.0, "20*abs(t-0.5)/(t-0.5)"), 0.8),
        0.017,
        300,
    );
    assert!(simulation.resolution().told().is_empty());
}

/// A rod on a hinge swings in its first mode: by steps that follow its fall but not its bending.
#[test]
fn deflections_are_told_apart_from_places() {
    let part = Body::reduced(planar_rod(4, &RodSection::default()), 2);
    let omega: f64 = 300.0;
    let body = with_stiffness(&part.body, omega * omega, 0.0);
    let mut builder = SystemBuilder::new(Dimension::Planar, Vector3::new(0.0, -9.81, 0.0));
    let rod = builder.body("rod", body, &Drawn::default());
    let end = builder.marker(rod, 0, Turning::Interface).unwrap();
    let ground = builder.ground(builder.frame(end).position, Matrix3::identity());
    builder.joint("hinge", ground, end, &about_z()).unwrap();
    let system = builder.finish();
    let simulation = stepped(started(system.clone(), 0.8), TAU / omega / 6.0, 200);
    let told = simulation.resolution().told();
    assert!(
        told.iter().any(|found| found.part == Part::Deflection),
        "{told:?}"
    );
    let simulation = stepped(started(system, 0.8), TAU / omega / 100.0, 1000);
    let told = simulation.resolution().told();
    assert!(told.is_empty(), "{told:?}");
}
