//! Cylindrical joint: an axis of a and one of b are on one line.

use dcb_formats::mesh::Dimension;
use nalgebra::Vector3;

use super::axis_pair::AxisPair;
use super::direction::across;
use super::rest::RestPlacement;
use super::rows::{JointRows, displacements};
use crate::error::Error;
use crate::measure::{Displacement, Measure};

pub(super) const NAME: &str = "cylindrical";

/// Leaves the rotation about an axis (zero as drawn) and the translation along it (zero where the origins coincide) free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylindrical {
    /// In a's axes, through a's origin.
    pub axis: Vector3<f64>,
    /// In b's axes; as drawn unless given.
    pub axis_b: Option<Vector3<f64>>,
}

impl Cylindrical {
    pub(super) fn rows(
        &self,
        dimension: Dimension,
        rest: &RestPlacement,
    ) -> Result<JointRows, Error> {
        if dimension == Dimension::Planar {
            return Err(Error::NotInPlane { joint: NAME });
        }
        let names = ["axis", "axis_b"];
        let axes = AxisPair::new(NAME, names, &self.axis, self.axis_b.as_ref(), rest)?;
        let held = displacements(across(&axes.a, dimension)).chain(axes.parallel());
        let [turned_a, turned_b] = axes.turned();
        Ok(JointRows {
            rotation: Some(axes.angle(rest)),
            translation: Some(Measure::Displacement(Displacement { direction: axes.a })),
            turned_a,
            turned_b,
            uses_axes_of_a: true,
            ..JointRows::holding(held.collect())
        })
    }
}
