//! How far apart equivalent descriptions of a mechanism move, for `docs/accuracy.md`, one line of JSON per comparison.

use std::f64::consts::FRAC_PI_2;

use serde_json::{Value, json};

use crate::mechanism::equivalent_models::{
    flexible_in_space, other_component_axes, other_order, other_units, rigid_linkage_in_space,
};
use crate::mechanism::{method, stabilized};

/// The comparisons and what each may be.
pub fn invariance() -> Vec<Value> {
    let axes = [0.7, FRAC_PI_2, -2.5].map(other_component_axes);
    let cases = [
        (
            "metre, kilogram, second and millimetre, tonne, second",
            other_units(),
            1e-8,
        ),
        (
            "component axes turned by 0.7, π/2, -2.5",
            axes.into_iter().fold(0.0, f64::max),
            1e-9,
        ),
        ("order of bodies and joints", other_order(), 1e-9),
        (
            "flexible rod in the plane and in space",
            flexible_in_space(),
            1e-9,
        ),
        (
            "rigid linkage in the plane and in space, index 3",
            rigid_linkage_in_space(method(0.9)),
            1e-9,
        ),
        (
            "rigid linkage in the plane and in space, stabilized index 2",
            rigid_linkage_in_space(stabilized(0.9)),
            1e-9,
        ),
    ];
    cases
        .into_iter()
        .map(|(case, error, bound)| {
            json!({"kind": "invariance", "case": case, "error": error, "bound": bound})
        })
        .collect()
}
