//! A direction that turns with a frame.

use nalgebra::{Unit, Vector3};

use crate::kinematics::frame_motion::FrameMotion;

/// A direction fixed in a frame, with its first two time derivatives, world axes.
pub(super) struct Carried {
    pub(super) now: Vector3<f64>,
    pub(super) rate: Vector3<f64>,
    pub(super) second_rate: Vector3<f64>,
}

impl Carried {
    pub(super) fn by(frame: &FrameMotion, direction: &Unit<Vector3<f64>>) -> Self {
        let now = frame.axes * direction.as_ref();
        let rate = frame.spin.cross(&now);
        Self {
            now,
            rate,
            second_rate: frame.spin_rate.cross(&now) + frame.spin.cross(&rate),
        }
    }
}
