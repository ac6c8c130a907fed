//! Rotation vectors: what a finite turn's rate and a moment's share of it need.
//!
//! With K = skew(θ) and θ = |θ|, the left Jacobian of the rotation group is
//!
//! ```text
//! d exp(θ) exp(θ)ᵀ = skew(J_l(θ) dθ),    J_l = I + a K + b K²,    a = (1 - cos θ)/θ²,  b = (θ - sin θ)/θ³
//! ```
//! The right one is its transpose, `J_r(θ) = J_l(-θ)`.

use nalgebra::{Matrix3, Vector3};

/// Below this θ² the closed forms lose digits to cancellation and four terms of the series are exact to rounding.
const SERIES_BELOW: f64 = 1e-2;

/// a, b and their derivatives by θ, divided by θ.
struct Coefficients {
    a: f64,
    b: f64,
    a_slope: f64,
    b_slope: f64,
}

impl Coefficients {
    fn at(theta: &Vector3<f64>) -> Self {
        let s = theta.norm_squared();
        if s < SERIES_BELOW {
            return Self {
                a: 0.5 - s / 24.0 * (1.0 - s / 30.0 * (1.0 - s / 56.0)),
                b: 1.0 / 6.0 - s / 120.0 * (1.0 - s / 42.0 * (1.0 - s / 72.0)),
                a_slope: -1.0 / 12.0
                    + s / 180.0 * (1.0 - s * 3.0 / 112.0 * (1.0 - s * 4.0 / 270.0)),
                b_slope: -1.0 / 60.0 + s / 1260.0 * (1.0 - s / 48.0 * (1.0 - s * 4.0 / 330.0)),
            };
        }
        let angle = s.sqrt();
        let (sin, cos) = angle.sin_cos();
        Self {
            a: (1.0 - cos) / s,
            b: (angle - sin) / (s * angle),
            a_slope: (angle * sin - 2.0 * (1.0 - cos)) / (s * s),
            b_slope: ((1.0 - cos) - 3.0 * (angle - sin) / angle) / (s * s),
        }
    }
}

/// J_l(θ).
pub fn left_jacobian(theta: &Vector3<f64>) -> Matrix3<f64> {
    let c = Coefficients::at(theta);
    let k = theta.cross_matrix();
    Matrix3::identity() + k * c.a + k * k * c.b
}

/// `d/dt J_l(θ)` times θ', the part of the angular acceleration that the turning turn makes.
pub fn left_jacobian_rate(theta: &Vector3<f64>, rate: &Vector3<f64>) -> Vector3<f64> {
    let c = Coefficients::at(theta);
    let along = theta.dot(rate);
    let first = theta.cross(rate);
    first * (c.a_slope * along)
        + theta.cross(&first) * (c.b_slope * along)
        + rate.cross(&first) * c.b
}

/// The derivative of `J_l(θ)ᵀ τ` by θ, at fixed τ.
pub fn left_jacobian_transpose_derivative(
    theta: &Vector3<f64>,
    torque: &Vector3<f64>,
) -> Matrix3<f64> {
    let c = Coefficients::at(theta);
    let (once, k) = (theta.cross(torque), theta.cross_matrix());
    let twice = theta.cross(&once);
    // Jᵀτ = τ - a θ×τ + b θ×(θ×τ)
    torque.cross_matrix() * c.a
        - once.cross_matrix() * c.b
        - k * torque.cross_matrix() * c.b
        - once * theta.transpose() * c.a_slope
        + twice * theta.transpose() * c.b_slope
}

/// `J_r(θ)⁻¹`: how a rotation vector changes when the turn that it stands for is followed by a small one in its own axes.
pub fn right_jacobian_inverse(theta: &Vector3<f64>) -> Matrix3<f64> {
    let s = theta.norm_squared();
    let factor = if s < SERIES_BELOW {
        1.0 / 12.0 + s / 720.0 * (1.0 + s / 42.0 * (1.0 + s / 40.0))
    } else {
        let angle = s.sqrt();
        1.0 / s - (1.0 + angle.cos()) / (2.0 * angle * angle.sin())
    };
    let k = theta.cross_matrix();
    Matrix3::identity() + k * 0.5 + k * k * factor
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;

    const TURNS: [[f64; 3]; 4] = [
        [0.3, -0.7, 0.2],
        [1.1, 0.4, -1.9],
        [0.05, 0.06, -0.061],
        [1e-5, -2e-5, 3e-6],
    ];

    fn numerical(
        function: impl Fn(&Vector3<f64>) -> Vector3<f64>,
        at: &Vector3<f64>,
    ) -> Matrix3<f64> {
        let h = 1e-5;
        let columns = [0, 1, 2].map(|i| {
            let step = Vector3::ith(i, h);
            (function(&(at + step)) - function(&(at - step))) / (2.0 * h)
        });
        Matrix3::from_columns(&columns)
    }

    #[test]
    fn jacobians_are_the_derivatives_of_the_exponential() {
        for turn in TURNS.map(Vector3::from) {
            let here = UnitQuaternion::new(turn);
            let spin = |t: &Vector3<f64>| (UnitQuaternion::new(*t) * here.inverse()).scaled_axis();
            assert!((numerical(spin, &turn) - left_jacobian(&turn)).norm() < 1e-9);
            let product = left_jacobian(&-turn) * right_jacobian_inverse(&turn);
            assert!((product - Matrix3::identity()).norm() < 1e-13, "{product}");
        }
    }

    #[test]
    fn derivatives_of_the_jacobian() {
        let torque = Vector3::new(0.8, -1.3, 0.4);
        for turn in TURNS.map(Vector3::from) {
            let share = |t: &Vector3<f64>| left_jacobian(t).transpose() * torque;
            let difference =
                numerical(share, &turn) - left_jacobian_transpose_derivative(&turn, &torque);
            assert!(difference.norm() < 1e-9, "{turn}{difference}");
            let h = 1e-5;
            let rate = (left_jacobian(&(turn + torque * h)) - left_jacobian(&(turn - torque * h)))
                * torque
                / (2.0 * h);
            assert!((rate - left_jacobian_rate(&turn, &torque)).norm() < 1e-9);
        }
    }

    #[test]
    fn series_meet_the_closed_forms() {
        let direction = Vector3::new(0.6, 0.0, 0.8);
        let (below, above) = (direction * 0.099_999_9, direction * 0.100_000_1);
        assert!((left_jacobian(&below) - left_jacobian(&above)).norm() < 3e-7);
        assert!((right_jacobian_inverse(&below) - right_jacobian_inverse(&above)).norm() < 3e-7);
    }
}
