//! Products of tall blocks (model-sized rows, few columns) with each other.
//!
//! Rows are cut into chunks of a fixed length and partial sums are added in chunk order, so every result is the same to
//! the last bit whatever the number of threads.

use faer::linalg::matmul::matmul;
use faer::reborrow::*;
use faer::{Accum, Mat, MatMut, MatRef, Par};
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
    let mut y = zeros(v.nrows(), c.ncols());
    add_combination(y.as_mut(), v, c, 1.0);
    y
}

/// `yⱼ += factorⱼ xⱼ` for each column.
pub fn add_scaled_columns(y: MatMut<'_, f64>, factors: &[f64], x: MatRef<'_, f64>) {
    assert_eq!((x.nrows(), x.ncols()), (y.nrows(), y.ncols()));
    assert_eq!(factors.len(), x.ncols());
    y.par_col_iter_mut()
        .zip(x.par_col_iter())
        .zip(factors)
        .for_each(|((y, x), factor)| {
            for (y, x) in y.iter_mut().zip(x.iter()) {
                *y += factor * x;
            }
        });
}

/// `x = x c` with x (n, k) and c (k, k), in place.
pub fn turn(x: MatMut<'_, f64>, c: MatRef<'_, f64>) {
    x.par_row_chunks_mut(DENSE_CHUNK_ROWS).for_each(|mut x| {
        let before = x.rb().to_owned();
        x.fill(0.0);
        add_chunk(x, before.as_ref(), c, 1.0);
    });
}

/// A block of zeros, written by all threads.
pub fn zeros(rows: usize, columns: usize) -> Mat<f64> {
    crate::zeros::matrix(rows, columns)
}

/// A copy of its own, made by all threads.
pub fn copied(from: MatRef<'_, f64>) -> Mat<f64> {
    crate::zeros::copy_of(from)
}

/// `to = from`.
pub fn copy(from: MatRef<'_, f64>, to: MatMut<'_, f64>) {
    assert_eq!((from.nrows(), from.ncols()), (to.nrows(), to.ncols()));
    to.par_col_iter_mut()
        .zip(from.par_col_iter())
        .for_each(|(mut to, from)| to.copy_from(from));
}

/// Some columns, in the order asked for.
pub fn some_columns(of: MatRef<'_, f64>, columns: &[usize]) -> Mat<f64> {
    let mut some = zeros(of.nrows(), columns.len());
    some.par_col_iter_mut()
        .zip(columns)
        .for_each(|(mut to, column)| to.copy_from(of.col(*column)));
    some
}

/// Puts columns into the places that [`some_columns`] took them from.
pub fn set_columns(mut of: MatMut<'_, f64>, columns: &[usize], some: MatRef<'_, f64>) {
    for (column, from) in columns.iter().zip(some.col_iter()) {
        of.rb_mut().col_mut(*column).copy_from(from);
    }
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use dcb_formats::SparseMatrix;
    use dcb_samples::PseudoRandom;
    use faer::sparse::Triplet;

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
        let x = PseudoRandom::new(7).matrix(n, 11);
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
