//! Entries of matrices whose rows have labels. Every block of a file numbers its labels on its own and is put behind the others in their
//! numbers; when all are read, the labels are sorted and the entries numbered anew.

use dcb_formats::matrix::blocks::{Entries, Triplet};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::stored::LARGEST_LABEL;
use crate::stored::row_key::RowKey;

/// Entries by numbers that labels have in the order in which they come.
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

    /// Gives room back of which most was not needed.
    pub(super) fn give_back_room(&mut self) {
        self.entries.give_back_room();
    }

    /// Puts those of the next block of lines behind its own.
    ///
    /// # Errors
    /// There are more entries than indices reach.
    pub(super) fn append(&mut self, block: Self) -> Result<(), String> {
        if self.keys.is_empty() {
            *self = block;
            return Ok(());
        }
        if self.entries.len() + block.entries.len() > u32::MAX as usize {
            return Err(format!("has more than {} entries", u32::MAX));
        }
        let numbers: Vec<u32> = block.keys.iter().map(|key| self.number(*key)).collect();
        let diagonal = block.diagonal.iter().map(|row| numbers[*row as usize]);
        self.diagonal.extend(diagonal);
        let mut entries = block.entries;
        entries.renumber(&numbers);
        self.entries.append(entries);
        Ok(())
    }

    /// Labels in rising order, and entries by their places there.
    ///
    /// # Errors
    /// There is no row, or more than indices reach; a label has entries, but none on the diagonal.
    pub(super) fn sorted(self) -> Result<(Vec<RowKey>, Entries), String> {
        let count = self.keys.len();
        if count == 0 || count > LARGEST_LABEL as usize {
            return Err(format!(
                "has {count} rows; expected from 1 to {LARGEST_LABEL}"
            ));
        }
        drop(self.numbers);
        let mut order: Vec<u32> = (0..count as u32).collect();
        order.par_sort_unstable_by_key(|number| self.keys[*number as usize]);
        let keys: Vec<RowKey> = (order.iter().map(|number| self.keys[*number as usize])).collect();
        let mut has_diagonal = vec![false; count];
        for row in self.diagonal {
            has_diagonal[row as usize] = true;
        }
        let without = order
            .iter()
            .position(|number| !has_diagonal[*number as usize]);
        if let Some(row) = without {
            return Err(format!(
                "{} has entries, but none on the diagonal, as no stiffness or mass matrix has it; the file is cut off, holds only a part of the matrix, or has rows of Lagrange multipliers",
                keys[row]
            ));
        }
        let mut places = vec![0; count];
        for (place, number) in (0..).zip(&order) {
            places[*number as usize] = place;
        }
        let mut entries = self.entries;
        entries.renumber(&places);
        Ok((keys, entries))
    }
}
