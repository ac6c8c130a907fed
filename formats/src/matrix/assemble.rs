//! Compressed columns from entries in any order.
//!
//! Count, prefix sum, scatter, then sort and sum within each column. Every thread owns a range of columns and walks over the
//! entries in file order, passing by chunks that don't touch its range; so a column's entries arrive in file order, duplicates
//! are summed in file order, and neither depends on the number of threads. A file sorted by rows or columns needs no sorting.

use std::ops::Range;

use faer::sparse::SymbolicSparseColMat;
use rayon::prelude::*;

use super::body::{Chunk, Triplet};
use crate::SparseMatrix;

/// Where a stored entry (i, j) goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Expansion {
    /// (i, j).
    AsStored,
    /// (j, i).
    Transposed,
    /// (i, j) and, off the diagonal, (j, i).
    Mirrored,
    /// (i, j) and, off the diagonal, (j, i) with the opposite sign.
    MirroredNegated,
}

/// Compressed columns with ascending, unique rows.
#[derive(Debug)]
pub(super) struct Columns {
    pub(super) row_count: usize,
    /// Start of each column, and the end of the last.
    pub(super) starts: Vec<u32>,
    pub(super) rows: Vec<u32>,
    pub(super) values: Vec<f64>,
    /// Stored entries that were added to an earlier one.
    pub(super) duplicates_summed: usize,
}

/// Why entries don't make a matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CannotAssemble {
    /// More entries than 32-bit indices reach.
    TooMany { entries: u64 },
    /// Duplicates add up to something infinite, 0-based place.
    NotFinite { row: u32, column: u32 },
}

/// Threads beyond these would mostly wait for the same memory.
const MOST_RANGES: usize = 16;

impl Columns {
    /// Sorts entries into columns and sums duplicates.
    pub(super) fn assemble(
        chunks: &[Chunk],
        row_count: usize,
        column_count: usize,
        expansion: Expansion,
    ) -> Result<Self, CannotAssemble> {
        let range_count = (2 * rayon::current_num_threads()).min(MOST_RANGES);
        let starts = column_starts(chunks, column_count, expansion, range_count)?;
        let total = starts[column_count] as usize;
        let mut rows = vec![0u32; total];
        let mut values = vec![0f64; total];
        let ranges = balanced_ranges(&starts, range_count);
        let parts = split_at_ranges(&mut rows, &mut values, &starts, &ranges);
        let settled: Vec<Settled> = ranges
            .par_iter()
            .cloned()
            .zip(parts)
            .map(|(range, (rows, values))| {
                let starts = &starts[range.start..=range.end];
                scatter(chunks, expansion, range.clone(), starts, rows, values);
                settle(expansion, range.start, starts, rows, values)
            })
            .collect();
        if let Some((row, column)) = settled.iter().find_map(|part| part.not_finite) {
            return Err(CannotAssemble::NotFinite { row, column });
        }
        let duplicates_summed = settled.iter().map(|part| part.duplicates_summed).sum();
        let mut columns = Self {
            row_count,
            starts,
            rows,
            values,
            duplicates_summed,
        };
        if settled.iter().any(|part| !part.lengths.is_empty()) {
            columns.close_gaps(&ranges, &settled);
        }
        Ok(columns)
    }

    /// Number of columns.
    pub(super) fn column_count(&self) -> usize {
        self.starts.len() - 1
    }

    /// Where a column's entries are.
    pub(super) fn column(&self, column: usize) -> Range<usize> {
        self.starts[column] as usize..self.starts[column + 1] as usize
    }

    /// As the matrix that the other crates use.
    pub(super) fn into_matrix(self) -> SparseMatrix {
        let column_count = self.column_count();
        let symbolic = SymbolicSparseColMat::new_checked(
            self.row_count,
            column_count,
            self.starts,
            None,
            self.rows,
        );
        SparseMatrix::new(symbolic, self.values)
    }

    /// Moves the columns together where summing duplicates has left gaps.
    fn close_gaps(&mut self, ranges: &[Range<usize>], settled: &[Settled]) {
        let mut end = 0usize;
        for (range, part) in ranges.iter().zip(settled) {
            for column in range.clone() {
                let from = self.column(column);
                let length = part
                    .lengths
                    .get(column - range.start)
                    .map_or(from.len(), |&length| length as usize);
                self.rows.copy_within(from.start..from.start + length, end);
                self.values
                    .copy_within(from.start..from.start + length, end);
                // Column starts behind this one are still needed, so write the one just used.
                self.starts[column] = end as u32;
                end += length;
            }
        }
        let last = self.starts.len() - 1;
        self.starts[last] = end as u32;
        self.rows.truncate(end);
        self.values.truncate(end);
    }
}

/// Hands out (column, row, value) of every place an entry goes to, within a range of columns, in file order.
#[inline]
fn for_each_place(
    chunks: &[Chunk],
    expansion: Expansion,
    range: &Range<usize>,
    mut place: impl FnMut(usize, u32, f64),
) {
    let width = range.len();
    let mut place_if_within = |column: u32, row: u32, value: f64| {
        let local = (column as usize).wrapping_sub(range.start);
        if local < width {
            place(local, row, value);
        }
    };
    for chunk in chunks {
        let [first, last] = chunk.index_range;
        if last < first || (last as usize) < range.start || first as usize >= range.end {
            continue;
        }
        for &Triplet { row, column, value } in &chunk.entries {
            match expansion {
                Expansion::AsStored => place_if_within(column, row, value),
                Expansion::Transposed => place_if_within(row, column, value),
                Expansion::Mirrored | Expansion::MirroredNegated => {
                    place_if_within(column, row, value);
                    if row != column {
                        let mirrored = if expansion == Expansion::Mirrored {
                            value
                        } else {
                            -value
                        };
                        place_if_within(row, column, mirrored);
                    }
                }
            }
        }
    }
}

/// Start of each column, duplicates included, and the total at the end.
fn column_starts(
    chunks: &[Chunk],
    column_count: usize,
    expansion: Expansion,
    range_count: usize,
) -> Result<Vec<u32>, CannotAssemble> {
    let stored: usize = chunks.iter().map(|chunk| chunk.entries.len()).sum();
    let off_diagonal: usize = chunks
        .iter()
        .map(|chunk| chunk.upper_count + chunk.lower_count)
        .sum();
    let is_mirrored = matches!(expansion, Expansion::Mirrored | Expansion::MirroredNegated);
    let entries = (stored + if is_mirrored { off_diagonal } else { 0 }) as u64;
    if entries > u64::from(u32::MAX) {
        return Err(CannotAssemble::TooMany { entries });
    }
    let mut starts = vec![0u32; column_count + 1];
    let width = column_count.div_ceil(range_count).max(1);
    starts[1..]
        .par_chunks_mut(width)
        .enumerate()
        .for_each(|(number, counts)| {
            let first = number * width;
            for_each_place(
                chunks,
                expansion,
                &(first..first + counts.len()),
                |column, _, _| counts[column] += 1,
            );
        });
    let mut total = 0;
    for start in &mut starts {
        total += *start;
        *start = total;
    }
    Ok(starts)
}

/// Ranges of columns with about the same number of entries.
fn balanced_ranges(starts: &[u32], range_count: usize) -> Vec<Range<usize>> {
    let column_count = starts.len() - 1;
    let total = u64::from(starts[column_count]);
    let mut first = 0;
    (1..=range_count as u64)
        .map(|number| {
            let goal = total * number / range_count as u64;
            let end = starts
                .partition_point(|&start| u64::from(start) < goal)
                .clamp(first, column_count);
            let end = if number == range_count as u64 {
                column_count
            } else {
                end
            };
            let range = first..end;
            first = end;
            range
        })
        .collect()
}

fn split_at_ranges<'a>(
    mut rows: &'a mut [u32],
    mut values: &'a mut [f64],
    starts: &[u32],
    ranges: &[Range<usize>],
) -> Vec<(&'a mut [u32], &'a mut [f64])> {
    let mut parts = Vec::with_capacity(ranges.len());
    for range in ranges {
        let length = (starts[range.end] - starts[range.start]) as usize;
        let (rows_here, rows_after) = rows.split_at_mut(length);
        let (values_here, values_after) = values.split_at_mut(length);
        parts.push((rows_here, values_here));
        (rows, values) = (rows_after, values_after);
    }
    parts
}

/// Puts the entries of a range of columns into place, in file order.
fn scatter(
    chunks: &[Chunk],
    expansion: Expansion,
    range: Range<usize>,
    starts: &[u32],
    rows: &mut [u32],
    values: &mut [f64],
) {
    let base = starts[0];
    let mut next: Vec<u32> = starts[..range.len()]
        .iter()
        .map(|start| start - base)
        .collect();
    for_each_place(chunks, expansion, &range, |column, row, value| {
        let at = next[column] as usize;
        next[column] += 1;
        rows[at] = row;
        values[at] = value;
    });
}

/// What sorting and summing did to a range of columns.
#[derive(Debug, Default)]
struct Settled {
    /// Length of each column; empty if all are what they were.
    lengths: Vec<u32>,
    duplicates_summed: usize,
    not_finite: Option<(u32, u32)>,
}

/// Sorts each column by row and sums duplicates in file order.
fn settle(
    expansion: Expansion,
    first_column: usize,
    starts: &[u32],
    rows: &mut [u32],
    values: &mut [f64],
) -> Settled {
    let mut settled = Settled::default();
    let mut scratch: Vec<(u32, f64)> = Vec::new();
    let base = starts[0];
    for (local, bounds) in starts.windows(2).enumerate() {
        let (start, end) = ((bounds[0] - base) as usize, (bounds[1] - base) as usize);
        let (rows, values) = (&mut rows[start..end], &mut values[start..end]);
        let mut length = rows.len();
        if !rows.is_sorted_by(|a, b| a < b) {
            let column = (first_column + local) as u32;
            scratch.clear();
            scratch.extend(rows.iter().copied().zip(values.iter().copied()));
            scratch.sort_by_key(|entry| entry.0);
            length = 0;
            for group in scratch.chunk_by(|a, b| a.0 == b.0) {
                let row = group[0].0;
                let sum = group[1..]
                    .iter()
                    .fold(group[0].1, |sum, entry| sum + entry.1);
                rows[length] = row;
                values[length] = sum;
                length += 1;
                // Of an entry and its mirror image, only the lower one is counted: one line of the file.
                let is_image =
                    matches!(expansion, Expansion::Mirrored | Expansion::MirroredNegated)
                        && row < column;
                if !is_image {
                    settled.duplicates_summed += group.len() - 1;
                }
                if !sum.is_finite() && settled.not_finite.is_none() {
                    settled.not_finite = Some((row, column));
                }
            }
        }
        if length < end - start && settled.lengths.is_empty() {
            settled.lengths = starts
                .windows(2)
                .map(|bounds| bounds[1] - bounds[0])
                .collect();
        }
        if let Some(known) = settled.lengths.get_mut(local) {
            *known = length as u32;
        }
    }
    settled
}
