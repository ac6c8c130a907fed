//! Entries of matrices whose rows have labels. Every block of a file numbers its labels on its own; when all are read, the labels are
//! sorted and the entries numbered anew.

use dcb_formats::matrix::blocks::{Entries, Triplet};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::stored::LARGEST_LABEL;
use crate::stored::row_key::RowKey;

/// Entries of a block, by numbers that the block gives to labels.
#[derive(Debug, Default)]
pub(super) struct LabelledEntries {
    entries: Entries,
    numbers: FxHashMap<RowKey, u32>,
    /// Labels in the order in which they came.
    keys: Vec<RowKey>,
    /// Numbers with an entry on the diagonal.
    diagonal: Vec<u32>,
}

impl LabelledEntries {
    /// Room for so many entries.
    pub(super) fn with_capacity(count: usize) -> Option<Self> {
        Entries::with_capacity(count).map(Self::new)
    }

    /// The number of a label.
    #[inline]
    pub(super) fn number(&mut self, key: RowKey) -> u32 {
        let next = self.keys.len() as u32;
        let number = *self.numbers.entry(key).or_insert(next);
        if number == next {
            self.keys.push(key);
        }
        number
    }

    /// With this room for entries.
    pub(super) fn new(entries: Entries) -> Self {
        Self {
            entries,
            ..Self::default()
        }
    }

    /// Adds an entry; of a zero, only that its row has one on the diagonal.
    #[inline]
    pub(super) fn add_filled(&mut self, row: u32, column: u32, value: f64) {
        match value == 0.0 {
            true if row == column => self.diagonal.push(row),
            true => {}
            false => self.add(row, column, value),
        }
    }

    /// Adds an entry.
    #[inline]
    pub(super) fn add(&mut self, row: u32, column: u32, value: f64) {
        if row == column {
            self.diagonal.push(row);
        }
        self.entries.push(Triplet { row, column, value });
    }

    /// Gives back what is needed only while entries come.
    pub(super) fn finish(&mut self) {
        self.entries.give_back_room();
        self.numbers = FxHashMap::default();
    }
}

/// Labels in rising order, and entries by their places there.
///
/// # Errors
/// There is no row, or more than indices reach; a label has entries, but none on the diagonal.
pub(super) fn sorted(blocks: Vec<LabelledEntries>) -> Result<(Vec<RowKey>, Vec<Entries>), String> {
    let keys = blocks.iter().flat_map(|block| &block.keys);
    let mut keys: Vec<RowKey> = keys.copied().collect();
    keys.par_sort_unstable();
    keys.dedup();
    keys.shrink_to_fit();
    if keys.is_empty() || keys.len() > LARGEST_LABEL as usize {
        return Err(format!(
            "has {} rows; expected from 1 to {LARGEST_LABEL}",
            keys.len()
        ));
    }
    let renumbered = |block: LabelledEntries| {
        let place = |key: &RowKey| keys.partition_point(|other| other < key) as u32;
        let numbers: Vec<u32> = block.keys.iter().map(place).collect();
        let diagonal = block.diagonal.iter().map(|row| numbers[*row as usize]);
        let diagonal: Vec<u32> = diagonal.collect();
        let mut entries = block.entries;
        entries.renumber(&numbers);
        (entries, diagonal)
    };
    let blocks: Vec<_> = blocks.into_par_iter().map(renumbered).collect();
    let mut has_diagonal = vec![false; keys.len()];
    for row in blocks.iter().flat_map(|(_, diagonal)| diagonal) {
        has_diagonal[*row as usize] = true;
    }
    if let Some(row) = has_diagonal.iter().position(|has| !has) {
        return Err(format!(
            "{} has entries, but none on the diagonal, as no stiffness or mass matrix has it; the file is cut off, holds only a part of the matrix, or has rows of Lagrange multipliers",
            keys[row]
        ));
    }
    let entries = blocks.into_iter().map(|(entries, _)| entries).collect();
    Ok((keys, entries))
}
