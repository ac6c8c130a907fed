//! Checks of points, cells, point sets and dofs against each other; planar or spatial is decided here.

use super::diagnosis::suggestion;
use super::file::CellPart;
use super::lists::{PointSets, Points};
use super::{DofLayout, Fault, check_label, fault};
use crate::mesh::{CellBlock, Dimension, Direction, DofMap, DofMapError, Mesh};
use crate::named::Object;

/// meshio's cell names and their node counts. Other names are kept as they are.
const CELL_TYPES: [(&str, usize); 24] = [
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

const PLANAR_DIRECTIONS: [Direction; 3] = [Direction::Ux, Direction::Uy, Direction::Rz];

pub fn mesh(
    points: Points,
    cells: Vec<Object<CellPart>>,
    PointSets(point_sets): PointSets,
    dofs: &DofLayout,
    notes: &mut Vec<String>,
) -> Result<Mesh, Fault> {
    let node_count = node_count(&points)?;
    check_dofs(dofs, node_count)?;
    let (dimension, coordinates) = dimension(points, dofs, notes)?;
    let cells = cells
        .into_iter()
        .enumerate()
        .map(|(block, Object(cells))| cell_block(block, cells, node_count, notes))
        .collect::<Result<_, _>>()?;
    for (name, nodes) in &point_sets {
        let location = format!("point_sets.{}", name.escape_debug());
        check_label(&location, name)?;
        check_ids(&location, nodes, node_count)?;
    }
    Ok(Mesh {
        dimension,
        coordinates,
        cells,
        point_sets,
    })
}

fn node_count(points: &Points) -> Result<usize, Fault> {
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

/// Every id must name a node.
pub fn check_ids(location: &str, ids: &[u32], node_count: usize) -> Result<(), Fault> {
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

fn check_dofs(dofs: &DofLayout, node_count: usize) -> Result<(), Fault> {
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

/// No direction may stand twice.
pub fn check_repeats(location: &str, directions: &[Direction]) -> Result<(), Fault> {
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

/// Whether some dof has this direction, and where the first such dof stands.
fn first_with(dofs: &DofLayout, wanted: impl Fn(Direction) -> bool) -> Option<(usize, Direction)> {
    match dofs {
        DofLayout::Pattern(pattern) => pattern
            .iter()
            .copied()
            .enumerate()
            .find(|&(_, direction)| wanted(direction)),
        DofLayout::Table(table) => table
            .iter()
            .map(|dof| dof.direction)
            .enumerate()
            .find(|&(_, direction)| wanted(direction)),
    }
}

fn dimension(
    points: Points,
    dofs: &DofLayout,
    notes: &mut Vec<String>,
) -> Result<(Dimension, Vec<f64>), Fault> {
    let out_of_plane = first_with(dofs, |direction| !PLANAR_DIRECTIONS.contains(&direction));
    let (dimension, coordinates) = match (points.coordinate_count, out_of_plane) {
        (2, Some((at, direction))) => {
            return Err(fault(
                format!("component.dofs[{at}]"),
                format!(
                    "is {}, but the points have two coordinates: a planar component has ux uy, or ux uy rz; \
                     a spatial one needs points [x, y, z]",
                    direction.name()
                ),
            ));
        }
        (2, None) => (Dimension::Planar, points.coordinates),
        (_, Some(_)) => (Dimension::Spatial, points.coordinates),
        (_, None) => (Dimension::Planar, flattened(points, notes)?),
    };
    for &translation in &Direction::ALL[..dimension.coordinate_count()] {
        if first_with(dofs, |direction| direction == translation).is_none() {
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
    Ok((dimension, coordinates))
}

/// The x and y of points that all lie in the plane z = 0.
fn flattened(points: Points, notes: &mut Vec<String>) -> Result<Vec<f64>, Fault> {
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
    node_count: usize,
    notes: &mut Vec<String>,
) -> Result<CellBlock, Fault> {
    let CellPart { cell_type, data } = cells;
    let (nodes, found) = (data.nodes, data.nodes_per_cell);
    let known = CELL_TYPES.iter().find(|(name, _)| *name == cell_type);
    let nodes_per_cell = match known {
        Some(&(_, count)) if nodes.is_empty() => count,
        Some(&(name, count)) if count != found => {
            return Err(fault(
                format!("cells[{block}].data"),
                format!("has {found} nodes per cell, but a {name} has {count}"),
            ));
        }
        Some(_) => found,
        None => {
            check_label(&format!("cells[{block}].type"), &cell_type)?;
            let hint = suggestion(&cell_type, CELL_TYPES.iter().map(|(name, _)| *name));
            notes.push(format!(
                "cells[{block}]: `{cell_type}` is not a cell type known here, kept as it is{hint}"
            ));
            found
        }
    };
    if let Some(at) = nodes.iter().position(|&node| node as usize >= node_count) {
        return Err(fault(
            format!(
                "cells[{block}].data[{}][{}]",
                at / nodes_per_cell,
                at % nodes_per_cell
            ),
            format!(
                "of the {cell_type} block {}",
                no_such_node(nodes[at], node_count)
            ),
        ));
    }
    Ok(CellBlock {
        cell_type,
        nodes_per_cell,
        nodes,
    })
}
