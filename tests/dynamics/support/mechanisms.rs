//! Rigid bodies, soft beams, signals and methods for small mechanisms.

use std::sync::Arc;

use dcb_formats::component::Units;
use dcb_formats::mesh::Dimension;
use dcb_formats::scene::Scheme;
use dcb_formats::{Function, TimeFunction};
use dcb_runtime::FlexibleBody;
use dcb_runtime::body::{RigidBody, RigidPoint};
use dcb_runtime::force_law::{Characteristic, Law};
use dcb_runtime::integrator::{Formulation, Method, Tolerance};
use dcb_runtime::joint::{JointKind, Revolute};
use dcb_runtime::system::Signal;
use nalgebra::{Matrix3, Vector3};

/// A rigid body with named points, its centre of mass at its origin.
pub fn rigid(
    dimension: Dimension,
    mass: f64,
    inertia: Vector3<f64>,
    points: &[Vector3<f64>],
) -> Arc<FlexibleBody> {
    let body = RigidBody {
        name: "rigid".into(),
        units: Units {
            length: "m".into(),
            mass: "kg".into(),
            time: "s".into(),
        },
        dimension,
        mass,
        tensor: Matrix3::from_diagonal(&inertia),
        center: Vector3::zeros(),
        points: points
            .iter()
            .enumerate()
            .map(|(index, position)| RigidPoint {
                name: format!("p{index}"),
                position: *position,
                axes: Matrix3::identity(),
            })
            .collect(),
    };
    Arc::new(FlexibleBody::rigid(&body).unwrap())
}

/// The same body with other stiffness and damping of its coordinates.
pub fn with_stiffness(body: &FlexibleBody, lowest: f64, damping: f64) -> Arc<FlexibleBody> {
    let mut body = body.clone();
    let count = body.stiffness.len();
    for (k, stiffness) in body.stiffness.iter_mut().enumerate() {
        *stiffness = lowest * (1.0 + k as f64 / count as f64);
    }
    body.damping.fill(damping);
    Arc::new(body)
}

/// A revolute joint about z as drawn.
pub fn about_z() -> JointKind {
    JointKind::Revolute(Revolute {
        axis: Vector3::z(),
        axis_b: None,
    })
}

/// A formula of time `t`.
pub fn formula(text: &str) -> Signal {
    Signal {
        function: TimeFunction::new(&Function::Formula(text.into())).unwrap(),
        input: None,
        offset: 0.0,
    }
}

/// A linear spring and damper.
pub fn linear(free: f64, stiffness: f64, damping: f64) -> Law {
    let slope = |slope| Characteristic::Linear { slope };
    Law::new(free, slope(stiffness), slope(damping)).unwrap()
}

/// Generalized-alpha with tight steps.
pub fn method(formulation: Formulation, spectral_radius: f64) -> Method {
    Method {
        scheme: Scheme::generalized_alpha(spectral_radius),
        formulation,
        tolerance: Tolerance {
            relative: 1e-9,
            max_iterations: 20,
        },
    }
}
