//! Joints: constraints between two places of two bodies, and between two joints.
//!
//! `a` and `b` are attachments on different bodies. An axis is given in the axes of `a` (`axis_b` in those of `b`), not
//! necessarily as a unit vector. Where `axis_b` is absent, the axis lies in `b` as the initial placement draws it.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::Checker;
use super::gear::{Gear, Rack};
use super::values::{in_space, positive};
use crate::Error;
use crate::named::object;

/// One joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Joint {
    /// No relative motion.
    #[serde(deserialize_with = "object")]
    Fixed(FixedJoint),
    /// Rotation about a common axis; planar: two points coincide.
    #[serde(deserialize_with = "object")]
    Revolute(AxisJoint),
    /// Translation along a common axis, no rotation.
    #[serde(deserialize_with = "object")]
    Prismatic(AxisJoint),
    /// Rotation about and translation along a common axis; spatial.
    #[serde(deserialize_with = "object")]
    Cylindrical(AxisJoint),
    /// Two points coincide, and an axis of each stays at right angles to the other; spatial.
    #[serde(deserialize_with = "object")]
    Universal(UniversalJoint),
    /// Two points coincide; spatial (planar: `revolute`).
    #[serde(deserialize_with = "object")]
    Spherical(PointJoint),
    /// Translation in a plane and rotation about its normal, which is the axis; spatial.
    #[serde(deserialize_with = "object")]
    Planar(AxisJoint),
    /// The point b stays on a line through a along the axis.
    #[serde(deserialize_with = "object")]
    PointOnLine(LineJoint),
    /// Two points keep their distance.
    #[serde(deserialize_with = "object")]
    Distance(DistanceJoint),
    /// The angles of two joints: second = ratio · first + constant.
    #[serde(deserialize_with = "object")]
    Gear(Gear),
    /// Angle and translation of two joints: translation = radius · rotation + constant.
    #[serde(deserialize_with = "object")]
    Rack(Rack),
}

/// Whose rotation a joint takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum OrientationSource {
    /// The frame of the body, where an interface has no rotation rows.
    Body,
}

/// Two places.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointJoint {
    /// First place.
    pub a: String,
    /// Second place.
    pub b: String,
}

/// Two places and their rotations.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FixedJoint {
    /// First place.
    pub a: String,
    /// Second place.
    pub b: String,
    /// `body`: the rotation of the body's frame where an interface has no rotation rows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<OrientationSource>,
}

/// Two places and a common axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AxisJoint {
    /// First place.
    pub a: String,
    /// Second place.
    pub b: String,
    /// Direction in the axes of a; a planar `revolute` has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<Vec<f64>>,
    /// Direction in the axes of b; as placed at the start where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis_b: Option<Vec<f64>>,
    /// `body`: the rotation of the body's frame where an interface has no rotation rows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<OrientationSource>,
}

/// Two places and an axis of each.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UniversalJoint {
    /// First place.
    pub a: String,
    /// Second place.
    pub b: String,
    /// Axis of the cross that is fixed in a, in the axes of a.
    pub axis: Vec<f64>,
    /// Axis of the cross that is fixed in b, in the axes of b.
    pub axis_b: Vec<f64>,
    /// `body`: the rotation of the body's frame where an interface has no rotation rows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<OrientationSource>,
}

/// A line through a and a point on it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LineJoint {
    /// Place that the line goes through.
    pub a: String,
    /// Place on the line.
    pub b: String,
    /// Direction of the line in the axes of a.
    pub axis: Vec<f64>,
    /// `body`: the rotation of the body's frame where the first interface has no rotation rows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<OrientationSource>,
}

/// Two places at a distance.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DistanceJoint {
    /// First place.
    pub a: String,
    /// Second place.
    pub b: String,
    /// Distance; as placed at the start where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length: Option<f64>,
}

/// One of the two places of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The first.
    A,
    /// The second.
    B,
}

impl Side {
    /// Both, in order.
    pub const BOTH: [Self; 2] = [Self::A, Self::B];
}

/// Axis of a joint, not necessarily of unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointAxis {
    /// Direction in the axes of a.
    pub a: Vector3<f64>,
    /// Direction in the axes of b.
    pub b: SecondAxis,
}

/// Axis of a joint at its second place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SecondAxis {
    /// In the axes of b.
    Given(Vector3<f64>),
    /// Parallel to the axis of a in the initial placement.
    AsDrawn,
    /// No direction of b is an axis.
    None,
}

/// Directions in which a joint can exert a force or a moment at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExertedDirections {
    /// None.
    None,
    /// The axis.
    Along,
    /// Those perpendicular to the axis.
    Across,
    /// All.
    All,
}

impl Joint {
    /// The kind, as the scene writes it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Fixed(_) => "fixed",
            Self::Revolute(_) => "revolute",
            Self::Prismatic(_) => "prismatic",
            Self::Cylindrical(_) => "cylindrical",
            Self::Universal(_) => "universal",
            Self::Spherical(_) => "spherical",
            Self::Planar(_) => "planar",
            Self::PointOnLine(_) => "point_on_line",
            Self::Distance(_) => "distance",
            Self::Gear(_) => "gear",
            Self::Rack(_) => "rack",
        }
    }

    /// Whether the joint has an angle.
    pub fn has_angle(&self) -> bool {
        matches!(self, Self::Revolute(_) | Self::Cylindrical(_))
    }

    /// Whether the joint has a length: a translation or a distance.
    pub fn has_length(&self) -> bool {
        matches!(
            self,
            Self::Prismatic(_) | Self::Cylindrical(_) | Self::Distance(_)
        )
    }

    /// The two attachments; `None` for a gear or rack, which connects joints.
    pub fn attachments(&self) -> Option<[&str; 2]> {
        match self {
            Self::Fixed(FixedJoint { a, b, .. })
            | Self::Revolute(AxisJoint { a, b, .. })
            | Self::Prismatic(AxisJoint { a, b, .. })
            | Self::Cylindrical(AxisJoint { a, b, .. })
            | Self::Planar(AxisJoint { a, b, .. })
            | Self::Universal(UniversalJoint { a, b, .. })
            | Self::Spherical(PointJoint { a, b })
            | Self::PointOnLine(LineJoint { a, b, .. })
            | Self::Distance(DistanceJoint { a, b, .. }) => Some([a, b]),
            Self::Gear(_) | Self::Rack(_) => None,
        }
    }

    /// Where the joint takes rotations from, if not from the interfaces.
    pub fn orientation(&self) -> Option<OrientationSource> {
        match self {
            Self::Fixed(joint) => joint.orientation,
            Self::Revolute(joint)
            | Self::Prismatic(joint)
            | Self::Cylindrical(joint)
            | Self::Planar(joint) => joint.orientation,
            Self::Universal(joint) => joint.orientation,
            Self::PointOnLine(joint) => joint.orientation,
            Self::Spherical(_) | Self::Distance(_) | Self::Gear(_) | Self::Rack(_) => None,
        }
    }

    /// Axis at both places; `None` for a kind that has none.
    pub fn axis(&self) -> Option<JointAxis> {
        match self {
            Self::Revolute(joint)
            | Self::Prismatic(joint)
            | Self::Cylindrical(joint)
            | Self::Planar(joint) => Some(joint.common_axis()),
            Self::Universal(joint) => Some(JointAxis {
                a: in_space(&joint.axis),
                b: SecondAxis::Given(in_space(&joint.axis_b)),
            }),
            Self::PointOnLine(joint) => Some(JointAxis {
                a: in_space(&joint.axis),
                b: SecondAxis::None,
            }),
            Self::Fixed(_)
            | Self::Spherical(_)
            | Self::Distance(_)
            | Self::Gear(_)
            | Self::Rack(_) => None,
        }
    }

    /// Directions of the force and of the moment that the joint can exert at one of its places, drives left aside.
    pub fn exerts(&self, side: Side) -> [ExertedDirections; 2] {
        use ExertedDirections::{Across, All, Along, None};
        match (self, side) {
            (Self::Fixed(_), _) => [All, All],
            (Self::Revolute(_) | Self::Universal(_), _) => [All, Across],
            (Self::Prismatic(_), _) => [Across, All],
            (Self::Cylindrical(_), _) | (Self::PointOnLine(_), Side::A) => [Across, Across],
            (Self::Spherical(_) | Self::Distance(_), _) | (Self::PointOnLine(_), Side::B) => {
                [All, None]
            }
            (Self::Planar(_), _) => [Along, Across],
            (Self::Gear(_) | Self::Rack(_), _) => [None, None],
        }
    }

    pub(super) fn check(&self, location: &str, checker: &Checker) -> Result<(), Error> {
        let kind = self.kind();
        let location = format!("{location}.{kind}");
        if checker.is_planar() {
            let instead = match self {
                Self::Cylindrical(_) => "revolute or prismatic",
                Self::Universal(_) | Self::Spherical(_) => "revolute",
                Self::Planar(_) => "no joint: every body moves in the plane",
                _ => "",
            };
            if !instead.is_empty() {
                return Err(Error::described(
                    location,
                    format!("{kind} joints are spatial, but the scene is planar; use {instead}"),
                ));
            }
        }
        if let Some([a, b]) = self.attachments() {
            checker.connection(&location, a, b)?;
        }
        checker.holds_no_point_mass(&location, self)?;
        match self {
            Self::Fixed(_) | Self::Spherical(_) => Ok(()),
            Self::Revolute(joint) if checker.is_planar() => joint.check_planar_pin(&location),
            Self::Revolute(joint)
            | Self::Prismatic(joint)
            | Self::Cylindrical(joint)
            | Self::Planar(joint) => joint.check_axes(&location, checker),
            Self::Universal(joint) => {
                checker.direction(&format!("{location}.axis"), &joint.axis)?;
                checker.direction(&format!("{location}.axis_b"), &joint.axis_b)
            }
            Self::PointOnLine(joint) => checker.direction(&format!("{location}.axis"), &joint.axis),
            Self::Distance(joint) => match joint.length {
                Some(length) => positive(&format!("{location}.length"), length),
                None => Ok(()),
            },
            Self::Gear(gear) => gear.check(&location, checker),
            Self::Rack(rack) => rack.check(&location, checker),
        }
    }
}

impl AxisJoint {
    fn common_axis(&self) -> JointAxis {
        match (&self.axis, &self.axis_b) {
            // A planar revolute joint.
            (None, _) => JointAxis {
                a: Vector3::z(),
                b: SecondAxis::Given(Vector3::z()),
            },
            (Some(axis), None) => JointAxis {
                a: in_space(axis),
                b: SecondAxis::AsDrawn,
            },
            (Some(axis), Some(axis_b)) => JointAxis {
                a: in_space(axis),
                b: SecondAxis::Given(in_space(axis_b)),
            },
        }
    }

    fn check_planar_pin(&self, location: &str) -> Result<(), Error> {
        for (key, axis) in [("axis", &self.axis), ("axis_b", &self.axis_b)] {
            if axis.is_some() {
                return Err(Error::described(
                    format!("{location}.{key}"),
                    "a revolute joint of a planar scene turns about z and has no axis",
                ));
            }
        }
        Ok(())
    }

    fn check_axes(&self, location: &str, checker: &Checker) -> Result<(), Error> {
        let Some(axis) = &self.axis else {
            let example = if checker.is_planar() {
                "[1, 0]"
            } else {
                "[0, 0, 1]"
            };
            return Err(Error::described(
                format!("{location}.axis"),
                format!("is missing; add for example \"axis\": {example}, in the axes of a"),
            ));
        };
        checker.direction(&format!("{location}.axis"), axis)?;
        match &self.axis_b {
            Some(axis) => checker.direction(&format!("{location}.axis_b"), axis),
            None => Ok(()),
        }
    }
}
