//! Readers of matrices, a file each.
//!
//! Each reader has `list`, which says what matrices a file has without reading their entries where the format allows it, and `read`, which
//! reads those that are asked for by their number in that list, in one pass over the file.

mod collected;
mod compressed;
#[doc(hidden)]
pub mod coordinate;
mod dense;
#[doc(hidden)]
pub mod dmig;
#[doc(hidden)]
pub mod harwell_boeing;
mod labelled;
mod labels;
#[doc(hidden)]
pub mod matlab5;
#[doc(hidden)]
pub mod matlab73;
#[doc(hidden)]
pub mod matrix_input;
pub(crate) mod matrix_market;
mod number;
#[doc(hidden)]
pub mod numpy;
mod op4;
#[doc(hidden)]
pub mod op4_binary;
#[doc(hidden)]
pub mod op4_text;
#[doc(hidden)]
pub mod petsc;
mod records;
mod stream;
#[doc(hidden)]
pub mod substructure;
#[doc(hidden)]
pub mod tables;
mod wanted;
