//! Dense elimination of a front's columns by blocks, on faer's kernels.
//!
//! How a front is cut into blocks depends on its size alone; threads share the blocks.

use std::ops::Range;

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
pub(super) const CHUNK: usize = 256;

/// How an update matrix of order `n` is stored: its lower triangle by chunks of columns, each from the chunk's first diagonal entry
/// down, column by column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UpdateLayout {
    /// n.
    pub order: usize,
}

impl UpdateLayout {
    /// Number of entries.
    pub fn len(self) -> usize {
        self.chunk_start(self.order.div_ceil(CHUNK))
    }

    fn chunk_start(self, chunk: usize) -> usize {
        let whole = chunk.min(self.order / CHUNK);
        let start = whole * CHUNK * self.order - CHUNK * CHUNK * (whole * whole.max(1) - whole) / 2;
        if chunk > whole {
            let width = self.order - whole * CHUNK;
            start + width * width
        } else {
            start
        }
    }

    /// Where a column lies, and the row that it starts with.
    pub fn column(self, column: usize) -> (std::ops::Range<usize>, usize) {
        let chunk = column / CHUNK;
        let first = chunk * CHUNK;
        let rows = self.order - first;
        let start = self.chunk_start(chunk) + (column - first) * rows;
        (start..start + rows, first)
    }

    /// The chunks of an update matrix with their columns, the first of which is the row that they start with.
    pub fn slices(self, update: &mut [f64]) -> Vec<(Range<usize>, &mut [f64])> {
        let mut slices = Vec::with_capacity(self.order.div_ceil(CHUNK));
        let mut rest = update;
        for first in (0..self.order).step_by(CHUNK) {
            let columns = first..self.order.min(first + CHUNK);
            let (chunk, after) = rest.split_at_mut((self.order - first) * columns.len());
            slices.push((columns, chunk));
            rest = after;
        }
        slices
    }

    /// The chunks of an update matrix with the row that each starts with.
    pub fn chunks(self, update: &mut [f64]) -> Vec<(usize, MatMut<'_, f64>)> {
        let slices = self.slices(update).into_iter();
        let matrix = |(columns, chunk): (Range<usize>, _)| {
            let rows = self.order - columns.start;
            let matrix = MatMut::from_column_major_slice_mut(chunk, rows, columns.len());
            (columns.start, matrix)
        };
        slices.map(matrix).collect()
    }
}

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
        subtract_products(trailing, below, below);
    }
    let order = rows - columns;
    if order > 0 {
        let lower = panel.as_mut();
        let lower = lower.rb().subrows(columns, order);
        subtract_from_update(update, lower, lower, Accum::Replace);
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

/// Subtracts `left rightᵀ` from the lower part of a trapezoid with as many rows as `left`.
pub fn subtract_products(target: MatMut<'_, f64>, left: MatRef<'_, f64>, right: MatRef<'_, f64>) {
    let (rows, columns) = (target.nrows(), target.ncols());
    let one = |index: usize, chunk: MatMut<'_, f64>| {
        let first = index * CHUNK;
        let chunk = chunk.subrows_mut(first, rows - first);
        subtract_chunk(chunk, first, left, right, Accum::Add);
    };
    match columns {
        0 => {}
        1..=CHUNK => one(0, target),
        _ => target
            .par_col_chunks_mut(CHUNK)
            .enumerate()
            .for_each(|(index, chunk)| one(index, chunk)),
    }
}

/// Subtracts `left rightᵀ` from an update matrix of as many rows as `left`, or replaces it by the negative.
pub fn subtract_from_update(
    update: &mut [f64],
    left: MatRef<'_, f64>,
    right: MatRef<'_, f64>,
    accumulate: Accum,
) {
    let layout = UpdateLayout {
        order: left.nrows(),
    };
    let chunks = layout.chunks(update);
    let one = |(first, chunk): (usize, MatMut<'_, f64>)| {
        subtract_chunk(chunk, first, left, right, accumulate);
    };
    if chunks.len() <= 1 {
        chunks.into_iter().for_each(one);
    } else {
        chunks.into_par_iter().for_each(one);
    }
}

/// One chunk of columns, from its first diagonal entry in row `first` down.
fn subtract_chunk(
    chunk: MatMut<'_, f64>,
    first: usize,
    left: MatRef<'_, f64>,
    right: MatRef<'_, f64>,
    accumulate: Accum,
) {
    let (rows, width) = (chunk.nrows(), chunk.ncols());
    let (diagonal, below) = chunk.split_at_row_mut(width);
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
        left.subrows(first + width, rows - width),
        across,
        -1.0,
        Par::Seq,
    );
}
