//! Radau IIA: its order, what its tolerance means, jumps, states between steps, and energy over many turns.

use std::sync::Arc;

use super::order::{double_pendulum, errors, flexible_pendulum};
use crate::support::Part;
use crate::support::mechanisms::{about_z, formula, rigid};
use dcb_formats::mesh::Dimension;
use dcb_formats::scene::RedundantConstraints;
use dcb_runtime::integrator::radau::{Accuracy, Stages};
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::builder::{Drawn, JointCoordinate, SystemBuilder, Turning};
use dcb_runtime::system::{LoadAxes, State, System};
use dcb_samples::spatial_beam::BeamSection;
use dcb_samples::{Material, SpatialBeam, spatial_beam};
use nalgebra::{Matrix3, Vector3};

const BOTH: [Stages; 2] = [Stages::Three, Stages::Five];

fn accuracy(tolerance: f64, stages: Stages) -> Accuracy {
    Accuracy {
        tolerance,
        of_forces: f64::INFINITY,
        stages,
        longest: f64::INFINITY,
        horizon: 10.0,
    }
}

fn start((system, state): (System, State), accuracy: Accuracy) -> Simulation {
    Simulation::start(system, state, accuracy, RedundantConstraints::MinimumNorm)
        .unwrap()
        .0
}

/// States at equal times, and how many steps led there.
fn run(
    system: (System, State),
    accuracy: Accuracy,
    end: f64,
    intervals: u32,
) -> (Vec<State>, usize) {
    let mut simulation = start(system, accuracy);
    let mut states = vec![simulation.state().clone()];
    for _ in 0..intervals {
        simulation.step(end / f64::from(intervals)).unwrap();
        states.push(simulation.state().clone());
    }
    (states, simulation.effort().0)
}

#[test]
fn errors_fall_with_the_order_of_the_method() {
    for (name, make, end) in [
        ("double pendulum", double_pendulum as fn() -> _, 2.0),
        ("flexible", flexible_pendulum, 2.0),
    ] {
        let (reference, _) = run(make(), accuracy(1e-12, Stages::Five), end, 4);
        for stages in BOTH {
            let found = [1e-4, 1e-8].map(|tolerance| {
                let (states, steps) = run(make(), accuracy(tolerance, stages), end, 4);
                (errors(&states, &reference), steps)
            });
            let order = stages.order() as f64;
            let finer = (found[1].1 as f64 / found[0].1 as f64).log2();
            for (k, quantity) in ["positions", "velocities", "forces"].iter().enumerate() {
                let slope = (found[0].0[k] / found[1].0[k]).log2() / finer;
                println!("{name} {stages:?} {quantity}: {slope:.2}");
                // Between two tolerances the steps don't all become shorter by the same factor.
                assert!(
                    slope > 0.7 * order,
                    "{name} {stages:?} {quantity}: {slope:.2}, {found:?}"
                );
            }
        }
    }
}

#[test]
fn tolerances_are_errors_of_the_motion() {
    for (name, make) in [
        ("double pendulum", double_pendulum as fn() -> _),
        ("flexible", flexible_pendulum),
    ] {
        let (reference, _) = run(make(), accuracy(1e-12, Stages::Five), 1.0, 5);
        for stages in BOTH {
            for tolerance in [1e-3, 1e-5, 1e-7, 1e-9] {
                let (states, _) = run(make(), accuracy(tolerance, stages), 1.0, 5);
                let [places, ..] = errors(&states, &reference);
                assert!(
                    places < 50.0 * tolerance && places > 1e-4 * tolerance,
                    "{name} {stages:?} {tolerance:e}: {places:e}"
                );
            }
        }
    }
}

/// Soft beams on hinges in a row, which fall from a straight horizontal line.
fn chain() -> (System, State) {
    let beam = SpatialBeam {
        elements: 4,
        end: [0.2, 0.0, 0.0],
        section: BeamSection::rectangle(0.02, 0.03),
        material: Material {
            youngs_modulus: 1e-4 * Material::STEEL.youngs_modulus,
            ..Material::STEEL
        },
        ..SpatialBeam::default()
    };
    let body = Arc::new(Part::reduced(spatial_beam(&beam), 4).body);
    let mut builder = SystemBuilder::new(Dimension::Spatial, Vector3::new(0.0, -9.81, 0.0));
    let mut above = builder.ground(Vector3::zeros(), Matrix3::identity());
    for number in 0..8 {
        let drawn = Drawn {
            position: Vector3::new(0.2 * f64::from(number), 0.0, 0.0),
            ..Drawn::default()
        };
        let beam = builder.body(&format!("beam{number}"), body.clone(), &drawn);
        let [start, end] = [0, 1].map(|i| builder.marker(beam, i, Turning::Interface).unwrap());
        let name = format!("hinge{number}");
        builder.joint(&name, above, start, &about_z()).unwrap();
        above = end;
    }
    builder.finish()
}

/// What the iteration leaves at a loose tolerance must not be what makes later steps fail.
#[test]
fn a_looser_tolerance_takes_no_more_steps() {
    let (reference, _) = run(chain(), accuracy(1e-9, Stages::Five), 1.0, 10);
    for stages in BOTH {
        let mut fewest = usize::MAX;
        for tolerance in [1e-2, 3e-2, 1e-1] {
            let (states, steps) = run(chain(), accuracy(tolerance, stages), 1.0, 10);
            let [places, ..] = errors(&states, &reference);
            println!("{stages:?} {tolerance:e}: {places:e} in {steps} steps");
            assert!(places < tolerance, "{stages:?} {tolerance:e}: {places:e}");
            assert!(
                steps <= fewest,
                "{stages:?} {tolerance:e}: {steps} steps, {fewest} at the tighter one"
            );
            fewest = steps;
        }
    }
}

/// Forces follow oscillations of stiff coordinates that the motion hardly sees.
#[test]
fn forces_follow_a_tolerance_of_their_own() {
    let (reference, _) = run(flexible_pendulum(), accuracy(1e-12, Stages::Five), 1.0, 20);
    for stages in BOTH {
        let error = |of_forces: f64| {
            let held = Accuracy {
                of_forces,
                ..accuracy(1e-2, stages)
            };
            let (states, steps) = run(flexible_pendulum(), held, 1.0, 20);
            let [.., forces] = errors(&states, &reference);
            println!("{stages:?} {of_forces:e}: {forces:e} in {steps} steps");
            forces
        };
        let free = error(f64::INFINITY);
        // A loose one asks for no more than the motion does: which of the two errs less is chance, and how much of the force is right.
        for (tolerance, part, bound) in [
            (1e-2, 10.0, f64::INFINITY),
            (1e-4, 0.2, 1e-2),
            (1e-6, 1e-2, 1e-4),
        ] {
            let held = error(tolerance);
            assert!(
                held < bound && held < part * free,
                "{stages:?} {tolerance:e}: {held:e} {free:e}"
            );
        }
    }
}

/// A wheel on a hinge.
fn wheel() -> (SystemBuilder, usize, usize) {
    let body = rigid(
        Dimension::Planar,
        2.0,
        Vector3::new(0.1, 0.1, 0.2),
        &[Vector3::zeros(), Vector3::new(0.5, 0.0, 0.0)],
    );
    let mut builder = SystemBuilder::new(Dimension::Planar, Vector3::zeros());
    let index = builder.body("wheel", body, &Drawn::default());
    let axle = builder.marker(index, 0, Turning::Interface).unwrap();
    let ground = builder.ground(Vector3::zeros(), Matrix3::identity());
    (builder, ground, axle)
}

/// A torque that jumps three times: the turn is known in closed form, and no step is taken across a jump.
#[test]
fn torques_that_jump_are_met_at_their_jumps() {
    let (mut builder, ground, axle) = wheel();
    builder.joint("hinge", ground, axle, &about_z()).unwrap();
    let torque = builder.signal(formula("if(t < 0.3, 1, if(t < 0.7, -2, 0.5))"));
    let own = [None, None, Some(torque)];
    builder.load("kick", axle, LoadAxes::World, [None; 3], own);
    let mut simulation = start(builder.finish(), accuracy(1e-6, Stages::Three));
    let mut times = vec![0.0];
    while simulation.state().time < 1.0 {
        simulation.step_towards(1.0).unwrap();
        times.push(simulation.state().time);
    }
    for jump in [0.3, 0.7] {
        assert!(times.contains(&jump), "{times:?}");
    }
    // Inertia 0.2; speeds at the jumps, and the turn by trapezoids.
    let speeds = [0.0, 1.5, 1.5 - 4.0, -2.5 + 0.75];
    let turn = 0.5 * (0.3 * 1.5 + 0.4 * (1.5 - 2.5) + 0.3 * (-2.5 - 1.75));
    let state = simulation.state();
    assert!((state.velocities[5] - speeds[3]).abs() < 1e-12);
    let found = state.orientations[0].scaled_axis().z;
    assert!((found - turn).abs() < 1e-12, "{found} {turn}");
    assert!(times.len() < 30, "{times:?}");
}

/// A drive whose speed jumps hands the jump on to the body at once, without ringing.
#[test]
fn drives_whose_speed_jumps_go_on_with_the_new_speed() {
    let (mut builder, ground, axle) = wheel();
    let hinge = builder.joint("hinge", ground, axle, &about_z()).unwrap();
    let angle = hinge.coordinate(JointCoordinate::Rotation).unwrap();
    let turn = builder.signal(formula("if(t < 0.5, 2*t, 1 - 3*(t-0.5))"));
    builder.drive("motor", &hinge, angle, turn);
    let mut simulation = start(builder.finish(), accuracy(1e-6, Stages::Three));
    simulation.step(0.75).unwrap();
    let state = simulation.state();
    assert!((state.velocities[5] + 3.0).abs() < 1e-10);
    assert!((state.orientations[0].scaled_axis().z - 0.25).abs() < 1e-10);
    assert!(state.forces.iter().all(|force| force.abs() < 1e-8));
}

/// A restored run goes on as the one that was saved, to the last bit.
#[test]
fn a_restored_run_goes_on_to_the_last_bit() {
    let mut one = start(flexible_pendulum(), accuracy(1e-6, Stages::Five));
    one.step(0.3).unwrap();
    let saved = one.save();
    one.step(0.2).unwrap();
    let mut other = start(flexible_pendulum(), accuracy(1e-6, Stages::Five));
    other.step(0.05).unwrap();
    other.restore(&saved).unwrap();
    other.step(0.2).unwrap();
    assert_eq!(one.state(), other.state());
}

/// A pendulum that swings on without friction: its energy stays, over thousands of swings.
#[test]
fn energy_stays_over_thousands_of_swings() {
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
    let mut simulation = start(builder.finish(), accuracy(1e-9, Stages::Five));
    let mut defects = Vec::new();
    for _ in 0..10 {
        simulation.step(200.0).unwrap();
        simulation.refresh();
        defects.push(simulation.energy().2.abs() / 9.81);
    }
    // Two thousand seconds are about 1200 swings; what is lost grows no faster than time.
    assert!(defects.iter().all(|defect| *defect < 1e-6), "{defects:?}");
}

/// The same motion with lengths in mm and masses in t: the steps are the same.
#[test]
fn units_change_no_step() {
    let pendulum = |length: f64, mass: f64| {
        let inertia = Vector3::new(0.02, 0.09, 0.07) * (mass * length * length);
        let ends = [Vector3::new(-0.5, 0.1, 0.0) * length];
        let body = rigid(Dimension::Spatial, mass, inertia, &ends);
        let gravity = Vector3::new(0.0, -9.81, 1.0) * length;
        let mut builder = SystemBuilder::new(Dimension::Spatial, gravity);
        let drawn = Drawn {
            position: Vector3::new(0.5, 0.0, 0.0) * length,
            angular_velocity: Vector3::new(0.0, 0.0, 3.0),
            ..Drawn::default()
        };
        let bar = builder.body("bar", body, &drawn);
        let end = builder.marker(bar, 0, Turning::Interface).unwrap();
        let ground = builder.ground(builder.frame(end).position, Matrix3::identity());
        builder.joint("hinge", ground, end, &about_z()).unwrap();
        builder.finish()
    };
    let [(metres, steps), (millimetres, same)] =
        [(1.0, 1.0), (1000.0, 1e-3)].map(|(length, mass)| {
            run(
                pendulum(length, mass),
                accuracy(1e-7, Stages::Three),
                2.0,
                1,
            )
        });
    assert_eq!(steps, same);
    let apart = metres[1].orientations[0].angle_to(&millimetres[1].orientations[0]);
    assert!(apart < 1e-10, "{apart:e}");
}
