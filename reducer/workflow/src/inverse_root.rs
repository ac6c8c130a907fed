//! The inverse of a stiffness over what is independent in it.

use dcb_dense::{symmetric_eigen, symmetrized};
use faer::{Mat, MatRef};

/// U with U Uᵀ = K⁺, (n, r); directions of the stiffness, scaled to a unit diagonal, up to `tolerance` count as none. `None` if the
/// eigenproblem fails, which only numbers that aren't finite cause.
pub(crate) fn inverse_root(stiffness: MatRef<'_, f64>, tolerance: f64) -> Option<Mat<f64>> {
    let n = stiffness.nrows();
    let scale: Vec<f64> = (0..n)
        .map(|j| match stiffness[(j, j)] {
            own if own > 0.0 => 1.0 / own.sqrt(),
            _ => 0.0,
        })
        .collect();
    let scaled = Mat::from_fn(n, n, |i, j| scale[i] * stiffness[(i, j)] * scale[j]);
    let (values, vectors) = symmetric_eigen(symmetrized(scaled.as_ref()).as_ref())?;
    let kept: Vec<usize> = (0..n).filter(|k| values[*k] > tolerance).collect();
    Some(Mat::from_fn(n, kept.len(), |i, k| {
        scale[i] * vectors[(i, kept[k])] / values[kept[k]].sqrt()
    }))
}
