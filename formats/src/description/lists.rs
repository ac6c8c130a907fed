//! The long lists of a component file, read straight into flat arrays; every complaint names the entry it is about.
//! Nothing is allocated from a size that the file claims.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fmt;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{
    Deserialize, DeserializeSeed, Deserializer, Error as _, IgnoredAny, MapAccess, SeqAccess,
    Visitor,
};

use super::values::{NodeId, Number, json_value};

/// Appends the entries `J` of a JSON list to a flat array and returns how many there were.
pub struct Append<'a, J, T> {
    into: &'a mut Vec<T>,
    expecting: &'static str,
    json: PhantomData<J>,
}

impl<'a, J, T> Append<'a, J, T> {
    pub fn to(into: &'a mut Vec<T>, expecting: &'static str) -> Self {
        Self {
            into,
            expecting,
            json: PhantomData,
        }
    }
}

impl<'de, J: Deserialize<'de> + Into<T>, T> DeserializeSeed<'de> for Append<'_, J, T> {
    type Value = usize;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<usize, D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de, J: Deserialize<'de> + Into<T>, T> Visitor<'de> for Append<'_, J, T> {
    type Value = usize;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.expecting)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<usize, A::Error> {
        let mut count = 0;
        while let Some(entry) = list.next_element::<J>()? {
            self.into.push(entry.into());
            count += 1;
        }
        Ok(count)
    }
}

/// Rows of equal length in one flat array, as points and the cells of a block.
fn equal_rows<'de, J, T, A>(
    rows: &mut A,
    row_name: &str,
    entry_name: &str,
    expecting: &'static str,
) -> Result<(Vec<T>, usize), A::Error>
where
    J: Deserialize<'de> + Into<T>,
    A: SeqAccess<'de>,
{
    let mut entries = Vec::new();
    let (mut row, mut length) = (0, 0);
    loop {
        let found = rows
            .next_element_seed(Append::<J, T>::to(&mut entries, expecting))
            .map_err(|error| A::Error::custom(format_args!("{row_name} {row}: {error}")))?;
        match found {
            None => break,
            Some(0) => return Err(A::Error::custom(format_args!("{row_name} {row} is empty"))),
            Some(found) if row == 0 => length = found,
            Some(found) if found != length => {
                return Err(A::Error::custom(format_args!(
                    "{row_name} {row} has {found} {entry_name}, but {row_name} 0 has {length}; all must have the same number"
                )));
            }
            Some(_) => {}
        }
        row += 1;
    }
    entries.shrink_to_fit();
    Ok((entries, length))
}

/// All points, with two or three coordinates each.
#[derive(Debug)]
pub struct Points {
    pub coordinates: Vec<f64>,
    /// Coordinates of each point, 0 where there is no point.
    pub coordinate_count: usize,
}

json_value!(Points, PointsVisitor, deserialize_seq, {
    "type": "array", "minItems": 1,
    "items": { "type": "array", "minItems": 2, "maxItems": 3, "items": { "type": "number" } }
});

struct PointsVisitor;

impl<'de> Visitor<'de> for PointsVisitor {
    type Value = Points;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a list of points [[x, y, z], ...]")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut points: A) -> Result<Points, A::Error> {
        let (coordinates, coordinate_count) = equal_rows::<Number, _, _>(
            &mut points,
            "point",
            "coordinates",
            "a point [x, y] or [x, y, z]",
        )?;
        Ok(Points {
            coordinates,
            coordinate_count,
        })
    }
}

/// The cells of one block.
#[derive(Debug)]
pub struct Connectivity {
    pub nodes: Vec<u32>,
    pub nodes_per_cell: usize,
}

json_value!(Connectivity, ConnectivityVisitor, deserialize_seq, {
    "type": "array",
    "items": { "type": "array", "minItems": 1, "items": { "type": "integer", "minimum": 0 } }
});

struct ConnectivityVisitor;

impl<'de> Visitor<'de> for ConnectivityVisitor {
    type Value = Connectivity;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a list of cells, each a list of node ids")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut cells: A) -> Result<Connectivity, A::Error> {
        let (nodes, nodes_per_cell) = equal_rows::<NodeId, _, _>(
            &mut cells,
            "cell",
            "nodes",
            "a cell, which is a list of node ids",
        )?;
        Ok(Connectivity {
            nodes,
            nodes_per_cell,
        })
    }
}

/// A list of node ids.
#[derive(Debug)]
pub struct NodeList(pub Vec<u32>);

impl<'de> Deserialize<'de> for NodeList {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut nodes = Vec::new();
        Append::<NodeId, u32>::to(&mut nodes, "a list of node ids").deserialize(deserializer)?;
        nodes.shrink_to_fit();
        Ok(Self(nodes))
    }
}

impl JsonSchema for NodeList {
    fn inline_schema() -> bool {
        true
    }
    fn schema_name() -> Cow<'static, str> {
        "NodeList".into()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        Vec::<NodeId>::json_schema(generator)
    }
}

/// Named lists of node ids; a name may stand once.
#[derive(Debug, Default)]
pub struct PointSets(pub BTreeMap<String, Vec<u32>>);

json_value!(PointSets, PointSetsVisitor, deserialize_map, {
    "type": "object",
    "additionalProperties": { "type": "array", "items": { "type": "integer", "minimum": 0 } }
});

struct PointSetsVisitor;

impl<'de> Visitor<'de> for PointSetsVisitor {
    type Value = PointSets;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("an object {\"set name\": [node ids], ...}")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<PointSets, A::Error> {
        let mut sets = BTreeMap::new();
        while let Some(name) = map.next_key::<String>()? {
            match sets.entry(name) {
                Entry::Vacant(slot) => slot.insert(map.next_value::<NodeList>()?.0),
                Entry::Occupied(slot) => {
                    return Err(A::Error::custom(format_args!(
                        "point set \"{}\" stands twice",
                        slot.key()
                    )));
                }
            };
        }
        Ok(PointSets(sets))
    }
}

/// The names of an object's keys; its values are skipped.
#[derive(Debug, Default)]
pub struct Keys(pub Vec<String>);

json_value!(Keys, KeysVisitor, deserialize_map, { "type": "object" });

struct KeysVisitor;

impl<'de> Visitor<'de> for KeysVisitor {
    type Value = Keys;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Keys, A::Error> {
        let mut names = Vec::new();
        while let Some((name, IgnoredAny)) = map.next_entry()? {
            names.push(name);
        }
        Ok(Keys(names))
    }
}
