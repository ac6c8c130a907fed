//! How much a reduction computed: counts that, unlike times, are the same on every machine.

use dcb_sparse::factorization::SymmetricFactor;
use serde::Serialize;

use crate::attachments::residual::ResidualFlexibility;
use crate::error::Error;
use crate::model::condensation::Model;
use crate::modes::free_modes::FreeModes;

/// Effort of a reduction; all zero where it was made before.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Work {
    /// Dofs of the model, rigid interfaces condensed.
    pub dofs: usize,
    /// Entries of the factor's lower triangle, padding of the fronts included.
    pub factor_entries: usize,
    /// Floating-point operations of one factorization.
    pub factor_flops: f64,
    /// Bytes of the stored factor.
    pub stored_bytes: usize,
    /// Columns solved with the factor, in total.
    pub solve_columns: u64,
    /// Passes over the factor: one forward and one backward sweep for a block of up to 16 columns.
    pub solve_passes: u64,
    /// Block steps of the eigensolver.
    pub lanczos_block_steps: usize,
    /// Preconditioned iterations of the attachments.
    pub attachment_iterations: usize,
    /// Threads that took part.
    pub threads: usize,
    /// Most memory that each process with a part of the factor has had in use, bytes; empty where this one had all of it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rank_peak_bytes: Vec<u64>,
}

impl Work {
    /// Gathers what the stages counted.
    ///
    /// # Errors
    /// [`Error::Ranks`] if they don't answer.
    pub fn of(
        model: &Model,
        factor: &SymmetricFactor,
        modes: &FreeModes,
        residual: &ResidualFlexibility,
    ) -> Result<Self, Error> {
        Ok(Self {
            dofs: model.len(),
            factor_entries: factor.factor_entries(),
            factor_flops: factor.flops(),
            stored_bytes: factor.stored_bytes(),
            solve_columns: factor.solve_columns(),
            solve_passes: factor.solve_passes(),
            lanczos_block_steps: modes.iterations,
            attachment_iterations: residual.iterations,
            threads: rayon::current_num_threads(),
            rank_peak_bytes: factor.rank_peak_bytes()?,
        })
    }
}
