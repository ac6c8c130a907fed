//! The dynamic coordinates beyond the modes, as a reader of the file makes them (`docs/theory.md`, sections 6 and 12): attachments that T_r keeps, and what
//! further columns X have beside them.
//!
//! ```text
//! X'  = X - B (Bᵀ M X),    B = [G_res L_bᵀ] T_r          filtered by D X'ᵀ M X' D, D = diag(Xᵀ M X)^(-1/2)
//! [B, X'] S = [G_res L_bᵀ, X] [T; T_x]                   orthonormal in M, K diagonal
//! ```

use dcb_dense::{symmetric_eigen, symmetrized};
use dcb_formats::Superelement;
use dcb_formats::superelement::Enrichment;
use faer::Mat;

/// Coordinates beyond the modes, of unit mass each.
#[derive(Clone, Debug)]
pub struct ResidualCoordinates {
    /// σ², ascending.
    pub squares: Vec<f64>,
    /// How they move the rows of L_b that forces act on, (n_b, r).
    pub shapes: Mat<f64>,
}

impl ResidualCoordinates {
    /// Those of a superelement; `None` if an eigenproblem fails, which only numbers that aren't finite cause.
    pub fn of(element: &Superelement) -> Option<Self> {
        let residual = &element.residual;
        match &element.enrichment {
            None => Some(Self {
                squares: residual.sigma_squared.clone(),
                shapes: &residual.flexibility * &residual.transform,
            }),
            Some(enrichment) => Self::with_further(element, enrichment),
        }
    }

    fn with_further(element: &Superelement, enrichment: &Enrichment) -> Option<Self> {
        let residual = &element.residual;
        let (n_k, n_b) = (element.mode_count(), element.boundary_row_count());
        let n_x = enrichment.interface_shapes.ncols();
        let block = |matrix: &Mat<f64>| {
            let block = matrix.submatrix(n_k, n_k, n_b + n_x, n_b + n_x);
            symmetrized(block)
        };
        let (mass, stiffness) = (
            block(&enrichment.reduced_mass),
            block(&enrichment.reduced_stiffness),
        );
        let rank = residual.transform.ncols();
        let attached = Mat::from_fn(n_b + n_x, rank, |i, j| match i < n_b {
            true => residual.transform[(i, j)],
            false => 0.0,
        });
        let shared = attached.transpose() * mass.subcols(n_b, n_x);
        let unit = Mat::from_fn(n_b + n_x, n_x, |i, j| f64::from(u8::from(i == n_b + j)));
        let own = unit - &attached * shared;
        let scale: Vec<f64> = (0..n_x)
            .map(|j| match mass[(n_b + j, n_b + j)] {
                norm if norm > 0.0 => 1.0 / norm.sqrt(),
                _ => 0.0,
            })
            .collect();
        let own_mass = own.transpose() * &mass * &own;
        let scaled = Mat::from_fn(n_x, n_x, |i, j| scale[i] * own_mass[(i, j)] * scale[j]);
        let (shares, vectors) = symmetric_eigen(symmetrized(scaled.as_ref()).as_ref())?;
        let kept: Vec<usize> = (0..n_x)
            .filter(|k| shares[*k] > residual.tolerance)
            .collect();
        let combined = Mat::from_fn(n_x, kept.len(), |i, k| {
            scale[i] * vectors[(i, kept[k])] / shares[kept[k]].sqrt()
        });
        let own = own * combined;
        let all = Mat::from_fn(n_b + n_x, rank + kept.len(), |i, j| {
            match j.checked_sub(rank) {
                None => attached[(i, j)],
                Some(j) => own[(i, j)],
            }
        });
        let projected = all.transpose() * &stiffness * &all;
        let (squares, rotation) = symmetric_eigen(symmetrized(projected.as_ref()).as_ref())?;
        let all = all * rotation;
        let of_attachments = &residual.flexibility * all.subrows(0, n_b);
        let of_further = &enrichment.interface_shapes * all.subrows(n_b, n_x);
        Some(Self {
            squares: squares.into_iter().map(|square| square.max(0.0)).collect(),
            shapes: of_attachments + of_further,
        })
    }
}
