//! Checks of nodal fields and of a mesh.

use super::interfaces::has_direction;
use super::rules::{Checked, finite, matrix, name, wrong};
use crate::mesh::{Dimension, Mesh};
use crate::superelement::RecoveryBasis;

/// Checks nodal fields against their superelement, and against the number of nodes if there is a mesh.
/// `columns` are n_k, n_b and n_x.
pub(in crate::dcb) fn recovery(
    basis: &RecoveryBasis,
    dimension: Dimension,
    columns: [usize; 3],
    node_count: Option<usize>,
) -> Checked {
    let n_f = basis.dofs.len();
    for (column, dof) in basis.dofs.iter().enumerate() {
        if !has_direction(dimension, dof.direction) {
            return wrong(
                "/fields/dofs",
                format!(
                    "column {column} is {}, which a planar body doesn't have",
                    dof.direction.name()
                ),
            );
        }
        if node_count.is_some_and(|count| dof.node as usize >= count) {
            return wrong(
                "/fields/dofs",
                format!(
                    "column {column} is of node {}, which the mesh doesn't have",
                    dof.node
                ),
            );
        }
    }
    let [modes, rows, further] = columns;
    matrix("/modes/shapes", &basis.modes, n_f, modes)?;
    matrix("/residual/shapes", &basis.residual, n_f, rows)?;
    match &basis.enrichment {
        Some(shapes) => matrix("/enrichment/shapes", shapes, n_f, further),
        None => Ok(()),
    }
}

/// Checks a mesh.
pub(in crate::dcb) fn mesh(mesh: &Mesh, dimension: Dimension) -> Checked {
    let d = dimension.coordinate_count();
    if mesh.dimension != dimension || !mesh.coordinates.len().is_multiple_of(d) {
        return wrong(
            "/mesh/points",
            format!("isn't made of points with {d} coordinates"),
        );
    }
    finite("/mesh/points", &mesh.coordinates)?;
    let nodes = |path: &str, ids: &[u32]| match ids
        .iter()
        .find(|node| **node as usize >= mesh.node_count())
    {
        Some(node) => wrong(
            path,
            format!(
                "names node {node}, but the mesh has {} (0-based ids)",
                mesh.node_count()
            ),
        ),
        None => Ok(()),
    };
    for (index, block) in mesh.cells.iter().enumerate() {
        name(
            &format!("/mesh/cells/{index}/type"),
            "cell type",
            &block.cell_type,
        )?;
        let path = format!("/mesh/cells/{index}/data");
        if block.nodes_per_cell == 0 || !block.nodes.len().is_multiple_of(block.nodes_per_cell) {
            return wrong(
                &path,
                format!(
                    "{} nodes aren't cells of {}",
                    block.nodes.len(),
                    block.nodes_per_cell
                ),
            );
        }
        nodes(&path, &block.nodes)?;
    }
    mesh.point_sets.iter().try_for_each(|(name, ids)| {
        nodes(
            &format!("/mesh/point_sets/{}", crate::dcb::names::encode(name)),
            ids,
        )
    })
}
