//! Springs with dampers: between two places, about the axis of a joint, or in all directions.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Characteristic;
use super::check::{Checker, finite};
use super::gear::with_angle;
use super::values::positive;
use crate::Error;
use crate::named::object;

/// One spring.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Spring {
    /// Along the line between two places.
    #[serde(deserialize_with = "object")]
    Spring(LineSpring),
    /// About the axis of a joint.
    #[serde(deserialize_with = "object")]
    TorsionSpring(TorsionSpring),
    /// Between two frames, in every direction of the first one's axes.
    #[serde(deserialize_with = "object")]
    Bushing(Bushing),
}

/// A spring and damper along the line between two places; pulls where longer than its free length.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LineSpring {
    /// First place.
    pub a: String,
    /// Second place.
    pub b: String,
    /// Force per elongation, or a table [[elongation, force], ...].
    #[serde(default)]
    pub stiffness: Characteristic,
    /// Force per rate of elongation, or a table [[rate, force], ...].
    #[serde(default)]
    pub damping: Characteristic,
    /// Length without force of the spring; as placed at the start where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub free_length: Option<f64>,
}

/// A spring and damper about the axis of a revolute or cylindrical joint; turns b back towards the free angle.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TorsionSpring {
    /// Name of the joint.
    pub joint: String,
    /// Moment per angle, or a table [[angle, moment], ...].
    #[serde(default)]
    pub stiffness: Characteristic,
    /// Moment per rate, or a table [[rate, moment], ...].
    #[serde(default)]
    pub damping: Characteristic,
    /// Angle of the joint without moment of the spring, rad; as placed at the start where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub free_angle: Option<f64>,
}

/// Springs and dampers in all directions; directions are the axes of a, free as placed at the start.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bushing {
    /// First place.
    pub a: String,
    /// Second place.
    pub b: String,
    /// Stiffness in each direction: 2 (planar) or 3; none where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub translation: Option<Vec<Characteristic>>,
    /// Stiffness about each axis: 1 (planar) or 3; none where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation: Option<Vec<Characteristic>>,
    /// Damping in each direction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub translation_damping: Option<Vec<Characteristic>>,
    /// Damping about each axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation_damping: Option<Vec<Characteristic>>,
}

impl Spring {
    pub(super) fn check(&self, location: &str, checker: &Checker) -> Result<(), Error> {
        match self {
            Self::Spring(spring) => {
                let location = format!("{location}.spring");
                checker.connection(&location, &spring.a, &spring.b)?;
                spring.stiffness.check(&format!("{location}.stiffness"))?;
                spring.damping.check(&format!("{location}.damping"))?;
                match spring.free_length {
                    Some(length) => positive(&format!("{location}.free_length"), length),
                    None => Ok(()),
                }
            }
            Self::TorsionSpring(spring) => {
                let location = format!("{location}.torsion_spring");
                with_angle(&format!("{location}.joint"), &spring.joint, checker)?;
                spring.stiffness.check(&format!("{location}.stiffness"))?;
                spring.damping.check(&format!("{location}.damping"))?;
                match spring.free_angle {
                    Some(angle) => finite(&format!("{location}.free_angle"), angle),
                    None => Ok(()),
                }
            }
            Self::Bushing(bushing) => bushing.check(&format!("{location}.bushing"), checker),
        }
    }
}

impl Bushing {
    fn check(&self, location: &str, checker: &Checker) -> Result<(), Error> {
        checker.connection(location, &self.a, &self.b)?;
        checker.turns(
            &format!("{location}.a"),
            &self.a,
            "the axes of a bushing; make it `b`",
        )?;
        if self.rotation.is_some() || self.rotation_damping.is_some() {
            let b = format!("{location}.b");
            checker.turns(&b, &self.b, "the rotational part of a bushing")?;
        }
        let directions = checker.dimension_count();
        let axes = checker.rotation_count();
        for (key, count, list) in [
            ("translation", directions, &self.translation),
            ("rotation", axes, &self.rotation),
            ("translation_damping", directions, &self.translation_damping),
            ("rotation_damping", axes, &self.rotation_damping),
        ] {
            let Some(list) = list else { continue };
            if list.len() != count {
                return Err(Error::described(
                    format!("{location}.{key}"),
                    format!("has {} entries, expected {count}", list.len()),
                ));
            }
            for (index, characteristic) in list.iter().enumerate() {
                characteristic.check(&format!("{location}.{key}[{index}]"))?;
            }
        }
        Ok(())
    }
}
