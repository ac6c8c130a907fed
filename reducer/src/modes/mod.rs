//! Free-free modes, and the count that certifies that none is missing.

pub mod certificate;
pub mod eigen_solver;
pub mod free_modes;
pub mod lanczos;
#[cfg(feature = "slepc")]
pub mod mpi_job;
pub mod multiplet;
#[cfg(feature = "slepc")]
pub mod petsc_binary;
#[cfg(feature = "slepc")]
pub mod slepc;
