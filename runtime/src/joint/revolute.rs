//! Revolute joint: the origins coincide and an axis is common.
//!
//! In a planar scene the axis is z, no rotation is loaded, and the angle is the one from a's x axis to b's; in space it
//! is zero as drawn.

use dcb_formats::mesh::Dimension;
use nalgebra::Vector3;

use super::axis_pair::AxisPair;
use super::direction::{axis_in_scene, translation_axes};
use super::rest::RestPlacement;
use super::rows::{FreeRotation, JointRows, coincidence, displacements};
use crate::error::Error;
use crate::measure::{Angle, Measure};

pub(super) const NAME: &str = "revolute";

/// Leaves the rotation about an axis free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Revolute {
    /// In a's axes; in a planar scene z.
    pub axis: Vector3<f64>,
    /// In b's axes; as drawn unless given.
    pub axis_b: Option<Vector3<f64>>,
}

impl Revolute {
    pub(super) fn rows(
        &self,
        dimension: Dimension,
        rest: &RestPlacement,
    ) -> Result<JointRows, Error> {
        axis_in_scene(NAME, "axis", &self.axis, dimension)?;
        if let Some(axis_b) = &self.axis_b {
            axis_in_scene(NAME, "axis_b", axis_b, dimension)?;
        }
        if dimension == Dimension::Planar {
            return Ok(rows_in_plane());
        }
        let names = ["axis", "axis_b"];
        let axes = AxisPair::new(NAME, names, &self.axis, self.axis_b.as_ref(), rest)?;
        let held = displacements(translation_axes(dimension)).chain(axes.parallel());
        let [turned_a, turned_b] = axes.turned();
        Ok(JointRows {
            rotation: Some(axes.angle(rest)),
            turned_a,
            turned_b,
            uses_axes_of_a: true,
            ..JointRows::holding(held.collect())
        })
    }
}

/// Two points of a planar scene together, and the angle between their frames.
pub(super) fn rows_in_plane() -> JointRows {
    JointRows {
        rotation: Some(FreeRotation {
            angle: Measure::Angle(Angle::in_plane()),
            axis_a: Vector3::z_axis(),
            axis_b: Vector3::z_axis(),
        }),
        ..JointRows::holding(coincidence(Dimension::Planar))
    }
}
