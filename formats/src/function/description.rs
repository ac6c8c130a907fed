//! Functions of time as a scene writes them: a number, or an object with one key that names the kind.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserialize, Deserializer, Error as _, MapAccess, Visitor};
use serde::{Deserialize as DeriveDeserialize, Serialize};

use super::chirp::Chirp;
use super::formula_text::FormulaText;
use super::pulse::Pulse;
use super::smooth_step::SmoothStep;
use super::trapezoid::Trapezoid;
use crate::Error;
use crate::named::Object;

/// A scalar function of time.
///
/// In JSON a bare number, or an object with one of the keys `constant`, `polynomial`, `harmonic`, `table`, `smooth_step`, `trapezoid`, `chirp`,
/// `pulse`, `formula`, `input`; for actuators also `controller`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Function {
    /// The same value at all times.
    Constant(f64),
    /// Σ c_k tᵏ, from the constant term on.
    Polynomial(Vec<f64>),
    /// A sine.
    Harmonic(Harmonic),
    /// Values at given times.
    Table(Table),
    /// A rise in a given time.
    SmoothStep(SmoothStep),
    /// A rise within limits of speed, acceleration and jerk.
    Trapezoid(Trapezoid),
    /// A sine of sweeping frequency.
    Chirp(Chirp),
    /// A pulse, once or again and again.
    Pulse(Pulse),
    /// A formula in `t`, for example `0.5*sin(3*t)^2`.
    Formula(FormulaText),
    /// A value that the caller sets between steps.
    Input(InputSignal),
    /// What a controller of the scene computes, by its name; for actuators.
    Controller(String),
}

/// offset + amplitude · sin(ω t + phase); exactly one of the two frequencies is given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, DeriveDeserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{"required": ["frequency_hz"]}, {"required": ["angular_frequency"]}]))]
pub struct Harmonic {
    /// Factor of the sine.
    pub amplitude: f64,
    /// Cycles per time unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency_hz: Option<f64>,
    /// Radians per time unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angular_frequency: Option<f64>,
    /// Angle of the sine at time zero, rad.
    #[serde(default)]
    pub phase: f64,
    /// Value about which the sine oscillates.
    #[serde(default)]
    pub offset: f64,
}

/// Values at given times, constant before the first and after the last.
#[derive(Clone, Debug, Default, PartialEq, Serialize, DeriveDeserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// At least two, strictly increasing.
    #[schemars(extend("minItems" = 2))]
    pub times: Vec<f64>,
    /// As many as times.
    #[schemars(extend("minItems" = 2))]
    pub values: Vec<f64>,
    /// Interpolation between the points.
    #[serde(default)]
    pub interpolation: Interpolation,
}

/// How a table is continued between its points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, DeriveDeserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Interpolation {
    /// Quintics: twice continuously differentiable everywhere. The function rises, falls and rests where the table does, without overshoot.
    #[default]
    Smooth,
    /// Natural cubic spline: first and second derivative are continuous between the ends; it overshoots.
    Spline,
    /// Monotone cubics: the first derivative is continuous between the ends, without overshoot.
    Pchip,
    /// Straight lines: the first derivative jumps at every point.
    Linear,
}

/// A value from outside; held between two settings, so that its derivatives are zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, DeriveDeserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InputSignal {
    /// Value until the first setting.
    #[serde(default)]
    pub initial: f64,
}

impl Harmonic {
    /// ω, radians per time unit; the angular frequency where both are given, zero where none is.
    pub fn radians_per_time(&self) -> f64 {
        match (self.angular_frequency, self.frequency_hz) {
            (Some(omega), _) => omega,
            (None, Some(frequency)) => std::f64::consts::TAU * frequency,
            (None, None) => 0.0,
        }
    }
}

impl Function {
    /// Refuses what can't be evaluated; a formula is looked at when it is parsed.
    pub(super) fn check(&self) -> Result<(), Error> {
        match self {
            Self::Constant(value) => finite("constant", *value),
            Self::Polynomial(coefficients) if coefficients.is_empty() => Err(Error::described(
                "polynomial",
                "is an empty list; expected coefficients [c0, c1, ...]",
            )),
            Self::Polynomial(coefficients) => all_finite("polynomial", coefficients),
            Self::Harmonic(harmonic) => harmonic.check().map_err(|error| error.within("harmonic")),
            Self::Table(table) => table.check().map_err(|error| error.within("table")),
            Self::SmoothStep(law) => law.check().map_err(|error| error.within("smooth_step")),
            Self::Trapezoid(law) => law.check().map_err(|error| error.within("trapezoid")),
            Self::Chirp(law) => law.check().map_err(|error| error.within("chirp")),
            Self::Pulse(law) => law.check().map_err(|error| error.within("pulse")),
            Self::Formula(_) | Self::Controller(_) => Ok(()),
            Self::Input(input) => finite("input.initial", input.initial),
        }
    }
}

impl Harmonic {
    fn check(&self) -> Result<(), Error> {
        let (key, frequency) = match (self.frequency_hz, self.angular_frequency) {
            (Some(frequency), None) => ("frequency_hz", frequency),
            (None, Some(omega)) => ("angular_frequency", omega),
            (both, _) => {
                let found = if both.is_some() {
                    "both are"
                } else {
                    "none is"
                };
                return Err(Error::described(
                    "frequency_hz",
                    format!("one of frequency_hz and angular_frequency is expected, {found} given"),
                ));
            }
        };
        positive(key, frequency)?;
        named_finite(&[
            ("amplitude", self.amplitude),
            ("phase", self.phase),
            ("offset", self.offset),
        ])
    }
}

impl Table {
    fn check(&self) -> Result<(), Error> {
        let (times, values) = (self.times.len(), self.values.len());
        if times != values {
            return Err(Error::described(
                "values",
                format!("has {values} numbers, but times has {times}; they must be as many"),
            ));
        }
        if times < 2 {
            return Err(Error::described(
                "times",
                format!("has {times} numbers, expected at least 2"),
            ));
        }
        all_finite("times", &self.times)?;
        all_finite("values", &self.values)?;
        match self.times.windows(2).position(|pair| pair[1] <= pair[0]) {
            Some(index) => Err(Error::described(
                format!("times[{}]", index + 1),
                format!(
                    "is {}, not after {}; the times must strictly increase",
                    self.times[index + 1],
                    self.times[index]
                ),
            )),
            None => Ok(()),
        }
    }
}

fn finite(key: &str, number: f64) -> Result<(), Error> {
    if number.is_finite() {
        Ok(())
    } else {
        Err(Error::described(
            key,
            format!("is {number}, expected a finite number"),
        ))
    }
}

/// Numbers of an object.
pub(super) fn named_finite(numbers: &[(&str, f64)]) -> Result<(), Error> {
    numbers
        .iter()
        .try_for_each(|(key, number)| finite(key, *number))
}

pub(super) fn positive(key: &str, number: f64) -> Result<(), Error> {
    if number.is_finite() && number > 0.0 {
        Ok(())
    } else {
        Err(Error::described(
            key,
            format!("is {number}, expected a positive number"),
        ))
    }
}

fn all_finite(key: &str, numbers: &[f64]) -> Result<(), Error> {
    for (index, number) in numbers.iter().enumerate() {
        finite(&format!("{key}[{index}]"), *number)?;
    }
    Ok(())
}

/// Reads a function whose key may stand beside other keys of the same object.
pub(crate) struct FunctionKey;

impl FunctionKey {
    /// The kinds, as keys.
    pub(crate) const NAMES: [&'static str; 11] = [
        "constant",
        "polynomial",
        "harmonic",
        "table",
        "smooth_step",
        "trapezoid",
        "chirp",
        "pulse",
        "formula",
        "input",
        "controller",
    ];

    /// The value under a key that [`Self::NAMES`] has; `None` for other keys, whose value is then still to be read.
    pub(crate) fn read<'de, A: MapAccess<'de>>(
        key: &str,
        map: &mut A,
    ) -> Result<Option<Function>, A::Error> {
        Ok(Some(match key {
            "constant" => Function::Constant(map.next_value()?),
            "polynomial" => Function::Polynomial(map.next_value()?),
            "harmonic" => Function::Harmonic(map.next_value::<Object<_>>()?.0),
            "table" => Function::Table(map.next_value::<Object<_>>()?.0),
            "smooth_step" => Function::SmoothStep(map.next_value::<Object<_>>()?.0),
            "trapezoid" => Function::Trapezoid(map.next_value::<Object<_>>()?.0),
            "chirp" => Function::Chirp(map.next_value::<Object<_>>()?.0),
            "pulse" => Function::Pulse(map.next_value::<Object<_>>()?.0),
            "formula" => Function::Formula(map.next_value::<String>()?.into()),
            "input" => Function::Input(map.next_value::<Object<_>>()?.0),
            "controller" => Function::Controller(map.next_value()?),
            _ => return Ok(None),
        }))
    }

    /// Schemas of the kinds under their keys.
    pub(crate) fn schemas(generator: &mut SchemaGenerator) -> [(&'static str, Schema); 11] {
        let [
            constant,
            polynomial,
            harmonic,
            table,
            smooth_step,
            trapezoid,
            chirp,
            pulse,
            formula,
            input,
            controller,
        ] = Self::NAMES;
        [
            (constant, generator.subschema_for::<f64>()),
            (
                polynomial,
                json_schema!({"type": "array", "minItems": 1, "items": {"type": "number"}, "description": "Coefficients from the constant term on."}),
            ),
            (harmonic, generator.subschema_for::<Harmonic>()),
            (table, generator.subschema_for::<Table>()),
            (smooth_step, generator.subschema_for::<SmoothStep>()),
            (trapezoid, generator.subschema_for::<Trapezoid>()),
            (chirp, generator.subschema_for::<Chirp>()),
            (pulse, generator.subschema_for::<Pulse>()),
            (
                formula,
                json_schema!({"type": "string", "description": "A formula in t, for example 0.5*sin(3*t)^2."}),
            ),
            (input, generator.subschema_for::<InputSignal>()),
            (
                controller,
                json_schema!({"type": "string", "description": "Name of a controller; for the actuators torque and force."}),
            ),
        ]
    }
}

impl<'de> Deserialize<'de> for Function {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(FunctionVisitor)
    }
}

struct FunctionVisitor;

impl<'de> Visitor<'de> for FunctionVisitor {
    type Value = Function;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a number or a function such as {\"polynomial\": [0, 150]}")
    }

    fn visit_f64<E>(self, value: f64) -> Result<Function, E> {
        Ok(Function::Constant(value))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Function, E> {
        Ok(Function::Constant(value as f64))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Function, E> {
        Ok(Function::Constant(value as f64))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Function, A::Error> {
        let Some(key) = map.next_key::<String>()? else {
            return Err(A::Error::invalid_length(0, &self));
        };
        let Some(function) = FunctionKey::read(&key, &mut map)? else {
            return Err(A::Error::unknown_field(&key, &FunctionKey::NAMES));
        };
        match map.next_key::<String>()? {
            None => Ok(function),
            Some(second) => Err(A::Error::custom(format_args!(
                "a function has one kind, found `{key}` and `{second}`"
            ))),
        }
    }
}

impl JsonSchema for Function {
    fn schema_name() -> Cow<'static, str> {
        "Function".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let kinds = FunctionKey::schemas(generator).map(|(key, schema)| {
            json_schema!({
                "type": "object",
                "properties": {key: schema},
                "required": [key],
                "additionalProperties": false
            })
        });
        let mut any = vec![json_schema!({"type": "number"})];
        any.extend(kinds);
        json_schema!({
            "description": "A scalar function of time: a number, or an object with one key that names the kind.",
            "oneOf": any
        })
    }
}
