//! Checks of the mesh and of the directions of its nodes.

use super::fault::{ComponentFault, fault};
use super::label::check_label;
use crate::mesh::{CellBlock, Dimension, Direction, MatrixRow, Mesh};

/// meshio's cell names and their node counts. Other names are kept as they are.
pub(crate) const CELL_TYPES: [(&str, usize); 24] = [
    ("vertex", 1),
    ("line", 2),
    ("line3", 3),
    ("line4", 4),
    ("triangle", 3),
    ("triangle6", 6),
    ("triangle10", 10),
    ("quad", 4),
    ("quad8", 8),
    ("quad9", 9),
    ("quad16", 16),
    ("tetra", 4),
    ("tetra10", 10),
    ("tetra20", 20),
    ("hexahedron", 8),
    ("hexahedron20", 20),
    ("hexahedron24", 24),
    ("hexahedron27", 27),
    ("wedge", 6),
    ("wedge15", 15),
    ("wedge18", 18),
    ("pyramid", 5),
    ("pyramid13", 13),
    ("pyramid14", 14),
];

/// Finite coordinates, cells and sets of nodes that are there.
///
/// # Errors
/// The first place that is wrong, by its key in the component file.
pub(crate) fn check_mesh(mesh: &Mesh) -> Result<(), ComponentFault> {
    let stride = mesh.dimension.coordinate_count();
    if mesh.coordinates.is_empty() {
        return Err(fault(
            "points",
            "is empty; expected a list of points [x, y, z] or [x, y]",
        ));
    }
    if !mesh.coordinates.len().is_multiple_of(stride) {
        return Err(fault(
            "points",
            format!(
                "has {} coordinates, expected {stride} for each node",
                mesh.coordinates.len()
            ),
        ));
    }
    if let Some(at) = mesh.coordinates.iter().position(|x| !x.is_finite()) {
        return Err(fault(
            format!("points[{}][{}]", at / stride, at % stride),
            format!("is {}, expected a finite number", mesh.coordinates[at]),
        ));
    }
    let node_count = mesh.node_count();
    for (block, cells) in mesh.cells.iter().enumerate() {
        check_cells(block, cells, node_count)?;
    }
    for (name, nodes) in &mesh.point_sets {
        let location = format!("point_sets.{}", name.escape_debug());
        check_label(&location, name)?;
        check_ids(&location, nodes, node_count)?;
    }
    Ok(())
}

fn check_cells(block: usize, cells: &CellBlock, node_count: usize) -> Result<(), ComponentFault> {
    let CellBlock {
        cell_type,
        nodes_per_cell,
        nodes,
    } = cells;
    match CELL_TYPES.iter().find(|(name, _)| name == cell_type) {
        Some((name, count)) if count != nodes_per_cell => {
            return Err(fault(
                format!("cells[{block}].data"),
                format!("has {nodes_per_cell} nodes per cell, but a {name} has {count}"),
            ));
        }
        Some(_) => {}
        None => check_label(&format!("cells[{block}].type"), cell_type)?,
    }
    if !nodes.is_empty() && !nodes.len().is_multiple_of(*nodes_per_cell) {
        return Err(fault(
            format!("cells[{block}].data"),
            format!(
                "has {} nodes, expected {nodes_per_cell} for each cell",
                nodes.len()
            ),
        ));
    }
    match nodes.iter().position(|&node| node as usize >= node_count) {
        None => Ok(()),
        Some(at) => Err(fault(
            format!(
                "cells[{block}].data[{}][{}]",
                at / nodes_per_cell,
                at % nodes_per_cell
            ),
            format!(
                "of the {cell_type} block {}",
                no_such_node(nodes[at], node_count)
            ),
        )),
    }
}

/// Every id must name a node.
pub(super) fn check_ids(
    location: &str,
    ids: &[u32],
    node_count: usize,
) -> Result<(), ComponentFault> {
    match ids.iter().position(|&id| id as usize >= node_count) {
        None => Ok(()),
        Some(at) => Err(fault(
            format!("{location}[{at}]"),
            no_such_node(ids[at], node_count),
        )),
    }
}

fn no_such_node(id: u32, node_count: usize) -> String {
    let off_by_one = if id as usize == node_count {
        "; are the ids 1-based?"
    } else {
        ""
    };
    format!(
        "is node {id}, but the mesh has {node_count} nodes (0-based ids, up to {}){off_by_one}",
        node_count - 1
    )
}

/// No direction may stand twice.
pub(crate) fn check_repeats(
    location: &str,
    directions: &[Direction],
) -> Result<(), ComponentFault> {
    for (at, direction) in directions.iter().enumerate() {
        if directions[..at].contains(direction) {
            return Err(fault(
                format!("{location}[{at}]"),
                format!("names {} twice", direction.name()),
            ));
        }
    }
    Ok(())
}

/// Internal rows alone make no component.
///
/// # Errors
/// If there are rows and none belongs to a node.
pub(crate) fn check_nodal(owners: &[MatrixRow]) -> Result<(), ComponentFault> {
    match !owners.is_empty() && owners.iter().all(|owner| owner.dof().is_none()) {
        false => Ok(()),
        true => Err(fault(
            "component.dofs",
            format!(
                "has {} internal rows and no row of a node; only rows that belong to no node are internal, those of nodes are \
                 [node, \"ux\"] and so on",
                owners.len()
            ),
        )),
    }
}

/// A planar component has dofs in the plane only, and some node moves along each coordinate. `first_with` finds the place of the first
/// dof whose direction is wanted.
///
/// # Errors
/// The dof out of the plane, or the direction that is missing.
pub(crate) fn check_directions(
    dimension: Dimension,
    first_with: impl Fn(&dyn Fn(Direction) -> bool) -> Option<(usize, Direction)>,
) -> Result<(), ComponentFault> {
    let in_plane = Dimension::Planar.frame_directions();
    let out_of_plane = first_with(&|direction| !in_plane.contains(&direction));
    if let (Dimension::Planar, Some((at, direction))) = (dimension, out_of_plane) {
        return Err(fault(
            format!("component.dofs[{at}]"),
            format!(
                "is {}, but the points have two coordinates: a planar component has ux uy, or ux uy rz; \
                 a spatial one needs points [x, y, z]",
                direction.name()
            ),
        ));
    }
    for &translation in &Direction::ALL[..dimension.coordinate_count()] {
        if first_with(&|direction| direction == translation).is_none() {
            let (kind, needed) = match dimension {
                Dimension::Planar => ("planar", "ux uy"),
                Dimension::Spatial => ("spatial", "ux uy uz"),
            };
            let name = translation.name();
            return Err(fault(
                "component.dofs",
                format!(
                    "has no {name}; a {kind} component moves freely, so its nodes need at least {needed}"
                ),
            ));
        }
    }
    Ok(())
}
