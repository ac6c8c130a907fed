//! Spectrum of the symmetric part of a small dense matrix.

use faer::{Mat, MatRef, Side};

/// Ascending eigenvalues and orthonormal eigenvectors of ½ (A + Aᵀ); none where an entry isn't finite or the iteration fails.
pub(super) fn symmetric_part_eigen(matrix: MatRef<'_, f64>) -> Option<(Vec<f64>, Mat<f64>)> {
    let symmetric = Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
        0.5 * (matrix[(i, j)] + matrix[(j, i)])
    });
    if !symmetric.as_ref().is_all_finite() {
        return None;
    }
    let eigen = symmetric.self_adjoint_eigen(Side::Lower).ok()?;
    let values = eigen.S().column_vector().iter().copied().collect();
    Some((values, eigen.U().to_owned()))
}
