//! Products of tall blocks (model-sized rows, few columns) with each other, and small dense eigenproblems.
//!
//! Rows are cut into chunks of a fixed length and partial sums are added in chunk order, so every result is the same to
//! the last bit whatever the number of threads.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{
    ComputeEigenvectors, SelfAdjointEvdParams, self_adjoint_evd, self_adjoint_evd_scratch,
};
use faer::linalg::matmul::matmul;
use faer::reborrow::*;
use faer::{Accum, Auto, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;

use crate::tall_products;

pub use crate::sparse_product::{
    absolute_product, symmetric_product, symmetric_product_into, transposed_product,
};

/// Rows per task of a dense product: long enough to feed a kernel, short enough to share among threads.
const DENSE_CHUNK_ROWS: usize = 2048;
/// Partial sums of a Gram matrix take at most this share of what its operands take.
const PARTIAL_SHARE: usize = 32;

/// `aᵀ b`, (k, l), for two blocks with the same number of rows.
pub fn gram(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let (k, l) = (a.ncols(), b.ncols());
    let chunk = DENSE_CHUNK_ROWS.max(PARTIAL_SHARE * k * l / (k + l).max(1));
    let partials: Vec<Mat<f64>> = a
        .par_row_chunks(chunk)
        .zip(b.par_row_chunks(chunk))
        .map(|(a, b)| {
            let mut partial = Mat::zeros(a.ncols(), b.ncols());
            if tall_products::dots(a, b, partial.as_mut()).is_none() {
                let out = partial.as_mut();
                matmul(out, Accum::Replace, a.transpose(), b, 1.0, Par::Seq);
            }
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
        .for_each(|(y, v)| add_chunk(y, v, c, factor));
}

fn add_chunk(mut y: MatMut<'_, f64>, v: MatRef<'_, f64>, c: MatRef<'_, f64>, factor: f64) {
    if tall_products::add(y.as_mut(), v, c, factor).is_none() {
        matmul(y, Accum::Add, v, c, factor, Par::Seq);
    }
}

/// `v c` with v (n, k) and c (k, l).
pub fn combination(v: MatRef<'_, f64>, c: MatRef<'_, f64>) -> Mat<f64> {
    let mut y = Mat::zeros(v.nrows(), c.ncols());
    add_combination(y.as_mut(), v, c, 1.0);
    y
}

/// `x = x c` with x (n, k) and c (k, k), in place.
pub fn turn(x: MatMut<'_, f64>, c: MatRef<'_, f64>) {
    x.par_row_chunks_mut(DENSE_CHUNK_ROWS).for_each(|mut x| {
        let before = x.rb().to_owned();
        x.fill(0.0);
        add_chunk(x, before.as_ref(), c, 1.0);
    });
}

/// `to = from`.
pub fn copy(from: MatRef<'_, f64>, to: MatMut<'_, f64>) {
    assert_eq!((from.nrows(), from.ncols()), (to.nrows(), to.ncols()));
    to.par_col_iter_mut()
        .zip(from.par_col_iter())
        .for_each(|(mut to, from)| to.copy_from(from));
}

/// Euclidean norm of each column.
pub fn column_norms(x: MatRef<'_, f64>) -> Vec<f64> {
    x.par_col_iter().map(|column| column.norm_l2()).collect()
}

/// `aᵢ · bᵢ` for each column.
pub fn column_dots(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Vec<f64> {
    (0..a.ncols())
        .into_par_iter()
        .map(|j| a.col(j).transpose() * b.col(j))
        .collect()
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

/// Largest relative residual of a dense eigensolution that is believed.
const DENSE_RESIDUAL: f64 = 1e-12;

/// Eigenvalues, ascending, and orthonormal eigenvectors (columns) of a small dense symmetric matrix.
///
/// `None` if the iteration does not converge, which only non-finite entries cause.
pub fn symmetric_eigen(a: MatRef<'_, f64>) -> Option<(Vec<f64>, Mat<f64>)> {
    if !a.is_all_finite() {
        return None;
    }
    // Entries near 1, because faer neglects what is small beside 1 rather than beside the matrix; a power of two doesn't round.
    let scale = match largest_entry(a) {
        0.0 => 1.0,
        largest => largest.log2().floor().exp2(),
    };
    let scaled = Mat::from_fn(a.nrows(), a.nrows(), |i, j| a[(i, j)] / scale);
    // faer 0.24's divide and conquer, its choice from 128 rows on, is fast, but its pairs can have relative residuals of
    // 1e-3 where eigenvalues repeat (`tests/reduction/spectra.rs` has such a matrix): checked, and QR iteration otherwise.
    let threshold = <SelfAdjointEvdParams as Auto<f64>>::auto().recursion_threshold;
    let (values, vectors) = match dense_eigen(&scaled, threshold)? {
        fast if a.nrows() < threshold || dense_residual(&scaled, &fast) <= DENSE_RESIDUAL => fast,
        _ => dense_eigen(&scaled, usize::MAX)?,
    };
    Some((
        values.into_iter().map(|value| value * scale).collect(),
        vectors,
    ))
}

fn dense_eigen(a: &Mat<f64>, recursion_threshold: usize) -> Option<(Vec<f64>, Mat<f64>)> {
    let n = a.nrows();
    let params = SelfAdjointEvdParams {
        recursion_threshold,
        ..<SelfAdjointEvdParams as Auto<f64>>::auto()
    };
    let (mut values, mut vectors) = (faer::Col::<f64>::zeros(n), Mat::zeros(n, n));
    let scratch =
        self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::Yes, Par::Seq, params.into());
    let mut memory = MemBuffer::new(scratch);
    self_adjoint_evd(
        a.as_ref(),
        values.as_mut().as_diagonal_mut(),
        Some(vectors.as_mut()),
        Par::Seq,
        MemStack::new(&mut memory),
        params.into(),
    )
    .ok()?;
    Some((values.iter().copied().collect(), vectors))
}

/// Largest entry of `A V - V Λ`, for a matrix whose largest entry is between 1 and 2.
fn dense_residual(a: &Mat<f64>, (values, vectors): &(Vec<f64>, Mat<f64>)) -> f64 {
    let n = a.nrows();
    let mut residual = Mat::from_fn(n, n, |i, j| -vectors[(i, j)] * values[j]);
    matmul(residual.as_mut(), Accum::Add, a, vectors, 1.0, Par::Seq);
    largest_entry(residual.as_ref())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use dcb_formats::SparseMatrix;
    use faer::sparse::Triplet;

    fn pseudo_random(rows: usize, columns: usize) -> Mat<f64> {
        let mut state = 7_u64;
        Mat::from_fn(rows, columns, |_, _| {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
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
            decay
                * if i == j {
                    1.0
                } else {
                    random[(i.min(j), i.max(j))]
                }
        });
        for size in [1.0, 1e-9, 1e-250, 1e250] {
            let matrix = Mat::from_fn(n, n, |i, j| size * graded[(i, j)]);
            let (values, vectors) = symmetric_eigen(matrix.as_ref()).unwrap();
            let left = vectors.transpose() * &matrix * &vectors;
            let defect = Mat::from_fn(n, n, |i, j| {
                left[(i, j)] / size - if i == j { values[i] / size } else { 0.0 }
            });
            assert!(
                largest_entry(defect.as_ref()) < 1e-13,
                "size {size:e}: {:e}",
                largest_entry(defect.as_ref())
            );
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
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
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
