//! Positions of nodes with rotations, from the null space of the stiffness: a substructure's file has no coordinates.
//!
//! The motions without stiffness are Z = R A as in `lost_order`. The three rotation rows of every node are the same, Θ; its translation rows are
//! T_i = T_0 - [q_i]× Θ, so q_i = p_i - p_0 follows from (T_i - T_0) Θ⁺.

use dcb_formats::SparseMatrix;
use dcb_formats::mesh::Direction;
use nalgebra::{Matrix3, SMatrix};

use crate::mesh::FoundMesh;
use crate::rigid_motions::null_space::null_space;
use crate::stored::RowLabel;

/// A mesh of the nodes that rows are labelled with, relative to the first one, without cells and sets.
///
/// # Errors
/// A node without one of the six directions; motions without stiffness that aren't those of one rigid body.
pub(crate) fn mesh_of_rows(
    stiffness: &SparseMatrix,
    labels: &[RowLabel],
) -> Result<FoundMesh, String> {
    let mut nodes: Vec<(u32, [Option<usize>; 6])> = Vec::new();
    let mut groups = Vec::with_capacity(labels.len());
    for (row, label) in labels.iter().enumerate() {
        let (point, slot) = match label {
            RowLabel::Nodal { node, direction } => (*node, Some(*direction)),
            RowLabel::Internal { .. } => {
                groups.push((nodes.len() + row) as u32);
                continue;
            }
        };
        if nodes.last().is_none_or(|(last, _)| *last != point) {
            nodes.push((point, [None; 6]));
        }
        groups.push((nodes.len() - 1) as u32);
        if let (Some((_, rows)), Some(direction)) = (nodes.last_mut(), slot) {
            rows[direction.index()] = Some(row);
        }
    }
    let null_space = null_space(stiffness, &groups)?;
    let rows_of = |rows: &[Option<usize>; 6], first: Direction| {
        let three = &rows[first.index()..first.index() + 3];
        let rows = [three[0]?, three[1]?, three[2]?];
        Some(SMatrix::<f64, 3, 6>::from_fn(|axis, motion| {
            null_space[(rows[axis], motion)]
        }))
    };
    let mut points = Vec::with_capacity(nodes.len());
    let mut first: Option<(SMatrix<f64, 3, 6>, SMatrix<f64, 6, 3>)> = None;
    for (label, rows) in &nodes {
        let (Some(moved), Some(turned)) =
            (rows_of(rows, Direction::Ux), rows_of(rows, Direction::Rx))
        else {
            return Err(format!(
                "node {label} doesn't have all of ux, uy, uz, rx, ry, rz, so its place can't follow from the stiffness; name a mesh, --mesh FILE"
            ));
        };
        if first.is_none() {
            let inverse = turned
                .pseudo_inverse(f64::EPSILON.sqrt())
                .map_err(|why| why.to_owned())?;
            first = Some((moved, inverse));
        }
        let Some((at_first, inverse)) = &first else {
            continue;
        };
        let skew: Matrix3<f64> = (moved - at_first) * inverse;
        points.push([
            0.5 * (skew[(1, 2)] - skew[(2, 1)]),
            0.5 * (skew[(2, 0)] - skew[(0, 2)]),
            0.5 * (skew[(0, 1)] - skew[(1, 0)]),
        ]);
    }
    Ok(FoundMesh {
        points,
        labels: Some(nodes.iter().map(|(label, _)| *label).collect()),
        notes: vec![
            "no mesh: the positions of the nodes follow from the stiffness, relative to the first one; there are no cells and no sets".into(),
        ],
        ..FoundMesh::default()
    })
}
