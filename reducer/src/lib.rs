//! Component → superelement: the offline half of the dual Craig–Bampton method for co-rotated bodies.
//!
//! [`reduce`] is the whole pipeline: rigid motions from geometry, one factorization of K + σ M that serves the free-free
//! modes and the residual flexibility, inertia invariants, an eigenvalue count as certificate, and a quality report. Everything
//! works on sparse matrices; nothing here reads clocks, prints or opens files ([`cli`] does), but for a factor that is kept on disk.

pub mod assemble;
pub mod attachment;
mod basis;
pub mod basis_size;
pub mod batch;
pub mod cache;
pub mod cell_coupling;
pub mod certificate;
pub mod cli;
pub mod cli_batch;
pub mod cli_cache;
pub mod cli_cached;
pub mod cli_eigen_solver;
pub mod cli_memory;
pub mod cli_plan;
pub mod cli_reduce;
pub mod cli_scene;
pub mod cli_study;
pub mod compare;
pub mod condensation;
pub mod couplings;
pub mod dependency;
pub mod diagnosis;
pub mod eigen_solver;
pub mod enrichment;
mod enrichment_source;
pub mod error;
mod error_report;
pub mod file_form;
pub mod forecast;
pub mod frame;
mod free_body;
pub mod free_modes;
pub mod huge_pages;
pub mod inspect;
pub mod interface_reduction;
pub mod invariants;
pub mod lanczos;
pub mod localization;
pub mod machine_speed;
pub mod memory_limit;
mod memory_plan;
pub mod mode_selection;
mod moments;
#[cfg(feature = "slepc")]
pub mod mpi_job;
pub mod multiplet;
pub mod observer;
pub mod part_loads;
#[cfg(feature = "slepc")]
pub mod petsc_binary;
pub mod piece_motions;
mod pipeline;
pub mod plan;
pub mod plausibility;
mod projection;
pub mod quality;
mod reduction;
pub mod residual;
pub mod residual_filter;
pub mod rigid_body;
pub mod scene;
pub mod scientific;
pub mod shift;
#[cfg(feature = "slepc")]
pub mod slepc;
pub mod spin_forces;
pub mod stiffening;
pub mod study;
pub mod summary;
pub mod surface;
pub mod timing;
pub mod verify;
pub mod verify_component;
mod verify_fields;
pub mod verify_further;
pub mod verify_interfaces;
pub mod verify_layout;
pub mod verify_moments;
mod warnings;
pub mod work;

pub use crate::diagnosis::{Grounding, LoosePieces};
pub use crate::eigen_solver::EigenSolver;
pub use crate::enrichment_source::EnrichmentSource;
pub use crate::error::Error;
pub use crate::forecast::EstimateChoice;
pub use crate::interface_reduction::InterfaceModes;
pub use crate::mode_selection::ModeSelection;
pub use crate::pipeline::{Reduced, reduce};
pub use crate::reduction::Reduction;
pub use crate::work::Work;
