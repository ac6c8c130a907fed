//! Products of sparse matrices with tall blocks.
//!
//! The block is packed so that a row is one or two cache lines, and a pass over the matrix serves eight or sixteen columns. Three
//! rows of the matrix are taken together. On solids they are those of one node and use the same rows of the block (stiffness) or
//! adjacent ones (mass), so that one index serves three entries. The product is bounded by fetching rows of the block, which
//! stand where the mesher numbered the nodes: they are asked for three rows ahead, as are the matrix's entries.
//!
//! Every entry of the result is a sum in the order of the matrix's entries, whatever the number of threads.

#![allow(clippy::needless_range_loop)] // loops of a constant length over several arrays, to be unrolled

use std::cell::RefCell;

use dcb_formats::SparseMatrix;
use faer::{Mat, MatMut, MatRef};
use rayon::prelude::*;

use crate::prefetch::{Ahead, LINE, Line};
use crate::zeros;

/// Rows of the matrix taken together.
const TOGETHER: usize = 3;
/// Rows per task, a multiple of [`TOGETHER`].
const CHUNK_ROWS: usize = 384 * TOGETHER;

/// Rows packed together, which stay in the nearest cache.
const TILE_ROWS: usize = 32;
thread_local! {
    /// The packed block, kept between products: fresh memory costs more than filling it.
    static PACKED: RefCell<Vec<Line>> = const { RefCell::new(Vec::new()) };
}

/// `A x` for a symmetric sparse matrix in full storage, (n, k): the same as `Aᵀ x`.
pub fn symmetric_product(matrix: &SparseMatrix, x: MatRef<'_, f64>) -> Mat<f64> {
    transposed_product(matrix, x)
}

/// `Aᵀ x` for a square sparse matrix, (n, k): each output row is one dot product over the column of the same index.
pub fn transposed_product(matrix: &SparseMatrix, x: MatRef<'_, f64>) -> Mat<f64> {
    let mut y = zeros::matrix(x.nrows(), x.ncols());
    product::<false>(matrix, x, y.as_mut());
    y
}

/// `|A| |x|` for a symmetric sparse matrix, (n, k): times machine precision, a bound of the rounding in `A x`.
pub fn absolute_product(matrix: &SparseMatrix, x: MatRef<'_, f64>) -> Mat<f64> {
    let mut y = zeros::matrix(x.nrows(), x.ncols());
    product::<true>(matrix, x, y.as_mut());
    y
}

/// `y = A x` for a symmetric sparse matrix in full storage, into memory that the caller keeps.
pub fn symmetric_product_into(matrix: &SparseMatrix, x: MatRef<'_, f64>, y: MatMut<'_, f64>) {
    product::<false>(matrix, x, y);
}

fn product<const ABSOLUTE: bool>(
    matrix: &SparseMatrix,
    x: MatRef<'_, f64>,
    mut y: MatMut<'_, f64>,
) {
    // What the kernels rely on.
    assert_eq!((matrix.nrows(), matrix.ncols()), (x.nrows(), x.nrows()));
    assert_eq!((y.nrows(), y.ncols()), (x.nrows(), x.ncols()));
    let mut buffer = PACKED.take();
    let mut first = 0;
    while first < x.ncols() {
        let rest = x.ncols() - first;
        let count = rest.min(if rest > LINE { 2 * LINE } else { LINE });
        let (x, y) = (
            x.subcols(first, count),
            y.as_mut().subcols_mut(first, count),
        );
        match count > LINE {
            true => pass::<2, ABSOLUTE>(matrix, x, &mut buffer, y),
            false => pass::<1, ABSOLUTE>(matrix, x, &mut buffer, y),
        }
        first += count;
    }
    PACKED.set(buffer);
}

/// Up to eight columns for each of `L` lines.
fn pass<const L: usize, const ABSOLUTE: bool>(
    matrix: &SparseMatrix,
    x: MatRef<'_, f64>,
    buffer: &mut Vec<Line>,
    y: MatMut<'_, f64>,
) {
    let needed = L * x.nrows();
    zeros::extend(buffer, needed);
    let (packed, _) = buffer[..needed].as_chunks_mut::<L>();
    pack::<L, ABSOLUTE>(x, packed);
    y.par_row_chunks_mut(CHUNK_ROWS)
        .enumerate()
        .for_each(|(chunk, y)| {
            // The widest vector instructions of the machine that runs this.
            pulp::Arch::new().dispatch(Chunk::<L, ABSOLUTE> {
                matrix,
                packed,
                first_row: chunk * CHUNK_ROWS,
                y,
            });
        });
}

/// Columns as rows of lines; what is left of a line is zero.
fn pack<const L: usize, const ABSOLUTE: bool>(x: MatRef<'_, f64>, packed: &mut [[Line; L]]) {
    packed
        .par_chunks_mut(CHUNK_ROWS)
        .zip(x.par_row_chunks(CHUNK_ROWS))
        .for_each(|(packed, x)| {
            for (tile, packed) in packed.chunks_mut(TILE_ROWS).enumerate() {
                pack_tile::<L, ABSOLUTE>(x.subrows(tile * TILE_ROWS, packed.len()), packed);
            }
        });
}

fn pack_tile<const L: usize, const ABSOLUTE: bool>(x: MatRef<'_, f64>, packed: &mut [[Line; L]]) {
    for lane in 0..L * LINE {
        let (line, lane) = (lane / LINE, lane % LINE);
        if LINE * line + lane < x.ncols() {
            for (row, value) in packed.iter_mut().zip(x.col(LINE * line + lane).iter()) {
                row[line].0[lane] = if ABSOLUTE { value.abs() } else { *value };
            }
        } else {
            for row in packed.iter_mut() {
                row[line].0[lane] = 0.0;
            }
        }
    }
}

/// Rows of a product, from `first_row` on.
struct Chunk<'a, const L: usize, const ABSOLUTE: bool> {
    matrix: &'a SparseMatrix,
    packed: &'a [[Line; L]],
    first_row: usize,
    y: MatMut<'a, f64>,
}

impl<const L: usize, const ABSOLUTE: bool> pulp::WithSimd for Chunk<'_, L, ABSOLUTE> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        match L * LINE / S::F64_LANES {
            1 => self.rows::<S, 1>(simd),
            2 => self.rows::<S, 2>(simd),
            4 => self.rows::<S, 4>(simd),
            8 => self.rows::<S, 8>(simd),
            _ => self.rows::<S, 16>(simd),
        }
    }
}

impl<const L: usize, const ABSOLUTE: bool> Chunk<'_, L, ABSOLUTE> {
    #[inline(always)]
    fn rows<S: pulp::Simd, const R: usize>(mut self, simd: S) {
        let count = self.y.nrows();
        let whole = count - count % TOGETHER;
        for local in (0..whole).step_by(TOGETHER) {
            self.together::<S, R, TOGETHER>(simd, local);
        }
        for local in whole..count {
            self.together::<S, R, 1>(simd, local);
        }
    }

    /// `T` rows from a chunk's row `local` on.
    #[inline(always)]
    fn together<S: pulp::Simd, const R: usize, const T: usize>(&mut self, simd: S, local: usize) {
        let row = self.first_row + local;
        let mut indices: [&[u32]; T] = [&[]; T];
        let mut values: [&[f64]; T] = [&[]; T];
        for t in 0..T {
            indices[t] = self.matrix.row_idx_of_col_raw(row + t);
            values[t] = self.matrix.val_of_col(row + t);
        }
        let shared = indices.iter().map(|row| row.len()).min().unwrap_or(0);
        let ahead = Ahead::of(self.matrix, row, T, shared);
        let mut sums = [[simd.splat_f64s(0.0); R]; T];
        match shifts(&indices) {
            Some(shifts) => {
                let rows = shifts.map(|shift| self.packed.as_ptr().wrapping_offset(shift));
                let lines = if shifts[T - 1] == 0 { L } else { T * L };
                for t in 0..T {
                    values[t] = &values[t][..shared];
                }
                for k in 0..shared {
                    ahead.ask::<L, T>(k, self.packed, lines);
                    let i = indices[0][k] as usize;
                    for t in 0..T {
                        // SAFETY: this is the packed row of an index of row t, and there are as many packed rows as the
                        // matrix has rows, which all indices are below.
                        let x = unsafe { &*rows[t].wrapping_add(i) };
                        add_scaled::<S, L, R, ABSOLUTE>(simd, &mut sums[t], values[t][k], x);
                    }
                }
            }
            None => {
                for k in 0..shared {
                    ahead.ask::<L, T>(k, self.packed, L);
                    for t in 0..T {
                        let (i, value) = (indices[t][..shared][k], values[t][..shared][k]);
                        let x = self.packed_row(i);
                        add_scaled::<S, L, R, ABSOLUTE>(simd, &mut sums[t], value, x);
                    }
                }
                for t in 0..T {
                    for (i, value) in indices[t][shared..].iter().zip(&values[t][shared..]) {
                        let x = self.packed_row(*i);
                        add_scaled::<S, L, R, ABSOLUTE>(simd, &mut sums[t], *value, x);
                    }
                }
            }
        }
        for t in 0..T {
            let lanes: &[f64] = pulp::bytemuck::cast_slice(&sums[t]);
            for (column, sum) in lanes.iter().take(self.y.ncols()).enumerate() {
                self.y[(local + t, column)] = *sum;
            }
        }
    }

    #[inline(always)]
    fn packed_row(&self, index: u32) -> &[Line; L] {
        // SAFETY: `product` has as many packed rows as the matrix, whose indices are below that.
        unsafe { self.packed.get_unchecked(index as usize) }
    }
}

/// `sum += value · row`
#[inline(always)]
fn add_scaled<S: pulp::Simd, const L: usize, const R: usize, const ABSOLUTE: bool>(
    simd: S,
    sum: &mut [S::f64s; R],
    value: f64,
    row: &[Line; L],
) {
    let value = simd.splat_f64s(if ABSOLUTE { value.abs() } else { value });
    for i in 0..R {
        let (packed, _) = S::as_simd_f64s(&row[i * S::F64_LANES / LINE].0);
        let x = packed[i % (LINE / S::F64_LANES)];
        sum[i] = simd.mul_add_f64s(value, x, sum[i]);
    }
}

/// How far the indices of each row stand above those of the first, if that is the same for all of a row's indices; below it where negative.
#[inline(always)]
fn shifts<const T: usize>(indices: &[&[u32]; T]) -> Option<[isize; T]> {
    let mut shifts = [0; T];
    let first = indices[0];
    let mut differences = 0;
    for t in 1..T {
        if indices[t].len() != first.len() || first.is_empty() {
            return None;
        }
        shifts[t] = indices[t][0] as isize - first[0] as isize;
        let shift = indices[t][0].wrapping_sub(first[0]);
        for k in 0..first.len() {
            differences |= first[k].wrapping_add(shift) ^ indices[t][k];
        }
    }
    (differences == 0).then_some(shifts)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use faer::sparse::Triplet;

    /// Rows of a node that share a pattern, stand beside each other, or have lost an entry, and a node of one dof.
    fn blocks() -> SparseMatrix {
        let mut entries = Vec::new();
        let nodes = 900_u32;
        for node in 0..nodes {
            for neighbour in [node, (node * 7 + 3) % nodes, (node + 1) % nodes] {
                for c in 0..3 {
                    for d in 0..3 {
                        let value =
                            f64::from(1 + (5 * node + 3 * neighbour + 2 * c + d) % 11) - 4.5;
                        let kept = match node % 3 {
                            0 => true,
                            1 => c == d,
                            _ => value != 0.5,
                        };
                        if kept {
                            entries.push(Triplet::new(3 * node + c, 3 * neighbour + d, value));
                        }
                    }
                }
            }
        }
        entries.push(Triplet::new(3 * nodes, 3 * nodes, -2.0));
        let n = 3 * nodes as usize + 1;
        SparseMatrix::try_new_from_triplets(n, n, &entries).unwrap()
    }

    /// Two dofs a node, each coupled to its own direction at every node: the rows 3, 4, 5 begin at columns 1, 0, 1.
    fn pairs() -> SparseMatrix {
        let n = 22;
        let mut entries = Vec::new();
        for row in 0..n {
            for column in (row % 2..n).step_by(2) {
                let value = f64::from(1 + (3 * row + 5 * column) % 7);
                entries.push(Triplet::new(row, column, value));
            }
        }
        SparseMatrix::try_new_from_triplets(n as usize, n as usize, &entries).unwrap()
    }

    #[test]
    fn products_of_any_width_are_sums_over_the_entries() {
        for matrix in [blocks(), pairs()] {
            assert_products(&matrix);
        }
    }

    fn assert_products(matrix: &SparseMatrix) {
        let n = matrix.ncols();
        for width in [1, 7, 8, 9, 16, 17, 25, 40] {
            let x = Mat::from_fn(n, width, |i, j| ((i * (j + 3)) as f64 * 0.7).sin());
            let mut plain = Mat::<f64>::zeros(n, width);
            let mut absolute = Mat::<f64>::zeros(n, width);
            for row in 0..n {
                for (index, value) in matrix.row_idx_of_col(row).zip(matrix.val_of_col(row)) {
                    for column in 0..width {
                        plain[(row, column)] += value * x[(index, column)];
                        absolute[(row, column)] += (value * x[(index, column)]).abs();
                    }
                }
            }
            let mut into = Mat::from_fn(n, width, |_, _| f64::NAN);
            symmetric_product_into(matrix, x.as_ref(), into.as_mut());
            assert!((&into - &plain).norm_max() < 1e-13);
            assert_eq!(into, transposed_product(matrix, x.as_ref()));
            let found = absolute_product(matrix, x.as_ref());
            assert!((&found - &absolute).norm_max() < 1e-13);
        }
    }
}
