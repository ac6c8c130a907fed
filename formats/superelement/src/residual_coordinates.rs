//! The coordinates beyond the modes: combinations of attachments and further columns, orthonormal in M and diagonal in K.
//!
//! ```text
//! ζ:  u = [G_res L_bᵀ, X] [T; T_x] ζ        [T; T_x]ᵀ M_rr [T; T_x] = I,   [T; T_x]ᵀ K_rr [T; T_x] = diag(σ²)
//! ```
//! Without further columns X that is the file's transform. With them, the part of each that the attachments don't have is filtered as
//! the reducer filters attachments, and both are diagonalised together.

use dcb_dense::{symmetric_eigen, symmetrized};
use dcb_formats::superelement::{Enrichment, Superelement};
use faer::{Mat, MatRef};

/// Largest entry of Φᵀ M X, relative to the norm of X's column, that still counts as rounding.
const ORTHOGONALITY_LIMIT: f64 = 1e-6;

/// Why a superelement has none.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoCoordinates {
    /// Further columns X have more of Φᵀ M X than rounding.
    #[error("its further columns are not orthogonal to its modes")]
    FurtherNotOrthogonal,
    /// K over attachments and further columns isn't positive semi-definite.
    #[error(
        "the reduced stiffness over attachments and further columns has the eigenvalue {0:.3e}"
    )]
    NotPositive(
        /// Its smallest eigenvalue; no number where an entry is none.
        f64,
    ),
}

/// Coordinates beyond the modes, of unit mass each.
#[derive(Clone, Debug)]
pub struct ResidualCoordinates {
    /// T, (n_b, r).
    pub attached: Mat<f64>,
    /// T_x, (n_x, r).
    pub further: Mat<f64>,
    /// σ², ascending, (r), 1/time².
    pub stiffness: Vec<f64>,
}

impl ResidualCoordinates {
    /// All that have mass: the attachments' and those of further columns.
    ///
    /// # Errors
    /// [`NoCoordinates`] if further columns aren't orthogonal to the modes, or the reduced matrices over them aren't those of a body.
    pub fn of(superelement: &Superelement) -> Result<Self, NoCoordinates> {
        let residual = &superelement.residual;
        match &superelement.enrichment {
            None => Ok(Self {
                attached: residual.transform.clone(),
                further: Mat::zeros(0, residual.sigma_squared.len()),
                stiffness: residual.sigma_squared.clone(),
            }),
            Some(enrichment) => Self::with_further(superelement, enrichment),
        }
    }

    /// L_b (G_res L_bᵀ T + X T_x), (n_b, r), over the rows that forces act on.
    pub fn seen(&self, superelement: &Superelement) -> Mat<f64> {
        let of_attachments = &superelement.residual.flexibility * &self.attached;
        match &superelement.enrichment {
            Some(enrichment) => of_attachments + &enrichment.interface_shapes * &self.further,
            None => of_attachments,
        }
    }

    fn with_further(
        superelement: &Superelement,
        enrichment: &Enrichment,
    ) -> Result<Self, NoCoordinates> {
        let n_k = superelement.mode_count();
        let n_b = superelement.rows.len();
        let n_x = enrichment.interface_shapes.ncols();
        refuse_parallel_to_modes(superelement, enrichment)?;
        let block = |matrix: &Mat<f64>| {
            matrix
                .as_ref()
                .submatrix(n_k, n_k, n_b + n_x, n_b + n_x)
                .to_owned()
        };
        let (mass, stiffness) = (
            block(&enrichment.reduced_mass),
            block(&enrichment.reduced_stiffness),
        );
        let transform = &superelement.residual.transform;
        let rank = transform.ncols();
        // B = [T_r; 0], and X less what it has of B: X' = X - B (Bᵀ M X).
        let attached = Mat::from_fn(n_b + n_x, rank, |i, j| match i < n_b {
            true => transform[(i, j)],
            false => 0.0,
        });
        let shared = attached.transpose() * mass.as_ref().subcols(n_b, n_x);
        let own = Mat::from_fn(n_b + n_x, n_x, |i, j| if i == n_b + j { 1.0 } else { 0.0 })
            - &attached * &shared;
        // D X'ᵀ M X' D with D = diag(XᵀMX)^(-1/2): how much of each column is its own.
        let scale: Vec<f64> = (0..n_x)
            .map(|j| mass[(n_b + j, n_b + j)].max(0.0).sqrt())
            .map(|norm| if norm > 0.0 { 1.0 / norm } else { 0.0 })
            .collect();
        let gram = own.transpose() * &mass * &own;
        let scaled = Mat::from_fn(n_x, n_x, |i, j| scale[i] * gram[(i, j)] * scale[j]);
        let (fractions, vectors) = eigen(scaled.as_ref())?;
        let kept: Vec<usize> = (0..n_x)
            .filter(|i| fractions[*i] > superelement.residual.tolerance)
            .collect();
        let combined = Mat::from_fn(n_x, kept.len(), |i, j| {
            scale[i] * vectors[(i, kept[j])] / fractions[kept[j]].sqrt()
        });
        let own = own * combined;
        let all = Mat::from_fn(n_b + n_x, rank + kept.len(), |i, j| match j < rank {
            true => attached[(i, j)],
            false => own[(i, j - rank)],
        });
        let (squares, rotation) = eigen((all.transpose() * &stiffness * &all).as_ref())?;
        let all = all * rotation;
        let largest = squares.last().copied().unwrap_or(0.0);
        if let Some(found) = squares
            .iter()
            .find(|square| **square < -superelement.residual.tolerance * largest)
        {
            return Err(NoCoordinates::NotPositive(*found));
        }
        Ok(Self {
            attached: all.as_ref().subrows(0, n_b).to_owned(),
            further: all.as_ref().subrows(n_b, n_x).to_owned(),
            stiffness: squares.iter().map(|square| square.max(0.0)).collect(),
        })
    }
}

fn refuse_parallel_to_modes(
    superelement: &Superelement,
    enrichment: &Enrichment,
) -> Result<(), NoCoordinates> {
    let n_k = superelement.mode_count();
    let mass = &enrichment.reduced_mass;
    let first = n_k + superelement.rows.len();
    for j in first..mass.ncols() {
        let norm = mass[(j, j)].max(0.0).sqrt();
        let found = (0..n_k).fold(0.0, |most, k| f64::max(most, mass[(k, j)].abs()));
        if found.is_nan() || found > ORTHOGONALITY_LIMIT * norm {
            return Err(NoCoordinates::FurtherNotOrthogonal);
        }
    }
    Ok(())
}

/// Ascending eigenvalues and eigenvectors of the symmetric part.
fn eigen(matrix: MatRef<'_, f64>) -> Result<(Vec<f64>, Mat<f64>), NoCoordinates> {
    symmetric_eigen(symmetrized(matrix).as_ref()).ok_or(NoCoordinates::NotPositive(f64::NAN))
}
