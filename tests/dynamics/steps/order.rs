//! Order of convergence of positions, velocities and the joints' forces, from the first step on.

use crate::support::Part;
use crate::support::mechanisms::{about_z, method, rigid, with_stiffness};
use dcb_formats::mesh::Dimension;
use dcb_formats::scene::RedundantConstraints;
use dcb_runtime::integrator::Formulation;
use dcb_runtime::joint::{JointKind, Revolute, Spherical};
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::builder::{Drawn, SystemBuilder, Turning};
use dcb_runtime::system::{State, System};
use dcb_samples::{Material, SpatialBeam, spatial_beam};
use nalgebra::{Matrix3, Vector3};

/// Two bars on a skew hinge and a ball, thrown so that all their axes turn far.
pub fn double_pendulum() -> (System, State) {
    let body = || {
        let inertia = Vector3::new(0.02, 0.09, 0.07);
        let ends = [Vector3::new(-0.5, 0.1, 0.0), Vector3::new(0.5, 0.0, 0.1)];
        rigid(Dimension::Spatial, 1.0, inertia, &ends)
    };
    let mut builder = SystemBuilder::new(Dimension::Spatial, Vector3::new(0.0, -9.81, 1.0));
    let drawn = |x: f64| Drawn {
        position: Vector3::new(x, 0.0, 0.0),
        angular_velocity: Vector3::new(4.0, 2.0, -3.0 * x),
        ..Drawn::default()
    };
    let first = builder.body("first", body(), &drawn(0.5));
    let second = builder.body("second", body(), &drawn(1.5));
    let [a, b] = [0, 1].map(|i| builder.marker(first, i, Turning::Interface).unwrap());
    let c = builder.marker(second, 0, Turning::Interface).unwrap();
    let ground = builder.ground(builder.frame(a).position, Matrix3::identity());
    let hinge = JointKind::Revolute(Revolute {
        axis: Vector3::new(0.3, 0.2, 1.0),
        axis_b: None,
    });
    builder.joint("hinge", ground, a, &hinge).unwrap();
    let ball = JointKind::Spherical(Spherical);
    builder.joint("ball", b, c, &ball).unwrap();
    builder.finish()
}

/// A beam so soft that it bends through tenths of its length while it falls.
pub fn flexible_pendulum() -> (System, State) {
    let beam = SpatialBeam {
        elements: 4,
        end: [0.8, 0.3, 0.1],
        material: Material::SOFT,
        ..SpatialBeam::default()
    };
    let part = Part::reduced(spatial_beam(&beam), 3);
    let mut builder = SystemBuilder::new(Dimension::Spatial, Vector3::new(0.0, -9.81, 0.0));
    let drawn = Drawn {
        angular_velocity: Vector3::new(0.0, 0.0, 2.0),
        ..Drawn::default()
    };
    let body = builder.body("beam", with_stiffness(&part.body, 1500.0, 0.02), &drawn);
    let end = builder.marker(body, 0, Turning::Interface).unwrap();
    let ground = builder.ground(builder.frame(end).position, Matrix3::identity());
    builder.joint("hinge", ground, end, &about_z()).unwrap();
    builder.finish()
}

/// States at all steps.
fn run(
    (system, state): (System, State),
    formulation: Formulation,
    radius: f64,
    end: f64,
    steps: usize,
) -> Vec<State> {
    let method = method(formulation, radius);
    let (mut simulation, _) =
        Simulation::start(system, state, method, RedundantConstraints::MinimumNorm).unwrap();
    let mut states = vec![simulation.state().clone()];
    for _ in 0..steps {
        simulation.step(end / steps as f64).unwrap();
        states.push(simulation.state().clone());
    }
    states
}

/// Largest errors of positions, velocities and forces over all steps.
pub fn errors(states: &[State], reference: &[State]) -> [f64; 3] {
    let every = (reference.len() - 1) / (states.len() - 1);
    let mut worst = [0.0_f64; 3];
    let difference = |a: &[f64], b: &[f64]| {
        a.iter()
            .zip(b)
            .map(|(a, b)| (a - b).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    for (index, state) in states.iter().enumerate() {
        let exact = &reference[index * every];
        let mut position = difference(&state.coordinates, &exact.coordinates);
        for body in 0..state.origins.len() {
            position += (state.origins[body] - exact.origins[body]).norm()
                + state.orientations[body].angle_to(&exact.orientations[body]);
        }
        worst[0] = worst[0].max(position);
        worst[1] = worst[1].max(difference(&state.velocities, &exact.velocities));
        worst[2] = worst[2].max(difference(&state.forces, &exact.forces));
    }
    worst
}

/// A name and a way to make a mechanism.
type Case = (&'static str, fn() -> (System, State));

#[test]
fn second_order_in_positions_velocities_and_forces() {
    let cases: [Case; 2] = [
        ("double pendulum", double_pendulum),
        ("flexible", flexible_pendulum),
    ];
    for (name, make) in cases {
        for formulation in [Formulation::Index3, Formulation::StabilizedIndex2] {
            let (end, coarse) = (0.4, 50);
            let reference = run(make(), formulation, 0.8, end, 24 * coarse);
            let found = [1, 2, 4].map(|fine| {
                errors(
                    &run(make(), formulation, 0.8, end, fine * coarse),
                    &reference,
                )
            });
            for (k, quantity) in ["positions", "velocities", "forces"]
                .into_iter()
                .enumerate()
            {
                let slopes = [0, 1].map(|i| (found[i][k] / found[i + 1][k]).log2());
                for slope in slopes {
                    assert!(
                        (slope - 2.0).abs() < 0.25,
                        "{name} {formulation:?} {quantity}: {slope:.2}, errors {:.1e} {:.1e} {:.1e}",
                        found[0][k],
                        found[1][k],
                        found[2][k]
                    );
                }
            }
        }
    }
}

/// Growth of the step within the run leaves no trace of first order in the forces.
#[test]
fn second_order_in_forces_across_growth_of_the_step() {
    let run = |fine: usize| {
        let (system, state) = double_pendulum();
        let method = method(Formulation::Index3, 0.8);
        let (mut simulation, _) =
            Simulation::start(system, state, method, RedundantConstraints::MinimumNorm).unwrap();
        let mut states = Vec::new();
        for (count, step) in [(40, 1e-3), (40, 2e-3), (40, 4e-3)] {
            for _ in 0..count {
                for _ in 0..fine {
                    simulation.step(step / fine as f64).unwrap();
                }
                states.push(simulation.state().clone());
            }
        }
        states
    };
    let reference = run(8);
    let found = [1, 2].map(|fine| errors(&run(fine), &reference)[2]);
    let slope = (found[0] / found[1]).log2();
    assert!(slope > 1.8, "{slope:.2}, errors {found:?}");
}
