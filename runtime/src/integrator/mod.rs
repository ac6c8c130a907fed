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

/// The larger of two; NaN if one is, which `max` would drop.
pub(crate) fn larger(one: f64, other: f64) -> f64 {
    match one.is_nan() || one > other {
        true => one,
        false => other,
    }
}
