//! `component.dofs`: the directions of every node, or the owner of every row.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::{Deserializer, Error as _, IgnoredAny, SeqAccess, Visitor};

use super::DofLayout;
use super::values::{DirectionName, DirectionVisitor, NodeId, json_value};
use crate::mesh::{Direction, Dof, MatrixRow};

/// Name of a row that belongs to no node.
const INTERNAL: &str = "internal";
/// Names that the entries of a table may have.
const OWNERS: [&str; 7] = ["ux", "uy", "uz", "rx", "ry", "rz", INTERNAL];

/// The dof pattern of every node, or a table with one entry per matrix row.
#[derive(Debug)]
pub struct Dofs(pub DofLayout);

json_value!(Dofs, DofsVisitor, deserialize_seq, {
    "oneOf": [
        { "type": "array", "minItems": 1, "maxItems": 6, "uniqueItems": true,
          "items": { "enum": ["ux", "uy", "uz", "rx", "ry", "rz"] } },
        { "type": "array", "minItems": 1, "items": { "oneOf": [
            { "type": "array", "minItems": 2, "maxItems": 2,
              "prefixItems": [{ "type": "integer", "minimum": 0 }, { "enum": ["ux", "uy", "uz", "rx", "ry", "rz"] }] },
            { "type": "array", "minItems": 2, "maxItems": 2, "prefixItems": [{ "type": "null" }, { "const": "internal" }] }
        ] } }
    ]
});

struct DofsVisitor;

impl<'de> Visitor<'de> for DofsVisitor {
    type Value = Dofs;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a pattern such as [\"ux\", \"uy\", \"uz\"] or a table [[node, \"ux\"], ...]")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Dofs, A::Error> {
        let (mut pattern, mut table) = (Vec::new(), Vec::new());
        loop {
            let entry = pattern.len() + table.len();
            let next = list
                .next_element::<DofEntry>()
                .map_err(|error| A::Error::custom(format_args!("dofs[{entry}]: {error}")))?;
            match next {
                None => break,
                Some(DofEntry::Pattern(direction)) => pattern.push(direction),
                Some(DofEntry::Table(owner)) => table.push(owner),
            }
            if !pattern.is_empty() && !table.is_empty() {
                return Err(A::Error::custom(format_args!(
                    "dofs[{entry}]: names and [node, name] pairs can't be mixed; expected {}",
                    &self as &dyn serde::de::Expected
                )));
            }
        }
        Ok(Dofs(if table.is_empty() {
            DofLayout::Pattern(pattern)
        } else {
            DofLayout::Table(table)
        }))
    }
}

enum DofEntry {
    Pattern(Direction),
    Table(MatrixRow),
}

impl<'de> Deserialize<'de> for DofEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(DofEntryVisitor)
    }
}

struct DofEntryVisitor;

impl<'de> Visitor<'de> for DofEntryVisitor {
    type Value = DofEntry;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a name from ux uy uz rx ry rz or a pair [node, name]")
    }

    fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<DofEntry, E> {
        if name == INTERNAL {
            return Err(E::custom(
                "a pattern has the directions of every node, and `internal` is none; give a table with one entry for each row of \
                 the matrices, [node, \"ux\"] for a row of a node and [null, \"internal\"] for a row of no node",
            ));
        }
        DirectionVisitor
            .visit_str(name)
            .map(|DirectionName(direction)| DofEntry::Pattern(direction))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut pair: A) -> Result<DofEntry, A::Error> {
        let node: Option<NodeId> = pair
            .next_element()?
            .ok_or_else(|| A::Error::invalid_length(0, &self))?;
        let OwnerName(name) = pair
            .next_element()?
            .ok_or_else(|| A::Error::invalid_length(1, &self))?;
        if pair.next_element::<IgnoredAny>()?.is_some() {
            return Err(A::Error::custom(
                "a dof is a pair [node, name], found more than two entries",
            ));
        }
        match (node, name) {
            (Some(NodeId(node)), Some(direction)) => {
                Ok(DofEntry::Table(Dof { node, direction }.into()))
            }
            (None, None) => Ok(DofEntry::Table(MatrixRow::Internal)),
            (None, Some(direction)) => {
                let name = direction.name();
                Err(A::Error::custom(format_args!(
                    "{name} is a direction of a node, but the node is null; expected [node, {name:?}], or [null, \"internal\"] \
                     for a row of no node"
                )))
            }
            (Some(NodeId(node)), None) => Err(A::Error::custom(format_args!(
                "an internal row belongs to no node, found node {node}; expected [null, \"internal\"], or [{node}, \"ux\"] for a \
                 row of the node"
            ))),
        }
    }
}

/// The name of a direction; `None` for `internal`.
struct OwnerName(Option<Direction>);

impl<'de> Deserialize<'de> for OwnerName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_str(OwnerNameVisitor)
    }
}

struct OwnerNameVisitor;

impl Visitor<'_> for OwnerNameVisitor {
    type Value = OwnerName;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("one of ux uy uz rx ry rz internal")
    }

    fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<OwnerName, E> {
        match name {
            INTERNAL => Ok(OwnerName(None)),
            _ => match Direction::from_name(name) {
                Some(direction) => Ok(OwnerName(Some(direction))),
                None => Err(E::unknown_variant(name, &OWNERS)),
            },
        }
    }
}
