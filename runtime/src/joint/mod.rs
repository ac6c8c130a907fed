//! Joints between two frames, as lists of measures held at zero.
//!
//! A [`JointKind`] has its geometry in the frames' own axes; [`JointKind::rows`] gives the measures that the joint holds,
//! and those along its free motion, which drives, springs and outputs can use:
//!
//! | kind | held in space | in a plane | rotation | translation |
//! |---|---|---|---|---|
//! | fixed | 6 | 3 | | |
//! | revolute | 5 | 2 | yes | |
//! | prismatic | 5 | 2 | | yes |
//! | cylindrical | 4 | | yes | yes |
//! | universal | 4 | | | |
//! | spherical | 3 | 2 | in a plane | |
//! | planar | 3 | | | |
//! | point on line | 2 | 1 | | yes |
//! | distance | 1 | 1 | | yes |
//!
//! Positions are held together: the two origins coincide, or are on one line or in one plane. Orientations are held as
//! drawn. A new kind is one file, its lines in this one, and its example in the family's tests.

mod axis_pair;
mod cylindrical;
mod direction;
mod distance;
mod fixed;
mod planar;
mod point_on_line;
mod prismatic;
mod rest;
mod revolute;
mod rows;
mod spherical;
mod universal;

use dcb_formats::mesh::Dimension;

pub use cylindrical::Cylindrical;
pub use distance::DistanceJoint;
pub use fixed::Fixed;
pub use planar::Planar;
pub use point_on_line::PointOnLine;
pub use prismatic::Prismatic;
pub use rest::RestPlacement;
pub use revolute::Revolute;
pub use rows::{FreeRotation, JointRows};
pub use spherical::Spherical;
pub use universal::Universal;

use crate::error::Error;

/// What a joint leaves free between its frames a and b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointKind {
    /// Nothing.
    Fixed(Fixed),
    /// Rotation about an axis.
    Revolute(Revolute),
    /// Translation along an axis.
    Prismatic(Prismatic),
    /// Rotation about an axis and translation along it.
    Cylindrical(Cylindrical),
    /// Rotations about an axis of a and one of b.
    Universal(Universal),
    /// All rotations.
    Spherical(Spherical),
    /// Translations in a plane and rotation about its normal.
    Planar(Planar),
    /// Translation along a line and all rotations.
    PointOnLine(PointOnLine),
    /// All but the distance between the origins.
    Distance(DistanceJoint),
}

impl JointKind {
    /// As error messages call it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Fixed(_) => fixed::NAME,
            Self::Revolute(_) => revolute::NAME,
            Self::Prismatic(_) => prismatic::NAME,
            Self::Cylindrical(_) => cylindrical::NAME,
            Self::Universal(_) => universal::NAME,
            Self::Spherical(_) => spherical::NAME,
            Self::Planar(_) => planar::NAME,
            Self::PointOnLine(_) => point_on_line::NAME,
            Self::Distance(_) => distance::NAME,
        }
    }

    /// The measures that the joint holds and those it leaves free.
    ///
    /// # Errors
    /// [`Error::NotInPlane`] for a kind with no meaning in a planar scene; [`Error::NoDirection`],
    /// [`Error::DirectionNotInPlane`], [`Error::AxesNotPerpendicular`], [`Error::AxesApart`] and
    /// [`Error::LengthNotPositive`] for a geometry that can't be used.
    pub fn rows(&self, dimension: Dimension, rest: &RestPlacement) -> Result<JointRows, Error> {
        match self {
            Self::Fixed(kind) => Ok(kind.rows(dimension, rest)),
            Self::Revolute(kind) => kind.rows(dimension, rest),
            Self::Prismatic(kind) => kind.rows(dimension, rest),
            Self::Cylindrical(kind) => kind.rows(dimension, rest),
            Self::Universal(kind) => kind.rows(dimension, rest),
            Self::Spherical(kind) => Ok(kind.rows(dimension)),
            Self::Planar(kind) => kind.rows(dimension, rest),
            Self::PointOnLine(kind) => kind.rows(dimension),
            Self::Distance(kind) => kind.rows(),
        }
    }
}
