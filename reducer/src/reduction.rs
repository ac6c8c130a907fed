//! What is asked of a reduction.

use crate::diagnosis::{Grounding, LoosePieces};
use crate::eigen_solver::EigenSolver;
use crate::enrichment::EnrichmentSource;
use crate::forecast::EstimateChoice;
use crate::interface_reduction::InterfaceModes;
use crate::memory_limit::MemoryLimit;

/// Which modes to keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ModeSelection {
    /// This many lowest elastic modes (a multiple root is never cut, so it may be more).
    Lowest(usize),
    /// Every elastic mode below this ω², (rad/time)².
    Below {
        /// The limit.
        eigenvalue: f64,
    },
    /// The same, but no more than so many, the lowest (or more where that would cut a multiple root).
    BelowAtMost {
        /// The limit.
        eigenvalue: f64,
        /// How many.
        count: usize,
    },
}

/// What to do.
#[derive(Clone, Debug, PartialEq)]
pub struct Reduction {
    /// Modes to keep.
    pub modes: ModeSelection,
    /// Directions of residual flexibility to keep.
    pub interface_modes: InterfaceModes,
    /// Further columns of the basis.
    pub enrichment: Vec<EnrichmentSource>,
    /// Whether the superelement says how far it is off; where memory is short it doesn't, with a warning.
    pub estimate: EstimateChoice,
    /// What to do with a part that is held.
    pub grounding: Grounding,
    /// What to do with loose pieces and mechanisms.
    pub loose_pieces: LoosePieces,
    /// What finds the modes.
    pub eigen_solver: EigenSolver,
    /// How much memory may be taken, and where the factor is kept.
    pub memory: MemoryLimit,
}

impl Reduction {
    /// The `count` lowest modes of a free part in one piece.
    pub fn lowest(count: usize) -> Self {
        Self {
            modes: ModeSelection::Lowest(count),
            interface_modes: InterfaceModes::All,
            enrichment: Vec::new(),
            estimate: EstimateChoice::Computed,
            grounding: Grounding::Refuse,
            loose_pieces: LoosePieces::Refuse,
            eigen_solver: EigenSolver::BlockLanczos,
            memory: MemoryLimit::default(),
        }
    }
}
