//! A rigid pendulum: closed form, energy, order of convergence.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::sync::Arc;

use dcb_formats::component::Units;
use dcb_formats::mesh::Dimension;
use dcb_runtime::FlexibleBody;
use dcb_runtime::body::{RigidBody, RigidPoint};
use dcb_runtime::initial::Redundancy;
use dcb_runtime::integrator::newton::{Formulation, Method, Tolerance};
use dcb_runtime::integrator::scheme::Scheme;
use dcb_runtime::joint::{JointKind, Revolute};
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::builder::{Drawn, SystemBuilder, Turning};
use nalgebra::{Matrix3, Vector3};

fn simulation(formulation: Formulation, dimension: Dimension) -> Simulation {
    let body = FlexibleBody::rigid(&RigidBody {
        name: "bob".into(),
        units: Units {
            length: "m".into(),
            mass: "kg".into(),
            time: "s".into(),
        },
        dimension,
        mass: 1.0,
        tensor: Matrix3::identity() * 0.01,
        center: Vector3::zeros(),
        points: vec![RigidPoint {
            name: "pivot".into(),
            position: Vector3::new(-1.0, 0.0, 0.0),
            axes: Matrix3::identity(),
        }],
    })
    .unwrap();
    let mut builder = SystemBuilder::new(dimension, Vector3::new(0.0, -9.81, 0.0));
    let bob = builder.body(
        "bob",
        Arc::new(body),
        &Drawn {
            position: Vector3::new(1.0, 0.0, 0.0),
            ..Drawn::default()
        },
    );
    let pin = builder.marker(bob, 0, Turning::Interface).unwrap();
    let ground = builder.ground(Vector3::zeros(), Matrix3::identity());
    let kind = JointKind::Revolute(Revolute {
        axis: Vector3::z(),
        axis_b: None,
    });
    builder.joint("pivot", ground, pin, &kind).unwrap();
    let (system, state) = builder.finish();
    let method = Method {
        scheme: Scheme::generalized_alpha(0.8),
        formulation,
        tolerance: Tolerance {
            relative: 1e-6,
            max_iterations: 12,
        },
    };
    let (simulation, report) =
        Simulation::start(system, state, method, Redundancy::MinimumNorm).unwrap();
    println!("{report:?}");
    simulation
}

#[test]
fn order() {
    for dimension in [Dimension::Planar, Dimension::Spatial] {
        for formulation in [Formulation::Index3, Formulation::StabilizedIndex2] {
            let mut last: Option<(Vector3<f64>, f64)> = None;
            for steps in [200, 400, 800, 1600, 3200] {
                let mut simulation = simulation(formulation, dimension);
                for _ in 0..steps {
                    simulation.step(1.0 / f64::from(steps)).unwrap();
                }
                simulation.refresh();
                let (_, _, defect) = simulation.energy();
                let state = simulation.state();
                let now = (state.origins[0], state.forces[0]);
                if let Some((x, l)) = last {
                    println!(
                        "{dimension:?} {formulation:?} {steps} dx {:.3e} dl {:.3e} defect {defect:.3e} effort {:?}",
                        (x - now.0).norm(),
                        l - now.1,
                        simulation.effort()
                    );
                }
                last = Some(now);
            }
        }
    }
}
