//! Whether what should be symmetric is.

use std::path::Path;

use rayon::prelude::*;

use super::assemble::Columns;
use super::body::{Chunk, Triplet, line_of_stored_entry};
use super::header::Header;
use crate::Error;

/// Largest |a_ij - a_ji| relative to max(|a_ij|, |a_ji|, √|a_ii a_jj|) that counts as rounding. In a semi-definite matrix
/// |a_ij| ≤ √(a_ii a_jj), so the measure is the same in any units, and cancellation remains (1e-7 beside 8e9) pass. Assembly in
/// double precision stays below 1e-12 and files with nine digits below 1e-8; an element matrix that really is unsymmetric
/// (follower load, friction, gyroscopic part) is far above.
const ROUNDING_ASYMMETRY: f64 = 1e-8;

/// A file that stores one triangle may use either, entry by entry, but not both for the same pair: mirroring would double it.
///
/// # Errors
/// [`Error::Line`] with the first pair.
pub(super) fn refuse_pairs_in_both_triangles(
    path: &Path,
    text: &[u8],
    header: &Header,
    chunks: &[Chunk],
) -> Result<(), Error> {
    let upper_count: usize = chunks.iter().map(|chunk| chunk.upper_count).sum();
    let lower_count: usize = chunks.iter().map(|chunk| chunk.lower_count).sum();
    if upper_count == 0 || lower_count == 0 {
        return Ok(());
    }
    let pair = |entry: &Triplet| (entry.row.min(entry.column), entry.row.max(entry.column));
    let mut upper: Vec<(u32, u32)> = chunks
        .iter()
        .flat_map(|chunk| &chunk.entries)
        .filter(|entry| entry.row < entry.column)
        .map(pair)
        .collect();
    upper.par_sort_unstable();
    let mut before = 0;
    for chunk in chunks {
        let is_repeated =
            |entry: &Triplet| entry.row > entry.column && upper.binary_search(&pair(entry)).is_ok();
        if let Some(at) = chunk.entries.par_iter().position_first(is_repeated) {
            let Triplet { row, column, .. } = chunk.entries[at];
            let (row, column) = (row + 1, column + 1);
            return Err(Error::Line {
                path: path.into(),
                line: line_of_stored_entry(text, header, before + at),
                message: format!(
                    "({row}, {column}) and ({column}, {row}) are both stored, but the banner promises one triangle; \
                     expected `general` in the banner or one of them"
                ),
            });
        }
        before += chunk.entries.len();
    }
    Ok(())
}

/// Relative difference of a pair across the diagonal, 0-based.
#[derive(Clone, Copy, Debug, Default)]
struct Asymmetry {
    relative: f64,
    row: usize,
    column: usize,
    values: [f64; 2],
}

/// The mean of a matrix and its transpose, exactly symmetric, and its largest relative asymmetry.
/// Where only one of a pair is stored, the other counts as zero, and both are stored afterwards.
///
/// # Errors
/// [`Error::File`] with the worst pair if it is beyond rounding.
pub(super) fn averaged(
    path: &Path,
    stored: Columns,
    transposed: Columns,
) -> Result<(Columns, f64), Error> {
    let diagonal: Vec<f64> = (0..stored.column_count())
        .into_par_iter()
        .map(|column| {
            let range = stored.column(column);
            let found = stored.rows[range.clone()].binary_search(&(column as u32));
            found.map_or(0.0, |at| stored.values[range.start + at].abs())
        })
        .collect();
    let columns: Vec<usize> = (0..stored.column_count()).collect();
    let worst = columns
        .par_iter()
        .map(|&column| {
            let mut worst = Asymmetry::default();
            for_each_pair(&stored, &transposed, column, |row, a, b| {
                let (row, difference) = (row as usize, (a - b).abs());
                let scale = a
                    .abs()
                    .max(b.abs())
                    .max(diagonal[row].sqrt() * diagonal[column].sqrt());
                if row > column && difference > worst.relative * scale {
                    worst = Asymmetry {
                        relative: difference / scale,
                        row,
                        column,
                        values: [a, b],
                    };
                }
            });
            worst
        })
        .reduce(Asymmetry::default, |a, b| {
            let b_is_first = (b.column, b.row) < (a.column, a.row);
            if b.relative > a.relative || (b.relative == a.relative && b_is_first) {
                b
            } else {
                a
            }
        });
    if worst.relative > ROUNDING_ASYMMETRY {
        let Asymmetry {
            relative,
            row,
            column,
            values: [a, b],
        } = worst;
        let (row, column) = (row + 1, column + 1);
        return Err(Error::File {
            path: path.into(),
            message: format!(
                "not symmetric: ({row}, {column}) is {a:e}, but ({column}, {row}) is {b:e}, the worst pair; \
                 relative difference {relative:.1e}, expected at most {ROUNDING_ASYMMETRY:e}"
            ),
        });
    }
    if worst.relative == 0.0 && stored.rows == transposed.rows && stored.starts == transposed.starts
    {
        return Ok((stored, 0.0));
    }
    Ok((mean(&stored, &transposed)?, worst.relative))
}

/// Walks over the union of two columns: (row, value of the first, value of the second).
fn for_each_pair(
    first: &Columns,
    second: &Columns,
    column: usize,
    mut pair: impl FnMut(u32, f64, f64),
) {
    let (mut a, mut b) = (first.column(column), second.column(column));
    loop {
        let row_a = first.rows[a.clone()].first().copied();
        let row_b = second.rows[b.clone()].first().copied();
        let row = match (row_a, row_b) {
            (None, None) => return,
            (Some(row), None) | (None, Some(row)) => row,
            (Some(row_a), Some(row_b)) => row_a.min(row_b),
        };
        let value_of = |values: &[f64], range: &mut std::ops::Range<usize>, found: Option<u32>| {
            if found != Some(row) {
                return 0.0;
            }
            let value = values[range.start];
            range.start += 1;
            value
        };
        let value_a = value_of(&first.values, &mut a, row_a);
        let value_b = value_of(&second.values, &mut b, row_b);
        pair(row, value_a, value_b);
    }
}

fn mean(stored: &Columns, transposed: &Columns) -> Result<Columns, Error> {
    let mut starts = Vec::with_capacity(stored.starts.len());
    let mut rows = Vec::with_capacity(stored.rows.len());
    let mut values = Vec::with_capacity(stored.rows.len());
    starts.push(0u32);
    for column in 0..stored.column_count() {
        for_each_pair(stored, transposed, column, |row, a, b| {
            rows.push(row);
            // Halving first can't overflow; equal values stay as they are.
            values.push(if a == b { a } else { 0.5 * a + 0.5 * b });
        });
        starts.push(u32::try_from(rows.len()).map_err(|_| Error::Mismatch {
            message:
                "more than 4294967295 entries after completing the pattern symmetrically".into(),
        })?);
    }
    Ok(Columns {
        row_count: stored.row_count,
        starts,
        rows,
        values,
        duplicates_summed: stored.duplicates_summed,
    })
}
