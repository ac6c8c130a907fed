//! A body of an assembly: a superelement or a rigid body, its placement, and whether it is mirrored.

use std::path::PathBuf;

use nalgebra::{Matrix3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scene::{Body, BodyKind, Orientation, RigidBody, SuperelementBody};

/// The component's axis across the mirror: the plane goes through the component's origin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Mirror {
    /// The plane x = 0.
    X,
    /// The plane y = 0.
    Y,
    /// The plane z = 0.
    Z,
}

impl Mirror {
    /// The reflection in component axes.
    pub fn reflection(self) -> Matrix3<f64> {
        let mut diagonal = Vector3::repeat(1.0);
        diagonal[self as usize] = -1.0;
        Matrix3::from_diagonal(&diagonal)
    }
}

/// One body: exactly one of `superelement` and `rigid`, and where it is.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "AssemblyBody", extend("oneOf" = [{"required": ["superelement"]}, {"required": ["rigid"]}]))]
pub(super) struct BodyPart {
    /// Path of a `.dcb.h5` file; a relative path starts at the folder of the assembly.
    #[serde(default)]
    superelement: Option<PathBuf>,
    /// A rigid body: an inertia zero makes it a point mass.
    #[serde(default)]
    rigid: Option<RigidBody>,
    /// The body is the mirror image of the component, across the plane through its origin with this normal; then it is turned and placed.
    #[serde(default)]
    mirror: Option<Mirror>,
    /// Origin of the component's frame in axes of the assembly; zero where absent.
    #[serde(default)]
    position: Option<Vec<f64>>,
    /// Component axes to axes of the assembly: angle in rad, or quaternion [w, x, y, z].
    #[serde(default)]
    orientation: Option<Orientation>,
}

impl BodyPart {
    /// The body of a scene, and its mirror.
    ///
    /// # Errors
    /// Why it is none.
    pub(super) fn into_body(self) -> Result<(Body, Option<Mirror>), String> {
        let kind = match (self.superelement, self.rigid) {
            (Some(file), None) => BodyKind::Superelement(SuperelementBody {
                file,
                ..SuperelementBody::default()
            }),
            (None, Some(_)) if self.mirror.is_some() => {
                return Err(
                    "a rigid body isn't mirrored; give the mirrored inertia and points".into(),
                );
            }
            (None, Some(rigid)) => BodyKind::Rigid(rigid),
            (Some(_), Some(_)) => {
                return Err("a body has one of `superelement` and `rigid`, found both".into());
            }
            (None, None) => {
                return Err("a body needs one of `superelement` and `rigid`, found none; add for example \"superelement\": \"arm.dcb.h5\"".into());
            }
        };
        let body = Body {
            position: self.position,
            orientation: self.orientation,
            ..Body::at_origin(kind)
        };
        Ok((body, self.mirror))
    }
}
