//! Cache lines asked for ahead of their use by a product.

use dcb_formats::SparseMatrix;

/// Doubles of a cache line.
pub(crate) const LINE: usize = 8;
/// Entries of a row between two looks ahead: a cache line of its values.
const STEP: usize = LINE;
/// How far ahead of the arithmetic the values and the indices of the matrix are asked for, in entries: 4 KiB.
const VALUES_AHEAD: usize = 512;
const INDICES_AHEAD: usize = 1024;

/// Eight columns of a packed row.
#[derive(Clone, Copy, Default)]
#[repr(C, align(64))]
pub(crate) struct Line(pub(crate) [f64; LINE]);

/// The data that the rows further on need.
#[derive(Clone, Copy)]
pub(crate) struct Ahead<'a> {
    /// Indices of the next rows, as far as they are as long as these; anything else is asked for in vain.
    next: &'a [u32],
    values: *const f64,
    indices: *const u32,
}

impl<'a> Ahead<'a> {
    /// Seen from `count` rows from `row` on, of at least `length` entries each.
    #[inline(always)]
    pub(crate) fn of(matrix: &'a SparseMatrix, row: usize, count: usize, length: usize) -> Self {
        let indices = matrix.row_idx();
        let start = matrix.col_ptr()[row] as usize;
        let next = matrix.col_ptr()[row + count] as usize;
        Self {
            next: &indices[next.min(indices.len() - length)..][..length],
            values: matrix.val().as_ptr().wrapping_add(start + VALUES_AHEAD),
            indices: indices.as_ptr().wrapping_add(start + INDICES_AHEAD),
        }
    }

    /// Asks for the packed row, in so many lines, that the next rows start entry `k` with, and for entries of the matrix.
    #[inline(always)]
    pub(crate) fn ask<const L: usize, const T: usize>(
        &self,
        k: usize,
        packed: &[[Line; L]],
        lines: usize,
    ) {
        if k.is_multiple_of(STEP) {
            for line in 0..(T * STEP).div_ceil(LINE) {
                ask_for(self.values.wrapping_add(T * k + line * LINE));
            }
            for line in 0..(T * STEP).div_ceil(2 * LINE) {
                ask_for(self.indices.wrapping_add(T * k + 2 * line * LINE));
            }
        }
        let row = packed
            .as_ptr()
            .wrapping_add(self.next[k] as usize)
            .cast::<Line>();
        for line in 0..L {
            ask_for(row.wrapping_add(line));
        }
        if lines > L {
            for line in L..T * L {
                ask_for(row.wrapping_add(line));
            }
        }
    }
}

/// Asks for a cache line ahead of its use.
#[inline(always)]
fn ask_for<E>(start: *const E) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: a prefetch of any address, mapped or not, has no effect but on caches.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(start.cast()) };
    }
}

/// Asks for a cache line well ahead of its use: not into the nearest cache, which holds what is in use now.
#[inline(always)]
pub(crate) fn ask_for_later<E>(start: *const E) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T1, _mm_prefetch};
        // SAFETY: a prefetch of any address, mapped or not, has no effect but on caches.
        unsafe { _mm_prefetch::<_MM_HINT_T1>(start.cast()) };
    }
}
