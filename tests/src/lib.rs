//! Oracles and helpers of the cross-crate tests. Nothing here shares code with what it checks: dense matrices, faer's and
//! nalgebra's dense routines, explicit loops over nodes and over quadrature points.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

pub mod accuracy;
pub mod accuracy_cases;
pub mod accuracy_page;
pub mod accuracy_references;
pub mod accuracy_sections;
pub mod closed_form_motions;
pub mod contradictions;
pub mod corotated_rod;
pub mod deflection;
pub mod dense;
pub mod equivalent_models;
pub mod error_estimate;
pub mod error_estimate_ports;
pub mod evidence_page;
pub mod fields;
pub mod governor;
pub mod hard_case;
pub mod hard_dynamics;
pub mod hard_dynamics_events;
pub mod hard_dynamics_loops;
pub mod hard_dynamics_motions;
pub mod hard_dynamics_scales;
pub mod hard_dynamics_steps;
pub mod hard_page;
pub mod hard_reduction;
pub mod hard_reduction_conditioning;
pub mod hard_reduction_refusals;
pub mod hard_reduction_rows;
pub mod hard_reduction_spectra;
pub mod identity_defects;
pub mod interface_reduction;
pub mod ivp_slider_crank;
pub mod large_file_page;
pub mod localization;
pub mod massless;
pub mod mechanism;
pub mod motion_deflection;
pub mod motion_invariance;
pub mod motion_order;
pub mod motion_page;
pub mod motion_pictures;
pub mod motion_published;
pub mod naive_constraints;
pub mod nodal;
pub mod oracle;
pub mod parts;
pub mod plain_methods;
pub mod random_chain;
pub mod random_parts;
pub mod raw_lines;
pub mod reduced_rod;
pub mod reference;
pub mod rigid_benchmarks;
pub mod same_superelement;
pub mod scene_driven_page;
pub mod scene_reduction_page;
pub mod slider_crank;
pub mod step_rules;
pub mod turned;
pub mod weak_form_map;

use dcb_formats::Component;
use dcb_reducer::{Reduced, Reduction, reduce};

/// The `count` lowest modes of a part that can be reduced.
pub fn lowest(component: &Component, count: usize) -> Reduced {
    with(component, &Reduction::lowest(count))
}

/// A reduction that succeeds.
pub fn with(component: &Component, options: &Reduction) -> Reduced {
    match reduce(component, options, &mut ()) {
        Ok(reduced) => reduced,
        Err(error) => panic!("{}: {error}", component.name),
    }
}

/// The message of a reduction that is refused.
pub fn refusal(component: &Component) -> String {
    match reduce(component, &Reduction::lowest(4), &mut ()) {
        Ok(_) => panic!("{} was reduced", component.name),
        Err(error) => error.to_string(),
    }
}

/// Asserts that a message has all these parts.
pub fn assert_says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "{part:?} is missing in {message:?}");
    }
}
