//! Making and cutting sparse matrices.

use std::collections::BTreeMap;

use dcb_formats::SparseMatrix;
use faer::sparse::SymbolicSparseColMat;

/// Wraps sorted compressed columns.
pub(crate) fn from_columns(
    size: usize,
    column_starts: Vec<u32>,
    rows: Vec<u32>,
    values: Vec<f64>,
) -> SparseMatrix {
    SparseMatrix::new(
        SymbolicSparseColMat::new_checked(size, size, column_starts, None, rows),
        values,
    )
}

/// Sums element matrices of a small model. Entries of (i, j) and (j, i) are added in the same order, so symmetric
/// elements give an exactly symmetric sum. Exact zeros are left out.
#[derive(Default)]
pub(crate) struct Assembly {
    columns: Vec<BTreeMap<u32, f64>>,
}

impl Assembly {
    /// An empty matrix of the given size.
    pub(crate) fn new(size: usize) -> Self {
        Self {
            columns: vec![BTreeMap::new(); size],
        }
    }

    /// Adds one number.
    pub(crate) fn add(&mut self, row: usize, column: usize, value: f64) {
        if value != 0.0 {
            *self.columns[column].entry(row as u32).or_insert(0.0) += value;
        }
    }

    /// The finished matrix.
    pub(crate) fn finish(self) -> SparseMatrix {
        let size = self.columns.len();
        let mut starts = vec![0_u32];
        let (mut rows, mut values) = (Vec::new(), Vec::new());
        for column in self.columns {
            for (row, value) in column.into_iter().filter(|(_, value)| *value != 0.0) {
                rows.push(row);
                values.push(value);
            }
            starts.push(rows.len() as u32);
        }
        from_columns(size, starts, rows, values)
    }
}

/// Rows and columns of `matrix` in the order of `kept`; an index not below the matrix size becomes an empty row and column.
pub(crate) fn principal_submatrix(matrix: &SparseMatrix, kept: &[usize]) -> SparseMatrix {
    let mut new_row = vec![None; matrix.ncols()];
    for (new, &old) in kept.iter().enumerate() {
        if let Some(slot) = new_row.get_mut(old) {
            *slot = Some(new);
        }
    }
    let mut assembly = Assembly::new(kept.len());
    for (column, row, value) in entries(matrix) {
        if let (Some(row), Some(column)) = (new_row[row], new_row[column]) {
            assembly.add(row, column, value);
        }
    }
    assembly.finish()
}

/// `(column, row, value)` of every stored entry, column after column.
pub(crate) fn entries(matrix: &SparseMatrix) -> impl Iterator<Item = (usize, usize, f64)> {
    let (starts, rows, values) = (matrix.col_ptr(), matrix.row_idx(), matrix.val());
    (0..matrix.ncols()).flat_map(move |column| {
        let range = starts[column] as usize..starts[column + 1] as usize;
        range.map(move |at| (column, rows[at] as usize, values[at]))
    })
}

/// The same pattern with `value(row, column, old)` in place of each entry.
pub(crate) fn map_entries(
    matrix: &SparseMatrix,
    value: impl Fn(usize, usize, f64) -> f64,
) -> SparseMatrix {
    let values = entries(matrix)
        .map(|(column, row, old)| value(row, column, old))
        .collect();
    from_columns(
        matrix.ncols(),
        matrix.col_ptr().to_vec(),
        matrix.row_idx().to_vec(),
        values,
    )
}
