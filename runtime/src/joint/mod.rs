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
//! drawn. A new kind is one file, its lines here and in the scene's `joint.rs`, and its example in the tests.

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
use dcb_formats::scene::{Joint, JointAxis, SecondAxis};
use nalgebra::Vector3;

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
use crate::kinematics::frame_motion::FrameMotion;

/// Motions that a joint leaves free between its frames a and b.
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
    /// A joint of a scene between two frames as drawn.
    ///
    /// # Errors
    /// [`Error::Description`] for a joint that couples joints, and for a key that has no meaning for its kind.
    pub(crate) fn of(
        joint: &Joint,
        location: &str,
        [a, b]: &[FrameMotion; 2],
    ) -> Result<Self, Error> {
        let (axis, axis_b) = match joint.axis() {
            Some(JointAxis { a, b }) => match b {
                SecondAxis::Given(b) => (a, Some(b)),
                SecondAxis::AsDrawn | SecondAxis::None => (a, None),
            },
            None => (Vector3::zeros(), None),
        };
        Ok(match joint {
            Joint::Fixed(_) => Self::Fixed(Fixed),
            Joint::Revolute(_) => Self::Revolute(Revolute { axis, axis_b }),
            Joint::Prismatic(_) if axis_b.is_some() => {
                return Err(Error::described(
                    format!("{location}.axis_b"),
                    "has no meaning: a prismatic joint keeps the orientation as drawn; leave it out",
                ));
            }
            Joint::Prismatic(_) => Self::Prismatic(Prismatic { axis }),
            Joint::Cylindrical(_) => Self::Cylindrical(Cylindrical { axis, axis_b }),
            Joint::Universal(_) => Self::Universal(Universal {
                axis_a: axis,
                axis_b: axis_b.unwrap_or(axis),
            }),
            Joint::Spherical(_) => Self::Spherical(Spherical),
            Joint::Planar(_) => Self::Planar(Planar {
                normal: axis,
                normal_b: axis_b,
            }),
            Joint::PointOnLine(_) => Self::PointOnLine(PointOnLine { direction: axis }),
            Joint::Distance(joint) => {
                let drawn = || (b.position - a.position).norm();
                Self::Distance(DistanceJoint {
                    length: joint.length.unwrap_or_else(drawn),
                })
            }
            Joint::Gear(_) | Joint::Rack(_) => {
                return Err(Error::described(location, "couples joints, not places"));
            }
        })
    }

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
