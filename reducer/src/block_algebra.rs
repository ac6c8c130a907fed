//! Products of tall blocks (model-sized rows, few columns) with sparse matrices and with each other.
//!
//! Rows are cut into chunks of a fixed length and partial sums are added in chunk order, so every result is the same to
//! the last bit whatever the number of threads.

use dcb_formats::SparseMatrix;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;

/// Rows per task of a dense product: long enough to feed a kernel, short enough to share among threads.
const DENSE_CHUNK_ROWS: usize = 4096;
/// Rows per task of a sparse product.
const SPARSE_CHUNK_ROWS: usize = 1024;
/// Columns of the block that a sparse product takes at a time: one cache line of doubles.
const SPARSE_COLUMNS: usize = 8;

/// `A x` for a symmetric sparse matrix in full storage, (n, k): the same as `Aᵀ x`.
pub fn symmetric_product(matrix: &SparseMatrix, x: MatRef<'_, f64>) -> Mat<f64> {
    transposed_product(matrix, x)
}

/// `Aᵀ x` for a square sparse matrix, (n, k): each output row is one dot product over the column of the same index.
pub fn transposed_product(matrix: &SparseMatrix, x: MatRef<'_, f64>) -> Mat<f64> {
    product(matrix, x, |value| value)
}

/// `|A| |x|` for a symmetric sparse matrix, (n, k): times machine precision, a bound of the rounding in `A x`.
pub fn absolute_product(matrix: &SparseMatrix, x: MatRef<'_, f64>) -> Mat<f64> {
    product(matrix, x, f64::abs)
}

fn product(matrix: &SparseMatrix, x: MatRef<'_, f64>, of: impl Fn(f64) -> f64 + Copy + Sync) -> Mat<f64> {
    let mut y = Mat::zeros(x.nrows(), x.ncols());
    let mut packed = vec![[0.0; SPARSE_COLUMNS]; x.nrows()];
    for first in (0..x.ncols()).step_by(SPARSE_COLUMNS) {
        let count = SPARSE_COLUMNS.min(x.ncols() - first);
        pack_rows(x.subcols(first, count), &mut packed, of);
        let out = y.as_mut().subcols_mut(first, count);
        out.par_row_chunks_mut(SPARSE_CHUNK_ROWS).enumerate().for_each(|(chunk, mut rows)| {
            for local in 0..rows.nrows() {
                let sums = row_times_packed(matrix, chunk * SPARSE_CHUNK_ROWS + local, &packed, of);
                for (column, sum) in sums.iter().take(rows.ncols()).enumerate() {
                    rows[(local, column)] = *sum;
                }
            }
        });
    }
    y
}

fn pack_rows(x: MatRef<'_, f64>, packed: &mut [[f64; SPARSE_COLUMNS]], of: impl Fn(f64) -> f64 + Sync) {
    packed.par_chunks_mut(SPARSE_CHUNK_ROWS).enumerate().for_each(|(chunk, rows)| {
        let first = chunk * SPARSE_CHUNK_ROWS;
        for (local, row) in rows.iter_mut().enumerate() {
            for (column, value) in row.iter_mut().enumerate() {
                *value = if column < x.ncols() { of(x[(first + local, column)]) } else { 0.0 };
            }
        }
    });
}

fn row_times_packed(
    matrix: &SparseMatrix,
    row: usize,
    packed: &[[f64; SPARSE_COLUMNS]],
    of: impl Fn(f64) -> f64,
) -> [f64; SPARSE_COLUMNS] {
    let mut sums = [0.0; SPARSE_COLUMNS];
    let indices = matrix.row_idx_of_col_raw(row);
    for (index, value) in indices.iter().zip(matrix.val_of_col(row)) {
        let x = &packed[*index as usize];
        let value = of(*value);
        for (sum, entry) in sums.iter_mut().zip(x) {
            *sum += value * entry;
        }
    }
    sums
}

/// `aᵀ b`, (k, l), for two blocks with the same number of rows.
pub fn gram(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let partials: Vec<Mat<f64>> = a
        .par_row_chunks(DENSE_CHUNK_ROWS)
        .zip(b.par_row_chunks(DENSE_CHUNK_ROWS))
        .map(|(a, b)| {
            let mut partial = Mat::zeros(a.ncols(), b.ncols());
            matmul(partial.as_mut(), Accum::Replace, a.transpose(), b, 1.0, Par::Seq);
            partial
        })
        .collect();
    let mut sum = Mat::zeros(a.ncols(), b.ncols());
    for partial in &partials {
        sum += partial;
    }
    sum
}

/// `y += factor · v c` with v (n, k) and c (k, l).
pub fn add_combination(y: MatMut<'_, f64>, v: MatRef<'_, f64>, c: MatRef<'_, f64>, factor: f64) {
    y.par_row_chunks_mut(DENSE_CHUNK_ROWS)
        .zip(v.par_row_chunks(DENSE_CHUNK_ROWS))
        .for_each(|(y, v)| matmul(y, Accum::Add, v, c, factor, Par::Seq));
}

/// `v c` with v (n, k) and c (k, l).
pub fn combination(v: MatRef<'_, f64>, c: MatRef<'_, f64>) -> Mat<f64> {
    let mut y = Mat::zeros(v.nrows(), c.ncols());
    add_combination(y.as_mut(), v, c, 1.0);
    y
}

/// Euclidean norm of each column.
pub fn column_norms(x: MatRef<'_, f64>) -> Vec<f64> {
    x.col_iter().map(|column| column.norm_l2()).collect()
}

/// Largest absolute entry; 0 for an empty matrix.
pub fn largest_entry(x: MatRef<'_, f64>) -> f64 {
    let mut largest = 0.0_f64;
    for column in x.col_iter() {
        for value in column.iter() {
            largest = largest.max(value.abs());
        }
    }
    largest
}

/// `(a + aᵀ)/2`.
pub fn symmetrized(a: MatRef<'_, f64>) -> Mat<f64> {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| 0.5 * (a[(i, j)] + a[(j, i)]))
}

/// Eigenvalues, ascending, and orthonormal eigenvectors (columns) of a small dense symmetric matrix.
///
/// `None` if the iteration does not converge, which only non-finite entries cause.
pub fn symmetric_eigen(a: MatRef<'_, f64>) -> Option<(Vec<f64>, Mat<f64>)> {
    use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
    let n = a.nrows();
    if n == 0 {
        return Some((Vec::new(), Mat::zeros(0, 0)));
    }
    if !a.is_all_finite() {
        return None;
    }
    // faer's divide and conquer neglects what is small beside 1, not beside the matrix. A power of two scales without rounding.
    let size = match largest_entry(a) {
        0.0 => 1.0,
        largest => largest.log2().floor().exp2(),
    };
    let scaled = Mat::from_fn(n, n, |i, j| a[(i, j)] / size);
    let mut values = faer::Col::<f64>::zeros(n);
    let mut vectors = Mat::zeros(n, n);
    let scratch = self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::Yes, Par::Seq, Default::default());
    let mut memory = MemBuffer::new(scratch);
    self_adjoint_evd(
        scaled.as_ref(),
        values.as_mut().as_diagonal_mut(),
        Some(vectors.as_mut()),
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    )
    .ok()?;
    Some((values.iter().map(|value| value * size).collect(), vectors))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use faer::sparse::Triplet;

    fn pseudo_random(rows: usize, columns: usize) -> Mat<f64> {
        let mut state = 7_u64;
        Mat::from_fn(rows, columns, |_, _| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        })
    }

    /// Projected flexibilities are of order 1e-9, and have to be diagonal to rounding beside that, not beside 1.
    #[test]
    fn eigenvectors_are_as_good_for_small_numbers() {
        let n = 120;
        let random = pseudo_random(n, n);
        let graded = Mat::from_fn(n, n, |i, j| {
            let decay = 0.93_f64.powi((i + j) as i32);
            decay * if i == j { 1.0 } else { random[(i.min(j), i.max(j))] }
        });
        for size in [1.0, 1e-9, 1e-250, 1e250] {
            let matrix = Mat::from_fn(n, n, |i, j| size * graded[(i, j)]);
            let (values, vectors) = symmetric_eigen(matrix.as_ref()).unwrap();
            let left = vectors.transpose() * &matrix * &vectors;
            let defect = Mat::from_fn(n, n, |i, j| left[(i, j)] / size - if i == j { values[i] / size } else { 0.0 });
            assert!(largest_entry(defect.as_ref()) < 1e-13, "size {size:e}: {:e}", largest_entry(defect.as_ref()));
        }
    }

    #[test]
    fn products_do_not_depend_on_the_number_of_threads() {
        let n = 10_000;
        let mut entries = Vec::new();
        for i in 0..n as u32 {
            entries.push(Triplet::new(i, i, 3.0 + f64::from(i) * 1e-3));
            if i > 0 {
                entries.push(Triplet::new(i, i - 1, -1.0 / f64::from(i)));
                entries.push(Triplet::new(i - 1, i, -1.0 / f64::from(i)));
            }
        }
        let matrix = SparseMatrix::try_new_from_triplets(n, n, &entries).unwrap();
        let x = pseudo_random(n, 11);
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let y = symmetric_product(&matrix, x.as_ref());
                let g = gram(x.as_ref(), y.as_ref());
                (combination(x.as_ref(), g.as_ref()), y)
            })
        };
        let (one, three) = (run(1), run(3));
        assert_eq!(one, three);
        // The same product by a plain loop over the entries.
        let mut plain = Mat::<f64>::zeros(n, 11);
        for entry in &entries {
            for column in 0..11 {
                plain[(entry.row as usize, column)] += entry.val * x[(entry.col as usize, column)];
            }
        }
        assert!(largest_entry((&plain - &one.1).as_ref()) < 1e-13);
    }
}
