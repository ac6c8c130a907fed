//! The stages of a reduction.

/// The stages of a reduction, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stage {
    /// Rigid interfaces condensed, L_b built, geometry checked.
    Model,
    /// Fill-reducing order and symbolic analysis.
    Order,
    /// Numerical factorization of K + σ M.
    Factor,
    /// Free-free modes.
    Modes,
    /// Attachment columns.
    Attachments,
    /// Moments of what the modes leave out.
    Estimate,
    /// Inertia invariants.
    Invariants,
    /// Count of eigenvalues, where the search has no proof that it found all.
    Certificate,
    /// Orthogonality defects and the like.
    Quality,
}

impl Stage {
    /// Short name for tables and bars.
    pub fn name(self) -> &'static str {
        match self {
            Self::Model => "model",
            Self::Order => "order",
            Self::Factor => "factor",
            Self::Modes => "modes",
            Self::Attachments => "attachments",
            Self::Estimate => "estimate",
            Self::Invariants => "invariants",
            Self::Certificate => "certificate",
            Self::Quality => "quality",
        }
    }
}
