//! Tables of integers beside matrices, and row labels from those named `dof_ref`.

use dcb_formats::mesh::Direction;
use rustc_hash::FxHashMap;

use crate::stored::{LARGEST_LABEL, RowLabel, Rows, StoredMatrix};

/// Name of the table that labels the rows, as ansys-mapdl-reader calls it.
pub(super) const DOF_REF: &str = "dof_ref";

/// A table of integers, one or two a row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IntegerTable {
    /// 1 or 2.
    pub columns: usize,
    /// Row after row.
    pub values: Vec<i64>,
}

impl IntegerTable {
    /// Number of rows.
    pub fn row_count(&self) -> usize {
        self.values.len() / self.columns.max(1)
    }

    /// From an array with one or two columns that is stored row after row, or column after column.
    pub(super) fn of(columns: u64, values: Vec<i64>, is_by_columns: bool) -> Result<Self, String> {
        let columns = match columns {
            1 => 1,
            2 => 2,
            other => return Err(format!("{other} columns; a table of dofs has one or two")),
        };
        let values = match is_by_columns && columns == 2 {
            true => {
                let (first, second) = values.split_at(values.len() / 2);
                first
                    .iter()
                    .zip(second)
                    .flat_map(|(a, b)| [*a, *b])
                    .collect()
            }
            false => values,
        };
        Ok(Self { columns, values })
    }

    /// Labels of rows: the node's label and the direction, 0 to 5.
    pub(crate) fn labels(&self) -> Result<Vec<RowLabel>, String> {
        let (pairs, _) = self.values.as_chunks::<2>();
        if self.columns != 2 {
            return Err(
                "has one column; it needs the node's label and the direction, 0 to 5".into(),
            );
        }
        let mut rows = FxHashMap::default();
        let label = |(row, pair): (usize, &[i64; 2])| -> Result<RowLabel, String> {
            let [node, direction] = *pair;
            let told = |found: String| format!("row {}: {found}", row + 1);
            let label = u32::try_from(node)
                .ok()
                .filter(|label| (1..=LARGEST_LABEL).contains(label));
            let label = label.ok_or_else(|| {
                told(format!(
                    "the label {node}; labels of nodes are from 1 to {LARGEST_LABEL}"
                ))
            })?;
            let direction = usize::try_from(direction)
                .ok()
                .and_then(Direction::from_index)
                .ok_or_else(|| {
                    told(format!(
                        "the direction {direction}; 0 to 5 are ux, uy, uz, rx, ry, rz, and no others are supported"
                    ))
                })?;
            match rows.insert((label, direction.index()), row) {
                Some(before) => Err(told(format!(
                    "node {label}, {}, as in row {} already",
                    direction.name(),
                    before + 1
                ))),
                None => Ok(RowLabel::Nodal {
                    node: label,
                    direction,
                }),
            }
        };
        pairs.iter().enumerate().map(label).collect()
    }

    /// Labels the rows of matrices that were read from the same file.
    ///
    /// # Errors
    /// Labels that can't be, pairs that come twice, another number of rows.
    pub(super) fn label_rows(&self, matrices: &mut [StoredMatrix]) -> Result<(), String> {
        let labels = self.labels()?;
        for matrix in matrices {
            if matrix.size != labels.len() {
                return Err(format!(
                    "has {} rows, but the matrix {:?} has {}",
                    labels.len(),
                    matrix.name,
                    matrix.size
                ));
            }
            matrix.rows = Rows::Labelled(labels.clone());
        }
        Ok(())
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn labels(values: &[i64]) -> Result<Vec<RowLabel>, String> {
        IntegerTable::of(2, values.to_vec(), false)
            .unwrap()
            .labels()
    }

    #[test]
    fn labels_that_cannot_be_are_refused_by_their_row() {
        assert_eq!(labels(&[7, 0, 7, 5]).unwrap().len(), 2);
        for (values, message) in [
            (
                [1, 0, 0, 1],
                "row 2: the label 0; labels of nodes are from 1 to 2147483647",
            ),
            (
                [-4, 0, 3, 1],
                "row 1: the label -4; labels of nodes are from 1 to 2147483647",
            ),
            (
                [1 << 31, 0, 3, 1],
                "row 1: the label 2147483648; labels of nodes are from 1 to 2147483647",
            ),
            ([3, 1, 3, 1], "row 2: node 3, uy, as in row 1 already"),
            (
                [3, 1, 3, 6],
                "row 2: the direction 6; 0 to 5 are ux, uy, uz, rx, ry, rz, and no others are supported",
            ),
        ] {
            assert_eq!(labels(&values).unwrap_err(), message);
        }
    }

    #[test]
    fn columns_become_rows() {
        let table = IntegerTable::of(2, vec![1, 2, 3, 4, 5, 6], true).unwrap();
        assert_eq!(table.values, [1, 4, 2, 5, 3, 6]);
        assert!(IntegerTable::of(3, vec![1, 2, 3], false).is_err());
        assert!(
            IntegerTable::of(1, vec![1], false)
                .unwrap()
                .labels()
                .is_err()
        );
    }
}
