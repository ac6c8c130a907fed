//! Joints: constraints between two places of two bodies, and between two joints.
//!
//! `a` and `b` are attachments on different bodies. An axis is given in the axes of `a` (`axis_b` in those of `b`), not
//! necessarily as a unit vector. Where `axis_b` is absent, the axis lies in `b` as the initial placement draws it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::{Checker, finite};
use super::values::positive;
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

/// Two rotations in a fixed ratio.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gear {
    /// Name of a revolute or cylindrical joint.
    pub first: String,
    /// Name of another one.
    pub second: String,
    /// Angle of the second per angle of the first; negative where they turn against each other.
    pub ratio: f64,
}

/// A rotation and a translation in a fixed ratio.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rack {
    /// Name of a revolute or cylindrical joint.
    pub rotation: String,
    /// Name of a prismatic or cylindrical joint.
    pub translation: String,
    /// Translation per angle, length; may be negative.
    pub radius: f64,
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

impl Gear {
    fn check(&self, location: &str, checker: &Checker) -> Result<(), Error> {
        for (key, name) in [("first", &self.first), ("second", &self.second)] {
            with_angle(&format!("{location}.{key}"), name, checker)?;
        }
        if self.first == self.second {
            return Err(Error::described(
                format!("{location}.second"),
                format!("is {:?} like first; expected another joint", self.second),
            ));
        }
        not_zero(&format!("{location}.ratio"), self.ratio)
    }
}

impl Rack {
    fn check(&self, location: &str, checker: &Checker) -> Result<(), Error> {
        with_angle(&format!("{location}.rotation"), &self.rotation, checker)?;
        with_length(
            &format!("{location}.translation"),
            &self.translation,
            checker,
        )?;
        not_zero(&format!("{location}.radius"), self.radius)
    }
}

/// A joint that has an angle, by name.
pub(super) fn with_angle(location: &str, name: &str, checker: &Checker) -> Result<(), Error> {
    let joint = checker.joint(location, name)?;
    if joint.has_angle() {
        return Ok(());
    }
    Err(Error::described(
        location,
        format!(
            "joint {name:?} is {}, which has no angle; expected a revolute or cylindrical joint",
            joint.kind()
        ),
    ))
}

/// A joint that has a translation or a distance, by name.
pub(super) fn with_length(location: &str, name: &str, checker: &Checker) -> Result<(), Error> {
    let joint = checker.joint(location, name)?;
    if joint.has_length() {
        return Ok(());
    }
    Err(Error::described(
        location,
        format!(
            "joint {name:?} is {}, which has no translation; expected a prismatic, cylindrical or distance joint",
            joint.kind()
        ),
    ))
}

fn not_zero(location: &str, number: f64) -> Result<(), Error> {
    finite(location, number)?;
    if number == 0.0 {
        return Err(Error::described(
            location,
            "is zero, expected another number",
        ));
    }
    Ok(())
}
