//! Sections of version 2.

use std::collections::HashMap;

use dcb_formats::Error;

use super::super::fields;
use super::source::{Encoding, Source};
use super::{MOST_NODES, Model, known_type};

/// Tags of an element: the physical group, the entity, and partitions.
const MOST_TAGS: i64 = 1 << 16;

/// Entities whose elements stand in several groups: they are listed once for each.
#[derive(Debug, Default)]
pub(super) struct Seen {
    group_of: HashMap<(u8, i64), i64>,
    has_repeats: bool,
}

impl Seen {
    fn see(&mut self, dimension: u8, entity: i64, group: i64) {
        let first = *self.group_of.entry((dimension, entity)).or_insert(group);
        self.has_repeats |= first != group;
    }

    /// Whether elements may be listed more than once.
    pub fn has_repeats(&self) -> bool {
        self.has_repeats
    }
}

/// `label x y z`.
pub(super) fn nodes(source: &mut Source, model: &mut Model) -> Result<(), Error> {
    let count = count(source)?;
    source.room_for(count, 4 + 24, "nodes")?;
    for _ in 0..count {
        let label = source.int_label()?;
        let point = source.point()?;
        model.nodes.push(label, point);
    }
    Ok(())
}

/// Nodes with the entity that they are on, and their parameters there.
pub(super) fn parametric_nodes(source: &mut Source, model: &mut Model) -> Result<(), Error> {
    let count = count(source)?;
    source.room_for(count, 4 + 24 + 8, "nodes")?;
    for _ in 0..count {
        let label = source.int_label()?;
        let point = source.point()?;
        model.nodes.push(label, point);
        let dimension = source.int()?;
        source.int()?;
        for _ in 0..match dimension {
            1 | 2 => dimension,
            _ => 0,
        } {
            source.real()?;
        }
    }
    Ok(())
}

/// The count of a section: text in binary files too.
fn count(source: &mut Source) -> Result<u64, Error> {
    let line = source.line().unwrap_or_default();
    let number = fields::integer(line)
        .and_then(|number| u64::try_from(number).map_err(|_| format!("{number} is no count")));
    number.map_err(|message| source.refused(message))
}

/// `label type tags... nodes...`; in binary files blocks of elements of one type.
pub(super) fn elements(source: &mut Source, model: &mut Model) -> Result<(), Error> {
    let announced = count(source)?;
    source.room_for(announced, 4 + 4, "elements")?;
    let mut found = 0;
    while found < announced {
        match source.encoding {
            Encoding::Text => {
                let label = source.int_label()?;
                let number = source.int()?;
                let tags = source.int()?;
                element(source, model, label, number, tags)?;
                found += 1;
            }
            Encoding::Binary { .. } => {
                let (number, many, tags) = (source.int()?, source.int()?, source.int()?);
                let many = u64::try_from(many)
                    .ok()
                    .filter(|many| (1..=announced - found).contains(many));
                let Some(many) = many else {
                    return Err(source.refused(format!(
                        "a block of elements doesn't fit the {announced} announced"
                    )));
                };
                source.room_for(many, 4 + 4, "elements")?;
                for _ in 0..many {
                    let label = source.int_label()?;
                    element(source, model, label, number, tags)?;
                }
                found += many;
            }
        }
    }
    Ok(())
}

fn element(
    source: &mut Source,
    model: &mut Model,
    label: u32,
    number: i64,
    tags: i64,
) -> Result<(), Error> {
    let kind = known_type(source, number)?;
    if !(0..=MOST_TAGS).contains(&tags) {
        return Err(source.refused(format!("{tags} tags of an element")));
    }
    let (mut group, mut entity) = (0, 0);
    for tag in 0..tags {
        let value = source.int()?;
        match tag {
            0 => group = value.saturating_abs(),
            1 => entity = value,
            _ => {}
        }
    }
    let mut nodes = [0; MOST_NODES];
    for node in &mut nodes[..kind.nodes] {
        *node = source.int_label()?;
    }
    let block = model.block(number, &kind);
    model.cell(block, label, &nodes[..kind.nodes], &kind);
    if group != 0 {
        let end = model.cells.block_len(block);
        model
            .groups
            .put((kind.dimension, group), (block, end - 1, end));
        model.seen.see(kind.dimension, entity, group);
    }
    Ok(())
}
