//! Matrices as MATLAB writes them.

pub mod version5;
pub mod version73;
