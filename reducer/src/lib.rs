//! Component → superelement: the offline half of the dual Craig–Bampton method for co-rotated bodies.
//!
//! [`reduce`] is the whole pipeline: rigid motions from geometry, one factorization of K + σ M that serves the free-free
//! modes and the residual flexibility, inertia invariants, a proof that no mode is missing, and a quality report. Everything
//! works on sparse matrices; nothing here reads clocks, prints or opens files, but for a factor that is kept on disk.
//!
//! ```
//! use dcb_reducer::{Reduction, reduce};
//! use dcb_samples::{Material, SolidElement, box_block};
//!
//! let block = box_block([8, 2, 2], [0.8, 0.1, 0.1], SolidElement::Hexahedron20, &Material::STEEL);
//! let reduced = reduce(&block, &Reduction::lowest(4), &mut ())?;
//! assert!(reduced.quality.broken_limits().is_empty());
//! // The lowest modes bend it: a free beam has (4.73 / l)² √(E I / (ρ A)), less what shear and rotary inertia take.
//! let modes = &reduced.superelement.modes;
//! let slender = (4.73_f64 / 0.8).powi(2) * (2.1e11_f64 / 7850.0 * 0.1_f64.powi(2) / 12.0).sqrt();
//! let ratio = modes.eigenvalues[0].sqrt() / slender;
//! assert!((0.9..1.0).contains(&ratio), "{ratio}");
//! # Ok::<(), dcb_reducer::Error>(())
//! ```

pub mod error;
pub mod observer;
pub mod quality;

// No part of the door: for the other crates of this workspace and its tests.
#[doc(hidden)]
pub mod attachments;
#[doc(hidden)]
pub mod inertia;
#[doc(hidden)]
pub mod mode_selection;
#[doc(hidden)]
pub mod model;
#[doc(hidden)]
pub mod modes;
#[doc(hidden)]
pub mod pipeline;
#[doc(hidden)]
pub mod resources;
#[doc(hidden)]
pub mod scientific;
#[doc(hidden)]
pub mod verify;

mod moments;

pub use crate::attachments::enrichment_source::EnrichmentSource;
pub use crate::attachments::interface_reduction::InterfaceModes;
pub use crate::error::Error;
pub use crate::mode_selection::ModeSelection;
pub use crate::modes::certificate::{ModeCount, Proof, ProofChoice};
pub use crate::observer::{Observer, Stage};
pub use crate::pipeline::diagnosis::{Grounding, LoosePieces};
pub use crate::pipeline::effort::Work;
pub use crate::pipeline::reduction::Reduction;
pub use crate::pipeline::row_shapes::WholeReduction;
pub use crate::pipeline::{Reduced, forecast, reduce, reduce_whole};
pub use crate::quality::Quality;
pub use crate::resources::forecast::EstimateChoice;
