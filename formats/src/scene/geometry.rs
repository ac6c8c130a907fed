//! What a body or the ground looks like in pictures. It has no influence on the motion.

use std::path::{Component, Path, PathBuf};

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::Checker;
use super::values::{in_space, positive};
use super::{Orientation, Placement};
use crate::Error;

/// A solid of a picture: what it is, and where it is in the frame of its body's component.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "GeometryPart", into = "GeometryPart")]
#[schemars(with = "GeometryPart")]
pub struct Geometry {
    /// What it is.
    pub kind: GeometryKind,
    /// Centre of a box, cylinder or ball, origin of a file; zero where `None`.
    pub position: Option<Vec<f64>>,
    /// Axes of the solid to axes of the component; parallel where `None`.
    pub orientation: Option<Orientation>,
    /// `#rrggbb`; the body's colour where `None`.
    pub color: Option<String>,
}

/// The kinds of solids.
#[derive(Clone, Debug, PartialEq)]
pub enum GeometryKind {
    /// A cuboid with these sides. In a planar scene the third is its thickness.
    Box([f64; 3]),
    /// A cylinder.
    Cylinder(Cylinder),
    /// A ball.
    Sphere(Sphere),
    /// Triangles of an STL or OBJ file.
    File {
        /// Inside the folder of the scene.
        file: PathBuf,
        /// Length in the scene's units of one unit of the file.
        scale: f64,
    },
}

/// A cylinder about z through its position, or between two places.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cylinder {
    /// Its radius.
    pub radius: f64,
    /// Its length along z of its axes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length: Option<f64>,
    /// Centre of its first end, in place of `length`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<Vec<f64>>,
    /// Centre of its other end, in place of `length`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to: Option<Vec<f64>>,
}

/// A ball.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sphere {
    /// Its radius.
    pub radius: f64,
}

impl Cylinder {
    /// Its two ends where it has them.
    pub fn ends(&self) -> Option<[Vector3<f64>; 2]> {
        let (from, to) = self.from.as_deref().zip(self.to.as_deref())?;
        Some([in_space(from), in_space(to)])
    }

    fn check(&self, at: &str, checker: &Checker) -> Result<(), Error> {
        positive(&format!("{at}.radius"), self.radius)?;
        match (self.length, &self.from, &self.to) {
            (Some(length), None, None) => positive(&format!("{at}.length"), length),
            (None, Some(from), Some(to)) => {
                checker.vector(&format!("{at}.from"), from)?;
                checker.vector(&format!("{at}.to"), to)?;
                match from == to {
                    true => Err(Error::described(
                        format!("{at}.to"),
                        "is where `from` is; expected another place",
                    )),
                    false => Ok(()),
                }
            }
            _ => Err(Error::described(
                at,
                "needs either `length`, or `from` and `to`",
            )),
        }
    }
}

impl Geometry {
    /// Place and axes in the component's frame; of a solid that has been checked.
    pub fn placement(&self) -> Placement {
        Placement {
            position: in_space(self.position.as_deref().unwrap_or_default()),
            orientation: self
                .orientation
                .map_or_else(nalgebra::UnitQuaternion::identity, |given| given.rotation()),
            velocity: Vector3::zeros(),
            angular_velocity: Vector3::zeros(),
        }
    }

    pub(super) fn check(&self, at: &str, checker: &Checker) -> Result<(), Error> {
        if let Some(position) = &self.position {
            checker.vector(&format!("{at}.position"), position)?;
        }
        if let Some(orientation) = &self.orientation {
            orientation.check(&format!("{at}.orientation"), checker)?;
        }
        if let Some(color) = self.color.as_deref().filter(|color| !is_color(color)) {
            return Err(Error::described(
                format!("{at}.color"),
                format!("is {color:?}, expected for example \"#b0b8c4\""),
            ));
        }
        match &self.kind {
            GeometryKind::Box(sides) => sides
                .iter()
                .try_for_each(|side| positive(&format!("{at}.box"), *side)),
            GeometryKind::Cylinder(cylinder) => cylinder.check(&format!("{at}.cylinder"), checker),
            GeometryKind::Sphere(sphere) => positive(&format!("{at}.sphere.radius"), sphere.radius),
            GeometryKind::File { file, scale } => {
                positive(&format!("{at}.scale"), *scale)?;
                match is_inside(file) {
                    true => Ok(()),
                    false => Err(Error::described(
                        format!("{at}.file"),
                        format!(
                            "is {:?}, expected an .stl or .obj file in the folder of the scene, without `..`",
                            file.display().to_string()
                        ),
                    )),
                }
            }
        }
    }
}

fn is_color(text: &str) -> bool {
    let digits = text.strip_prefix('#').unwrap_or_default();
    digits.len() == 6 && digits.bytes().all(|digit| digit.is_ascii_hexdigit())
}

/// A scene may come from a stranger: what it draws lies beside it.
fn is_inside(file: &Path) -> bool {
    let mut parts = file.components().peekable();
    parts.peek().is_some() && parts.all(|part| matches!(part, Component::Normal(_)))
}

/// One solid: exactly one of `box`, `cylinder`, `sphere` and `file`, and where it is.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Geometry", extend("oneOf" = [{"required": ["box"]}, {"required": ["cylinder"]}, {"required": ["sphere"]}, {"required": ["file"]}]))]
struct GeometryPart {
    /// Sides of a cuboid about its position.
    #[serde(rename = "box", default, skip_serializing_if = "Option::is_none")]
    sides: Option<[f64; 3]>,
    /// A cylinder about z through its position, or between two places.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    cylinder: Option<Cylinder>,
    /// A ball about its position.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sphere: Option<Sphere>,
    /// An STL or OBJ file in the folder of the scene.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    file: Option<PathBuf>,
    /// Length in the scene's units of one unit of the file; 1 where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    scale: Option<f64>,
    /// In the frame of the body's component (ground: world); zero where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    position: Option<Vec<f64>>,
    /// Axes of the solid to axes of the component: angle in rad, or quaternion [w, x, y, z].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    orientation: Option<Orientation>,
    /// `#rrggbb`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    color: Option<String>,
}

impl TryFrom<GeometryPart> for Geometry {
    type Error = String;

    fn try_from(part: GeometryPart) -> Result<Self, String> {
        if part.scale.is_some() && part.file.is_none() {
            return Err("`scale` is for a `file` alone".into());
        }
        let kind = match (part.sides, part.cylinder, part.sphere, part.file) {
            (Some(sides), None, None, None) => GeometryKind::Box(sides),
            (None, Some(cylinder), None, None) => GeometryKind::Cylinder(cylinder),
            (None, None, Some(sphere), None) => GeometryKind::Sphere(sphere),
            (None, None, None, Some(file)) => GeometryKind::File {
                file,
                scale: part.scale.unwrap_or(1.0),
            },
            _ => {
                return Err(
                    "a solid of a geometry has exactly one of `box`, `cylinder`, `sphere` and `file`; for example {\"box\": [0.1, 0.05, 0.05]}"
                        .into(),
                );
            }
        };
        Ok(Self {
            kind,
            position: part.position,
            orientation: part.orientation,
            color: part.color,
        })
    }
}

impl From<Geometry> for GeometryPart {
    fn from(geometry: Geometry) -> Self {
        let placed = Self {
            position: geometry.position,
            orientation: geometry.orientation,
            color: geometry.color,
            ..Self::default()
        };
        match geometry.kind {
            GeometryKind::Box(sides) => Self {
                sides: Some(sides),
                ..placed
            },
            GeometryKind::Cylinder(cylinder) => Self {
                cylinder: Some(cylinder),
                ..placed
            },
            GeometryKind::Sphere(sphere) => Self {
                sphere: Some(sphere),
                ..placed
            },
            GeometryKind::File { file, scale } => Self {
                file: Some(file),
                scale: Some(scale),
                ..placed
            },
        }
    }
}
