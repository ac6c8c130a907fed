//! Small mechanisms of the runtime: units, rigid bodies, methods and runs that succeed.

use std::sync::Arc;

use dcb_formats::component::Units;
use dcb_formats::mesh::Dimension;
use dcb_runtime::FlexibleBody;
use dcb_runtime::body::{RigidBody, RigidPoint};
use dcb_runtime::initial::{InitialReport, Redundancy};
use dcb_runtime::integrator::newton::{Formulation, Method, Tolerance};
use dcb_runtime::integrator::scheme::Scheme;
use dcb_runtime::joint::{JointKind, Revolute};
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::{State, System};
use nalgebra::{Matrix3, Vector3};

/// Metre, kilogram, second.
pub fn si() -> Units {
    Units {
        length: "m".into(),
        mass: "kg".into(),
        time: "s".into(),
    }
}

/// A rigid body about its centre of mass, with points whose axes are the body's.
pub fn rigid(
    dimension: Dimension,
    mass: f64,
    tensor: Matrix3<f64>,
    points: &[[f64; 3]],
) -> Arc<FlexibleBody> {
    let points = points.iter().enumerate();
    let body = RigidBody {
        name: "rigid".into(),
        units: si(),
        dimension,
        mass,
        tensor,
        center: Vector3::zeros(),
        points: points
            .map(|(index, position)| RigidPoint {
                name: format!("p{index}"),
                position: Vector3::from(*position),
                axes: Matrix3::identity(),
            })
            .collect(),
    };
    Arc::new(FlexibleBody::rigid(&body).expect("a rigid body"))
}

/// A slender bar along x with a point at each end.
pub fn slender_bar(dimension: Dimension, mass: f64, length: f64) -> Arc<FlexibleBody> {
    let moment = mass * length * length / 12.0;
    let tensor = Matrix3::from_diagonal(&Vector3::new(0.0, moment, moment));
    let half = 0.5 * length;
    rigid(
        dimension,
        mass,
        tensor,
        &[[-half, 0.0, 0.0], [half, 0.0, 0.0]],
    )
}

/// A revolute joint about an axis of the first frame.
pub fn revolute(axis: Vector3<f64>) -> JointKind {
    JointKind::Revolute(Revolute { axis, axis_b: None })
}

/// Generalized-alpha on positions, converged to rounding.
pub fn method(spectral_radius: f64) -> Method {
    Method {
        scheme: Scheme::generalized_alpha(spectral_radius),
        formulation: Formulation::Index3,
        tolerance: Tolerance {
            relative: 1e-10,
            max_iterations: 20,
        },
    }
}

/// The same with positions and velocities of the constraints.
pub fn stabilized(spectral_radius: f64) -> Method {
    Method {
        formulation: Formulation::StabilizedIndex2,
        ..method(spectral_radius)
    }
}

/// A start that succeeds.
pub fn start(system: System, state: State, method: Method) -> (Simulation, InitialReport) {
    match Simulation::start(system, state, method, Redundancy::MinimumNorm) {
        Ok(started) => started,
        Err(error) => panic!("{error}"),
    }
}

/// `steps` equal steps over `duration`; after each of them `see` is shown the simulation.
pub fn run(
    simulation: &mut Simulation,
    duration: f64,
    steps: usize,
    mut see: impl FnMut(&mut Simulation),
) {
    for step in 0..steps {
        if let Err(error) = simulation.step(duration / steps as f64) {
            panic!("step {step}: {error}");
        }
        see(simulation);
    }
}

/// The limit that values with errors of second order, at steps h, h/2, h/4, ..., go to: errors in h², h³, ... are removed in turn.
pub fn extrapolated(values: &[f64]) -> f64 {
    let mut table = values.to_vec();
    for order in 2..values.len() as i32 + 1 {
        let factor = 2.0_f64.powi(order);
        for k in 0..table.len() - 1 {
            table[k] = table[k + 1] + (table[k + 1] - table[k]) / (factor - 1.0);
        }
        table.pop();
    }
    table[0]
}
