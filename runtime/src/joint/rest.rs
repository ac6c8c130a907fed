//! How the two frames of a joint are drawn.

use nalgebra::{Matrix3, Unit, Vector3};

use crate::kinematics::frame_motion::FrameMotion;

/// The orientation of b against a at the initial placement. In a planar scene both turn about z only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestPlacement {
    /// `R_aᵀ R_b`: b's axes in a's.
    relative: Matrix3<f64>,
}

impl RestPlacement {
    /// Of the two frames as drawn.
    pub fn of(a: &FrameMotion, b: &FrameMotion) -> Self {
        Self {
            relative: a.axes.transpose() * b.axes,
        }
    }

    /// A direction of a's axes in b's, as drawn.
    pub(super) fn seen_from_b(&self, direction_a: &Unit<Vector3<f64>>) -> Unit<Vector3<f64>> {
        Unit::new_normalize(self.relative.transpose() * direction_a.as_ref())
    }
}
