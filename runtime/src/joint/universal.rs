//! Universal joint: the origins coincide, an axis of a stays perpendicular to one of b.

use dcb_formats::mesh::Dimension;
use nalgebra::Vector3;

use super::direction::{direction, perpendiculars, translation_axes};
use super::rest::RestPlacement;
use super::rows::{JointRows, displacements};
use crate::error::Error;
use crate::measure::{Alignment, Measure};

pub(super) const NAME: &str = "universal";

/// Largest cosine between the axes, as drawn, that still counts as rounding of the placement.
const PERPENDICULAR_LIMIT: f64 = 1e-6;

/// Leaves the rotations about two perpendicular axes free, one of each frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Universal {
    /// In a's axes.
    pub axis_a: Vector3<f64>,
    /// In b's axes.
    pub axis_b: Vector3<f64>,
}

impl Universal {
    pub(super) fn rows(
        &self,
        dimension: Dimension,
        rest: &RestPlacement,
    ) -> Result<JointRows, Error> {
        if dimension == Dimension::Planar {
            return Err(Error::NotInPlane { joint: NAME });
        }
        let direction_a = direction(NAME, "axis_a", &self.axis_a)?;
        let direction_b = direction(NAME, "axis_b", &self.axis_b)?;
        let cosine = rest.seen_from_b(&direction_a).dot(&direction_b);
        // Negated, so that an orientation that isn't a number is refused as well.
        if cosine.is_nan() || cosine.abs() > PERPENDICULAR_LIMIT {
            return Err(Error::AxesNotPerpendicular {
                joint: NAME,
                cosine,
                limit: PERPENDICULAR_LIMIT,
            });
        }
        let cross = Measure::Alignment(Alignment {
            direction_a,
            direction_b,
        });
        let held = displacements(translation_axes(dimension)).chain([cross]);
        // The moment is along the normal of the two axes, which turns about each of them.
        Ok(JointRows {
            turned_a: perpendiculars(&direction_a).into(),
            turned_b: perpendiculars(&direction_b).into(),
            uses_axes_of_a: true,
            ..JointRows::holding(held.collect())
        })
    }
}
