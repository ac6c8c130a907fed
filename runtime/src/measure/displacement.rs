//! How far b is from a, along a direction of a.
//!
//! ```text
//! e  =  d · w,   d = R_a d_0,   w = p_b - p_a
//! δe =  d · (δp_b - δp_a) + (d × w) · δψ_a
//! ```

use nalgebra::{Matrix6, Unit, Vector3};

use super::carried::Carried;
use super::gradient::six;
use super::{FrameFunction, Gradient, GradientDerivative};
use crate::kinematics::frame_motion::FrameMotion;

/// Component of the separation `p_b - p_a` along a direction that turns with a; length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Displacement {
    /// In a's axes.
    pub direction: Unit<Vector3<f64>>,
}

impl FrameFunction for Displacement {
    fn value(&self, a: &FrameMotion, b: &FrameMotion) -> f64 {
        (a.axes * self.direction.as_ref()).dot(&(b.position - a.position))
    }

    fn gradient(&self, a: &FrameMotion, b: &FrameMotion) -> Gradient {
        let d = a.axes * self.direction.as_ref();
        let w = b.position - a.position;
        Gradient {
            a: six(&-d, &d.cross(&w)),
            b: six(&d, &Vector3::zeros()),
        }
    }

    fn second_rate(&self, a: &FrameMotion, b: &FrameMotion) -> f64 {
        let d = Carried::by(a, &self.direction);
        d.now.dot(&(b.acceleration - a.acceleration))
            + 2.0 * d.rate.dot(&(b.velocity - a.velocity))
            + d.second_rate.dot(&(b.position - a.position))
    }

    fn gradient_derivative(&self, a: &FrameMotion, b: &FrameMotion) -> GradientDerivative {
        // δd = -skew(d) δψ_a,   δ(d × w) = skew(d) (δp_b - δp_a) + skew(w) skew(d) δψ_a
        let d = (a.axes * self.direction.as_ref()).cross_matrix();
        let w = (b.position - a.position).cross_matrix();
        let [mut aa, mut ab, mut ba] = [Matrix6::zeros(); 3];
        aa.fixed_view_mut::<3, 3>(0, 3).copy_from(&d);
        aa.fixed_view_mut::<3, 3>(3, 0).copy_from(&-d);
        aa.fixed_view_mut::<3, 3>(3, 3).copy_from(&(w * d));
        ab.fixed_view_mut::<3, 3>(3, 0).copy_from(&d);
        ba.fixed_view_mut::<3, 3>(0, 3).copy_from(&-d);
        GradientDerivative {
            aa,
            ab,
            ba,
            bb: Matrix6::zeros(),
        }
    }
}
