//! Checks of points, cells, point sets and dofs against each other; planar or spatial is decided here.

use std::collections::BTreeMap;

use super::DofLayout;
use super::diagnosis::suggestion;
use super::file::CellPart;
use super::lists::{PointSets, Points};
use crate::component::{
    CELL_TYPES, ComponentFault, check_directions, check_mesh, check_nodal, check_repeats, fault,
};
use crate::mesh::{CellBlock, Dimension, Direction, DofMap, DofMapError, Mesh};
use crate::named::Object;

pub fn mesh(
    points: Points,
    cells: Vec<Object<CellPart>>,
    PointSets(point_sets): PointSets,
    dofs: &DofLayout,
    notes: &mut Vec<String>,
) -> Result<Mesh, ComponentFault> {
    let node_count = node_count(&points)?;
    check_dofs(dofs, node_count)?;
    let (dimension, coordinates) = dimension(points, dofs, notes)?;
    checked(dimension, coordinates, cells, point_sets, notes)
}

/// A mesh alone: two coordinates make it planar.
pub fn mesh_alone(
    points: Points,
    cells: Vec<Object<CellPart>>,
    PointSets(point_sets): PointSets,
    notes: &mut Vec<String>,
) -> Result<Mesh, ComponentFault> {
    node_count(&points)?;
    let dimension = match points.coordinate_count {
        2 => Dimension::Planar,
        _ => Dimension::Spatial,
    };
    checked(dimension, points.coordinates, cells, point_sets, notes)
}

fn checked(
    dimension: Dimension,
    coordinates: Vec<f64>,
    cells: Vec<Object<CellPart>>,
    point_sets: BTreeMap<String, Vec<u32>>,
    notes: &mut Vec<String>,
) -> Result<Mesh, ComponentFault> {
    let cells = cells
        .into_iter()
        .enumerate()
        .map(|(block, Object(cells))| cell_block(block, cells, notes))
        .collect::<Result<_, _>>()?;
    let mesh = Mesh {
        dimension,
        coordinates,
        cells,
        point_sets,
    };
    check_mesh(&mesh)?;
    Ok(mesh)
}

fn node_count(points: &Points) -> Result<usize, ComponentFault> {
    if points.coordinates.is_empty() {
        return Err(fault(
            "points",
            "is empty; expected a list of points [x, y, z] or [x, y]",
        ));
    }
    if !(2..=3).contains(&points.coordinate_count) {
        let found = points.coordinate_count;
        return Err(fault(
            "points[0]",
            format!("has {found} coordinates, expected 3 ([x, y, z]) or 2 (planar, [x, y])"),
        ));
    }
    Ok(points.coordinates.len() / points.coordinate_count)
}

fn check_dofs(dofs: &DofLayout, node_count: usize) -> Result<(), ComponentFault> {
    let dof_count = match dofs {
        DofLayout::Pattern(pattern) if pattern.is_empty() => {
            return Err(fault(
                "component.dofs",
                "is empty; expected for example [\"ux\", \"uy\", \"uz\"]",
            ));
        }
        DofLayout::Pattern(pattern) => {
            check_repeats("component.dofs", pattern)?;
            node_count.saturating_mul(pattern.len())
        }
        DofLayout::Table(table) => {
            DofMap::new(table.clone(), node_count).map_err(|error| {
                let (DofMapError::NoSuchNode { row, .. } | DofMapError::Repeated { row, .. }) =
                    error;
                fault(format!("component.dofs[{row}]"), error.to_string())
            })?;
            check_nodal(table)?;
            table.len()
        }
    };
    if dof_count >= u32::MAX as usize {
        return Err(fault(
            "component.dofs",
            format!("make {dof_count} dofs, expected fewer than {}", u32::MAX),
        ));
    }
    Ok(())
}

/// The place and the direction of the first dof whose direction is wanted.
fn first_with(dofs: &DofLayout, wanted: &dyn Fn(Direction) -> bool) -> Option<(usize, Direction)> {
    match dofs {
        DofLayout::Pattern(pattern) => {
            (pattern.iter().copied().enumerate()).find(|&(_, direction)| wanted(direction))
        }
        DofLayout::Table(table) => (table.iter().enumerate())
            .filter_map(|(row, owner)| Some((row, owner.dof()?.direction)))
            .find(|&(_, direction)| wanted(direction)),
    }
}

fn dimension(
    points: Points,
    dofs: &DofLayout,
    notes: &mut Vec<String>,
) -> Result<(Dimension, Vec<f64>), ComponentFault> {
    let in_plane = Dimension::Planar.frame_directions();
    let is_spatial = first_with(dofs, &|direction| !in_plane.contains(&direction)).is_some();
    let (dimension, coordinates) = match (points.coordinate_count, is_spatial) {
        (2, _) => (Dimension::Planar, points.coordinates),
        (_, true) => (Dimension::Spatial, points.coordinates),
        (_, false) => (Dimension::Planar, flattened(points, notes)?),
    };
    check_directions(dimension, |wanted| first_with(dofs, wanted))?;
    Ok((dimension, coordinates))
}

/// The x and y of points that all lie in the plane z = 0.
fn flattened(points: Points, notes: &mut Vec<String>) -> Result<Vec<f64>, ComponentFault> {
    if let Some((node, point)) = points
        .coordinates
        .chunks_exact(3)
        .enumerate()
        .find(|(_, point)| point[2] != 0.0)
    {
        return Err(fault(
            "component.dofs",
            format!(
                "names only in-plane directions, which make a planar component, but point {node} has z = {}; \
                 add uz for a spatial component, or give the points two coordinates [x, y]",
                point[2]
            ),
        ));
    }
    notes.push(
        "all points have z = 0 and the dofs are in the plane: taken as a planar component".into(),
    );
    Ok(points
        .coordinates
        .chunks_exact(3)
        .flat_map(|point| [point[0], point[1]])
        .collect())
}

fn cell_block(
    block: usize,
    cells: CellPart,
    notes: &mut Vec<String>,
) -> Result<CellBlock, ComponentFault> {
    let CellPart { cell_type, data } = cells;
    let known = CELL_TYPES.iter().find(|(name, _)| *name == cell_type);
    if known.is_none() {
        let hint = suggestion(&cell_type, CELL_TYPES.iter().map(|(name, _)| *name));
        notes.push(format!(
            "cells[{block}]: `{cell_type}` is not a cell type known here, kept as it is{hint}"
        ));
    }
    let nodes_per_cell = match known {
        Some(&(_, count)) if data.nodes.is_empty() => count,
        _ => data.nodes_per_cell,
    };
    Ok(CellBlock {
        cell_type,
        nodes_per_cell,
        nodes: data.nodes,
    })
}
