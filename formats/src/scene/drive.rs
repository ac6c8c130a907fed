//! Drives: joint coordinates as functions of time.
//!
//! The angle of a planar revolute joint is that from the axes of a to the axes of b, so that zero is where they are
//! parallel. Every other coordinate but a distance is zero as placed at the start; a distance is the distance.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserialize, Deserializer, Error as _, MapAccess, Visitor};
use serde::{Deserialize as DeriveDeserialize, Serialize};

use super::check::Checker;
use super::gear::{with_angle, with_length};
use crate::Error;
use crate::function::{Function, FunctionKey, FunctionValue, TimeFunction};

/// Motion of a joint that follows a function of time.
#[derive(Clone, Debug, PartialEq, Serialize, DeriveDeserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Drive {
    /// Angle of a revolute or cylindrical joint, rad.
    Angle(DriveFunction),
    /// Translation of a prismatic or cylindrical joint, or length of a distance joint.
    Position(DriveFunction),
    /// Rate of a revolute (rad/time), prismatic or distance joint (length/time).
    Speed(DriveFunction),
}

/// A joint and the function that its coordinate follows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DriveFunction {
    /// Name of the joint.
    pub joint: String,
    /// Function of time; in JSON its key stands beside `joint`.
    #[serde(flatten)]
    pub function: Function,
}

impl Drive {
    /// Joint and function.
    pub fn motion(&self) -> &DriveFunction {
        match self {
            Self::Angle(motion) | Self::Position(motion) | Self::Speed(motion) => motion,
        }
    }

    /// The function, to be changed.
    pub(super) fn function_mut(&mut self) -> &mut Function {
        match self {
            Self::Angle(motion) | Self::Position(motion) | Self::Speed(motion) => {
                &mut motion.function
            }
        }
    }

    /// The driven motion, as the scene writes it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Angle(_) => "angle",
            Self::Position(_) => "position",
            Self::Speed(_) => "speed",
        }
    }

    /// The driven coordinate, ready to be evaluated; of a speed its integral from time zero up to `end`, which is then
    /// the change of the coordinate.
    ///
    /// # Errors
    /// [`Error::Description`] as of [`TimeFunction::new`] and [`TimeFunction::integral_of`].
    pub fn coordinate(&self, end: f64) -> Result<TimeFunction, Error> {
        match self {
            Self::Angle(motion) | Self::Position(motion) => TimeFunction::new(&motion.function),
            Self::Speed(motion) => TimeFunction::integral_of(&motion.function, end),
        }
    }

    pub(super) fn check(
        &self,
        location: &str,
        checker: &Checker,
        end: Option<f64>,
    ) -> Result<(), Error> {
        let location = format!("{location}.{}", self.kind());
        let DriveFunction { joint, function } = self.motion();
        let at = format!("{location}.joint");
        match self {
            Self::Angle(_) => with_angle(&at, joint, checker)?,
            Self::Position(_) => with_length(&at, joint, checker)?,
            Self::Speed(_) => {
                let driven = checker.joint(&at, joint)?;
                if driven.has_angle() && driven.has_length() {
                    return Err(Error::described(
                        at,
                        format!(
                            "joint {joint:?} is cylindrical and has two speeds; drive its angle or its position"
                        ),
                    ));
                }
                match driven.has_angle() {
                    true => with_angle(&at, joint, checker)?,
                    false => with_length(&at, joint, checker)?,
                }
            }
        }
        let coordinate = match end {
            Some(end) => self.coordinate(end),
            None => TimeFunction::new(function),
        }
        .map_err(|error| error.within(&location))?;
        let initial = match function {
            Function::Input(input) => input.initial,
            _ => 0.0,
        };
        for time in [Some(0.0), end].into_iter().flatten() {
            let FunctionValue {
                value,
                rate,
                second_rate,
            } = coordinate.evaluate(time, initial);
            if ![value, rate, second_rate]
                .iter()
                .all(|number| number.is_finite())
            {
                return Err(Error::described(
                    location,
                    format!(
                        "is {value} with the derivatives {rate} and {second_rate} at t = {time}; all must be finite"
                    ),
                ));
            }
        }
        Ok(())
    }
}

impl<'de> Deserialize<'de> for DriveFunction {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(DriveVisitor)
    }
}

struct DriveVisitor;

impl<'de> Visitor<'de> for DriveVisitor {
    type Value = DriveFunction;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(
            "a joint and a function such as {\"joint\": \"axle\", \"polynomial\": [0, 150]}",
        )
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<DriveFunction, A::Error> {
        const KEYS: [&str; FunctionKey::NAMES.len() + 1] = {
            let mut keys = ["joint"; FunctionKey::NAMES.len() + 1];
            let mut index = 0;
            while index < FunctionKey::NAMES.len() {
                keys[index + 1] = FunctionKey::NAMES[index];
                index += 1;
            }
            keys
        };
        let (mut joint, mut function) = (None, None);
        while let Some(key) = map.next_key::<String>()? {
            if key == "joint" {
                if joint.replace(map.next_value::<String>()?).is_some() {
                    return Err(A::Error::duplicate_field("joint"));
                }
            } else if let Some(read) = FunctionKey::read(&key, &mut map)? {
                if function.replace(read).is_some() {
                    return Err(A::Error::custom(format_args!(
                        "one function is expected, but `{key}` is the second"
                    )));
                }
            } else {
                return Err(A::Error::unknown_field(&key, &KEYS));
            }
        }
        Ok(DriveFunction {
            joint: joint.ok_or_else(|| A::Error::missing_field("joint"))?,
            function: function.ok_or_else(|| A::Error::missing_field("polynomial"))?,
        })
    }
}

impl JsonSchema for DriveFunction {
    fn schema_name() -> Cow<'static, str> {
        "DriveFunction".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut properties = serde_json::Map::new();
        properties.insert(
            "joint".into(),
            serde_json::json!({"type": "string", "description": "Name of the joint."}),
        );
        for (key, schema) in FunctionKey::schemas(generator) {
            properties.insert(key.into(), schema.to_value());
        }
        json_schema!({
            "description": "A joint, and beside it one key that names the kind of function.",
            "type": "object",
            "properties": properties,
            "required": ["joint"],
            "minProperties": 2,
            "maxProperties": 2,
            "additionalProperties": false
        })
    }
}
