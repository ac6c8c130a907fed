//! Cosine of the angle between a direction of a and one of b.
//!
//! ```text
//! e  =  d · f,   d = R_a d_0,   f = R_b f_0
//! δe =  (f × d) · (δψ_b - δψ_a)
//! ```
//! Held at zero, the directions stay perpendicular. The gradient vanishes where they are parallel, so no other value of
//! one is a target.

use nalgebra::{Unit, Vector3};

use super::carried::Carried;
use super::{FrameFunction, Gradient, GradientDerivative};
use crate::kinematics::frame_motion::FrameMotion;

/// Product of a direction of a with one of b; between -1 and 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alignment {
    /// In a's axes.
    pub direction_a: Unit<Vector3<f64>>,
    /// In b's axes.
    pub direction_b: Unit<Vector3<f64>>,
}

impl Alignment {
    /// d and f.
    fn directions(&self, a: &FrameMotion, b: &FrameMotion) -> (Vector3<f64>, Vector3<f64>) {
        (
            a.axes * self.direction_a.as_ref(),
            b.axes * self.direction_b.as_ref(),
        )
    }
}

impl FrameFunction for Alignment {
    fn value(&self, a: &FrameMotion, b: &FrameMotion) -> f64 {
        let (d, f) = self.directions(a, b);
        d.dot(&f)
    }

    fn gradient(&self, a: &FrameMotion, b: &FrameMotion) -> Gradient {
        let (d, f) = self.directions(a, b);
        Gradient::of_relative_turn(&f.cross(&d))
    }

    fn second_rate(&self, a: &FrameMotion, b: &FrameMotion) -> f64 {
        let d = Carried::by(a, &self.direction_a);
        let f = Carried::by(b, &self.direction_b);
        d.second_rate.dot(&f.now) + 2.0 * d.rate.dot(&f.rate) + d.now.dot(&f.second_rate)
    }

    fn gradient_derivative(&self, a: &FrameMotion, b: &FrameMotion) -> GradientDerivative {
        // δ(f × d) = skew(d) skew(f) δψ_b - skew(f) skew(d) δψ_a
        let (d, f) = self.directions(a, b);
        let (d, f) = (d.cross_matrix(), f.cross_matrix());
        GradientDerivative::of_relative_turn(&-(f * d), &(d * f))
    }
}
