//! Prismatic joint: b's origin stays on a line of a, the orientation stays as drawn.

use dcb_formats::mesh::Dimension;
use nalgebra::Vector3;

use super::direction::{across, direction_in_scene};
use super::rest::RestPlacement;
use super::rows::{JointRows, displacements, orientation};
use crate::error::Error;
use crate::measure::{Displacement, Measure};

pub(super) const NAME: &str = "prismatic";

/// Leaves the translation along an axis free; zero where the origins coincide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prismatic {
    /// In a's axes, through a's origin.
    pub axis: Vector3<f64>,
}

impl Prismatic {
    pub(super) fn rows(
        &self,
        dimension: Dimension,
        rest: &RestPlacement,
    ) -> Result<JointRows, Error> {
        let direction = direction_in_scene(NAME, "axis", &self.axis, dimension)?;
        let held = displacements(across(&direction, dimension)).chain(orientation(dimension, rest));
        Ok(JointRows {
            translation: Some(Measure::Displacement(Displacement { direction })),
            ..JointRows::holding_orientation(held.collect(), dimension)
        })
    }
}
