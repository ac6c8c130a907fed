//! Solvers for the free modes. With each of them the sharpening, the residuals and the eigenvalue count afterwards are the same.

use dcb_sparse::factorization::PositiveFactor;
use serde::Serialize;

use crate::error::Error;
use crate::model::condensation::Model;
use crate::modes::free_modes::{FreeModes, KnownMotions, Search};
#[cfg(feature = "slepc")]
use crate::modes::slepc::SlepcRun;
use crate::observer::Observer;

/// Solver for the free modes.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EigenSolver {
    /// Block Lanczos with the factorization that the attachments use too (`crate::modes::lanczos`).
    #[default]
    BlockLanczos,
    /// SLEPc with MUMPS on MPI processes.
    #[cfg(feature = "slepc")]
    Slepc(SlepcRun),
}

impl EigenSolver {
    pub(crate) fn is_built_in(&self) -> bool {
        *self == Self::BlockLanczos
    }

    /// Finds the lowest modes.
    ///
    /// # Errors
    /// Those of [`FreeModes::compute`], or of the other solver.
    pub fn free_modes(
        &self,
        model: &Model,
        known: KnownMotions<'_>,
        factor: &PositiveFactor,
        shift: f64,
        search: Search,
        observer: &mut dyn Observer,
    ) -> Result<FreeModes, Error> {
        match self {
            Self::BlockLanczos => FreeModes::compute(model, known, factor, shift, search, observer),
            #[cfg(feature = "slepc")]
            Self::Slepc(run) => run.free_modes(model, known.rigid, factor, shift, search, observer),
        }
    }
}
