//! Distance of b from a: `e = |w|`, `w = p_b - p_a`.
//!
//! A spring between coinciding points has no direction to pull along. Within [`VANISHING`] times the given length the
//! gradient and everything made of it are zero, so that nothing is infinite there.

use nalgebra::{Matrix3, Vector3};

use super::{FrameFunction, Gradient, GradientDerivative};
use crate::kinematics::frame_motion::FrameMotion;

/// Distance, in given lengths, below which there is no direction.
const VANISHING: f64 = 1e-10;

/// Distance between the origins; length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elongation {
    /// A length typical of the coupling, above zero: sets what counts as no distance at all.
    pub length: f64,
}

impl Elongation {
    /// The distance and the direction from a to b; none where they coincide.
    fn polar(&self, a: &FrameMotion, b: &FrameMotion) -> Option<(f64, Vector3<f64>)> {
        let w = b.position - a.position;
        let distance = w.norm();
        (distance > VANISHING * self.length).then(|| (distance, w / distance))
    }
}

impl FrameFunction for Elongation {
    fn value(&self, a: &FrameMotion, b: &FrameMotion) -> f64 {
        (b.position - a.position).norm()
    }

    fn gradient(&self, a: &FrameMotion, b: &FrameMotion) -> Gradient {
        let direction = self.polar(a, b).map_or_else(Vector3::zeros, |(_, u)| u);
        Gradient::of_separation(&direction)
    }

    fn second_rate(&self, a: &FrameMotion, b: &FrameMotion) -> f64 {
        self.polar(a, b).map_or(0.0, |(distance, u)| {
            let velocity = b.velocity - a.velocity;
            let across = velocity - u * u.dot(&velocity);
            u.dot(&(b.acceleration - a.acceleration)) + across.norm_squared() / distance
        })
    }

    fn gradient_derivative(&self, a: &FrameMotion, b: &FrameMotion) -> GradientDerivative {
        self.polar(a, b)
            .map_or_else(GradientDerivative::zero, |(distance, u)| {
                let across = Matrix3::identity() - u * u.transpose();
                GradientDerivative::of_separation(&(across / distance))
            })
    }
}
