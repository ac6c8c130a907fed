//! Outputs: measures, tables, pictures and fields.

mod internal_rows;
mod measures;
mod pictures;
mod vtu;
