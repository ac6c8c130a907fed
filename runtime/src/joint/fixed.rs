//! Fixed joint: the origins coincide, the orientation stays as drawn.

use dcb_formats::mesh::Dimension;

use super::direction::translation_axes;
use super::rest::RestPlacement;
use super::rows::{JointRows, displacements, orientation};

pub(super) const NAME: &str = "fixed";

/// Leaves nothing free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fixed;

impl Fixed {
    pub(super) fn rows(&self, dimension: Dimension, rest: &RestPlacement) -> JointRows {
        let held = displacements(translation_axes(dimension)).chain(orientation(dimension, rest));
        JointRows::holding_orientation(held.collect(), dimension)
    }
}
