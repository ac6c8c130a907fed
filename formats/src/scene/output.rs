//! Recorded quantities.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::Checker;
use super::observed::{
    AngularMomentum, AtPlace, ChordDeflection, MassPoint, MeshNode, MomentPoint, OfActuator,
    OfBody, OfDrive, OfJoint, OfMass, OfSpring, OfSuperelement, Reaction, ReactionAxes,
    StressOutput,
};
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
    /// Velocity of a node of the mesh.
    #[serde(deserialize_with = "object")]
    NodeVelocity(MeshNode),
    /// Acceleration of a node of the mesh.
    #[serde(deserialize_with = "object")]
    NodeAcceleration(MeshNode),
    /// Position of the origin of a body's frame: where its centre of mass is undeformed.
    #[serde(deserialize_with = "object")]
    BodyPosition(OfBody),
    /// Velocity of the origin of a body's frame.
    #[serde(deserialize_with = "object")]
    BodyVelocity(OfBody),
    /// Orientation of a body's frame: angle in rad (planar) or quaternion w, x, y, z.
    #[serde(deserialize_with = "object")]
    BodyOrientation(OfBody),
    /// Rate of rotation of a body's frame.
    #[serde(deserialize_with = "object")]
    BodyAngularVelocity(OfBody),
    /// Centre of mass of a body, or of all of them.
    #[serde(deserialize_with = "object")]
    CenterOfMass(OfMass),
    /// Linear momentum of a body, or of all of them.
    #[serde(deserialize_with = "object")]
    Momentum(OfMass),
    /// Angular momentum of a body, or of all of them.
    #[serde(deserialize_with = "object")]
    AngularMomentum(AngularMomentum),
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
    Modal(OfSuperelement),
    /// Stress or strain at places of a superelement, body axes.
    #[serde(deserialize_with = "object")]
    Stress(StressOutput),
    /// Kinetic, elastic and potential energy, and the work of drives, loads and dampers.
    Energy,
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
            Self::NodeVelocity(_) => "node_velocity",
            Self::NodeAcceleration(_) => "node_acceleration",
            Self::BodyPosition(_) => "body_position",
            Self::BodyVelocity(_) => "body_velocity",
            Self::BodyOrientation(_) => "body_orientation",
            Self::BodyAngularVelocity(_) => "body_angular_velocity",
            Self::CenterOfMass(_) => "center_of_mass",
            Self::Momentum(_) => "momentum",
            Self::AngularMomentum(_) => "angular_momentum",
            Self::JointCoordinate(_) => "joint_coordinate",
            Self::JointRate(_) => "joint_rate",
            Self::Reaction(_) => "reaction",
            Self::InterfaceForce(_) => "interface_force",
            Self::DriveEffort(_) => "drive_effort",
            Self::SpringForce(_) => "spring_force",
            Self::ActuatorEffort(_) => "actuator_effort",
            Self::Modal(_) => "modal",
            Self::Stress(_) => "stress",
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
            | Self::NodeVelocity(_)
            | Self::NodeAcceleration(_)
            | Self::BodyPosition(_)
            | Self::BodyVelocity(_)
            | Self::BodyOrientation(_)
            | Self::BodyAngularVelocity(_)
            | Self::CenterOfMass(_)
            | Self::Momentum(_)
            | Self::AngularMomentum(_)
            | Self::DriveEffort(_)
            | Self::SpringForce(_)
            | Self::ActuatorEffort(_)
            | Self::Modal(_)
            | Self::Stress(_)
            | Self::Energy => Vec::new(),
        }
    }

    /// The body and the node of its mesh that it looks at.
    pub fn node(&self) -> Option<(&str, u32)> {
        match self {
            Self::ChordDeflection(of) => Some((&of.body, of.node)),
            Self::NodeDisplacement(of)
            | Self::NodePosition(of)
            | Self::NodeVelocity(of)
            | Self::NodeAcceleration(of) => Some((&of.body, of.node)),
            _ => None,
        }
    }

    /// Whether it shows the motion of a body as a whole: its frame, or its mass alone or with that of the others.
    pub fn shows_whole(&self, body: &str) -> bool {
        match self {
            Self::BodyPosition(of)
            | Self::BodyVelocity(of)
            | Self::BodyOrientation(of)
            | Self::BodyAngularVelocity(of) => of.body == body,
            Self::CenterOfMass(OfMass { body: of })
            | Self::Momentum(OfMass { body: of })
            | Self::AngularMomentum(AngularMomentum { body: of, .. }) => {
                of.as_deref().is_none_or(|of| of == body)
            }
            _ => false,
        }
    }

    pub(super) fn check(&self, location: &str, checker: &Checker) -> Result<(), Error> {
        let location = format!("{location}.{}", self.kind());
        match self {
            Self::Position(place)
            | Self::Displacement(place)
            | Self::Velocity(place)
            | Self::Acceleration(place) => {
                checker.attachment(&format!("{location}.at"), &place.at)?;
                Ok(())
            }
            Self::Orientation(place) | Self::AngularVelocity(place) => {
                let at = format!("{location}.at");
                checker.attachment(&at, &place.at)?;
                checker.turns(&at, &place.at, "an output")
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
            | Self::NodeVelocity(MeshNode { body, .. })
            | Self::NodeAcceleration(MeshNode { body, .. })
            | Self::Stress(StressOutput { body, .. })
            | Self::Modal(OfSuperelement { body }) => {
                checker.superelement(&format!("{location}.body"), body)
            }
            Self::BodyPosition(OfBody { body }) | Self::BodyVelocity(OfBody { body }) => {
                checker.body(&format!("{location}.body"), body)?;
                Ok(())
            }
            Self::BodyOrientation(OfBody { body }) | Self::BodyAngularVelocity(OfBody { body }) => {
                let at = format!("{location}.body");
                checker.body(&at, body)?;
                checker.body_turns(&at, body, "an output")
            }
            Self::CenterOfMass(OfMass { body }) | Self::Momentum(OfMass { body }) => {
                of_mass(&location, body.as_deref(), checker)
            }
            Self::AngularMomentum(of) => {
                of_mass(&location, of.body.as_deref(), checker)?;
                match &of.about {
                    Some(MomentPoint::Fixed(point)) => {
                        checker.vector(&format!("{location}.about"), point)
                    }
                    Some(MomentPoint::OfMass(MassPoint::CenterOfMass)) | None => Ok(()),
                }
            }
            Self::JointCoordinate(OfJoint { joint }) | Self::JointRate(OfJoint { joint }) => {
                let at = format!("{location}.joint");
                let found = checker.joint(&at, joint)?;
                if found.has_angle() {
                    return checker.has_turning_angle(&at, found);
                }
                if found.has_length() {
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
            Self::Reaction(Reaction { joint, axes }) => {
                let found = checker.joint(&format!("{location}.joint"), joint)?;
                let turning = match (axes, found.attachments()) {
                    (ReactionAxes::First, Some([first, _])) => first,
                    (ReactionAxes::Second, Some([_, second])) => second,
                    (ReactionAxes::World, _) | (_, None) => return Ok(()),
                };
                checker.turns(&format!("{location}.axes"), turning, "axes that follow it")
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

/// Whether there is what an output weighs: a body, or any.
fn of_mass(location: &str, body: Option<&str>, checker: &Checker) -> Result<(), Error> {
    match body {
        Some(body) => checker.body(&format!("{location}.body"), body).map(|_| ()),
        None => checker.any_body(location),
    }
}
