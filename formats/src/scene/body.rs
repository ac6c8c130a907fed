//! Bodies of a scene: superelements and rigid bodies, and where they are at the start.

use std::path::PathBuf;

use nalgebra::{UnitQuaternion, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::{Checker, each, each_of};
use super::damping::DampingOverride;
use super::values::{in_space, positive};
use super::{AngularVelocity, Geometry, Named, Orientation, RotaryInertia};
use crate::Error;
use crate::named::{object, unique};

/// A body and its state at time zero.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "BodyPart", into = "BodyPart")]
pub struct Body {
    /// The moving thing.
    pub kind: BodyKind,
    /// Origin of the component's frame in world axes, (d); zero where `None`.
    pub position: Option<Vec<f64>>,
    /// Component axes to world axes; parallel where `None`.
    pub orientation: Option<Orientation>,
    /// Velocity of the origin of the component's frame in world axes, (d); zero where `None`.
    pub velocity: Option<Vec<f64>>,
    /// Rate of rotation in world axes; zero where `None`.
    pub angular_velocity: Option<AngularVelocity>,
    /// What it looks like in pictures, besides its mesh; no influence on the motion.
    pub geometry: Vec<Geometry>,
}

/// A flexible or a rigid body.
#[derive(Clone, Debug, PartialEq)]
pub enum BodyKind {
    /// A reduced component.
    Superelement(SuperelementBody),
    /// A rigid body.
    Rigid(RigidBody),
}

/// A reduced component and how it is used here.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SuperelementBody {
    /// The `.dcb.h5` file; a relative path starts at the folder of the scene.
    pub file: PathBuf,
    /// How many of the file's modes are used, the lowest; all where `None`. The others' flexibility stays, in the attachments.
    pub modes: Option<u32>,
    /// Damping in place of the file's.
    pub damping: Option<DampingOverride>,
    /// How the deflection changes the inertia.
    pub inertia_change: InertiaChange,
    /// Whether the file's geometric stiffening acts.
    pub geometric_stiffening: GeometricStiffening,
}

/// Mass, inertia and points of a rigid body, in the frame of its component.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RigidBody {
    /// Mass, positive.
    pub mass: f64,
    /// About the centre of mass, in component axes: a number (planar), three principal moments or a symmetric matrix. Zero about every
    /// axis: a point mass, which has no rotation.
    pub inertia: RotaryInertia,
    /// Centre of mass in component coordinates; the origin where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub center_of_mass: Option<Vec<f64>>,
    /// Places where joints, springs and loads attach.
    #[serde(default, deserialize_with = "unique")]
    pub points: Named<Point>,
}

/// A place on a rigid body or on the ground: coordinates, or an object that also has axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected coordinates, or {\"position\": [...], \"orientation\": ...}"
)]
pub enum Point {
    /// Coordinates; the axes are the body's.
    Coordinates(Vec<f64>),
    /// Coordinates and axes.
    Frame(PointFrame),
}

/// A place with axes of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointFrame {
    /// Coordinates in the frame of the body.
    pub position: Vec<f64>,
    /// Axes of the point to axes of the body.
    pub orientation: Orientation,
}

/// How far the inertia follows the deflection.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum InertiaChange {
    /// The inertia is that of the undeformed body.
    Constant,
    /// Terms linear in the deflection.
    FirstOrder,
    /// All terms: energy and momentum are conserved.
    #[default]
    SecondOrder,
}

impl InertiaChange {
    /// Name in scenes, tables and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::FirstOrder => "first-order",
            Self::SecondOrder => "second-order",
        }
    }
}

/// Whether the geometric stiffening of a superelement's file acts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum GeometricStiffening {
    /// The stiffening that the file has.
    #[default]
    Stored,
    /// None: the linear theory.
    Off,
}

/// A frame at time zero in three dimensions; planar scenes move in the plane z = 0 and turn about z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Origin of the component's frame, world axes.
    pub position: Vector3<f64>,
    /// Component axes to world axes.
    pub orientation: UnitQuaternion<f64>,
    /// Velocity of the origin, world axes.
    pub velocity: Vector3<f64>,
    /// Rate of rotation, world axes.
    pub angular_velocity: Vector3<f64>,
}

impl Body {
    /// A body of this kind at rest, with its component's frame on the world's.
    pub fn at_origin(kind: BodyKind) -> Self {
        Self {
            kind,
            position: None,
            orientation: None,
            velocity: None,
            angular_velocity: None,
            geometry: Vec::new(),
        }
    }

    /// The state at time zero; of a body that has been checked.
    pub fn placement(&self) -> Placement {
        Placement {
            position: in_space(self.position.as_deref().unwrap_or_default()),
            orientation: self
                .orientation
                .map_or_else(UnitQuaternion::identity, |given| given.rotation()),
            velocity: in_space(self.velocity.as_deref().unwrap_or_default()),
            angular_velocity: self
                .angular_velocity
                .map_or_else(Vector3::zeros, |given| given.components()),
        }
    }

    pub(super) fn check(&self, location: &str, checker: &Checker) -> Result<(), Error> {
        for (key, vector) in [("position", &self.position), ("velocity", &self.velocity)] {
            if let Some(vector) = vector {
                checker.vector(&format!("{location}.{key}"), vector)?;
            }
        }
        if let Some(orientation) = &self.orientation {
            orientation.check(&format!("{location}.orientation"), checker)?;
        }
        if let Some(rate) = &self.angular_velocity {
            rate.check(&format!("{location}.angular_velocity"), checker)?;
        }
        each_of(
            &format!("{location}.geometry"),
            &self.geometry,
            |at, solid| solid.check(at, checker),
        )?;
        match &self.kind {
            BodyKind::Rigid(rigid) => {
                let spins = self.placement().angular_velocity != Vector3::zeros();
                if spins && rigid.is_point_mass() {
                    return Err(Error::described(
                        format!("{location}.angular_velocity"),
                        "is of a point mass (its `inertia` is zero), which doesn't turn; leave it out, or give the body an inertia",
                    ));
                }
                rigid.check(&format!("{location}.rigid"), checker)
            }
            BodyKind::Superelement(superelement) => superelement.check(location),
        }
    }
}

impl SuperelementBody {
    fn check(&self, location: &str) -> Result<(), Error> {
        if self.file.as_os_str().is_empty() {
            return Err(Error::described(
                format!("{location}.superelement"),
                "is empty; expected the path of a .dcb.h5 file",
            ));
        }
        match &self.damping {
            None => Ok(()),
            Some(damping) => damping.check(&format!("{location}.damping")),
        }
    }
}

impl RigidBody {
    fn check(&self, location: &str, checker: &Checker) -> Result<(), Error> {
        positive(&format!("{location}.mass"), self.mass)?;
        self.inertia
            .check(&format!("{location}.inertia"), checker)?;
        if let Some(center) = &self.center_of_mass {
            checker.vector(&format!("{location}.center_of_mass"), center)?;
        }
        each(
            &format!("{location}.points"),
            &self.points,
            |location, point| point.check(location, checker),
        )?;
        match self.is_point_mass() {
            true => self.check_points_of_mass(location),
            false => Ok(()),
        }
    }
}

impl Point {
    /// Coordinates in the frame of the body; z is zero where planar.
    pub fn position(&self) -> Vector3<f64> {
        in_space(match self {
            Self::Coordinates(position) => position,
            Self::Frame(frame) => &frame.position,
        })
    }

    /// Axes of the point to axes of the body.
    pub fn rotation(&self) -> UnitQuaternion<f64> {
        match self {
            Self::Coordinates(_) => UnitQuaternion::identity(),
            Self::Frame(frame) => frame.orientation.rotation(),
        }
    }

    pub(super) fn check(&self, location: &str, checker: &Checker) -> Result<(), Error> {
        match self {
            Self::Coordinates(position) => checker.vector(location, position),
            Self::Frame(PointFrame {
                position,
                orientation,
            }) => {
                checker.vector(&format!("{location}.position"), position)?;
                orientation.check(&format!("{location}.orientation"), checker)
            }
        }
    }
}

/// One body: exactly one of `superelement` and `rigid`, and the state at time zero.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Body", extend("oneOf" = [{"required": ["superelement"]}, {"required": ["rigid"]}]))]
struct BodyPart {
    /// Path of a `.dcb.h5` file; a relative path starts at the folder of the scene.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    superelement: Option<PathBuf>,
    /// A rigid body.
    #[serde(
        default,
        deserialize_with = "some_object",
        skip_serializing_if = "Option::is_none"
    )]
    rigid: Option<RigidBody>,
    /// How many modes of the superelement are used, the lowest; all where absent. The flexibility of the others is kept in the
    /// attachments.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    modes: Option<u32>,
    /// Damping in place of the superelement's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    damping: Option<DampingOverride>,
    /// How the deflection of the superelement changes its inertia; `second-order` where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    inertia_change: Option<InertiaChange>,
    /// Whether the superelement's geometric stiffening acts, where its file has any; `stored` where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    geometric_stiffening: Option<GeometricStiffening>,
    /// Origin of the component's frame, world axes; zero where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    position: Option<Vec<f64>>,
    /// Component axes to world axes: angle in rad, or quaternion [w, x, y, z].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    orientation: Option<Orientation>,
    /// Velocity of the origin of the component's frame, world axes; zero where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    velocity: Option<Vec<f64>>,
    /// World axes; zero where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    angular_velocity: Option<AngularVelocity>,
    /// What the body looks like in pictures; no influence on the motion.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    geometry: Vec<Geometry>,
}

fn some_object<'de, D: serde::Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<RigidBody>, D::Error> {
    object(deserializer).map(Some)
}

impl TryFrom<BodyPart> for Body {
    type Error = String;

    fn try_from(part: BodyPart) -> Result<Self, String> {
        let kind = match (part.superelement, part.rigid) {
            (Some(file), None) => BodyKind::Superelement(SuperelementBody {
                file,
                modes: part.modes,
                damping: part.damping,
                inertia_change: part.inertia_change.unwrap_or_default(),
                geometric_stiffening: part.geometric_stiffening.unwrap_or_default(),
            }),
            (None, Some(_)) if part.modes.is_some() => {
                return Err("a rigid body has no `modes`".into());
            }
            (None, Some(_)) if part.damping.is_some() => {
                return Err("a rigid body has no `damping`".into());
            }
            (None, Some(_)) if part.inertia_change.is_some() => {
                return Err("a rigid body has no `inertia_change`".into());
            }
            (None, Some(_)) if part.geometric_stiffening.is_some() => {
                return Err("a rigid body has no `geometric_stiffening`".into());
            }
            (None, Some(rigid)) => BodyKind::Rigid(rigid),
            (Some(_), Some(_)) => {
                return Err("a body has one of `superelement` and `rigid`, found both".into());
            }
            (None, None) => {
                return Err(
                    "a body needs one of `superelement` and `rigid`, found none; add for example \
                     \"superelement\": \"rod.dcb.h5\""
                        .into(),
                );
            }
        };
        Ok(Self {
            kind,
            position: part.position,
            orientation: part.orientation,
            velocity: part.velocity,
            angular_velocity: part.angular_velocity,
            geometry: part.geometry,
        })
    }
}

impl From<Body> for BodyPart {
    fn from(body: Body) -> Self {
        let state = Self {
            position: body.position,
            orientation: body.orientation,
            velocity: body.velocity,
            angular_velocity: body.angular_velocity,
            geometry: body.geometry,
            ..Self::default()
        };
        match body.kind {
            BodyKind::Rigid(rigid) => Self {
                rigid: Some(rigid),
                ..state
            },
            BodyKind::Superelement(superelement) => Self {
                superelement: Some(superelement.file),
                modes: superelement.modes,
                damping: superelement.damping,
                inertia_change: (superelement.inertia_change != InertiaChange::default())
                    .then_some(superelement.inertia_change),
                geometric_stiffening: (superelement.geometric_stiffening
                    != GeometricStiffening::default())
                .then_some(superelement.geometric_stiffening),
                ..state
            },
        }
    }
}
