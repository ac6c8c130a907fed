//! How a caller follows a reduction: which stage runs, how far it is. Clocks, bars and printing are the caller's.

use crate::forecast::Forecast;
use crate::memory_limit::MemoryLimit;

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
    /// Sturm count.
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

/// Told what a reduction is doing.
pub trait Observer {
    /// A stage begins; the one before is over.
    fn begin(&mut self, stage: Stage);
    /// The running stage has done about this share of its work, 0 to 1.
    fn progress(&mut self, share: f64);
    /// What the reduction will cost, before the first factorization.
    fn forecast(&mut self, _: &Forecast, _: &MemoryLimit) {}
}

/// Nobody is watching.
impl Observer for () {
    fn begin(&mut self, _: Stage) {}
    fn progress(&mut self, _: f64) {}
}
