//! Records of a run.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::{Checker, finite};
use super::values::positive;
use super::{Joint, Scene};
use crate::Error;
use crate::named::object;

/// One recorded quantity; in world axes where nothing else is said.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Output {
    /// Position of a place.
    #[serde(deserialize_with = "object")]
    Position(AtPlace),
    /// Position of a place less that at time zero.
    #[serde(deserialize_with = "object")]
    Displacement(AtPlace),
    /// Velocity of a place.
    #[serde(deserialize_with = "object")]
    Velocity(AtPlace),
    /// Acceleration of a place.
    #[serde(deserialize_with = "object")]
    Acceleration(AtPlace),
    /// Orientation of a place: angle in rad (planar) or quaternion w, x, y, z.
    #[serde(deserialize_with = "object")]
    Orientation(AtPlace),
    /// Rate of rotation of a place.
    #[serde(deserialize_with = "object")]
    AngularVelocity(AtPlace),
    /// Deflection of a node from the chord between two interfaces, divided by the chord's reference length.
    #[serde(deserialize_with = "object")]
    ChordDeflection(ChordDeflection),
    /// Elastic displacement of a node of the mesh, body axes.
    #[serde(deserialize_with = "object")]
    NodeDisplacement(MeshNode),
    /// Position of a node of the mesh.
    #[serde(deserialize_with = "object")]
    NodePosition(MeshNode),
    /// Angle, translation or distance of a joint; of a cylindrical joint angle and translation.
    #[serde(deserialize_with = "object")]
    JointCoordinate(OfJoint),
    /// Rate of the coordinate of a joint.
    #[serde(deserialize_with = "object")]
    JointRate(OfJoint),
    /// Force and moment of a joint on its first body.
    #[serde(deserialize_with = "object")]
    Reaction(Reaction),
    /// Force on the rows of an interface of a superelement, body axes.
    #[serde(deserialize_with = "object")]
    InterfaceForce(AtPlace),
    /// Force or moment that a drive exerts, on its coordinate.
    #[serde(deserialize_with = "object")]
    DriveEffort(OfDrive),
    /// Force or moment of a spring with its damper.
    #[serde(deserialize_with = "object")]
    SpringForce(OfSpring),
    /// Moment or force of an actuator, on its coordinate.
    #[serde(deserialize_with = "object")]
    ActuatorEffort(OfActuator),
    /// Coordinates of the deflection of a superelement.
    #[serde(deserialize_with = "object")]
    Modal(OfBody),
    /// Kinetic, elastic and potential energy, and the work of drives, loads and dampers.
    Energy,
}

/// An attachment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AtPlace {
    /// `body/interface` or `body/point`.
    pub at: String,
}

/// A node and the interfaces at the ends of a chord.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChordDeflection {
    /// Name of a superelement's body.
    pub body: String,
    /// Node of its mesh, from 0.
    pub node: u32,
    /// Two interfaces of the body.
    pub between: [String; 2],
}

/// A node of the mesh of a superelement.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshNode {
    /// Name of a superelement's body.
    pub body: String,
    /// Node of its mesh, from 0.
    pub node: u32,
}

/// A joint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OfJoint {
    /// Name of the joint.
    pub joint: String,
}

/// A joint and the axes of its force and moment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Reaction {
    /// Name of the joint.
    pub joint: String,
    /// Axes of the components.
    #[serde(default)]
    pub axes: ReactionAxes,
}

/// Axes of a reaction's components.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ReactionAxes {
    /// Fixed.
    #[default]
    World,
    /// Those of the first place.
    First,
    /// Those of the second place.
    Second,
}

/// A drive.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OfDrive {
    /// Name of the drive.
    pub drive: String,
}

/// A spring.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OfSpring {
    /// Name of the spring.
    pub spring: String,
}

/// An actuator.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OfActuator {
    /// Name of the actuator.
    pub actuator: String,
}

/// A body.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OfBody {
    /// Name of a superelement's body.
    pub body: String,
}

/// How often results are recorded; after every step where a scene says nothing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Record {
    /// After every so many steps.
    Every(u32),
    /// At the multiples of this time, wherever steps end, and at the end.
    Interval(f64),
}

/// Displacement fields of a superelement, written as VTU files.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{"required": ["times"]}, {"required": ["every"]}]))]
pub struct FieldRequest {
    /// Name of a superelement's body.
    pub body: String,
    /// Times, not negative and strictly increasing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub times: Option<Vec<f64>>,
    /// Interval of time, in place of times.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub every: Option<f64>,
    /// Folder of the files; a relative path starts at the folder of the scene.
    pub directory: PathBuf,
}

impl Output {
    /// The quantity, as the scene writes it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Position(_) => "position",
            Self::Displacement(_) => "displacement",
            Self::Velocity(_) => "velocity",
            Self::Acceleration(_) => "acceleration",
            Self::Orientation(_) => "orientation",
            Self::AngularVelocity(_) => "angular_velocity",
            Self::ChordDeflection(_) => "chord_deflection",
            Self::NodeDisplacement(_) => "node_displacement",
            Self::NodePosition(_) => "node_position",
            Self::JointCoordinate(_) => "joint_coordinate",
            Self::JointRate(_) => "joint_rate",
            Self::Reaction(_) => "reaction",
            Self::InterfaceForce(_) => "interface_force",
            Self::DriveEffort(_) => "drive_effort",
            Self::SpringForce(_) => "spring_force",
            Self::ActuatorEffort(_) => "actuator_effort",
            Self::Modal(_) => "modal",
            Self::Energy => "energy",
        }
    }

    /// Places `body/interface` whose motion or force it shows, or what turns with them, without loading them.
    pub fn observes(&self, scene: &Scene) -> Vec<String> {
        let of_joint = |name: &str| scene.joints.get(name).and_then(Joint::attachments);
        match self {
            Self::Position(of)
            | Self::Displacement(of)
            | Self::Velocity(of)
            | Self::Acceleration(of)
            | Self::Orientation(of)
            | Self::AngularVelocity(of)
            | Self::InterfaceForce(of) => vec![of.at.clone()],
            Self::ChordDeflection(of) => {
                let ends = of.between.iter();
                ends.map(|end| format!("{}/{end}", of.body)).collect()
            }
            Self::JointCoordinate(of) | Self::JointRate(of) => {
                let places = of_joint(&of.joint).into_iter().flatten();
                places.map(str::to_owned).collect()
            }
            // Its axes turn with the place.
            Self::Reaction(of) => {
                let turning = of_joint(&of.joint).and_then(|[a, b]| match of.axes {
                    ReactionAxes::World => None,
                    ReactionAxes::First => Some(a.to_owned()),
                    ReactionAxes::Second => Some(b.to_owned()),
                });
                turning.into_iter().collect()
            }
            Self::NodeDisplacement(_)
            | Self::NodePosition(_)
            | Self::DriveEffort(_)
            | Self::SpringForce(_)
            | Self::ActuatorEffort(_)
            | Self::Modal(_)
            | Self::Energy => Vec::new(),
        }
    }

    /// The body and the node of its mesh that it looks at.
    pub fn node(&self) -> Option<(&str, u32)> {
        match self {
            Self::ChordDeflection(of) => Some((&of.body, of.node)),
            Self::NodeDisplacement(of) | Self::NodePosition(of) => Some((&of.body, of.node)),
            _ => None,
        }
    }

    pub(super) fn check(&self, location: &str, checker: &Checker) -> Result<(), Error> {
        let location = format!("{location}.{}", self.kind());
        match self {
            Self::Position(place)
            | Self::Displacement(place)
            | Self::Velocity(place)
            | Self::Acceleration(place)
            | Self::Orientation(place)
            | Self::AngularVelocity(place) => {
                checker.attachment(&format!("{location}.at"), &place.at)?;
                Ok(())
            }
            Self::InterfaceForce(place) => {
                let at = format!("{location}.at");
                match checker.attachment(&at, &place.at)?.body() {
                    Some(body) => checker.superelement(&at, body),
                    None => Err(Error::described(
                        at,
                        "is on the ground; expected an interface of a superelement",
                    )),
                }
            }
            Self::ChordDeflection(chord) => {
                checker.superelement(&format!("{location}.body"), &chord.body)?;
                let [first, second] = &chord.between;
                if first == second {
                    return Err(Error::described(
                        format!("{location}.between"),
                        format!("names {first:?} twice; expected two interfaces"),
                    ));
                }
                Ok(())
            }
            Self::NodeDisplacement(MeshNode { body, .. })
            | Self::NodePosition(MeshNode { body, .. })
            | Self::Modal(OfBody { body }) => {
                checker.superelement(&format!("{location}.body"), body)
            }
            Self::JointCoordinate(OfJoint { joint }) | Self::JointRate(OfJoint { joint }) => {
                let at = format!("{location}.joint");
                let found = checker.joint(&at, joint)?;
                if found.has_angle() || found.has_length() {
                    return Ok(());
                }
                Err(Error::described(
                    at,
                    format!(
                        "joint {joint:?} is {}, which has no coordinate; \
                         expected a revolute, prismatic, cylindrical or distance joint",
                        found.kind()
                    ),
                ))
            }
            Self::Reaction(Reaction { joint, .. }) => {
                checker.joint(&format!("{location}.joint"), joint)?;
                Ok(())
            }
            Self::DriveEffort(OfDrive { drive }) => {
                checker.drive(&format!("{location}.drive"), drive)
            }
            Self::SpringForce(OfSpring { spring }) => {
                checker.spring(&format!("{location}.spring"), spring)
            }
            Self::ActuatorEffort(OfActuator { actuator }) => {
                checker.actuator(&format!("{location}.actuator"), actuator)
            }
            Self::Energy => Ok(()),
        }
    }
}

impl Record {
    pub(super) fn check(&self, end: Option<f64>) -> Result<(), Error> {
        match *self {
            Self::Every(0) => Err(Error::described(
                "record.every",
                "is 0, expected a number of steps from 1",
            )),
            Self::Every(_) => Ok(()),
            Self::Interval(interval) => often("record.interval", interval, end),
        }
    }
}

/// Times that a scene may ask for.
const MOST_TIMES: f64 = 1e9;

/// An interval of time, not so short that nobody could wait for its records.
fn often(location: &str, interval: f64, end: Option<f64>) -> Result<(), Error> {
    positive(location, interval)?;
    match end {
        Some(end) if end > MOST_TIMES * interval => Err(Error::described(
            location,
            format!(
                "is {interval:?}: {:.0e} times up to the end at {end}; expected at most {MOST_TIMES:.0e}, an interval of {:.1e} or more",
                end / interval,
                end / MOST_TIMES
            ),
        )),
        _ => Ok(()),
    }
}

impl FieldRequest {
    pub(super) fn check(
        &self,
        location: &str,
        checker: &Checker,
        end: Option<f64>,
    ) -> Result<(), Error> {
        checker.superelement(&format!("{location}.body"), &self.body)?;
        if self.directory.as_os_str().is_empty() {
            return Err(Error::described(
                format!("{location}.directory"),
                "is empty; expected a folder",
            ));
        }
        let times = match (&self.times, self.every) {
            (None, Some(interval)) => return often(&format!("{location}.every"), interval, end),
            (Some(times), None) => times,
            _ => {
                return Err(Error::described(
                    location,
                    "needs exactly one of `times` and `every`",
                ));
            }
        };
        let mut before = None;
        for (index, &time) in times.iter().enumerate() {
            let at = format!("{location}.times[{index}]");
            finite(&at, time)?;
            if time < 0.0 || before.is_some_and(|before| time <= before) {
                return Err(Error::described(
                    at,
                    format!("is {time}; the times must not be negative and must strictly increase"),
                ));
            }
            before = Some(time);
        }
        Ok(())
    }
}
