//! How many vectors a Krylov basis has: known before it is built, because memory depends on it.

use serde::Serialize;

/// Columns of a Lanczos block: finds roots up to this multiplicity at once, and one cache line of a packed row.
const BLOCK_WIDTH: usize = 8;
/// Modes from which a block of twice as many columns is faster: fewer passes over the factor and the basis.
const WIDE_FROM: usize = 200;

/// Columns of the block for so many modes.
pub fn block_width(wanted: usize) -> usize {
    match wanted < WIDE_FROM {
        true => BLOCK_WIDTH,
        false => 2 * BLOCK_WIDTH,
    }
}

/// How often a basis is restarted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum BasisSize {
    /// Rarely: three times the modes and guard vectors with eight blocks, or room for twenty-two blocks beside these. A search that isn't restarted can prove that it
    /// missed no mode.
    Comfortable,
    /// Again and again, with room for a few blocks: about half as large, for where memory is short.
    Short,
}

impl BasisSize {
    /// Columns kept for `guarded` modes and guard vectors, without the block that comes next.
    pub fn columns(self, guarded: usize, block: usize) -> usize {
        match self {
            Self::Comfortable => (3 * guarded + 8 * block).max(guarded + 22 * block),
            Self::Short => guarded + guarded / 2 + 3 * block,
        }
    }

    /// All columns of a search for so many modes.
    pub fn all_columns(self, wanted: usize) -> usize {
        let block = block_width(wanted);
        self.columns(wanted + block, block) + block
    }
}
