//! Angle from a to b about an axis of a.
//!
//! ```text
//! e  =  atan2(k · f, h · f),   h = R_a h_0,   k = R_a k_0,   f = R_b f_0
//! δe =  m · (δψ_b - δψ_a),     m = (n - z f) / (1 - z²),     n = h × k,   z = n · f
//! ```
//! Where f is perpendicular to the axis, as a hinge keeps it, m is the axis n itself. Away from there the angle is that
//! of f's projection; it is undefined, and its gradient infinite, where f is along the axis.

use nalgebra::{Matrix3, Unit, Vector3};

use super::{FrameFunction, Gradient, GradientDerivative};
use crate::kinematics::frame_motion::FrameMotion;

/// Angle of a direction of b in a plane of a; rad, from -π to π. It jumps by a whole turn where the direction passes
/// opposite to `first_a`, its gradient doesn't.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Angle {
    /// h_0, in a's axes: where the angle is zero.
    pub first_a: Unit<Vector3<f64>>,
    /// k_0, in a's axes, perpendicular to `first_a`: where it is a quarter turn.
    pub second_a: Unit<Vector3<f64>>,
    /// f_0, in b's axes.
    pub first_b: Unit<Vector3<f64>>,
}

impl Angle {
    /// From a's x axis to b's, about z: the angle of planar scenes.
    pub fn in_plane() -> Self {
        Self {
            first_a: Vector3::x_axis(),
            second_a: Vector3::y_axis(),
            first_b: Vector3::x_axis(),
        }
    }

    fn poles(&self, a: &FrameMotion, b: &FrameMotion) -> Poles {
        let n = a.axes * self.first_a.cross(&self.second_a);
        let f = b.axes * self.first_b.as_ref();
        let z = n.dot(&f);
        let q = 1.0 - z * z;
        Poles {
            n,
            f,
            z,
            q,
            m: (n - z * f) / q,
        }
    }
}

/// Common terms of the derivatives.
struct Poles {
    n: Vector3<f64>,
    f: Vector3<f64>,
    z: f64,
    /// 1 - z²
    q: f64,
    m: Vector3<f64>,
}

impl FrameFunction for Angle {
    fn value(&self, a: &FrameMotion, b: &FrameMotion) -> f64 {
        let f = b.axes * self.first_b.as_ref();
        let sine = (a.axes * self.second_a.as_ref()).dot(&f);
        let cosine = (a.axes * self.first_a.as_ref()).dot(&f);
        sine.atan2(cosine)
    }

    fn gradient(&self, a: &FrameMotion, b: &FrameMotion) -> Gradient {
        Gradient::of_relative_turn(&self.poles(a, b).m)
    }

    fn second_rate(&self, a: &FrameMotion, b: &FrameMotion) -> f64 {
        // m' = (n' - z f' - z' f + 2 z z' m) / q
        let Poles { n, f, z, q, m } = self.poles(a, b);
        let relative_spin = b.spin - a.spin;
        let z_rate = f.cross(&n).dot(&relative_spin);
        let m_rate = (a.spin.cross(&n) - z * b.spin.cross(&f) + z_rate * (2.0 * z * m - f)) / q;
        m.dot(&(b.spin_rate - a.spin_rate)) + m_rate.dot(&relative_spin)
    }

    fn gradient_derivative(&self, a: &FrameMotion, b: &FrameMotion) -> GradientDerivative {
        // δm = (-skew(n) δψ_a + z skew(f) δψ_b + (2 z m - f) δz) / q,   δz = (f × n) · (δψ_b - δψ_a)
        let Poles { n, f, z, q, m } = self.poles(a, b);
        let with_z: Matrix3<f64> = (2.0 * z * m - f) * f.cross(&n).transpose();
        GradientDerivative::of_relative_turn(
            &(-(n.cross_matrix() + with_z) / q),
            &((z * f.cross_matrix() + with_z) / q),
        )
    }
}
