//! Steps chosen by their error.

use crate::support::Part;
use crate::support::mechanisms::{about_z, formula, method, rigid, with_stiffness};
use dcb_formats::mesh::Dimension;
use dcb_formats::scene::RedundantConstraints;
use dcb_runtime::Error;
use dcb_runtime::integrator::Formulation;
use dcb_runtime::integrator::adaptive::{AdaptiveStep, StepSize};
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::builder::{Drawn, JointCoordinate, SystemBuilder, Turning};
use dcb_runtime::system::{LoadAxes, State, System};
use dcb_samples::{RodSection, planar_rod};
use nalgebra::{Matrix3, Vector3};

/// A bar on a hinge, with a torque on it that is a function of time.
fn pendulum(torque: &str) -> (System, State) {
    let ends = [Vector3::new(-0.5, 0.0, 0.0)];
    let body = rigid(Dimension::Planar, 2.0, Vector3::new(0.1, 0.1, 0.2), &ends);
    let mut builder = SystemBuilder::new(Dimension::Planar, Vector3::new(0.0, -9.81, 0.0));
    let drawn = Drawn {
        position: Vector3::new(0.5, 0.0, 0.0),
        ..Drawn::default()
    };
    let bar = builder.body("bar", body, &drawn);
    let end = builder.marker(bar, 0, Turning::Interface).unwrap();
    let ground = builder.ground(Vector3::zeros(), Matrix3::identity());
    builder.joint("hinge", ground, end, &about_z()).unwrap();
    let torque = builder.signal(formula(torque));
    builder.load(
        "kick",
        end,
        LoadAxes::World,
        [None; 3],
        [None, None, Some(torque)],
    );
    builder.finish()
}

/// A soft rod driven round by a hinge.
fn flexible_crank() -> (System, State) {
    let part = Part::reduced(planar_rod(4, &RodSection::default()), 2);
    let mut builder = SystemBuilder::new(Dimension::Planar, Vector3::zeros());
    let body = builder.body(
        "rod",
        with_stiffness(&part.body, 2000.0, 0.05),
        &Drawn::default(),
    );
    let end = builder.marker(body, 0, Turning::Interface).unwrap();
    let ground = builder.ground(builder.frame(end).position, Matrix3::identity());
    let hinge = builder.joint("hinge", ground, end, &about_z()).unwrap();
    let tip = builder.marker(body, 1, Turning::Interface).unwrap();
    let turn = builder.signal(formula("0.5*(1-cos(6*t))"));
    let push = builder.signal(formula("0.02*cos(5*t)"));
    let angle = hinge.coordinate(JointCoordinate::Rotation).unwrap();
    builder.drive("motor", &hinge, angle, turn);
    builder.load(
        "push",
        tip,
        LoadAxes::Follower,
        [None, Some(push), None],
        [None; 3],
    );
    builder.finish()
}

fn start((system, state): (System, State)) -> Simulation {
    let method = method(Formulation::Index3, 0.8);
    Simulation::start(system, state, method, RedundantConstraints::MinimumNorm)
        .unwrap()
        .0
}

fn settings(tolerance: f64) -> AdaptiveStep {
    AdaptiveStep {
        tolerance,
        first: 1e-4,
        smallest: 1e-9,
        largest: 0.1,
    }
}

/// The end of a run, its steps and its factorizations.
fn adaptive(system: (System, State), tolerance: f64, end: f64) -> (State, Vec<f64>, usize) {
    let mut simulation = start(system);
    let mut size = StepSize::new(settings(tolerance));
    let mut times = vec![0.0];
    simulation
        .advance_to(end, &mut size, &mut |state| times.push(state.time))
        .unwrap();
    let (_, effort) = simulation.effort();
    assert_eq!(simulation.state().time, end);
    (simulation.state().clone(), times, effort.factorizations)
}

fn fixed(system: (System, State), steps: usize, end: f64) -> State {
    let mut simulation = start(system);
    for _ in 0..steps {
        simulation.step(end / steps as f64).unwrap();
    }
    simulation.state().clone()
}

fn distance(a: &State, b: &State) -> f64 {
    (a.origins[0] - b.origins[0]).norm()
}

/// A name and a way to make a mechanism.
type Case = (&'static str, fn() -> (System, State));

#[test]
fn errors_follow_the_tolerance_over_three_decades() {
    let cases: [Case; 2] = [
        ("pendulum", || pendulum("0")),
        ("flexible crank", flexible_crank),
    ];
    for (name, make) in cases {
        let reference = fixed(make(), 40_000, 1.0);
        let runs = [1e-5, 1e-6, 1e-7, 1e-8].map(|tolerance| adaptive(make(), tolerance, 1.0));
        let errors = runs.each_ref().map(|(end, _, _)| distance(end, &reference));
        for (at, (_, times, factorizations)) in runs.iter().enumerate() {
            println!(
                "{name} {:e} in {} steps, {factorizations} factors",
                errors[at],
                times.len()
            );
        }
        // A local error of third order for a global one of second: errors go with the tolerance to the power 2/3.
        let slope = (errors[0] / errors[3]).log10() / 3.0;
        assert!(
            (slope - 2.0 / 3.0).abs() < 0.2,
            "{name}: {slope}, {errors:?}"
        );
        assert!(errors[3] < 1e-4, "{name}: {errors:?}");
    }
}

/// After a kick that lasts a thousandth of a second: small steps there, large ones elsewhere, and fewer than equal ones would be.
#[test]
fn a_kick_is_resolved_and_left_behind() {
    let torque = "400*exp(-((t-0.5)/0.0005)^2)";
    let reference = fixed(pendulum(torque), 100_000, 1.0);
    let (end, times, _) = adaptive(pendulum(torque), 1e-6, 1.0);
    let step_at = |time: f64| {
        let at = times.partition_point(|t| *t < time);
        times[at] - times[at - 1]
    };
    let (before, during, after) = (step_at(0.4), step_at(0.5), step_at(0.9));
    assert!(
        during < 0.1 * before && during < 0.1 * after,
        "{before} {during} {after}"
    );
    let error = distance(&end, &reference);
    let equal = distance(&fixed(pendulum(torque), times.len(), 1.0), &reference);
    println!("{} steps: {error:e}, equal steps {equal:e}", times.len());
    assert!(error < 0.1 * equal, "{error:e} {equal:e}");
}

#[test]
fn a_jump_is_met_by_steps_taken_again() {
    let torque = "20*abs(t-0.5)/(t-0.5)";
    let reference = fixed(pendulum(torque), 99_999, 1.0);
    let (end, _, _) = adaptive(pendulum(torque), 1e-7, 1.0);
    let error = distance(&end, &reference);
    assert!(error < 1e-3, "{error:e}");
}

#[test]
fn steps_that_would_vanish_are_an_error() {
    let mut simulation = start(pendulum("0"));
    let mut size = StepSize::new(AdaptiveStep {
        tolerance: 1e-16,
        smallest: 1e-3,
        first: 1e-2,
        largest: 0.1,
    });
    match simulation.advance_to(1.0, &mut size, &mut |_| {}) {
        Err(Error::StepTooSmall { error, .. }) => assert!(error > 1.0),
        other => panic!("{other:?}"),
    }
}
