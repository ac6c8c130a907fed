//! How much the distance of b from a exceeds a given one: `e = (|w|² - L²) / (2 L)`, `w = p_b - p_a`.
//!
//! Equal to `|w| - L` to first order around the given distance, and smooth everywhere.

use nalgebra::Matrix3;

use super::{FrameFunction, Gradient, GradientDerivative};
use crate::kinematics::frame_motion::FrameMotion;

/// Excess of the distance between the origins over a given one; length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// L, above zero.
    pub length: f64,
}

impl FrameFunction for Distance {
    fn value(&self, a: &FrameMotion, b: &FrameMotion) -> f64 {
        // (|w| - L) (|w| + L): no cancellation near L.
        let distance = (b.position - a.position).norm();
        (distance - self.length) * (distance + self.length) / (2.0 * self.length)
    }

    fn gradient(&self, a: &FrameMotion, b: &FrameMotion) -> Gradient {
        Gradient::of_separation(&((b.position - a.position) / self.length))
    }

    fn second_rate(&self, a: &FrameMotion, b: &FrameMotion) -> f64 {
        let w = b.position - a.position;
        (w.dot(&(b.acceleration - a.acceleration)) + (b.velocity - a.velocity).norm_squared())
            / self.length
    }

    fn gradient_derivative(&self, _: &FrameMotion, _: &FrameMotion) -> GradientDerivative {
        GradientDerivative::of_separation(&(Matrix3::identity() / self.length))
    }
}
