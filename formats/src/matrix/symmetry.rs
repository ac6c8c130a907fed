//! Whether what should be symmetric is.

use std::ops::Range;
use std::path::Path;
use std::sync::atomic::Ordering;

use rayon::prelude::*;

use super::assemble::Columns;
use super::entries::Triplet;
use super::entry_blocks::Blocks;
use super::shared::shared_reals;
use crate::{Error, SparseMatrix};

/// Largest |a_ij - a_ji| relative to max(|a_ij|, |a_ji|, √|a_ii a_jj|) that counts as rounding. In a semi-definite matrix
/// |a_ij| ≤ √(a_ii a_jj), so the measure is the same in any units, and cancellation remains (1e-7 beside 8e9) pass. Assembly in
/// double precision stays below 1e-12 and files with nine digits below 1e-8; an element matrix that really is unsymmetric
/// (follower load, friction, gyroscopic part) is far above.
const ROUNDING_ASYMMETRY: f64 = 1e-8;

/// A file that stores one triangle may use either, entry by entry, but not both for the same pair: mirroring would double it.
///
/// # Errors
/// [`Error::Line`] with the first pair.
pub(super) fn refuse_pairs_in_both_triangles(path: &Path, file: &Blocks) -> Result<(), Error> {
    let blocks = &file.blocks;
    let upper_count: usize = blocks.iter().map(|block| block.upper_count).sum();
    let lower_count: usize = blocks.iter().map(|block| block.lower_count).sum();
    if upper_count == 0 || lower_count == 0 {
        return Ok(());
    }
    let pair = |entry: Triplet| (entry.row.min(entry.column), entry.row.max(entry.column));
    let mut upper: Vec<(u32, u32)> = blocks
        .par_iter()
        .flat_map_iter(|block| block.entries.iter())
        .filter(|entry| entry.row < entry.column)
        .map(pair)
        .collect();
    upper.par_sort_unstable();
    let is_repeated =
        |entry: Triplet| entry.row > entry.column && upper.binary_search(&pair(entry)).is_ok();
    let first = blocks
        .par_iter()
        .enumerate()
        .find_map_first(|(number, block)| {
            let found = block
                .entries
                .iter()
                .enumerate()
                .find(|(_, entry)| is_repeated(*entry));
            found.map(|(at, entry)| (number, at, entry))
        });
    let Some((number, at, Triplet { row, column, .. })) = first else {
        return Ok(());
    };
    let (row, column) = (row + 1, column + 1);
    Err(Error::Line {
        path: path.into(),
        line: file.line_of_entry(number, at),
        message: format!(
            "({row}, {column}) and ({column}, {row}) are both stored, but the banner promises one triangle; \
             expected `general` in the banner or one of them"
        ),
    })
}

/// Relative difference of a pair across the diagonal, 0-based; the row is below it.
#[derive(Clone, Copy, Debug, Default)]
struct Asymmetry {
    relative: f64,
    row: usize,
    column: usize,
    values: [f64; 2],
}

impl Asymmetry {
    /// Of an entry and its mirror image, which are measured by at least `scale`.
    fn of([row, column]: [usize; 2], [here, across]: [f64; 2], scale: f64) -> Self {
        let largest = here.abs().max(across.abs()).max(scale);
        let (row, column, values) = if row > column {
            (row, column, [here, across])
        } else {
            (column, row, [across, here])
        };
        Self {
            relative: (here - across).abs() / largest,
            row,
            column,
            values,
        }
    }

    /// The larger one, of equal ones the first.
    fn worse(self, other: Self) -> Self {
        let other_is_first = (other.column, other.row) < (self.column, self.row);
        if other.relative > self.relative || (other.relative == self.relative && other_is_first) {
            other
        } else {
            self
        }
    }
}

/// A matrix that isn't symmetric, or can't be made so: its worst pair, or why, in words.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NotSymmetric(String);

impl From<NotSymmetric> for String {
    fn from(NotSymmetric(message): NotSymmetric) -> Self {
        message
    }
}

/// A matrix with sorted columns as [`averaged`], and its largest relative asymmetry. One that is symmetric already is only looked through.
///
/// # Errors
/// As [`averaged`].
pub(crate) fn made_symmetric(matrix: SparseMatrix) -> Result<(SparseMatrix, f64), NotSymmetric> {
    if is_symmetric(&matrix) {
        return Ok((matrix, 0.0));
    }
    let (symbolic, values) = matrix.into_parts();
    let (row_count, _, starts, _, rows) = symbolic.into_parts();
    let columns = Columns {
        row_count,
        starts,
        rows,
        values,
        duplicates_summed: 0,
    };
    let (columns, largest) = averaged(columns)?;
    Ok((columns.into_matrix(), largest))
}

/// Whether a square matrix with sorted columns is its own transpose, to the last bit and in its pattern.
fn is_symmetric(matrix: &SparseMatrix) -> bool {
    let count = matrix.ncols();
    let chunk = count.div_ceil(4 * rayon::current_num_threads()).max(1);
    let chunks = (0..count).into_par_iter().step_by(chunk);
    let balance = chunks
        .map(|first| mirrored(matrix, first..(first + chunk).min(count)))
        .try_reduce(|| 0, |a, b| Some(a + b));
    // Each entry below the diagonal has its mirror image above it; so none is left over where there are as many.
    balance == Some(0)
}

/// Entries below the diagonal less those above it, in some columns of a matrix; `None` if one below isn't mirrored.
fn mirrored(matrix: &SparseMatrix, columns: Range<usize>) -> Option<i64> {
    // The entries above the diagonal of a column, from the top, are those below it in the columns before, in their order.
    let mut above: Vec<usize> = (columns.start..matrix.ncols())
        .map(|row| {
            let rows = matrix.row_idx_of_col_raw(row);
            rows.partition_point(|row| (*row as usize) < columns.start)
        })
        .collect();
    let mut balance = 0;
    for column in columns.clone() {
        let (rows, values) = (matrix.row_idx_of_col_raw(column), matrix.val_of_col(column));
        let first = rows.partition_point(|row| (*row as usize) <= column);
        let has_diagonal = first > 0 && rows[first - 1] as usize == column;
        balance -= (first - usize::from(has_diagonal)) as i64;
        balance += (rows.len() - first) as i64;
        for (row, value) in rows[first..].iter().zip(&values[first..]) {
            let row = *row as usize;
            let at = &mut above[row - columns.start];
            let is_mirrored = matrix.row_idx_of_col_raw(row).get(*at) == Some(&(column as u32))
                && matrix.val_of_col(row)[*at] == *value;
            if !is_mirrored {
                return None;
            }
            *at += 1;
        }
    }
    Some(balance)
}

/// The mean of a matrix and its transpose, exactly symmetric, and its largest relative asymmetry.
/// Where only one of a pair is stored, the other counts as zero, and both are stored afterwards.
///
/// # Errors
/// The worst pair if it is beyond rounding.
pub(super) fn averaged(mut matrix: Columns) -> Result<(Columns, f64), NotSymmetric> {
    let (worst, unpaired_count) = worst_asymmetry(&matrix);
    if worst.relative > ROUNDING_ASYMMETRY {
        let Asymmetry {
            relative,
            row,
            column,
            values: [a, b],
        } = worst;
        let (row, column) = (row + 1, column + 1);
        return Err(NotSymmetric(format!(
            "not symmetric: ({row}, {column}) is {a:e}, but ({column}, {row}) is {b:e}, the worst pair; \
             relative difference {relative:.1e}, expected at most {ROUNDING_ASYMMETRY:e}"
        )));
    }
    if unpaired_count > 0 {
        let places = unpaired(&matrix);
        matrix = with_zeros_at(matrix, &places)?;
    }
    if worst.relative > 0.0 {
        average_pairs(&mut matrix);
    }
    Ok((matrix, worst.relative))
}

/// Where (row, column) is stored.
#[inline]
fn position(matrix: &Columns, row: usize, column: usize) -> Option<usize> {
    let range = matrix.column(column);
    let found = matrix.rows[range.clone()].binary_search(&(row as u32));
    found.ok().map(|at| range.start + at)
}

/// The worst pair, and how many entries have no mirror image. Of each pair across the diagonal at least one is stored; both are
/// looked at from each that is.
fn worst_asymmetry(matrix: &Columns) -> (Asymmetry, usize) {
    let value_at = |row, column| position(matrix, row, column).map(|at| matrix.values[at]);
    let scale: Vec<f64> = (0..matrix.column_count())
        .into_par_iter()
        .map(|column| value_at(column, column).unwrap_or(0.0).abs().sqrt())
        .collect();
    let in_column = |column: usize| {
        let mut worst = Asymmetry::default();
        let mut unpaired = 0;
        for at in matrix.column(column) {
            let (row, here) = (matrix.rows[at] as usize, matrix.values[at]);
            let stored = value_at(column, row);
            unpaired += usize::from(stored.is_none());
            let across = stored.unwrap_or(0.0);
            if here != across {
                let scale = scale[row] * scale[column];
                worst = worst.worse(Asymmetry::of([row, column], [here, across], scale));
            }
        }
        (worst, unpaired)
    };
    (0..matrix.column_count())
        .into_par_iter()
        .map(in_column)
        .reduce(Default::default, |a, b| (a.0.worse(b.0), a.1 + b.1))
}

/// (column, row) of the places that aren't stored though their mirror images are, in order.
fn unpaired(matrix: &Columns) -> Vec<(u32, u32)> {
    let mut places: Vec<(u32, u32)> = (0..matrix.column_count())
        .into_par_iter()
        .flat_map_iter(|column| {
            matrix.rows[matrix.column(column)]
                .iter()
                .filter(move |row| position(matrix, column, **row as usize).is_none())
                .map(move |row| (*row, column as u32))
        })
        .collect();
    places.par_sort_unstable();
    places
}

/// Stores zeros at places (column, row), given in order, that weren't stored.
fn with_zeros_at(matrix: Columns, places: &[(u32, u32)]) -> Result<Columns, NotSymmetric> {
    let total = matrix.rows.len() + places.len();
    if u32::try_from(total).is_err() {
        return Err(NotSymmetric(
            "more than 4294967295 entries after completing the pattern symmetrically".into(),
        ));
    }
    let mut starts = Vec::with_capacity(matrix.starts.len());
    let mut rows = Vec::with_capacity(total);
    let mut values = Vec::with_capacity(total);
    let mut places = places.iter().peekable();
    for column in 0..matrix.column_count() {
        starts.push(rows.len() as u32);
        for at in matrix.column(column) {
            let place = (column as u32, matrix.rows[at]);
            while let Some((_, row)) = places.next_if(|&&zero| zero < place) {
                rows.push(*row);
                values.push(0.0);
            }
            rows.push(matrix.rows[at]);
            values.push(matrix.values[at]);
        }
        while let Some((_, row)) = places.next_if(|zero| zero.0 as usize == column) {
            rows.push(*row);
            values.push(0.0);
        }
    }
    starts.push(rows.len() as u32);
    Ok(Columns {
        starts,
        rows,
        values,
        ..matrix
    })
}

/// Puts the mean into both places of every pair of a symmetric pattern.
fn average_pairs(matrix: &mut Columns) {
    let mut values = std::mem::take(&mut matrix.values);
    let shared = shared_reals(&mut values);
    let load = |at: usize| f64::from_bits(shared[at].load(Ordering::Relaxed));
    let matrix_ref = &*matrix;
    (0..matrix_ref.column_count())
        .into_par_iter()
        .for_each(|column| {
            let range = matrix_ref.column(column);
            // Each pair is seen from its place below the diagonal only, by one thread.
            for below in range.filter(|&at| matrix_ref.rows[at] as usize > column) {
                let Some(above) = position(matrix_ref, column, matrix_ref.rows[below] as usize)
                else {
                    continue;
                };
                let (a, b) = (load(below), load(above));
                if a != b {
                    // Halving first can't overflow.
                    let mean = (0.5 * a + 0.5 * b).to_bits();
                    shared[below].store(mean, Ordering::Relaxed);
                    shared[above].store(mean, Ordering::Relaxed);
                }
            }
        });
    matrix.values = values;
}
