//! Free-free modes, and the count that certifies that none is missing.

pub(crate) mod certificate;
pub(crate) mod eigen_solver;
pub mod free_modes;
pub(crate) mod lanczos;
#[cfg(feature = "slepc")]
pub mod mpi_job;
pub(crate) mod multiplet;
#[cfg(feature = "slepc")]
pub(crate) mod petsc_binary;
#[cfg(feature = "slepc")]
pub mod slepc;
