//! Mass in motion: centre of mass, linear and angular momentum of bodies and of a mechanism.
//!
//! ```text
//! S = m R + A L1 y                        first moment of mass about the world's origin
//! P = A (m V + L1 y' + ω × L1 y)          V, ω in body axes
//! H = R × P + A (J ω + (I3 + L) y' + L1 y × V)
//! ```
//! Forces that deflect a body beside its coordinates (static compatibility) move no mass.

use std::ops::{Add, AddAssign};

use nalgebra::Vector3;

use crate::system::evaluation::Evaluation;
use crate::system::{State, System};

/// Mass and momentum, world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Momentum {
    /// Mass.
    pub mass: f64,
    /// First moment of mass about the world's origin, mass·length.
    pub first_moment: Vector3<f64>,
    /// Linear momentum.
    pub linear: Vector3<f64>,
    /// Angular momentum about the world's origin.
    pub angular: Vector3<f64>,
}

impl Default for Momentum {
    fn default() -> Self {
        let zero = Vector3::zeros();
        Self {
            mass: 0.0,
            first_moment: zero,
            linear: zero,
            angular: zero,
        }
    }
}

impl Momentum {
    /// Of one body, at the state that was evaluated last.
    pub fn of_body(system: &System, state: &State, evaluation: &Evaluation, index: usize) -> Self {
        let (rigid, _) = state.body_rates(system, index);
        let pose = &evaluation.poses[index];
        let terms = &evaluation.inertia[index];
        let mass = system.bodies[index].flexible.inertia.mass();
        let velocity = pose.axes.tr_mul(&rigid.linear);
        let (linear, angular) = terms.momenta(mass, &velocity, &rigid.angular);
        let linear = pose.axes * linear;
        Self {
            mass,
            first_moment: pose.origin * mass + pose.axes * terms.first_moment(),
            linear,
            angular: pose.origin.cross(&linear) + pose.axes * angular,
        }
    }

    /// Of all bodies, at the state that was evaluated last.
    pub fn of_all(system: &System, state: &State, evaluation: &Evaluation) -> Self {
        let bodies = 0..system.bodies.len();
        bodies
            .map(|index| Self::of_body(system, state, evaluation, index))
            .fold(Self::default(), Add::add)
    }

    /// Centre of mass.
    pub fn center(&self) -> Vector3<f64> {
        self.first_moment / self.mass
    }

    /// Angular momentum about a point, which may move.
    pub fn angular_about(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.angular - point.cross(&self.linear)
    }
}

impl Add for Momentum {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

impl AddAssign for Momentum {
    fn add_assign(&mut self, other: Self) {
        self.mass += other.mass;
        self.first_moment += other.first_moment;
        self.linear += other.linear;
        self.angular += other.angular;
    }
}
