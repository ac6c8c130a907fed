//! Compressed columns from entries in any order.
//!
//! Count, prefix sum, scatter, then sort and sum within each column. Every chunk (some blocks of the file) has its own counters, so it knows
//! where in each column its entries go and writes them there while others write theirs: a column's entries arrive in file order,
//! duplicates are summed in file order, and neither depends on the number of threads. A file sorted by rows or columns needs no
//! sorting.
//!
//! Entries that stand in compressed columns already are joined, block after block.

use std::ops::Range;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use faer::sparse::SymbolicSparseColMat;
use rayon::iter::repeat_n;
use rayon::prelude::*;

use super::entries::{Entries, Order, Part};
use super::entry_blocks::Block;
use super::shared::{shared_indices, shared_reals};
use crate::SparseMatrix;

/// Where a stored entry (i, j) goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Expansion {
    /// (i, j).
    AsStored,
    /// (i, j) and, off the diagonal, (j, i).
    Mirrored,
    /// (i, j) and, off the diagonal, (j, i) with the opposite sign.
    MirroredNegated,
}

impl Expansion {
    /// Whether an entry goes to two places.
    pub(super) fn mirrors(self) -> bool {
        self != Self::AsStored
    }

    /// The value in the mirrored place.
    #[inline(always)]
    fn image(self, value: f64) -> f64 {
        match self {
            Self::MirroredNegated => -value,
            _ => value,
        }
    }
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
pub enum CannotAssemble {
    /// More entries than 32-bit indices reach.
    TooMany {
        /// In full storage.
        entries: u64,
    },
    /// Duplicates add up to something infinite, 0-based place.
    NotFinite {
        /// Of the place, 0-based.
        row: u32,
        /// Of the place, 0-based.
        column: u32,
    },
}

/// Entries in any order as a matrix, and how many stored entries were added to an earlier one.
///
/// # Errors
/// [`CannotAssemble`].
pub fn assembled(
    entries: Vec<Entries>,
    (row_count, column_count): (usize, usize),
    expansion: Expansion,
) -> Result<(SparseMatrix, usize), CannotAssemble> {
    let blocks = entries.into_par_iter().map(Block::of_entries).collect();
    let columns = Columns::assemble(blocks, row_count, column_count, expansion)?;
    let duplicates_summed = columns.duplicates_summed;
    Ok((columns.into_matrix(), duplicates_summed))
}

/// Chunks for each thread, so that none waits long for another.
const CHUNKS_PER_THREAD: usize = 4;
/// Threads beyond these would mostly wait for the same memory.
const MOST_CHUNKS: usize = 64;

/// Entries that one thread puts into place, in file order.
struct Chunk<'a> {
    parts: Vec<Part<'a>>,
    /// Entries for each column of the full matrix, mirror images too; then the place of the column's next entry.
    per_column: Vec<u32>,
}

impl<'a> Chunk<'a> {
    /// Blocks side by side make a chunk, and a long one several. Counters take no more memory than row indices.
    fn of_blocks(blocks: &'a [Block], column_count: usize, expansion: Expansion) -> Vec<Self> {
        let total: usize = blocks.iter().map(|block| block.entries.len()).sum();
        let count = (CHUNKS_PER_THREAD * rayon::current_num_threads())
            .min(MOST_CHUNKS)
            .min(total / column_count.max(1))
            .max(1);
        let mut chunks: Vec<Vec<Part<'a>>> = (0..count).map(|_| Vec::new()).collect();
        let mut before = 0;
        for Block { entries, .. } in blocks.iter().filter(|block| !block.entries.is_empty()) {
            let part_count = (entries.len() * count).div_ceil(total);
            for (number, part) in entries.parts(part_count).enumerate() {
                let before = before + entries.len() * number / part_count;
                chunks[before * count / total].push(part);
            }
            before += entries.len();
        }
        chunks
            .into_par_iter()
            .map(|parts| {
                let mut per_column = vec![0; column_count];
                for part in &parts {
                    part.count_columns(expansion, &mut per_column);
                }
                Self { parts, per_column }
            })
            .collect()
    }
}

/// Ranges of columns that are sorted one after the other.
const MOST_RANGES: usize = 64;

impl Columns {
    /// Sorts entries into columns and sums duplicates.
    pub(super) fn assemble(
        blocks: Vec<Block>,
        row_count: usize,
        column_count: usize,
        expansion: Expansion,
    ) -> Result<Self, CannotAssemble> {
        let entries = full_count(&blocks, expansion);
        if entries > u64::from(u32::MAX) {
            return Err(CannotAssemble::TooMany { entries });
        }
        if expansion == Expansion::AsStored && stand_in_columns(&blocks) {
            return Ok(Self::joined(
                blocks,
                row_count,
                column_count,
                entries as usize,
            ));
        }
        let mut chunks = Chunk::of_blocks(&blocks, column_count, expansion);
        let starts = place_columns(&mut chunks, column_count);
        let total = starts[column_count] as usize;
        // By all threads: the first touch of a page takes longer than writing it.
        let mut rows: Vec<u32> = repeat_n(0, total).collect();
        let mut values: Vec<f64> = repeat_n(0.0, total).collect();
        let (to_rows, to_values) = (shared_indices(&mut rows), shared_reals(&mut values));
        chunks
            .into_par_iter()
            .for_each(|chunk| scatter(chunk, expansion, to_rows, to_values));
        drop(blocks);
        let ranges = balanced_ranges(&starts, MOST_RANGES);
        let parts = split_at_ranges(&mut rows, &mut values, &starts, &ranges);
        let settled: Vec<Settled> = ranges
            .par_iter()
            .cloned()
            .zip(parts)
            .map(|(range, (rows, values))| {
                let starts = &starts[range.start..=range.end];
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

    /// Of blocks that are parts of compressed columns.
    fn joined(blocks: Vec<Block>, row_count: usize, column_count: usize, total: usize) -> Self {
        let mut counts = vec![0; column_count];
        let mut blocks = blocks.into_iter();
        let first = blocks.next().unwrap_or_default();
        let (mut rows, mut values) = first.entries.into_columns(&mut counts);
        rows.reserve_exact(total - rows.len());
        values.reserve_exact(total - values.len());
        for block in blocks {
            let (more_rows, more_values) = block.entries.into_columns(&mut counts);
            rows.extend_from_slice(&more_rows);
            values.extend_from_slice(&more_values);
        }
        let mut starts = Vec::with_capacity(column_count + 1);
        let mut end = 0;
        starts.push(end);
        starts.extend(counts.iter().map(|count| {
            end += count;
            end
        }));
        Self {
            row_count,
            starts,
            rows,
            values,
            duplicates_summed: 0,
        }
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

/// Whether blocks, one after the other, are compressed columns.
fn stand_in_columns(blocks: &[Block]) -> bool {
    let mut blocks = blocks.iter();
    blocks
        .try_fold(None, |last, block| {
            block.entries.rise_behind(last, Order::ByColumns)
        })
        .is_some()
}

/// Entries in full storage, duplicates counted.
pub(super) fn full_count(blocks: &[Block], expansion: Expansion) -> u64 {
    let images = |block: &Block| match expansion.mirrors() {
        true => block.upper_count + block.lower_count,
        false => 0,
    };
    let count = |block: &Block| (block.entries.len() + images(block)) as u64;
    blocks.iter().map(count).sum()
}

/// Start of each column, and the end of the last; a chunk's counts become the places of its next entries.
fn place_columns(chunks: &mut [Chunk], column_count: usize) -> Vec<u32> {
    let mut starts = Vec::with_capacity(column_count + 1);
    let mut total = 0;
    for column in 0..column_count {
        starts.push(total);
        for chunk in &mut *chunks {
            let here = &mut chunk.per_column[column];
            (*here, total) = (total, total + *here);
        }
    }
    starts.push(total);
    starts
}

/// Puts a chunk's entries into place.
fn scatter(chunk: Chunk<'_>, expansion: Expansion, rows: &[AtomicU32], values: &[AtomicU64]) {
    let mut next = chunk.per_column;
    let mut put = |column: u32, row: u32, value: f64| {
        let next = &mut next[column as usize];
        let at = *next as usize;
        *next += 1;
        rows[at].store(row, Ordering::Relaxed);
        values[at].store(value.to_bits(), Ordering::Relaxed);
    };
    for part in chunk.parts {
        part.iter().for_each(|entry| {
            put(entry.column, entry.row, entry.value);
            if expansion.mirrors() && entry.row != entry.column {
                put(entry.row, entry.column, expansion.image(entry.value));
            }
        });
    }
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

/// Effect of sorting and summing a range of columns.
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
                let is_image = expansion.mirrors() && row < column;
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
