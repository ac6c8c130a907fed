//! Nodes whose rows are along axes of their own: rotated into those of the component.

use std::collections::BTreeMap;

use dcb_formats::SparseMatrix;
use dcb_formats::mesh::{Direction, Dof, MatrixRow};
use faer::sparse::Triplet;

/// Directions that belong together.
const TRIPLES: [[Direction; 3]; 2] = [
    [Direction::Ux, Direction::Uy, Direction::Uz],
    [Direction::Rx, Direction::Ry, Direction::Rz],
];

/// T of u_own = T u_component, identity but for the rows of nodes with axes of their own.
///
/// # Errors
/// The place of a node that lacks one of three directions.
pub(crate) fn transform(
    rows: &[MatrixRow],
    axes: &[(u32, [[f64; 3]; 3])],
) -> Result<Option<SparseMatrix>, u32> {
    let places: BTreeMap<Dof, u32> = rows
        .iter()
        .zip(0..)
        .filter_map(|(owner, row)| Some((owner.dof()?, row)))
        .collect();
    let mut is_rotated = vec![false; rows.len()];
    let mut triplets: Vec<Triplet<u32, u32, f64>> = Vec::new();
    for (node, axes) in axes {
        for triple in TRIPLES {
            let found = triple.map(|direction| {
                places
                    .get(&Dof {
                        node: *node,
                        direction,
                    })
                    .copied()
            });
            let [Some(x), Some(y), Some(z)] = found else {
                match found {
                    [None, None, None] => continue,
                    _ => return Err(*node),
                }
            };
            let of_node = [x, y, z];
            for (row, axis) in of_node.into_iter().zip(axes) {
                is_rotated[row as usize] = true;
                for (column, component) in of_node.into_iter().zip(axis) {
                    triplets.push(Triplet::new(row, column, *component));
                }
            }
        }
    }
    if triplets.is_empty() {
        return Ok(None);
    }
    let same = (0..rows.len()).filter(|&row| !is_rotated[row]);
    triplets.extend(same.map(|row| Triplet::new(row as u32, row as u32, 1.0)));
    let matrix = SparseMatrix::try_new_from_triplets(rows.len(), rows.len(), &triplets);
    // Rows are below the size, so there is nothing to refuse.
    Ok(matrix.ok())
}

/// Tᵀ K T, of rows along their own axes as of rows along those of the component.
pub(crate) fn rotated(matrix: &SparseMatrix, transform: &SparseMatrix) -> Option<SparseMatrix> {
    let transposed = transform.transpose().to_col_major().ok()?;
    Some(&transposed * &(matrix * transform))
}
