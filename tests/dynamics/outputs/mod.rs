//! Outputs: measures, tables, pictures and fields.

mod internal_rows;
mod masses;
mod measures;
mod pictures;
mod stress;
mod vtu;
