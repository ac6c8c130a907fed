//! Orthonormalization of a block of few columns by its Gram matrix.

use dcb_dense::symmetric_eigen;
use dcb_sparse::block_algebra::{gram, turn};
use faer::Mat;

use crate::error::Error;

/// Below this fraction of its size a direction is found by itself: the Gram matrix of a block resolves only the square root
/// of machine precision.
const NEARLY_DEPENDENT: f64 = 1e-3;

/// Makes a block M-orthonormal, with M times it, and returns the coupling: the block before is the new one times that. `None`, with nothing done, where
/// a direction has fallen below [`NEARLY_DEPENDENT`] of its size before, `reference` (squared), which a Gram matrix can't resolve.
pub(super) fn orthonormalize(
    block: &mut Mat<f64>,
    mass_block: &mut Mat<f64>,
    reference: &[f64],
) -> Result<Option<Mat<f64>>, Error> {
    if reference.iter().any(|r| *r <= 0.0) {
        return Ok(None);
    }
    let plain = gram(block.as_ref(), mass_block.as_ref());
    let scale: Vec<f64> = reference.iter().map(|r| r.sqrt()).collect();
    let scaled = Mat::from_fn(plain.nrows(), plain.ncols(), |i, j| {
        0.5 * (plain[(i, j)] + plain[(j, i)]) / (scale[i] * scale[j])
    });
    let (values, vectors) = symmetric_eigen(scaled.as_ref()).ok_or(Error::NotFinite {
        what: "orthonormalising a Lanczos block",
    })?;
    let smallest = values.first().copied().unwrap_or(0.0);
    if smallest < NEARLY_DEPENDENT * NEARLY_DEPENDENT {
        return Ok(None);
    }
    let width = values.len();
    let forward = Mat::from_fn(width, width, |i, j| {
        vectors[(i, j)] / (values[j].sqrt() * scale[i])
    });
    turn(block.as_mut(), forward.as_ref());
    turn(mass_block.as_mut(), forward.as_ref());
    Ok(Some(Mat::from_fn(width, width, |i, j| {
        vectors[(j, i)] * values[i].sqrt() * scale[j]
    })))
}
