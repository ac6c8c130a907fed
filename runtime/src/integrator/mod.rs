//! Time integration.

pub mod adaptive;
pub mod newton;
pub mod scheme;
