//! Stiffness and mass of a component from the matrices of files: duplicates summed, triangles completed, rows in a wanted order.

use dcb_formats::component::ROUNDING_ASYMMETRY;
use dcb_formats::matrix::blocks::{CannotAssemble, Entries, Expansion, Triplet, assembled};
use dcb_formats::matrix::symmetrized;
use dcb_formats::{Error, SparseMatrix};
use faer::sparse::SymbolicSparseColMat;
use rayon::prelude::*;

use crate::stored::{Content, StoredMatrix, Triangles};

/// A matrix is as symmetric as it should be where pairs agree to this, relative to their diagonals.
const PAIR_TOLERANCE: f64 = 1e-9;

/// A matrix on its way into a component.
pub(crate) struct Operator {
    /// Full symmetric storage.
    pub matrix: SparseMatrix,
    /// Remarks for the user.
    pub notes: Vec<String>,
}

/// A stored matrix in full symmetric storage; row i of the file becomes row `new_rows[i]` of `size`.
///
/// # Errors
/// A message for the file: pairs that disagree, more entries than are supported.
pub(crate) fn operator(
    stored: StoredMatrix,
    new_rows: Option<&[u32]>,
    size: usize,
) -> Result<Operator, String> {
    let StoredMatrix {
        content,
        triangles,
        mut notes,
        ..
    } = stored;
    let mut entries = match (content, new_rows) {
        (Content::Compressed(matrix), None) if matrix.nrows() == size => {
            return completed_columns(matrix, triangles, notes);
        }
        (Content::Compressed(matrix), _) => vec![entries_of(&matrix)?],
        (Content::Entries(blocks), _) => blocks,
    };
    // As stored: in the new order a triangle is none any more.
    let is_one_sided = is_one_sided(&entries);
    if let Some(new_rows) = new_rows {
        entries
            .par_iter_mut()
            .for_each(|block| block.renumber(new_rows));
    }
    let (mut entries, expansion) = match (triangles, is_one_sided) {
        (Triangles::One | Triangles::Unsaid, true) => (entries, Expansion::Mirrored),
        (Triangles::Both | Triangles::Unsaid, false) | (Triangles::Both, true) => {
            (entries, Expansion::AsStored)
        }
        (Triangles::One, false) => (one_of_each_pair(entries)?, Expansion::Mirrored),
    };
    if expansion == Expansion::AsStored && entries.iter().all(Entries::stand_by_rows) {
        // What is averaged with its mirror image may as well be the mirror image, which is joined without sorting.
        entries.par_iter_mut().for_each(Entries::transpose);
    }
    let (matrix, duplicates) =
        assembled(entries, (size, size), expansion).map_err(|why| match why {
            CannotAssemble::TooMany { entries } => {
                format!(
                    "{entries} entries in full storage; at most {} are supported",
                    u32::MAX
                )
            }
            CannotAssemble::NotFinite { row, column } => format!(
                "the repeated entries of row {}, column {} add up to something infinite",
                row + 1,
                column + 1
            ),
        })?;
    if duplicates > 0 {
        notes.push(format!("{duplicates} repeated entries were summed"));
    }
    symmetric(matrix, notes)
}

/// Compressed columns of both triangles, or of one.
fn completed_columns(
    matrix: SparseMatrix,
    triangles: Triangles,
    notes: Vec<String>,
) -> Result<Operator, String> {
    let (above, below) = (0..matrix.ncols())
        .into_par_iter()
        .map(|column| {
            let rows = matrix.row_idx_of_col_raw(column);
            let above = rows.partition_point(|row| (*row as usize) < column);
            let diagonal = rows.get(above).is_some_and(|row| *row as usize == column);
            (above, rows.len() - above - usize::from(diagonal))
        })
        .reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    let is_one_sided = (above == 0) != (below == 0);
    if is_one_sided && triangles != Triangles::Both
        || triangles == Triangles::One && above + below > 0
    {
        let size = matrix.nrows();
        let entries = vec![entries_of(&matrix)?];
        drop(matrix);
        let entries = match is_one_sided {
            true => entries,
            false => one_of_each_pair(entries)?,
        };
        let assembled = assembled(entries, (size, size), Expansion::Mirrored);
        let (matrix, _) = assembled.map_err(|why| format!("{why:?}"))?;
        return Ok(Operator { matrix, notes });
    }
    symmetric(matrix, notes)
}

fn symmetric(matrix: SparseMatrix, mut notes: Vec<String>) -> Result<Operator, String> {
    let (matrix, asymmetry) = symmetrized(matrix)?;
    if asymmetry > ROUNDING_ASYMMETRY {
        notes.push(format!(
            "an asymmetry of up to {asymmetry:.1e} was averaged away"
        ));
    }
    Ok(Operator { matrix, notes })
}

/// Whether everything is on one side of the diagonal, or on it.
fn is_one_sided(blocks: &[Entries]) -> bool {
    let counts = blocks.par_iter().map(Entries::triangle_counts);
    let (above, below) = counts.reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    above == 0 || below == 0
}

/// Entries of compressed columns.
fn entries_of(matrix: &SparseMatrix) -> Result<Entries, String> {
    let count = matrix.compute_nnz();
    let mut entries = Entries::with_capacity(count)
        .ok_or_else(|| format!("not enough memory for {count} entries"))?;
    for column in 0..matrix.ncols() {
        let rows = matrix.row_idx_of_col_raw(column).iter();
        for (row, value) in rows.zip(matrix.val_of_col(column)) {
            entries.push(Triplet {
                row: *row,
                column: column as u32,
                value: *value,
            });
        }
    }
    Ok(entries)
}

/// Where a file that promises one of each pair has some pairs twice: those must agree and count once.
///
/// # Errors
/// The pair that disagrees most.
fn one_of_each_pair(blocks: Vec<Entries>) -> Result<Vec<Entries>, String> {
    let mut stored: Vec<(u32, u32, bool, f64)> = blocks
        .par_iter()
        .flat_map_iter(|block| block.iter())
        .map(|Triplet { row, column, value }| {
            (row.max(column), row.min(column), row < column, value)
        })
        .collect();
    drop(blocks);
    // Stable: repeated entries add up in file order.
    stored.par_sort_by_key(|(row, column, is_above, _)| (*column, *row, *is_above));
    let mut summed: Vec<(u32, u32, bool, f64)> = Vec::new();
    for entry in stored {
        match summed.last_mut() {
            Some(last) if (last.0, last.1, last.2) == (entry.0, entry.1, entry.2) => {
                last.3 += entry.3
            }
            _ => summed.push(entry),
        }
    }
    let diagonal = |row: u32, summed: &[(u32, u32, bool, f64)]| {
        let place = summed.binary_search_by_key(&(row, row), |(row, column, ..)| (*column, *row));
        place.map_or(0.0, |at| summed[at].3.abs())
    };
    let mut entries = Entries::with_capacity(summed.len())
        .ok_or_else(|| format!("not enough memory for {} entries", summed.len()))?;
    for group in summed.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let (row, column, _, value) = group[0];
        if let Some((.., across)) = group.get(1) {
            let scale = (diagonal(row, &summed) * diagonal(column, &summed)).sqrt();
            if (value - across).abs() > PAIR_TOLERANCE * scale.max(value.abs()) {
                return Err(format!(
                    "row {}, column {} is {value:e} in one triangle and {across:e} in the other; expected one triangle, or both that agree",
                    row + 1,
                    column + 1
                ));
            }
        }
        entries.push(Triplet { row, column, value });
    }
    Ok(vec![entries])
}

/// The rows and columns that are kept, in their order.
pub(crate) fn restricted(matrix: &SparseMatrix, kept: &[usize]) -> SparseMatrix {
    const GONE: u32 = u32::MAX;
    let mut new = vec![GONE; matrix.nrows()];
    for (at, &row) in kept.iter().enumerate() {
        new[row] = at as u32;
    }
    let mut starts = Vec::with_capacity(kept.len() + 1);
    let (mut rows, mut values) = (Vec::new(), Vec::new());
    starts.push(0);
    for &column in kept {
        let stored = matrix.row_idx_of_col_raw(column).iter();
        for (row, value) in stored.zip(matrix.val_of_col(column)) {
            if new[*row as usize] != GONE {
                rows.push(new[*row as usize]);
                values.push(*value);
            }
        }
        starts.push(rows.len() as u32);
    }
    let size = kept.len();
    let symbolic = SymbolicSparseColMat::new_checked(size, size, starts, None, rows);
    SparseMatrix::new(symbolic, values)
}

/// An error of a file, of a message about its matrix.
pub(crate) fn of_file(path: &std::path::Path, message: String) -> Error {
    Error::File {
        path: path.to_path_buf(),
        message,
    }
}
