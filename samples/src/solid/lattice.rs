//! Meshes from cells on a lattice of possible points, of which only those that cells use become nodes.

use std::collections::BTreeMap;

use dcb_formats::mesh::{CellBlock, Dimension, Mesh};

use super::element::SolidElement;

/// A mesh without sets, and the node of each lattice point (`u32::MAX` where no cell uses it). Nodes are numbered in the
/// order of their points; `cell_points` lists the points of one cell after another.
pub(crate) fn mesh_of_used_points(
    element: SolidElement,
    cell_points: &[usize],
    point_count: usize,
    position: impl Fn(usize) -> [f64; 3],
) -> (Mesh, Vec<u32>) {
    let mut node_of_point = vec![u32::MAX; point_count];
    for &point in cell_points {
        node_of_point[point] = 0;
    }
    let mut coordinates = Vec::new();
    let used = node_of_point
        .iter_mut()
        .enumerate()
        .filter(|(_, node)| **node == 0);
    for (point, node) in used {
        *node = (coordinates.len() / 3) as u32;
        coordinates.extend(position(point));
    }
    let mesh = Mesh {
        dimension: Dimension::Spatial,
        coordinates,
        cells: vec![CellBlock {
            cell_type: element.cell_type().into(),
            nodes_per_cell: element.node_count(),
            nodes: cell_points
                .iter()
                .map(|&point| node_of_point[point])
                .collect(),
        }],
        point_sets: BTreeMap::new(),
    };
    (mesh, node_of_point)
}
