//! Time integration.

pub mod adaptive;
pub mod between;
pub mod equal_steps;
pub mod method;
pub mod newton;
pub mod profile;
pub mod resolution;

pub use method::{Effort, Formulation, Method, Tolerance};
pub use profile::Profile;
