//! How far b is from a, along a direction of the world: `e = d · (p_b - p_a)`, d constant.
//!
//! The rows of joints that bring two points together: no rotation of either frame is involved. The two forces are in
//! equilibrium only where the points coincide, so this measure is to be held at zero in every direction of the scene.

use nalgebra::{Unit, Vector3};

use super::{FrameFunction, Gradient, GradientDerivative};
use crate::kinematics::frame_motion::FrameMotion;

/// Component of the separation `p_b - p_a` along a fixed direction; length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldDisplacement {
    /// In world axes.
    pub direction: Unit<Vector3<f64>>,
}

impl FrameFunction for WorldDisplacement {
    fn value(&self, a: &FrameMotion, b: &FrameMotion) -> f64 {
        self.direction.dot(&(b.position - a.position))
    }

    fn gradient(&self, _: &FrameMotion, _: &FrameMotion) -> Gradient {
        Gradient::of_separation(&self.direction)
    }

    fn second_rate(&self, a: &FrameMotion, b: &FrameMotion) -> f64 {
        self.direction.dot(&(b.acceleration - a.acceleration))
    }

    fn gradient_derivative(&self, _: &FrameMotion, _: &FrameMotion) -> GradientDerivative {
        GradientDerivative::zero()
    }
}
