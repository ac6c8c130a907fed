//! Component of the rotation vector from a to b.
//!
//! ```text
//! e  =  d · t,   d = R_a d_0,   t = Log(R_b Q_0ᵀ R_aᵀ)              (t: the rotation vector, world axes)
//! δe =  m · (δψ_b - δψ_a),      m = J(t)ᵀ d = d + ½ t × d + κ t × (t × d)
//! J  =  I - ½ skew(t) + κ skew(t)²,   κ(x) = 1/x² - cot(x/2) / (2 x),   x = |t|
//! ```
//! J is the inverse of the left Jacobian of the rotation group: δt, seen from a, is J (δψ_b - δψ_a).

use nalgebra::{Matrix3, Rotation3, Unit, UnitQuaternion, Vector3};

use super::{FrameFunction, Gradient, GradientDerivative};
use crate::kinematics::frame_motion::FrameMotion;

/// Component of the rotation vector of b against a, from a given relative rotation at rest; rad. Valid up to half a
/// turn from rest, where the vector jumps to its opposite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation {
    /// d_0, in a's axes.
    pub direction: Unit<Vector3<f64>>,
    /// Q_0, b's axes in a's (`R_aᵀ R_b`) where the rotation is zero.
    pub rest: Matrix3<f64>,
}

impl Rotation {
    /// t, world axes.
    fn vector(&self, a: &FrameMotion, b: &FrameMotion) -> Vector3<f64> {
        // Through a quaternion: the angle of a matrix is inaccurate near zero.
        let turned = b.axes * (a.axes * self.rest).transpose();
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turned))
            .scaled_axis()
    }

    /// m, and B J with `B δt` the change of m seen from a:
    /// `B = -½ skew(d) - κ (skew(t × d) + skew(t) skew(d)) + κ'/x (t × (t × d)) tᵀ`.
    fn axis_and_derivative(
        &self,
        a: &FrameMotion,
        b: &FrameMotion,
    ) -> (Vector3<f64>, Matrix3<f64>) {
        let t = self.vector(a, b);
        let d = a.axes * self.direction.as_ref();
        let (kappa, slope) = curvature(t.norm_squared());
        let (once, twice) = (t.cross(&d), t.cross(&t.cross(&d)));
        let (skew_t, skew_d) = (t.cross_matrix(), d.cross_matrix());
        let jacobian = Matrix3::identity() - 0.5 * skew_t + kappa * skew_t * skew_t;
        let change = -0.5 * skew_d - kappa * (once.cross_matrix() + skew_t * skew_d)
            + slope * twice * t.transpose();
        (d + 0.5 * once + kappa * twice, change * jacobian)
    }
}

impl FrameFunction for Rotation {
    fn value(&self, a: &FrameMotion, b: &FrameMotion) -> f64 {
        (a.axes * self.direction.as_ref()).dot(&self.vector(a, b))
    }

    fn gradient(&self, a: &FrameMotion, b: &FrameMotion) -> Gradient {
        let t = self.vector(a, b);
        let d = a.axes * self.direction.as_ref();
        let (kappa, _) = curvature(t.norm_squared());
        let once = t.cross(&d);
        Gradient::of_relative_turn(&(d + 0.5 * once + kappa * t.cross(&once)))
    }

    fn second_rate(&self, a: &FrameMotion, b: &FrameMotion) -> f64 {
        let (m, change) = self.axis_and_derivative(a, b);
        let relative_spin = b.spin - a.spin;
        let m_rate = a.spin.cross(&m) + change * relative_spin;
        m.dot(&(b.spin_rate - a.spin_rate)) + m_rate.dot(&relative_spin)
    }

    fn gradient_derivative(&self, a: &FrameMotion, b: &FrameMotion) -> GradientDerivative {
        let (m, change) = self.axis_and_derivative(a, b);
        GradientDerivative::of_relative_turn(&-(m.cross_matrix() + change), &change)
    }
}

/// κ and κ'/x at x². `κ = Σ_n |B_2n| / (2n)! x^(2n-2)` with Bernoulli's numbers; the series near zero, where the closed
/// form cancels.
fn curvature(squared: f64) -> (f64, f64) {
    /// |B_2n| / (2n)!
    const SERIES: [f64; 6] = [
        1.0 / 12.0,
        1.0 / 720.0,
        1.0 / 30_240.0,
        1.0 / 1_209_600.0,
        1.0 / 47_900_160.0,
        691.0 / 1_307_674_368_000.0,
    ];
    if squared < 0.1 {
        // Horner's rule for κ and, in step, for dκ/d(x²) = κ'/(2x).
        let (kappa, derivative) =
            SERIES
                .iter()
                .rev()
                .fold((0.0, 0.0), |(value, derivative), coefficient| {
                    (value * squared + coefficient, derivative * squared + value)
                });
        (kappa, 2.0 * derivative)
    } else {
        let x = squared.sqrt();
        let (sine, cosine) = (0.5 * x).sin_cos();
        let cotangent = cosine / sine;
        let kappa = 1.0 / squared - cotangent / (2.0 * x);
        let slope = -2.0 / (squared * squared)
            + 1.0 / (4.0 * squared * sine * sine)
            + cotangent / (2.0 * squared * x);
        (kappa, slope)
    }
}
