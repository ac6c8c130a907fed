//! Outputs: measures, tables, pictures and fields.

mod measures;
mod pictures;
mod vtu;
