//! Arrays of integers of NumPy and MATLAB files: label and direction of each row (`dof_ref` of ansys-mapdl-reader), directions 0 to 5, or the label of
//! each node in one column.

use std::path::Path;

use dcb_formats::Error;

use super::DofTable;
use super::direction::{note, of_each_node};
use crate::matrix::tables::read_table;
use crate::stored::{LARGEST_LABEL, RowLabel};

/// Reads an array by its name, or `dof_ref`.
pub(super) fn read(path: &Path, name: Option<&str>, row_count: usize) -> Result<DofTable, Error> {
    let (table, sha256) = read_table(path, name)?;
    let bad = |message| Error::File {
        path: path.into(),
        message,
    };
    if table.columns != 1 {
        let rows = table.labels().map_err(bad)?;
        if rows.len() != row_count {
            return Err(bad(format!(
                "has {} rows, the matrix {row_count}; this table belongs to another one",
                rows.len()
            )));
        }
        return Ok(DofTable {
            rows,
            sha256,
            notes: Vec::new(),
        });
    }
    let node_count = table.row_count();
    let directions = of_each_node(row_count, node_count).map_err(bad)?;
    let mut rows = Vec::with_capacity(row_count);
    for value in &table.values {
        let node = u32::try_from(*value)
            .ok()
            .filter(|node| (1..=LARGEST_LABEL).contains(node));
        let node = node.ok_or_else(|| {
            bad(format!(
                "has the label {value}; labels of nodes are from 1 to {LARGEST_LABEL}"
            ))
        })?;
        let of_node = directions
            .iter()
            .map(|&direction| RowLabel::Nodal { node, direction });
        rows.extend(of_node);
    }
    let mut sorted = table.values;
    sorted.sort_unstable();
    if let Some(pair) = sorted.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(bad(format!(
            "has the label {} twice; a map names every node once",
            pair[0]
        )));
    }
    Ok(DofTable {
        rows,
        sha256,
        notes: vec![note(row_count, node_count, directions)],
    })
}
