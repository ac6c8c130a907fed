//! Spectrum of a small dense symmetric matrix, to the last digits.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{
    ComputeEigenvectors, SelfAdjointEvdParams, self_adjoint_evd, self_adjoint_evd_scratch,
};
use faer::{Auto, Mat, Par};

use crate::error::Error;

/// Eigenvalues, ascending, and orthonormal eigenvectors. Scaled by a power of two, because faer neglects what is small beside 1,
/// and by QR iteration: its divide and conquer loses digits where eigenvalues repeat.
pub(super) fn symmetric_eigen(matrix: &Mat<f64>) -> Result<(Vec<f64>, Mat<f64>), Error> {
    let n = matrix.nrows();
    if !matrix.as_ref().is_all_finite() {
        return Err(Error::NoEigenvalues);
    }
    if n == 0 {
        return Ok((Vec::new(), Mat::zeros(0, 0)));
    }
    let scale = match matrix.as_ref().norm_max() {
        0.0 => 1.0,
        largest => largest.log2().floor().exp2(),
    };
    let scaled = Mat::from_fn(n, n, |i, j| matrix[(i, j)] / scale);
    let params = SelfAdjointEvdParams {
        recursion_threshold: usize::MAX,
        ..<SelfAdjointEvdParams as Auto<f64>>::auto()
    };
    let (mut values, mut vectors) = (faer::Col::<f64>::zeros(n), Mat::zeros(n, n));
    let scratch =
        self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::Yes, Par::Seq, params.into());
    let mut memory = MemBuffer::new(scratch);
    self_adjoint_evd(
        scaled.as_ref(),
        values.as_mut().as_diagonal_mut(),
        Some(vectors.as_mut()),
        Par::Seq,
        MemStack::new(&mut memory),
        params.into(),
    )
    .map_err(|_| Error::NoEigenvalues)?;
    let values = values.iter().map(|value| value * scale).collect();
    Ok((values, vectors))
}
