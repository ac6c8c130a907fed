//! Time integration.

pub mod newton;
pub mod scheme;
