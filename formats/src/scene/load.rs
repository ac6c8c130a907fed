//! Forces and torques that follow functions of time.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::Checker;
use crate::Error;
use crate::function::{Function, TimeFunction};
use crate::named::object;

/// One load.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Load {
    /// A force: 2 (planar) or 3 components.
    #[serde(deserialize_with = "object")]
    Force(LoadFunction),
    /// A torque: 1 (planar) or 3 components.
    #[serde(deserialize_with = "object")]
    Torque(LoadFunction),
    /// A load on the inside of a component, by its name in the superelement's file; it turns with the body.
    #[serde(deserialize_with = "object")]
    PartLoad(PartLoadFunction),
}

/// A load of a superelement's file and how large it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PartLoadFunction {
    /// The body.
    pub body: String,
    /// The load's name in the file of its superelement.
    pub load: String,
    /// Factor of the load, a function of time.
    pub factor: Function,
}

/// Where a load acts and how large it is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LoadFunction {
    /// Place on a body.
    pub at: String,
    /// One function of time per component.
    pub components: Vec<Function>,
    /// Axes of the components.
    #[serde(default)]
    pub axes: LoadAxes,
}

/// Axes of a load's components.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum LoadAxes {
    /// Fixed.
    #[default]
    World,
    /// Those of the place, which turn with it.
    Follower,
}

impl Load {
    /// The functions, to be changed.
    pub(super) fn functions_mut(&mut self) -> &mut [Function] {
        match self {
            Self::Force(load) | Self::Torque(load) => &mut load.components,
            Self::PartLoad(load) => std::slice::from_mut(&mut load.factor),
        }
    }

    pub(super) fn check(&self, location: &str, checker: &Checker) -> Result<(), Error> {
        let (kind, count, load) = match self {
            Self::PartLoad(load) => return load.check(&format!("{location}.part_load"), checker),
            Self::Force(load) => ("force", checker.dimension_count(), load),
            Self::Torque(load) => ("torque", checker.rotation_count(), load),
        };
        let location = format!("{location}.{kind}");
        let at = format!("{location}.at");
        if checker.attachment(&at, &load.at)?.body().is_none() {
            return Err(Error::described(
                at,
                "is on the ground, which doesn't move; expected a place on a body",
            ));
        }
        if kind == "torque" {
            checker.turns(&at, &load.at, "a torque")?;
        } else if load.axes == LoadAxes::Follower {
            checker.turns(&at, &load.at, "a force that follows it")?;
        }
        let components = format!("{location}.components");
        if load.components.len() != count {
            return Err(Error::described(
                components,
                format!("has {} functions, expected {count}", load.components.len()),
            ));
        }
        for (index, function) in load.components.iter().enumerate() {
            starts_finite(&format!("{components}[{index}]"), function)?;
        }
        Ok(())
    }
}

impl PartLoadFunction {
    fn check(&self, location: &str, checker: &Checker) -> Result<(), Error> {
        checker.superelement(&format!("{location}.body"), &self.body)?;
        starts_finite(&format!("{location}.factor"), &self.factor)
    }
}

fn starts_finite(place: &str, function: &Function) -> Result<(), Error> {
    let start = TimeFunction::new(function)
        .map_err(|error| error.within(place))?
        .evaluate(0.0, 0.0);
    match start.value.is_finite() {
        true => Ok(()),
        false => Err(Error::described(
            place,
            format!("is {} at t = 0; it must be finite", start.value),
        )),
    }
}
