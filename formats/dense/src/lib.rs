//! Eigenvalues and eigenvectors of small dense symmetric matrices, to the last digits: the one solution that reduction, superelements and
//! mechanisms use.
//!
//! ```
//! use dcb_dense::symmetric_eigen;
//! use faer::mat;
//!
//! // Two masses of 1e-30 kg between springs: entries far from 1 are as good as others.
//! let stiffness = mat![[2e-30, -1e-30], [-1e-30, 2e-30]];
//! let (values, vectors) = symmetric_eigen(stiffness.as_ref()).ok_or("an entry isn't a number")?;
//! assert!((values[0] - 1e-30).abs() < 1e-45 && (values[1] - 3e-30).abs() < 1e-45);
//! assert!((vectors[(0, 0)] - vectors[(1, 0)]).abs() < 1e-15);
//! # Ok::<(), &str>(())
//! ```

mod symmetric_eigen;

use faer::Mat;
use faer::mat::AsMatRef;

pub use symmetric_eigen::{symmetric_eigen, symmetric_eigenvalues};

/// `½ (a + aᵀ)`, of a square matrix.
pub fn symmetrized(a: impl AsMatRef<T = f64, Rows = usize, Cols = usize>) -> Mat<f64> {
    let a = a.as_mat_ref();
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| 0.5 * (a[(i, j)] + a[(j, i)]))
}
