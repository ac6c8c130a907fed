//! The values of a component file that need their own reading, so that a complaint says what would be right.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::{
    Deserializer, MapAccess, SeqAccess, Unexpected, Visitor, value::MapAccessDeserializer,
};

use super::lists::Append;
use crate::component::Weights;
use crate::mesh::Direction;

/// Implements `Deserialize` with a visitor and `JsonSchema` with a fixed schema.
macro_rules! json_value {
    ($type:ident, $visitor:expr, $method:ident, $schema:tt) => {
        impl<'de> Deserialize<'de> for $type {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                deserializer.$method($visitor)
            }
        }

        impl JsonSchema for $type {
            fn inline_schema() -> bool {
                true
            }
            fn schema_name() -> Cow<'static, str> {
                stringify!($type).into()
            }
            fn json_schema(_: &mut SchemaGenerator) -> Schema {
                json_schema!($schema)
            }
        }
    };
}

pub(super) use json_value;

/// A finite number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Number(pub f64);

json_value!(Number, NumberVisitor, deserialize_f64, { "type": "number" });

impl From<Number> for f64 {
    fn from(number: Number) -> Self {
        number.0
    }
}

struct NumberVisitor;

impl Visitor<'_> for NumberVisitor {
    type Value = Number;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a finite number")
    }

    fn visit_f64<E: serde::de::Error>(self, value: f64) -> Result<Number, E> {
        if value.is_finite() {
            Ok(Number(value))
        } else {
            Err(E::invalid_value(Unexpected::Float(value), &self))
        }
    }

    fn visit_u64<E>(self, value: u64) -> Result<Number, E> {
        Ok(Number(value as f64))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Number, E> {
        Ok(Number(value as f64))
    }
}

/// A 0-based node id.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeId(pub u32);

json_value!(NodeId, NodeIdVisitor, deserialize_u64, { "type": "integer", "minimum": 0 });

impl From<NodeId> for u32 {
    fn from(node: NodeId) -> Self {
        node.0
    }
}

struct NodeIdVisitor;

impl Visitor<'_> for NodeIdVisitor {
    type Value = NodeId;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a node id (whole number from 0)")
    }

    fn visit_u64<E: serde::de::Error>(self, value: u64) -> Result<NodeId, E> {
        match u32::try_from(value) {
            Ok(node) => Ok(NodeId(node)),
            Err(_) => Err(E::invalid_value(Unexpected::Unsigned(value), &self)),
        }
    }
}

/// The name of a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionName(pub Direction);

json_value!(DirectionName, DirectionVisitor, deserialize_str, { "enum": ["ux", "uy", "uz", "rx", "ry", "rz"] });

pub(super) struct DirectionVisitor;

impl Visitor<'_> for DirectionVisitor {
    type Value = DirectionName;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("one of ux uy uz rx ry rz")
    }

    fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<DirectionName, E> {
        Direction::from_name(name)
            .map(DirectionName)
            .ok_or_else(|| E::unknown_variant(name, &Direction::NAMES))
    }
}

/// `uniform`, `area`, `mass` or one number per node.
#[derive(Debug)]
pub struct WeightsValue(pub Weights);

json_value!(WeightsValue, WeightsVisitor, deserialize_any, {
    "oneOf": [
        { "enum": ["uniform", "area", "mass"] },
        { "type": "array", "minItems": 1, "items": { "type": "number", "exclusiveMinimum": 0 } }
    ]
});

struct WeightsVisitor;

impl<'de> Visitor<'de> for WeightsVisitor {
    type Value = WeightsValue;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("\"uniform\", \"area\", \"mass\" or a list with one positive number per node")
    }

    fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<WeightsValue, E> {
        Ok(WeightsValue(match name {
            "uniform" => Weights::Uniform,
            "area" => Weights::Area,
            "mass" => Weights::Mass,
            _ => return Err(E::unknown_variant(name, &["uniform", "area", "mass"])),
        }))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<WeightsValue, A::Error> {
        let mut weights = Vec::new();
        Append::<Number, f64>::to(&mut weights, "a list of numbers").visit_seq(list)?;
        Ok(WeightsValue(Weights::Given(weights)))
    }
}

/// One ratio, or a list of them.
#[derive(Debug)]
pub enum ModalDamping {
    Uniform(f64),
    PerMode(Vec<f64>),
}

json_value!(ModalDamping, ModalDampingVisitor, deserialize_any, {
    "oneOf": [
        { "type": "number", "minimum": 0 },
        { "type": "array", "minItems": 1, "items": { "type": "number", "minimum": 0 } }
    ]
});

struct ModalDampingVisitor;

impl<'de> Visitor<'de> for ModalDampingVisitor {
    type Value = ModalDamping;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a damping ratio or a list of them")
    }

    fn visit_f64<E: serde::de::Error>(self, value: f64) -> Result<ModalDamping, E> {
        NumberVisitor
            .visit_f64(value)
            .map(|Number(ratio)| ModalDamping::Uniform(ratio))
    }

    fn visit_u64<E>(self, value: u64) -> Result<ModalDamping, E> {
        Ok(ModalDamping::Uniform(value as f64))
    }

    fn visit_i64<E>(self, value: i64) -> Result<ModalDamping, E> {
        Ok(ModalDamping::Uniform(value as f64))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<ModalDamping, A::Error> {
        let mut ratios = Vec::new();
        Append::<Number, f64>::to(&mut ratios, "a list of numbers").visit_seq(list)?;
        Ok(ModalDamping::PerMode(ratios))
    }
}

/// Both factors, or the ratios at two frequencies.
#[derive(Debug)]
pub enum RayleighDamping {
    Factors(Vec<f64>),
    Through(RayleighRatios),
}

/// Ratios to critical at frequencies in cycles per time, two of each.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RayleighRatios {
    pub frequencies: Vec<Number>,
    pub ratios: Vec<Number>,
}

json_value!(RayleighDamping, RayleighDampingVisitor, deserialize_any, {
    "oneOf": [
        { "type": "array", "minItems": 2, "maxItems": 2, "items": { "type": "number", "minimum": 0 } },
        {
            "type": "object",
            "properties": {
                "frequencies": {
                    "description": "Two frequencies, cycles per time.",
                    "type": "array", "minItems": 2, "maxItems": 2, "items": { "type": "number", "exclusiveMinimum": 0 }
                },
                "ratios": {
                    "description": "The ratio to critical at each.",
                    "type": "array", "minItems": 2, "maxItems": 2, "items": { "type": "number", "minimum": 0 }
                }
            },
            "required": ["frequencies", "ratios"],
            "additionalProperties": false
        }
    ]
});

struct RayleighDampingVisitor;

impl<'de> Visitor<'de> for RayleighDampingVisitor {
    type Value = RayleighDamping;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("[alpha, beta] or {\"frequencies\": [f1, f2], \"ratios\": [z1, z2]}")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<RayleighDamping, A::Error> {
        let mut factors = Vec::new();
        Append::<Number, f64>::to(&mut factors, "a list of numbers").visit_seq(list)?;
        Ok(RayleighDamping::Factors(factors))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<RayleighDamping, A::Error> {
        RayleighRatios::deserialize(MapAccessDeserializer::new(map)).map(RayleighDamping::Through)
    }
}
