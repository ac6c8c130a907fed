//! Residuals of the kept modes, and the errors of ω² that follow.

use dcb_sparse::block_algebra::{add_scaled_columns, column_dots, copied, symmetric_product};
use dcb_sparse::column_products::BLOCK;
use dcb_sparse::factorization::PositiveFactor;

use crate::attachments::enrichment::Reducing;
use crate::error::Error;
use crate::modes::free_modes::FreeModes;

/// Residuals of the kept modes, ρ = K φ - ω² M φ, in the norm of the factorized matrix: ρᵀ (K + σ M)⁻¹ ρ; rigid motions have no part in ρ.
#[derive(Clone, Debug)]
pub(super) struct ModeResiduals {
    squares: Vec<f64>,
    shift: f64,
}

impl ModeResiduals {
    /// # Errors
    /// Those of solving.
    pub(super) fn of(
        of: &Reducing<'_>,
        factor: &PositiveFactor,
        shift: f64,
    ) -> Result<Self, Error> {
        let modes = of.modes;
        let mut squares = Vec::with_capacity(modes.count());
        let opposite: Vec<f64> = modes.eigenvalues.iter().map(|value| -value).collect();
        for first in (0..modes.count()).step_by(BLOCK) {
            let count = BLOCK.min(modes.count() - first);
            let shapes = modes.shapes.as_ref().subcols(first, count);
            let mut left = symmetric_product(&of.model.stiffness, shapes);
            add_scaled_columns(
                left.as_mut(),
                &opposite[first..first + count],
                modes.mass_shapes.as_ref().subcols(first, count),
            );
            let mut solved = copied(left.as_ref());
            factor.solve_in_place(solved.as_mut())?;
            squares.extend(column_dots(left.as_ref(), solved.as_ref()));
        }
        Ok(Self { squares, shift })
    }

    /// Relative bounds of what each ω² is off. With ν = 1/(ω² + σ) the eigenvalues of (K + σ M)⁻¹ M: kept ones differ from exact ones by
    /// ‖E‖² over the distance to those left out, E the residuals of all of them in the same norm; rounding comes on top.
    pub(super) fn eigenvalue_errors(&self, modes: &FreeModes, eigenvalue_bound: f64) -> Vec<f64> {
        let shifted = |k: usize| modes.eigenvalues[k] + self.shift;
        let elastic = modes.zero_count..modes.count();
        let residual_square: f64 = elastic
            .clone()
            .map(|k| self.squares[k].max(0.0) / shifted(k).powi(3))
            .sum();
        let residual = residual_square.sqrt();
        let omitted = 1.0 / (eigenvalue_bound + self.shift);
        let error = |k: usize| {
            if !elastic.contains(&k) {
                return 0.0;
            }
            let distance = 1.0 / shifted(k) - omitted - residual;
            let apart = match distance > residual {
                true => residual_square / distance,
                false => residual,
            };
            let of_residual = apart * shifted(k) * shifted(k) / modes.eigenvalues[k];
            of_residual + modes.eigenvalue_roundings[k]
        };
        (0..modes.count()).map(error).collect()
    }
}
