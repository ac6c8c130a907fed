//! Random frames, and frames moved by finite variations.

use dcb_runtime::kinematics::frame_motion::{FrameMotion, Six};
use dcb_samples::PseudoRandom;
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

/// Pseudo-random vectors and frames.
pub struct Random(PseudoRandom);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(PseudoRandom::new(seed))
    }

    /// In [-1, 1).
    pub fn number(&mut self) -> f64 {
        self.0.number()
    }

    pub fn vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.number())
    }

    pub fn unit(&mut self) -> Unit<Vector3<f64>> {
        Unit::new_normalize(self.vector())
    }

    pub fn axes(&mut self) -> Matrix3<f64> {
        turn(&(3.0 * self.vector()))
    }

    /// Moving and accelerating.
    pub fn frame(&mut self) -> FrameMotion {
        FrameMotion {
            velocity: self.vector(),
            spin: self.vector(),
            acceleration: self.vector(),
            spin_rate: self.vector(),
            ..FrameMotion::at_rest(self.vector(), self.axes())
        }
    }
}

/// Rotation matrix of a rotation vector.
pub fn turn(vector: &Vector3<f64>) -> Matrix3<f64> {
    Rotation3::new(*vector).into_inner()
}

/// The frame displaced by a finite variation: `p + δp`, `exp(skew(δψ)) R`.
pub fn varied(frame: &FrameMotion, variation: &Six) -> FrameMotion {
    let (shift, turned) = (variation.fixed_rows::<3>(0), variation.fixed_rows::<3>(3));
    FrameMotion {
        position: frame.position + shift,
        axes: turn(&turned.into_owned()) * frame.axes,
        ..*frame
    }
}
