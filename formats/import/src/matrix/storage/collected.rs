//! Entries that a binary file gives one after the other, in blocks.

use dcb_formats::matrix::blocks::{Entries, Triplet};

use crate::stored::Content;

/// Entries of a block.
const BLOCK: usize = 1 << 16;

/// Entries so far. Those that rise row after row, or column after column, stay in one block, which becomes compressed columns without a copy.
#[derive(Debug, Default)]
pub(crate) struct Collected {
    full: Vec<Entries>,
    last: Entries,
    order: Order,
}

/// How places follow each other.
#[derive(Debug)]
struct Order {
    before: Option<(u32, u32)>,
    by_rows: bool,
    by_columns: bool,
}

impl Default for Order {
    fn default() -> Self {
        Self {
            before: None,
            by_rows: true,
            by_columns: true,
        }
    }
}

impl Order {
    #[inline(always)]
    fn add(&mut self, row: u32, column: u32) {
        if let Some(before) = self.before {
            self.by_rows &= before < (row, column);
            self.by_columns &= (before.1, before.0) < (column, row);
        }
        self.before = Some((row, column));
    }

    fn rises(&self) -> bool {
        self.by_rows || self.by_columns
    }
}

impl Collected {
    /// Adds an entry at a 0-based place.
    ///
    /// # Errors
    /// Its value isn't finite.
    #[inline]
    pub(crate) fn add(&mut self, row: u32, column: u32, value: f64) -> Result<(), String> {
        if !value.is_finite() {
            return Err(not_finite(row, column, value));
        }
        self.order.add(row, column);
        if self.last.len() >= BLOCK && !self.order.rises() {
            self.full.push(std::mem::take(&mut self.last));
            self.last = Entries::with_capacity(BLOCK).unwrap_or_default();
        }
        self.last.push(Triplet { row, column, value });
        Ok(())
    }

    /// All of them.
    pub(crate) fn content(mut self) -> Content {
        self.last.give_back_room();
        self.full.push(self.last);
        Content::Entries(self.full)
    }
}

/// Message on a value at a 0-based place.
pub(crate) fn not_finite(row: u32, column: u32, value: f64) -> String {
    format!(
        "the entry in row {}, column {} is {value}; stiffness and mass are finite",
        row + 1,
        column + 1
    )
}

/// Sizes of indices end here.
pub(crate) const LARGEST_SIZE: u64 = (1 << 31) - 1;

/// Rows of a square matrix.
///
/// # Errors
/// It isn't square, or larger than indices reach.
pub(crate) fn square(rows: u64, columns: u64) -> Result<u32, String> {
    if rows != columns {
        return Err(format!(
            "{rows} rows and {columns} columns; stiffness and mass are square"
        ));
    }
    match u32::try_from(rows) {
        Ok(size) if rows <= LARGEST_SIZE => Ok(size),
        _ => Err(format!("{rows} rows; at most {LARGEST_SIZE} are supported")),
    }
}

/// Obstacle of a matrix that isn't square.
pub(crate) fn obstacle_of_shape(rows: u64, columns: u64) -> Option<String> {
    (rows != columns).then(|| format!("rectangular, {rows} x {columns}"))
}
