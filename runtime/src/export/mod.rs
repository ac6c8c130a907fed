//! Results for other programs and for people: tables, pictures, nodal fields.

pub mod csv;
pub mod history;
pub mod nodal_field;
pub(crate) mod nodal_stress;
pub mod picture;
pub mod vtu;
