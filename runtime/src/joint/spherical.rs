//! Spherical joint: the origins coincide. No rotation is involved; in a planar scene it is a revolute joint.

use dcb_formats::mesh::Dimension;

use super::revolute;
use super::rows::{JointRows, coincidence};

pub(super) const NAME: &str = "spherical";

/// Leaves all rotations free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spherical;

impl Spherical {
    pub(super) fn rows(&self, dimension: Dimension) -> JointRows {
        match dimension {
            Dimension::Spatial => JointRows::holding(coincidence(dimension)),
            Dimension::Planar => revolute::rows_in_plane(),
        }
    }
}
