//! Newton's iteration of a step: how many iterations it takes, when it stops, and to what it is accurate.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::f64::consts::FRAC_PI_2;

use common::mechanisms::{about_z, method, rigid};
use dcb_formats::mesh::Dimension;
use dcb_runtime::initial::Redundancy;
use dcb_runtime::integrator::Formulation;
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::builder::{Drawn, SystemBuilder, Turning};
use dcb_runtime::system::{State, System};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// Slender bars in the plane, each hung by its first end; `at` is where: a place on the ground, or the second end of an earlier bar.
enum Hung {
    Ground(Vector3<f64>),
    Bar(usize),
}

/// A bar of some mass and length that hangs somewhere, at an angle from the x axis.
struct Bar {
    mass: f64,
    length: f64,
    hung: Hung,
    angle: f64,
    spin: f64,
}

fn bars(gravity: f64, bars: &[Bar]) -> (System, State) {
    let mut builder = SystemBuilder::new(Dimension::Planar, Vector3::new(0.0, -gravity, 0.0));
    let mut ends = Vec::new();
    for (index, bar) in bars.iter().enumerate() {
        let half = Vector3::new(0.5 * bar.length, 0.0, 0.0);
        let moment = bar.mass * bar.length * bar.length / 12.0;
        let body = rigid(
            Dimension::Planar,
            bar.mass,
            Vector3::repeat(moment),
            &[-half, half],
        );
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), bar.angle);
        let foot = match &bar.hung {
            Hung::Ground(place) => *place,
            Hung::Bar(above) => ends[*above],
        };
        let spin = Vector3::new(0.0, 0.0, bar.spin);
        let drawn = Drawn {
            position: foot + turn * half,
            orientation: turn,
            velocity: spin.cross(&(turn * half)),
            angular_velocity: spin,
        };
        ends.push(foot + turn * half * 2.0);
        let body = builder.body(&format!("bar {index}"), body, &drawn);
        let above = match &bar.hung {
            Hung::Ground(place) => builder.ground(*place, Matrix3::identity()),
            Hung::Bar(above) => builder.marker(*above, 1, Turning::Interface).unwrap(),
        };
        let below = builder.marker(body, 0, Turning::Interface).unwrap();
        let name = format!("pin {index}");
        builder.joint(&name, above, below, &about_z()).unwrap();
    }
    builder.finish()
}

fn run((system, state): (System, State), step: f64, steps: usize) -> (Simulation, f64) {
    let method = method(Formulation::Index3, 0.8);
    let (mut simulation, _) =
        Simulation::start(system, state, method, Redundancy::MinimumNorm).unwrap();
    for _ in 0..steps {
        simulation.step(step).unwrap();
    }
    let (made, effort) = simulation.effort();
    let iterations = effort.iterations as f64 / made as f64;
    (simulation, iterations)
}

/// The force of the pin turns with the bar, and with it the bar's matrix has what it does to its moment.
#[test]
fn turning_by_half_a_radian_a_step_takes_few_iterations() {
    let bar = Bar {
        mass: 1.0,
        length: 1.0,
        hung: Hung::Ground(Vector3::zeros()),
        angle: 0.0,
        spin: 100.0,
    };
    let (simulation, iterations) = run(bars(0.0, &[bar]), 5e-3, 200);
    println!("{iterations} iterations a step");
    assert!(iterations < 4.0, "{iterations}");
    let forces = &simulation.state().forces;
    let spin = simulation.state().velocities[5];
    let pull = forces[0].hypot(forces[1]) / (0.5 * spin * spin);
    assert!((pull - 1.0).abs() < 1e-6, "{pull}");
}

/// A light bar under the push of a heavy one, of which the light bar's own matrix would be singular at some step: none fails.
#[test]
fn no_step_is_singular_for_a_light_strut() {
    for k in 0..40 {
        let step = 1e-4 * 1.2_f64.powi(k);
        let strut = Bar {
            mass: 0.01,
            length: 1.0,
            hung: Hung::Ground(Vector3::zeros()),
            angle: FRAC_PI_2 - 1e-3,
            spin: 0.0,
        };
        let weight = Bar {
            mass: 1.0,
            length: 1.0,
            hung: Hung::Bar(0),
            angle: FRAC_PI_2,
            spin: 0.0,
        };
        let (_, iterations) = run(bars(9.81, &[strut, weight]), step, 5);
        assert!(iterations < 9.0, "{iterations} at {step}");
    }
}

/// A pendulum of a micrometre swings beside one of a kilometre as it does alone; hung on its end, where places are as coarse as a
/// kilometre makes them, it swings as well as these allow.
#[test]
fn a_small_body_has_its_own_rounding_unless_it_is_joined_to_a_large_one() {
    let (small, large) = (1e-6, 1e3);
    let tiny = |hung: Hung| Bar {
        mass: 1e-15,
        length: small,
        hung,
        angle: 0.0,
        spin: 0.0,
    };
    let huge = || Bar {
        mass: 1e9,
        length: large,
        hung: Hung::Ground(Vector3::new(0.0, large, 0.0)),
        angle: -FRAC_PI_2,
        spin: 0.0,
    };
    let (step, steps) = (1e-5, 200);
    let swing = |system: (System, State), body: usize| {
        let (simulation, iterations) = run(system, step, steps);
        let axis = simulation.state().orientations[body] * Vector3::x();
        (axis.y.atan2(axis.x), iterations)
    };
    let ground = || Hung::Ground(Vector3::zeros());
    let (alone, of_alone) = swing(bars(9.81, &[tiny(ground())]), 0);
    let (beside, of_beside) = swing(bars(9.81, &[huge(), tiny(ground())]), 1);
    let (joined, of_joined) = swing(bars(9.81, &[huge(), tiny(Hung::Bar(0))]), 1);
    println!("{alone} {beside} {joined}, iterations {of_alone} {of_beside} {of_joined}");
    assert!((beside - alone).abs() < 1e-9, "{:e}", beside - alone);
    assert!((joined - alone).abs() < 2e-2, "{:e}", joined - alone);
    assert!(of_beside < of_alone + 0.1 && of_joined < of_alone + 1.0);
}
