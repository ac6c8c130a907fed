//! Component → superelement: the offline half of the dual Craig–Bampton method for co-rotated bodies.
//!
//! [`reduce`] is the whole pipeline: rigid motions from geometry, one factorization of K + σ M that serves the free-free
//! modes and the residual flexibility, inertia invariants, an eigenvalue count as certificate, and a quality report. Everything
//! works on sparse matrices; nothing here reads clocks, prints or opens files, but for a factor that is kept on disk.

pub mod attachments;
pub mod error;
pub mod inertia;
pub mod mode_selection;
pub mod model;
pub mod modes;
mod moments;
pub mod observer;
pub mod pipeline;
pub mod quality;
pub mod resources;
pub mod scientific;
pub mod verify;

pub use crate::attachments::enrichment_source::EnrichmentSource;
pub use crate::attachments::interface_reduction::InterfaceModes;
pub use crate::error::Error;
pub use crate::mode_selection::ModeSelection;
pub use crate::modes::eigen_solver::EigenSolver;
pub use crate::pipeline::diagnosis::{Grounding, LoosePieces};
pub use crate::pipeline::reduction::Reduction;
pub use crate::pipeline::work::Work;
pub use crate::pipeline::{Reduced, forecast, reduce};
pub use crate::resources::forecast::EstimateChoice;
