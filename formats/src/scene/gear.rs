//! Gears and racks: joints that couple the coordinates of other joints.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::{Checker, finite};
use crate::Error;

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

impl Gear {
    pub(super) fn check(&self, location: &str, checker: &Checker) -> Result<(), Error> {
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
    pub(super) fn check(&self, location: &str, checker: &Checker) -> Result<(), Error> {
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
        return checker.has_turning_angle(location, joint);
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
