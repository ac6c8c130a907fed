//! Cost of a reduction, known from the pattern of the matrices before a number is computed.

use dcb_sparse::factor_store::{FactorStorage, Place};
use dcb_sparse::factorization::SymmetricFactor;
use serde::Serialize;

use crate::ModeSelection;
use crate::model::condensation::Model;
use crate::model::localization::Localization;
use crate::resources::basis_size::{BasisSize, block_width};
use crate::resources::machine_speed::MachineSpeed;
use crate::resources::stage::Stage;

/// Bytes of a double.
const DOUBLE: u64 = 8;
/// Bytes of an entry of a sparse matrix: value and row.
const MATRIX_ENTRY: u64 = 12;
/// Bytes that mesh, dof tables and symbolic analysis take for each dof.
const TABLES_PER_DOF: u64 = 200;
/// Bytes of the program itself.
const PROGRAM: u64 = 15 << 20;
/// Modes assumed where a frequency limit decides.
const ASSUMED_MODES: usize = 50;
/// Blocks of modes held beside the Krylov basis.
const MODE_BLOCKS: f64 = 8.0;
/// Blocks of [`SOLVE_BLOCK`] columns held beside all shapes while attachments are solved for, or invariants formed.
const WORKING_BLOCKS: f64 = 11.0;
/// Columns of a block of attachment columns.
const SOLVE_BLOCK: usize = 16;
/// Preconditioned iterations of the attachment columns.
const ATTACHMENT_ITERATIONS: f64 = 2.0;
/// Factorizations: that of K, and those of parts of M that show whether it is positive.
const FACTORIZATIONS: f64 = 1.1;
/// Share of a dense product's speed that a factorization reaches.
const FACTOR_EFFICIENCY: f64 = 0.7;
/// Share that a solution with the factor reaches.
const SOLVE_EFFICIENCY: f64 = 0.4;
/// Solutions with a rounded factor and refinement, over one with an exact factor.
const REFINED_OVER_PLAIN: f64 = 5.0;

/// Whether what an error estimate needs is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum EstimateChoice {
    /// It is.
    Computed,
    /// Memory has no room for its columns.
    LeftOut,
}

/// Sizes that decide what a reduction costs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Forecast {
    /// Dofs of the model that is factorized.
    pub dofs: usize,
    /// Entries of K, both triangles.
    pub stiffness_entries: usize,
    /// Entries of M, both triangles.
    pub mass_entries: usize,
    /// Modes wanted.
    pub modes: usize,
    /// Whether a frequency limit decides on the modes, so that their number is a guess.
    pub modes_are_assumed: bool,
    /// Attachment columns.
    pub attachment_columns: usize,
    /// How large the Krylov basis is; what memory leaves room for is decided by [`crate::resources::memory_limit::MemoryLimit::fitted`].
    pub basis: BasisSize,
    /// Whether the error estimate is made; decided as the basis is.
    pub estimate: EstimateChoice,
    /// Entries of the factor's lower triangle.
    pub factor_entries: usize,
    /// Entries stored for it, padding included.
    pub stored_entries: usize,
    /// Multiplications and additions of a factorization, each pair one.
    pub flops: f64,
    /// Bound of the entries of update matrices held at once.
    pub update_entries: usize,
    /// Bound of the entries of dense panels held at once.
    pub panel_entries: usize,
    /// Worker threads.
    pub threads: usize,
}

/// Memory up to the end of a stage, bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StageMemory {
    /// Stage.
    pub stage: Stage,
    /// Held at most while it runs.
    pub bytes: u64,
}

impl Forecast {
    /// From what has been analysed.
    pub fn of(
        model: &Model,
        localization: &Localization,
        factor: &SymmetricFactor,
        modes: ModeSelection,
    ) -> Self {
        let threads = rayon::current_num_threads();
        let fronts = factor.fronts();
        let modes_are_assumed = matches!(
            modes,
            ModeSelection::Below { .. } | ModeSelection::BelowAtMost { .. }
        );
        let modes = match modes {
            ModeSelection::Lowest(count) => count,
            ModeSelection::Below { .. } => ASSUMED_MODES,
            ModeSelection::BelowAtMost { count, .. } => count.min(ASSUMED_MODES),
        };
        Self {
            dofs: model.len(),
            stiffness_entries: model.stiffness.compute_nnz(),
            mass_entries: model.mass.compute_nnz(),
            modes: modes.min(model.len()),
            modes_are_assumed,
            basis: BasisSize::Comfortable,
            estimate: EstimateChoice::Computed,
            attachment_columns: localization.len(),
            factor_entries: fronts.factor_entries(),
            stored_entries: factor.stored_entries(),
            flops: factor.flops(),
            update_entries: fronts.stack_bound(threads),
            panel_entries: threads * fronts.largest_panel(),
            threads,
        }
    }

    /// Bytes of K and M.
    pub fn matrix_bytes(&self) -> u64 {
        (self.stiffness_entries + self.mass_entries) as u64 * MATRIX_ENTRY
    }

    /// Bytes of the factor, in memory or on disk.
    pub fn factor_bytes(&self, storage: &FactorStorage) -> u64 {
        (self.stored_entries * storage.entry_bytes()) as u64
    }

    /// Bytes of update matrices and panels.
    pub fn scratch_bytes(&self) -> u64 {
        (self.update_entries + self.panel_entries) as u64 * DOUBLE
    }

    /// Bytes of so many columns over the model's dofs.
    fn columns(&self, count: f64) -> u64 {
        (count * self.dofs as f64) as u64 * DOUBLE
    }

    /// Columns of the Krylov basis.
    pub fn basis_columns(&self) -> usize {
        self.basis.all_columns(self.modes)
    }

    /// Memory of each stage.
    pub fn stages(&self, storage: &FactorStorage) -> Vec<StageMemory> {
        let (resident, scratch) = match storage.place {
            Place::Memory => (self.factor_bytes(storage), self.scratch_bytes()),
            // The system may write it out and read it again.
            Place::Disk { .. } => (0, self.scratch_bytes()),
            // Other processes compute it.
            #[cfg(feature = "ranks")]
            Place::Ranks(_) => (0, 0),
        };
        let base = PROGRAM + self.matrix_bytes() + self.dofs as u64 * TABLES_PER_DOF;
        let (modes, attached) = (self.modes as f64, self.attachment_columns as f64);
        // Φ, M Φ and X.
        let shapes = 2.0 * modes + attached;
        let working = shapes + WORKING_BLOCKS * SOLVE_BLOCK as f64;
        let stage = |stage, bytes| StageMemory { stage, bytes };
        // Z, and X once more where other columns stand beside it.
        let estimating = match self.estimate {
            EstimateChoice::Computed => working + 2.0 * attached,
            EstimateChoice::LeftOut => 0.0,
        };
        vec![
            stage(Stage::Factor, base + resident + scratch),
            stage(
                Stage::Modes,
                base + resident + self.columns(self.basis_columns() as f64 + MODE_BLOCKS * modes),
            ),
            stage(Stage::Attachments, base + resident + self.columns(working)),
            stage(Stage::Estimate, base + resident + self.columns(estimating)),
            stage(Stage::Certificate, base + self.columns(shapes) + scratch),
            stage(Stage::Quality, base + self.columns(working)),
        ]
    }

    /// Largest memory of all stages, bytes.
    pub fn peak_bytes(&self, storage: &FactorStorage) -> u64 {
        let stages = self.stages(storage);
        stages.iter().map(|stage| stage.bytes).max().unwrap_or(0)
    }

    /// Wall time from the factorization to the end, s. It is right within a factor of two where the factor is in memory; the number of
    /// iterations isn't known before.
    pub fn seconds(&self, storage: &FactorStorage, speed: MachineSpeed) -> f64 {
        let (modes, attached) = (self.modes as f64, self.attachment_columns as f64);
        let factorization = self.flops / (FACTOR_EFFICIENCY * speed.flops);
        let doubles = (self.stored_entries as u64 * DOUBLE) as f64;
        let refined = match storage.entry_bytes() {
            4 => REFINED_OVER_PLAIN,
            _ => 1.0,
        };
        // Forward and back; bound by reading or by arithmetic.
        let solution = |columns: usize| {
            let arithmetic =
                (self.stored_entries * columns) as f64 / (SOLVE_EFFICIENCY * speed.flops);
            2.0 * refined * arithmetic.max(doubles / speed.bandwidth)
        };
        let product = self.matrix_bytes() as f64 / speed.bandwidth;
        let column = self.columns(1.0) as f64 / speed.bandwidth;
        let block = block_width(self.modes);
        let basis = BasisSize::Comfortable.all_columns(self.modes) as f64;
        let steps = basis / block as f64 + 4.0;
        let modes_time = steps * (solution(block) + 3.0 * product + 3.0 * basis * column);
        let blocks = (attached / SOLVE_BLOCK as f64).ceil();
        let attachments = ATTACHMENT_ITERATIONS
            * (blocks * (solution(SOLVE_BLOCK) + 2.0 * product) + 15.0 * attached * column);
        // One solution for each column, and one for what each mode leaves.
        let estimate = blocks * (solution(SOLVE_BLOCK) + 2.0 * product)
            + 15.0 * attached * column
            + (modes / SOLVE_BLOCK as f64).ceil() * solution(SOLVE_BLOCK);
        let width = modes + attached;
        let invariants = 12.0 * self.dofs as f64 * width * width / speed.flops;
        FACTORIZATIONS * factorization
            + modes_time
            + attachments
            + estimate
            + invariants
            + 20.0 * width * column
    }
}
