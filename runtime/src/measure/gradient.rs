//! First and second variations of a measure.

use nalgebra::{Matrix3, Matrix6, Vector3};

use crate::kinematics::frame_motion::{FrameMotion, Six};

/// Where the rotations of a six-fold quantity start.
const TURN: usize = 3;

/// How a measure e varies: `δe = a · (δp_a, δψ_a) + b · (δp_b, δψ_b)`, world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gradient {
    /// With the frame a.
    pub a: Six,
    /// With the frame b.
    pub b: Six,
}

impl Gradient {
    /// e depends on `p_b - p_a` only, and grows along `direction` (world axes).
    pub(super) fn of_separation(direction: &Vector3<f64>) -> Self {
        let b = six(direction, &Vector3::zeros());
        Self { a: -b, b }
    }

    /// e depends on the rotation of b against a only, and grows with turns about `axis` (world axes).
    pub(super) fn of_relative_turn(axis: &Vector3<f64>) -> Self {
        let b = six(&Vector3::zeros(), axis);
        Self { a: -b, b }
    }

    /// Of a measure that doesn't change.
    pub fn zero() -> Self {
        Self {
            a: Six::zeros(),
            b: Six::zeros(),
        }
    }

    /// Of a multiple of the measure.
    #[inline]
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            a: self.a * factor,
            b: self.b * factor,
        }
    }

    /// de/dt, from velocities and spins.
    #[inline]
    pub fn rate(&self, a: &FrameMotion, b: &FrameMotion) -> f64 {
        self.a.dot(&six(&a.velocity, &a.spin)) + self.b.dot(&six(&b.velocity, &b.spin))
    }
}

/// How a gradient, in world components, varies:
///
/// ```text
/// δ(gradient.a)  =  aa (δp_a, δψ_a) + ab (δp_b, δψ_b)
/// δ(gradient.b)  =  ba (δp_a, δψ_a) + bb (δp_b, δψ_b)
/// ```
/// Not symmetric where rotations are involved: turns about different axes don't commute.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GradientDerivative {
    /// The part of a, with a.
    pub aa: Matrix6<f64>,
    /// The part of a, with b.
    pub ab: Matrix6<f64>,
    /// The part of b, with a.
    pub ba: Matrix6<f64>,
    /// The part of b, with b.
    pub bb: Matrix6<f64>,
}

impl GradientDerivative {
    /// The gradient doesn't change.
    pub(super) fn zero() -> Self {
        let zero = Matrix6::zeros();
        Self {
            aa: zero,
            ab: zero,
            ba: zero,
            bb: zero,
        }
    }

    /// Of [`Gradient::of_separation`], whose direction changes by `derivative (δp_b - δp_a)`.
    pub(super) fn of_separation(derivative: &Matrix3<f64>) -> Self {
        let mut same = Matrix6::zeros();
        same.fixed_view_mut::<3, 3>(0, 0).copy_from(derivative);
        Self {
            aa: same,
            ab: -same,
            ba: -same,
            bb: same,
        }
    }

    /// Of [`Gradient::of_relative_turn`], whose axis changes by `with_a δψ_a + with_b δψ_b`.
    pub(super) fn of_relative_turn(with_a: &Matrix3<f64>, with_b: &Matrix3<f64>) -> Self {
        let [mut ba, mut bb] = [Matrix6::zeros(); 2];
        ba.fixed_view_mut::<3, 3>(TURN, TURN).copy_from(with_a);
        bb.fixed_view_mut::<3, 3>(TURN, TURN).copy_from(with_b);
        Self {
            aa: -ba,
            ab: -bb,
            ba,
            bb,
        }
    }
}

/// `(first, second)` as one vector.
pub(super) fn six(first: &Vector3<f64>, second: &Vector3<f64>) -> Six {
    Six::new(first.x, first.y, first.z, second.x, second.y, second.z)
}
