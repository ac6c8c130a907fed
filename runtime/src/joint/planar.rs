//! Planar joint: b's origin stays in a plane of a, and so does the plane of b.

use dcb_formats::mesh::Dimension;
use nalgebra::Vector3;

use super::axis_pair::AxisPair;
use super::rest::RestPlacement;
use super::rows::{JointRows, displacements};
use crate::error::Error;

pub(super) const NAME: &str = "planar";

/// Leaves the translations in a plane and the rotation about its normal free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Planar {
    /// In a's axes; the plane goes through a's origin.
    pub normal: Vector3<f64>,
    /// In b's axes; as drawn unless given.
    pub normal_b: Option<Vector3<f64>>,
}

impl Planar {
    pub(super) fn rows(
        &self,
        dimension: Dimension,
        rest: &RestPlacement,
    ) -> Result<JointRows, Error> {
        if dimension == Dimension::Planar {
            return Err(Error::NotInPlane { joint: NAME });
        }
        let names = ["normal", "normal_b"];
        let normals = AxisPair::new(NAME, names, &self.normal, self.normal_b.as_ref(), rest)?;
        let held = displacements(vec![normals.a]).chain(normals.parallel());
        let [turned_a, turned_b] = normals.turned();
        Ok(JointRows {
            turned_a,
            turned_b,
            uses_axes_of_a: true,
            ..JointRows::holding(held.collect())
        })
    }
}
