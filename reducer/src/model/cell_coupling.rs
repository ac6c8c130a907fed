//! Whether the mesh's cells join nodes that the stiffness joins. Their node numbers take no part in the reduction, except for
//! `area` weights: a mesh whose points were brought into the order of the matrices, and whose cells were not, passes every
//! other check.

use dcb_formats::component::Component;
use dcb_formats::mesh::Direction;

/// So many cells, spread evenly over the mesh, tell whether the numbers belong together.
const EXAMINED: usize = 2000;
/// A few cells may join nothing (surfaces of contact, lines for a picture); of wrong ones, hardly any joins its nodes.
const STRANGE: f64 = 0.1;

/// Defect of the cells' node numbers, if more than a tenth of the cells join nodes most of which no entry of the
/// stiffness joins.
pub fn cell_warning(component: &Component) -> Option<String> {
    let count: usize = component
        .mesh
        .cells
        .iter()
        .map(|block| block.cell_count())
        .sum();
    let stride = count.div_ceil(EXAMINED).max(1);
    let cells = component.mesh.cells.iter().flat_map(|block| block.cells());
    let (mut examined, mut strange) = (0_u32, 0_u32);
    for cell in cells.step_by(stride) {
        if let Some(coupled) = coupled_part(component, cell) {
            examined += 1;
            strange += u32::from(coupled < 0.5);
        }
    }
    (f64::from(strange) > STRANGE * f64::from(examined)).then(|| {
        format!(
            "{strange} of {examined} cells looked at join nodes that no stiffness joins: the node numbers of the mesh's `cells` don't belong to its `points`, so that pictures, and interfaces with `area` weights, are wrong"
        )
    })
}

/// Part of a cell's pairs of nodes that the stiffness couples; `None` where fewer than two of its nodes have dofs.
fn coupled_part(component: &Component, cell: &[u32]) -> Option<f64> {
    let rows: Vec<Vec<u32>> = cell
        .iter()
        .map(|&node| {
            Direction::ALL
                .iter()
                .filter_map(|&direction| component.dofs.row(node, direction))
                .map(|row| row as u32)
                .collect()
        })
        .filter(|rows: &Vec<u32>| !rows.is_empty())
        .collect();
    let (mut pairs, mut coupled) = (0_u32, 0_u32);
    for (at, first) in rows.iter().enumerate() {
        for second in &rows[at + 1..] {
            pairs += 1;
            coupled += u32::from(first.iter().any(|&column| {
                let entries = component.stiffness.row_idx_of_col_raw(column as usize);
                second.iter().any(|row| entries.binary_search(row).is_ok())
            }));
        }
    }
    (pairs > 0).then(|| f64::from(coupled) / f64::from(pairs))
}
