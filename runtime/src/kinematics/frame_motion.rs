//! Motion of a frame: what joints, springs, loads and outputs see of a body at one of its interfaces or points.
//!
//! All vectors are in world axes. A variation of the frame is `(δp, δψ)`: δp moves its origin, δψ turns its axes,
//! `δ axes = skew(δψ) axes`. Wrenches `(f, τ)` are conjugate to it: δW = f · δp + τ · δψ.

use nalgebra::{Matrix3, SVector, Vector3};

/// `(δp, δψ)` or `(f, τ)`, world axes.
pub type Six = SixOf<f64>;

/// The same of other numbers.
pub type SixOf<T> = SVector<T, 6>;

/// Position, velocity and acceleration of a frame, world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameMotion {
    /// Origin.
    pub position: Vector3<f64>,
    /// Rotation matrix, frame axes to world axes: its columns are the frame's axes.
    pub axes: Matrix3<f64>,
    /// Velocity of the origin.
    pub velocity: Vector3<f64>,
    /// Angular velocity.
    pub spin: Vector3<f64>,
    /// Acceleration of the origin.
    pub acceleration: Vector3<f64>,
    /// Angular acceleration, the time derivative of `spin`.
    pub spin_rate: Vector3<f64>,
}

impl FrameMotion {
    /// A frame at rest.
    pub fn at_rest(position: Vector3<f64>, axes: Matrix3<f64>) -> Self {
        let zero = Vector3::zeros();
        Self {
            position,
            axes,
            velocity: zero,
            spin: zero,
            acceleration: zero,
            spin_rate: zero,
        }
    }
}
