//! Readers of matrices, a file each.
//!
//! Each reader has `list`, which says what matrices a file has without reading their entries where the format allows it, and `read`, which
//! reads those that are asked for by their number in that list, in one pass over the file.

#[doc(hidden)]
pub mod abaqus;
#[doc(hidden)]
pub mod harwell_boeing;
mod labelled;
mod labels;
#[doc(hidden)]
pub mod matlab;
pub(crate) mod matrix_market;
#[doc(hidden)]
pub mod nastran;
#[doc(hidden)]
pub mod numpy;
#[doc(hidden)]
pub mod petsc;
mod storage;
#[doc(hidden)]
pub mod tables;
mod wanted;
