//! The motions without stiffness.

use dcb_formats::SparseMatrix;
use dcb_sparse::block_algebra::symmetric_product;
use dcb_sparse::factorization::{SymmetricFactor, Unfactorized};
use faer::sparse::Triplet;
use faer::{Mat, MatRef};

/// Most steps of the inverse iteration, which ends when K Z is at rounding.
const MOST_STEPS: usize = 30;
/// The shift as a fraction of the diagonal of K.
const SHIFT: f64 = 1e-8;

/// Orthonormal motions without stiffness, (n, 6), by inverse iteration with a small shift; rows of one node have the same group.
///
/// # Errors
/// A stiffness that isn't positive semi-definite; no room.
pub(crate) fn null_space(stiffness: &SparseMatrix, groups: &[u32]) -> Result<Mat<f64>, String> {
    let size = stiffness.nrows();
    let diagonal = |row: usize| stiffness.as_ref().get(row, row).copied().unwrap_or(0.0);
    let units: Vec<_> = (0..size as u32)
        .map(|row| Triplet::new(row, row, diagonal(row as usize).abs()))
        .collect();
    let diagonal = SparseMatrix::try_new_from_triplets(size, size, &units)
        .map_err(|_| "the stiffness is too large".to_owned())?;
    let mut factor = SymmetricFactor::analyse(stiffness, &diagonal, groups)
        .map_err(|error| error.to_string())?;
    let factor = factor
        .factorize(stiffness, &diagonal, SHIFT)
        .map_err(|why| match why {
            Unfactorized::NotPositive => {
                "the stiffness isn't positive semi-definite; is it the stiffness?".to_owned()
            }
            Unfactorized::Failed(error) => error.to_string(),
        })?;
    // Any start that isn't orthogonal to the null space: numbers without pattern.
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut block = Mat::from_fn(size, 6, |_, _| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    });
    let mut least = f64::INFINITY;
    for _ in 0..MOST_STEPS {
        // Rigid motions are eigenvectors of K with any weights; without these they would only be nearly so.
        let mut next = symmetric_product(&diagonal, block.as_ref());
        (factor.solve_in_place(next.as_mut())).map_err(|error| error.to_string())?;
        let next = orthonormal(next.as_ref());
        let forces = symmetric_product(stiffness, next.as_ref()).norm_l2();
        let has_ended = forces > 0.5 * least;
        if forces < least {
            (block, least) = (next, forces);
        }
        if has_ended {
            break;
        }
    }
    Ok(block)
}

fn orthonormal(block: MatRef<'_, f64>) -> Mat<f64> {
    block.qr().compute_thin_Q()
}
