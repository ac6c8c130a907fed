//! Sections of version 4.1: the same numbers in text and binary files.

use std::collections::HashMap;

use dcb_formats::Error;

use super::source::Source;
use super::{MOST_NODES, Model, known_type};

/// Physical groups of each entity, by its dimension and number.
#[derive(Debug, Default)]
pub(super) struct Entities {
    groups: HashMap<(i64, i64), Vec<i64>>,
}

/// Points, curves, surfaces, volumes, each with its physical groups.
pub(super) fn entities(source: &mut Source, model: &mut Model) -> Result<(), Error> {
    let counts = [
        source.size()?,
        source.size()?,
        source.size()?,
        source.size()?,
    ];
    for (dimension, count) in (0..).zip(counts) {
        source.room_for(count, 4 + 24 + source.width(), "entities")?;
        for _ in 0..count {
            let tag = source.int()?;
            entity(source, model, (dimension, tag), None)?;
        }
    }
    Ok(())
}

/// As the entities, with partitions; what a part comes from tells its groups too.
pub(super) fn partitioned_entities(source: &mut Source, model: &mut Model) -> Result<(), Error> {
    source.size()?;
    let ghosts = source.size()?;
    source.room_for(ghosts, 8, "ghosts")?;
    for _ in 0..ghosts {
        source.int()?;
        source.int()?;
    }
    let counts = [
        source.size()?,
        source.size()?,
        source.size()?,
        source.size()?,
    ];
    for (dimension, count) in (0..).zip(counts) {
        source.room_for(count, 3 * 4 + source.width() + 24, "entities")?;
        for _ in 0..count {
            let tag = source.int()?;
            let parent = (source.int()?, source.int()?);
            let partitions = source.size()?;
            source.room_for(partitions, 4, "partitions")?;
            for _ in 0..partitions {
                source.int()?;
            }
            entity(source, model, (dimension, tag), Some(parent))?;
        }
    }
    Ok(())
}

/// What follows the numbers of an entity: its box, groups and boundary.
fn entity(
    source: &mut Source,
    model: &mut Model,
    entity: (i64, i64),
    parent: Option<(i64, i64)>,
) -> Result<(), Error> {
    for _ in 0..if entity.0 == 0 { 3 } else { 6 } {
        source.real()?;
    }
    let count = source.size()?;
    source.room_for(count, 4, "physical groups")?;
    let mut groups = Vec::new();
    for _ in 0..count {
        // The sign tells the direction of the entity in its group.
        groups.push(source.int()?.saturating_abs());
    }
    if entity.0 > 0 {
        let boundary = source.size()?;
        source.room_for(boundary, 4, "parts of a boundary")?;
        for _ in 0..boundary {
            source.int()?;
        }
    }
    // Parts of the boundary between partitions have parents of a higher dimension: they are inside.
    if let Some(parent) = parent.filter(|parent| parent.0 == entity.0)
        && groups.is_empty()
    {
        groups = model
            .entities
            .groups
            .get(&parent)
            .cloned()
            .unwrap_or_default();
    }
    if !groups.is_empty() {
        model.entities.groups.insert(entity, groups);
    }
    Ok(())
}

/// Blocks of nodes: labels, then coordinates, with parameters behind where the block says so.
pub(super) fn nodes(source: &mut Source, model: &mut Model) -> Result<(), Error> {
    let blocks = source.size()?;
    let announced = source.size()?;
    source.room_for(announced, source.width() + 24, "nodes")?;
    source.size()?;
    source.size()?;
    source.room_for(blocks, 3 * 4 + source.width(), "blocks of nodes")?;
    let mut found = 0;
    for _ in 0..blocks {
        let dimension = source.int()?;
        source.int()?;
        let parameters = match source.int()? {
            0 => 0,
            1 => dimension.clamp(0, 3),
            other => {
                return Err(source.refused(format!("{other} where 0 or 1 tells of parameters")));
            }
        };
        let count = source.size()?;
        source.room_for(count, source.width() + 24, "nodes")?;
        for _ in 0..count {
            let label = source.label()?;
            model.nodes.labels.push(label);
        }
        for _ in 0..count {
            let point = source.point()?;
            model.nodes.points.push(point);
            for _ in 0..parameters {
                source.real()?;
            }
        }
        found += count;
    }
    match found == announced {
        true => Ok(()),
        false => Err(source.refused(format!(
            "{announced} nodes are announced, but the blocks have {found}"
        ))),
    }
}

/// Blocks of elements of one entity and type.
pub(super) fn elements(source: &mut Source, model: &mut Model) -> Result<(), Error> {
    let blocks = source.size()?;
    let announced = source.size()?;
    source.room_for(announced, 2 * source.width(), "elements")?;
    source.size()?;
    source.size()?;
    source.room_for(blocks, 3 * 4 + source.width(), "blocks of elements")?;
    let mut found = 0;
    for _ in 0..blocks {
        let entity = (source.int()?, source.int()?);
        let number = source.int()?;
        let kind = known_type(source, number)?;
        let count = source.size()?;
        source.room_for(count, source.width() * (1 + kind.nodes), "elements")?;
        let block = model.block(number, &kind);
        let first = model.cells.block_len(block);
        let mut nodes = [0; MOST_NODES];
        for _ in 0..count {
            let label = source.label()?;
            for node in &mut nodes[..kind.nodes] {
                *node = source.label()?;
            }
            model.cell(block, label, &nodes[..kind.nodes], &kind);
        }
        found += count;
        let range = (block, first, model.cells.block_len(block));
        let groups = model.entities.groups.get(&entity);
        for group in groups.into_iter().flatten() {
            model.groups.put((kind.dimension, *group), range);
        }
    }
    match found == announced {
        true => Ok(()),
        false => Err(source.refused(format!(
            "{announced} elements are announced, but the blocks have {found}"
        ))),
    }
}
