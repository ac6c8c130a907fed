//! Time integration.

pub mod adaptive;
pub(crate) mod between;
pub mod equal_steps;
pub(crate) mod method;
pub(crate) mod newton;
pub(crate) mod profile;
pub mod radau;
pub mod resolution;

pub use method::{Effort, Formulation, Method, Rule, Tolerance};
pub use profile::Profile;
