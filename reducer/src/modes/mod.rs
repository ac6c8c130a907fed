//! Free-free modes, and the count that certifies that none is missing.

pub(crate) mod certificate;
mod completeness;
#[cfg(test)]
mod completeness_tests;
pub mod free_modes;
pub(crate) mod lanczos;
#[cfg(test)]
mod lanczos_tests;
pub(crate) mod multiplet;
mod orthonormal_block;
