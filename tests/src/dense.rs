//! Dense matrices and what is computed with them.

use dcb_formats::SparseMatrix;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{
    ComputeEigenvectors, SelfAdjointEvdParams, self_adjoint_evd, self_adjoint_evd_scratch,
};
use faer::linalg::solvers::Solve;
use faer::{Auto, Mat, MatRef, Par};

/// Dense copy.
pub fn dense(matrix: &SparseMatrix) -> Mat<f64> {
    let mut full = Mat::zeros(matrix.nrows(), matrix.ncols());
    for column in 0..matrix.ncols() {
        for (row, value) in matrix
            .row_idx_of_col_raw(column)
            .iter()
            .zip(matrix.val_of_col(column))
        {
            full[(*row as usize, column)] += *value;
        }
    }
    full
}

/// Sparse copy of the entries that are not zero.
pub fn sparse(matrix: &Mat<f64>) -> SparseMatrix {
    let mut entries = Vec::new();
    for j in 0..matrix.ncols() {
        for i in 0..matrix.nrows() {
            if matrix[(i, j)] != 0.0 {
                entries.push(faer::sparse::Triplet::new(
                    i as u32,
                    j as u32,
                    matrix[(i, j)],
                ));
            }
        }
    }
    SparseMatrix::try_new_from_triplets(matrix.nrows(), matrix.ncols(), &entries)
        .expect("the entries are in range")
}

/// `A x` entry by entry.
pub fn times(matrix: &SparseMatrix, x: MatRef<'_, f64>) -> Mat<f64> {
    let mut y = Mat::zeros(x.nrows(), x.ncols());
    for column in 0..matrix.ncols() {
        for (row, value) in matrix
            .row_idx_of_col_raw(column)
            .iter()
            .zip(matrix.val_of_col(column))
        {
            for k in 0..x.ncols() {
                y[(*row as usize, k)] += value * x[(column, k)];
            }
        }
    }
    y
}

/// Ascending eigenvalues and eigenvectors of a symmetric matrix.
pub fn eigen(a: &Mat<f64>) -> (Vec<f64>, Mat<f64>) {
    if a.nrows() == 0 {
        return (Vec::new(), Mat::zeros(0, 0));
    }
    let n = a.nrows();
    // QR iteration: divide and conquer is wrong for repeated eigenvalues.
    let params = SelfAdjointEvdParams {
        recursion_threshold: usize::MAX,
        ..Auto::<f64>::auto()
    };
    let (mut values, mut vectors) = (faer::Col::<f64>::zeros(n), Mat::zeros(n, n));
    let mut memory = MemBuffer::new(self_adjoint_evd_scratch::<f64>(
        n,
        ComputeEigenvectors::Yes,
        Par::Seq,
        params.into(),
    ));
    let (diagonal, u) = (values.as_mut().as_diagonal_mut(), Some(vectors.as_mut()));
    self_adjoint_evd(
        a.as_ref(),
        diagonal,
        u,
        Par::Seq,
        MemStack::new(&mut memory),
        params.into(),
    )
    .expect("finite numbers");
    (values.iter().copied().collect(), vectors)
}

/// Solves `a x = b` by LU with partial pivoting and two steps of refinement.
pub fn solve(a: &Mat<f64>, b: &Mat<f64>) -> Mat<f64> {
    let lu = a.partial_piv_lu();
    let mut x = lu.solve(b);
    for _ in 0..2 {
        let residual = b - a * &x;
        x += lu.solve(&residual);
    }
    x
}

/// `(a + aᵀ)/2`.
pub fn symmetric(a: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| 0.5 * (a[(i, j)] + a[(j, i)]))
}

/// Largest absolute entry.
pub fn largest(a: MatRef<'_, f64>) -> f64 {
    let mut largest = 0.0_f64;
    for j in 0..a.ncols() {
        for i in 0..a.nrows() {
            assert!(a[(i, j)].is_finite(), "entry ({i}, {j}) is {}", a[(i, j)]);
            largest = largest.max(a[(i, j)].abs());
        }
    }
    largest
}

/// Largest |a - b| as a fraction of the largest |b|; absolute where b is zero.
pub fn difference(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    assert_eq!((a.nrows(), a.ncols()), (b.nrows(), b.ncols()));
    let scale = largest(b.as_ref());
    largest((a - b).as_ref()) / if scale > 0.0 { scale } else { 1.0 }
}

/// Largest |a - b|_ij / (s_i s_j), so that units of rows do not matter; rows with s = 0 are compared with zero.
pub fn scaled_difference(a: &Mat<f64>, b: &Mat<f64>, scale: &[f64]) -> f64 {
    let mut worst = 0.0_f64;
    for j in 0..b.ncols() {
        for i in 0..b.nrows() {
            let s = scale[i] * scale[j];
            worst = worst.max((a[(i, j)] - b[(i, j)]).abs() / if s > 0.0 { s } else { 1.0 });
        }
    }
    worst
}

/// Square roots of the diagonal.
pub fn diagonal_roots(a: &Mat<f64>) -> Vec<f64> {
    (0..a.nrows()).map(|i| a[(i, i)].max(0.0).sqrt()).collect()
}

/// Largest relative difference of two lists.
pub fn relative(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs() / b.abs().max(f64::MIN_POSITIVE))
        .fold(0.0, f64::max)
}

/// Identity matrix of this size.
pub fn identity(n: usize) -> Mat<f64> {
    Mat::from_fn(n, n, |i, j| if i == j { 1.0 } else { 0.0 })
}

/// Diagonal matrix.
pub fn diagonal(values: &[f64]) -> Mat<f64> {
    Mat::from_fn(values.len(), values.len(), |i, j| {
        if i == j { values[i] } else { 0.0 }
    })
}
