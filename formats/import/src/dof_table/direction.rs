//! Directions as programs call them.

use dcb_formats::matrix::blocks::{shown, unsigned};
use dcb_formats::mesh::Direction;

use crate::stored::LARGEST_LABEL;

/// Names of displacements and rotations: ours, Ansys', Nastran's.
const NAMES: [[&str; 6]; 3] = [
    Direction::NAMES,
    ["ux", "uy", "uz", "rotx", "roty", "rotz"],
    ["t1", "t2", "t3", "r1", "r2", "r3"],
];

/// The direction of a name, without regard to case.
///
/// # Errors
/// Says that it is none.
pub(super) fn named(name: &[u8]) -> Result<Direction, String> {
    let place = |names: &[&str; 6]| {
        let mut names = names.iter();
        names.position(|known| name.eq_ignore_ascii_case(known.as_bytes()))
    };
    let index = NAMES.iter().find_map(place);
    index.and_then(Direction::from_index).ok_or_else(|| {
        format!(
            "`{}` is no displacement or rotation; expected ux, uy, uz, rotx, roty, rotz or 1 to 6",
            shown(name)
        )
    })
}

/// A label of a node.
///
/// # Errors
/// Says that it is none.
pub(super) fn label(field: &[u8]) -> Result<u32, String> {
    match unsigned(field) {
        Ok((label, length))
            if length == field.len() && (1..=u64::from(LARGEST_LABEL)).contains(&label) =>
        {
            Ok(label as u32)
        }
        _ => Err(format!(
            "`{}`; expected the label of a node, from 1 to {LARGEST_LABEL}",
            shown(field)
        )),
    }
}

/// Directions of each node's rows, where a table lists nodes and no directions.
///
/// # Errors
/// Says that the rows of the matrix are not 2, 3 or 6 for each node.
pub(super) fn of_each_node(
    row_count: usize,
    node_count: usize,
) -> Result<&'static [Direction], String> {
    match row_count.checked_div(node_count) {
        Some(each @ (2 | 3 | 6)) if row_count.is_multiple_of(node_count) => {
            Ok(&Direction::ALL[..each])
        }
        _ => Err(format!(
            "{node_count} nodes for the {row_count} rows of the matrix; expected 2, 3 or 6 rows for each node, because this table tells no directions"
        )),
    }
}

/// A remark on directions that are taken so.
pub(super) fn note(row_count: usize, node_count: usize, directions: &[Direction]) -> String {
    let names: Vec<&str> = directions
        .iter()
        .map(|direction| direction.name())
        .collect();
    format!(
        "the table names {node_count} nodes for {row_count} rows; their directions are taken as {}",
        names.join(", ")
    )
}
