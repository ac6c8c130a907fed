//! Dense elimination of a front's columns by blocks, on faer's kernels.
//!
//! How a front is cut into blocks depends on its size alone; threads share the blocks.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltError, cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::reborrow::*;
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;

/// Columns eliminated together.
const BLOCK: usize = 192;
/// Columns of an update that are one task, and rows of a triangular solution.
const CHUNK: usize = 256;

/// The columns of a front: `rows` by `columns`, column by column; of the first `columns` rows only the lower triangle counts.
pub struct Panel<'a> {
    /// Entries.
    pub values: &'a mut [f64],
    /// m.
    pub rows: usize,
    /// k.
    pub columns: usize,
}

impl Panel<'_> {
    /// As a matrix.
    pub fn as_mut(&mut self) -> MatMut<'_, f64> {
        MatMut::from_column_major_slice_mut(self.values, self.rows, self.columns)
    }
}

/// Cholesky factorization of a front's columns; `update` becomes `-L₂₁ L₂₁ᵀ`, lower triangle.
///
/// # Errors
/// The column whose pivot isn't positive.
pub fn eliminate_positive(panel: &mut Panel<'_>, update: &mut [f64]) -> Result<(), usize> {
    let (rows, columns) = (panel.rows, panel.columns);
    let mut whole = panel.as_mut();
    for first in (0..columns).step_by(BLOCK) {
        let width = BLOCK.min(columns - first);
        let (block, rest) = whole
            .rb_mut()
            .submatrix_mut(first, first, rows - first, columns - first)
            .split_at_col_mut(width);
        let (mut diagonal, mut below) = block.split_at_row_mut(width);
        factor_diagonal(diagonal.rb_mut()).map_err(|column| first + column)?;
        solve_below(diagonal.rb(), below.rb_mut());
        let below = below.rb();
        let trailing = rest.split_at_row_mut(width).1;
        subtract_products(trailing, below, below, Accum::Add);
    }
    let order = rows - columns;
    if order > 0 {
        let lower = panel.as_mut();
        let lower = lower.rb().subrows(columns, order);
        let update = MatMut::from_column_major_slice_mut(update, order, order);
        subtract_products(update, lower, lower, Accum::Replace);
    }
    Ok(())
}

fn factor_diagonal(block: MatMut<'_, f64>) -> Result<(), usize> {
    let scratch = cholesky_in_place_scratch::<f64>(block.nrows(), Par::Seq, Default::default());
    let mut memory = MemBuffer::new(scratch);
    cholesky_in_place(
        block,
        Default::default(),
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    )
    .map(|_| ())
    .map_err(|LltError::NonPositivePivot { index }| index)
}

/// `B L⁻ᵀ` in place.
fn solve_below(lower: MatRef<'_, f64>, below: MatMut<'_, f64>) {
    if below.nrows() <= CHUNK {
        solve_lower_triangular_in_place(lower, below.transpose_mut(), Par::Seq);
    } else {
        below.par_row_chunks_mut(CHUNK).for_each(|rows| {
            solve_lower_triangular_in_place(lower, rows.transpose_mut(), Par::Seq);
        });
    }
}

/// Subtracts `left rightᵀ` from (or replaces by its negative) the lower part of a trapezoid with as many rows as `left`, and as
/// many columns as the first rows of `right` that belong to them.
pub fn subtract_products(
    target: MatMut<'_, f64>,
    left: MatRef<'_, f64>,
    right: MatRef<'_, f64>,
    accumulate: Accum,
) {
    let (rows, columns) = (target.nrows(), target.ncols());
    if columns == 0 {
        return;
    }
    let one = |index: usize, chunk: MatMut<'_, f64>| {
        let first = index * CHUNK;
        let width = chunk.ncols();
        let (diagonal, below) = chunk
            .submatrix_mut(first, 0, rows - first, width)
            .split_at_row_mut(width);
        let across = right.subrows(first, width).transpose();
        triangular::matmul(
            diagonal,
            BlockStructure::TriangularLower,
            accumulate,
            left.subrows(first, width),
            BlockStructure::Rectangular,
            across,
            BlockStructure::Rectangular,
            -1.0,
            Par::Seq,
        );
        matmul(
            below,
            accumulate,
            left.subrows(first + width, rows - first - width),
            across,
            -1.0,
            Par::Seq,
        );
    };
    if columns <= CHUNK {
        one(0, target);
    } else {
        target
            .par_col_chunks_mut(CHUNK)
            .enumerate()
            .for_each(|(index, chunk)| one(index, chunk));
    }
}
