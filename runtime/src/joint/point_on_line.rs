//! Point on a line: b's origin stays on a line of a. b's rotation isn't involved; the line turns with a.

use dcb_formats::mesh::Dimension;
use nalgebra::Vector3;

use super::direction::{across, direction_in_scene};
use super::rows::{JointRows, displacements};
use crate::error::Error;
use crate::measure::{Displacement, Measure};

pub(super) const NAME: &str = "point-on-line";

/// Leaves the translation along a line (zero where the origins coincide) and all rotations free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointOnLine {
    /// In a's axes, through a's origin.
    pub direction: Vector3<f64>,
}

impl PointOnLine {
    pub(super) fn rows(&self, dimension: Dimension) -> Result<JointRows, Error> {
        let direction = direction_in_scene(NAME, "direction", &self.direction, dimension)?;
        let held = displacements(across(&direction, dimension));
        Ok(JointRows {
            translation: Some(Measure::Displacement(Displacement { direction })),
            uses_axes_of_a: true,
            ..JointRows::holding(held.collect())
        })
    }
}
