//! Dense elimination of a front's columns by blocks, on faer's kernels.
//!
//! How a front is cut into blocks depends on its size alone; threads share the blocks.

use std::ops::Range;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltError, cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::reborrow::*;
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;

use super::product::subtract_product;

/// Columns of a chunk of a front or of an update matrix: they are eliminated together, and updating them is one task. So are as many rows of
/// a triangular solution.
pub(super) const CHUNK: usize = 192;

/// How the lower triangle of a front's first columns, or of an update matrix, is stored with the rows below: by chunks of columns, each from
/// the chunk's first diagonal entry down, column by column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Trapezoid {
    /// m, at least as many as columns.
    pub rows: usize,
    /// k.
    pub columns: usize,
}

impl Trapezoid {
    /// A lower triangle of order n.
    pub fn triangle(order: usize) -> Self {
        Self {
            rows: order,
            columns: order,
        }
    }

    /// Number of entries.
    pub fn len(self) -> usize {
        self.chunk_start(self.columns.div_ceil(CHUNK))
    }

    fn chunk_start(self, chunk: usize) -> usize {
        let whole = chunk.min(self.columns / CHUNK);
        let start = whole * CHUNK * self.rows - CHUNK * CHUNK * (whole * whole.max(1) - whole) / 2;
        if chunk > whole {
            let first = whole * CHUNK;
            start + (self.rows - first) * (self.columns - first)
        } else {
            start
        }
    }

    /// Where a column lies, and the row that it starts with.
    pub fn column(self, column: usize) -> (Range<usize>, usize) {
        let chunk = column / CHUNK;
        let first = chunk * CHUNK;
        let rows = self.rows - first;
        let start = self.chunk_start(chunk) + (column - first) * rows;
        (start..start + rows, first)
    }

    /// The chunks with their columns, the first of which is the row that they start with.
    pub fn slices(self, values: &mut [f64]) -> Vec<(Range<usize>, &mut [f64])> {
        let mut slices = Vec::with_capacity(self.columns.div_ceil(CHUNK));
        let mut rest = values;
        for first in (0..self.columns).step_by(CHUNK) {
            let columns = first..self.columns.min(first + CHUNK);
            let (chunk, after) = rest.split_at_mut((self.rows - first) * columns.len());
            slices.push((columns, chunk));
            rest = after;
        }
        slices
    }

    /// The chunks with the row that each starts with.
    pub fn chunks(self, values: &mut [f64]) -> Vec<(usize, MatMut<'_, f64>)> {
        let slices = self.slices(values).into_iter();
        let matrix = |(columns, chunk): (Range<usize>, _)| {
            let rows = self.rows - columns.start;
            let matrix = MatMut::from_column_major_slice_mut(chunk, rows, columns.len());
            (columns.start, matrix)
        };
        slices.map(matrix).collect()
    }
}

/// The columns of a front.
pub struct Panel<'a> {
    /// Entries.
    pub values: &'a mut [f64],
    /// How they are stored.
    pub layout: Trapezoid,
}

/// Cholesky factorization of a front's columns; `update` becomes `-L₂₁ L₂₁ᵀ`, lower triangle.
///
/// # Errors
/// The column whose pivot isn't positive.
pub fn eliminate_positive(panel: &mut Panel<'_>, update: &mut [f64]) -> Result<(), usize> {
    let Trapezoid { rows, columns } = panel.layout;
    let mut chunks = panel.layout.chunks(panel.values);
    let mut rest = &mut chunks[..];
    while let Some(((first, chunk), after)) = rest.split_first_mut() {
        let width = chunk.ncols();
        let (mut diagonal, mut below) = chunk.rb_mut().split_at_row_mut(width);
        factor_diagonal(diagonal.rb_mut()).map_err(|column| *first + column)?;
        solve_below(diagonal.rb(), below.rb_mut());
        subtract_from_later(after, *first + width, below.rb(), below.rb());
        rest = after;
    }
    let order = rows - columns;
    let lower: Vec<MatRef<'_, f64>> = chunks
        .iter()
        .map(|(first, chunk)| chunk.rb().subrows(columns - first, order))
        .collect();
    let one = |(first, mut target): (usize, MatMut<'_, f64>)| {
        let mut accumulate = Accum::Replace;
        for lower in &lower {
            subtract_chunk(target.rb_mut(), first, *lower, *lower, accumulate);
            accumulate = Accum::Add;
        }
    };
    each(Trapezoid::triangle(order).chunks(update), one);
    Ok(())
}

/// Every item by itself, more than one by all threads.
fn each<T: Send>(items: Vec<T>, one: impl Fn(T) + Sync + Send) {
    match items.len() {
        0 | 1 => items.into_iter().for_each(one),
        _ => items.into_par_iter().for_each(one),
    }
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

/// Subtracts `left rightᵀ`, whose first row is the front's row `start`, from chunks further on.
pub fn subtract_from_later(
    chunks: &mut [(usize, MatMut<'_, f64>)],
    start: usize,
    left: MatRef<'_, f64>,
    right: MatRef<'_, f64>,
) {
    let targets = chunks.iter_mut();
    let targets: Vec<_> = targets
        .map(|(first, chunk)| (*first - start, chunk.rb_mut()))
        .collect();
    each(targets, |(first, chunk)| {
        subtract_chunk(chunk, first, left, right, Accum::Add);
    });
}

/// Subtracts `left rightᵀ` from an update matrix of as many rows as `left`, or replaces it by the negative.
pub fn subtract_from_update(
    update: &mut [f64],
    left: MatRef<'_, f64>,
    right: MatRef<'_, f64>,
    accumulate: Accum,
) {
    let chunks = Trapezoid::triangle(left.nrows()).chunks(update);
    each(chunks, |(first, chunk)| {
        subtract_chunk(chunk, first, left, right, accumulate);
    });
}

/// One chunk of columns, from its first diagonal entry in row `first` down.
pub(super) fn subtract_chunk(
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
    subtract_product(
        below,
        left.subrows(first + width, rows - width),
        right.subrows(first, width),
        accumulate,
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_of_a_trapezoid_follow_each_other_from_their_chunks_first_row_on() {
        for (rows, columns) in [(0, 0), (1, 1), (192, 192), (200, 7), (500, 193), (900, 900)] {
            let layout = Trapezoid { rows, columns };
            let mut end = 0;
            for column in 0..columns {
                let (range, first) = layout.column(column);
                assert_eq!((range.start, first), (end, column / CHUNK * CHUNK));
                end = range.start + rows - first;
            }
            assert_eq!(end, layout.len());
            let mut values = vec![0.0; end];
            let chunks = layout.chunks(&mut values);
            let entries: usize = chunks.iter().map(|(_, c)| c.nrows() * c.ncols()).sum();
            assert_eq!(entries, end);
        }
    }
}
