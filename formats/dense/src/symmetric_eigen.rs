//! Eigenpairs of one dense symmetric matrix.
//!
//! Two faults of faer 0.24 are worked round. It neglects what is small beside 1 rather than beside the matrix; so the matrix is scaled by
//! a power of two, which doesn't round. Its divide and conquer, its choice from 128 rows on, is fast, but its pairs can have relative
//! residuals of 1e-3 where eigenvalues repeat; so they are checked, and QR iteration takes over where they are no good.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{
    ComputeEigenvectors, SelfAdjointEvdParams, self_adjoint_evd, self_adjoint_evd_scratch,
};
use faer::linalg::matmul::matmul;
use faer::{Accum, Auto, Col, Mat, MatMut, MatRef, Par};

/// Largest relative residual of a solution by divide and conquer that is believed.
const RESIDUAL: f64 = 1e-12;

/// Eigenvalues, ascending, and orthonormal eigenvectors, the columns of an (n, n) matrix. Of `a`, (n, n), the lower triangle is read.
///
/// `None` where an entry isn't finite.
pub fn symmetric_eigen(a: MatRef<'_, f64>) -> Option<(Vec<f64>, Mat<f64>)> {
    let (scaled, scale) = near_one(a)?;
    let n = a.nrows();
    let threshold = <SelfAdjointEvdParams as Auto<f64>>::auto().recursion_threshold;
    let mut vectors = Mat::zeros(n, n);
    let mut values = eigen(&scaled, Some(vectors.as_mut()), threshold)?;
    if n >= threshold && residual(&scaled, &values, &vectors) > RESIDUAL {
        values = eigen(&scaled, Some(vectors.as_mut()), usize::MAX)?;
    }
    Some((of_size(values, scale), vectors))
}

/// The same without eigenvectors.
pub fn symmetric_eigenvalues(a: MatRef<'_, f64>) -> Option<Vec<f64>> {
    let (scaled, scale) = near_one(a)?;
    // Without vectors faer takes QR iteration, whatever the size.
    Some(of_size(eigen(&scaled, None, usize::MAX)?, scale))
}

/// A multiple whose largest entry is between 1 and 2, and the factor, a power of two, that leads back; `None` where an entry isn't finite.
fn near_one(a: MatRef<'_, f64>) -> Option<(Mat<f64>, f64)> {
    if !a.is_all_finite() {
        return None;
    }
    let scale = match a.norm_max() {
        0.0 => 1.0,
        largest => largest.log2().floor().exp2(),
    };
    Some((
        Mat::from_fn(a.nrows(), a.nrows(), |i, j| a[(i, j)] / scale),
        scale,
    ))
}

fn of_size(values: Vec<f64>, scale: f64) -> Vec<f64> {
    values.into_iter().map(|value| value * scale).collect()
}

/// Eigenvalues, and eigenvectors where there is room for them. Divide and conquer goes down to `recursion_threshold` rows.
fn eigen(
    a: &Mat<f64>,
    vectors: Option<MatMut<'_, f64>>,
    recursion_threshold: usize,
) -> Option<Vec<f64>> {
    let n = a.nrows();
    if n == 0 {
        return Some(Vec::new());
    }
    let params = SelfAdjointEvdParams {
        recursion_threshold,
        ..<SelfAdjointEvdParams as Auto<f64>>::auto()
    };
    let wanted = match vectors {
        Some(_) => ComputeEigenvectors::Yes,
        None => ComputeEigenvectors::No,
    };
    let mut values = Col::<f64>::zeros(n);
    let scratch = self_adjoint_evd_scratch::<f64>(n, wanted, Par::Seq, params.into());
    let mut memory = MemBuffer::new(scratch);
    self_adjoint_evd(
        a.as_ref(),
        values.as_mut().as_diagonal_mut(),
        vectors,
        Par::Seq,
        MemStack::new(&mut memory),
        params.into(),
    )
    .ok()?;
    Some(values.iter().copied().collect())
}

/// Largest entry of `A V - V Λ`, for a matrix whose largest entry is between 1 and 2.
fn residual(a: &Mat<f64>, values: &[f64], vectors: &Mat<f64>) -> f64 {
    let n = a.nrows();
    let mut residual = Mat::from_fn(n, n, |i, j| -vectors[(i, j)] * values[j]);
    matmul(residual.as_mut(), Accum::Add, a, vectors, 1.0, Par::Seq);
    residual.norm_max()
}
