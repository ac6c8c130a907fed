//! The hard cases of the dynamics, each with a plain method that fails at it.

pub mod events;
pub mod loops;
pub mod motions;
pub mod naive_constraints;
pub mod scales;
pub mod springs;
pub mod step_rules;
pub mod steps;
pub mod weak_form_map;

use crate::hard::case::HardCase;

/// Those of the default test run, each in seconds.
pub fn cases() -> Vec<fn() -> HardCase> {
    vec![
        steps::tiny_steps,
        steps::long_steps,
        steps::no_numerical_damping,
        steps::weak_form_below_its_window,
        steps::unscaled_newton_matrix,
        steps::unscaled_newton_matrix_by_radau,
        steps::forces_far_from_the_origin,
        steps::forces_far_from_the_origin_by_radau,
        weak_form_map::coarse_map,
        scales::mass_ratio_1e8,
        scales::mass_ratio_1e8_by_radau,
        springs::stiffness_ratio_1e10,
        springs::stiffness_ratio_1e10_by_radau,
        springs::bushing_on_steel,
        springs::bushing_on_steel_by_radau,
        scales::force_of_a_pin,
        scales::force_of_a_pin_by_radau,
        scales::micrometre_beside_kilometre,
        scales::micrometre_beside_kilometre_by_radau,
        scales::attachments_of_rounding,
        loops::nearly_redundant_loop,
        loops::nearly_redundant_loop_by_radau,
        loops::closed_ring,
        loops::closed_ring_by_radau,
        loops::dead_centre,
        loops::dead_centre_by_radau,
        motions::long_chain,
        motions::long_chain_by_radau,
        motions::whirling_bar,
        motions::whirling_bar_by_radau,
        motions::inconsistent_start,
        motions::inconsistent_start_by_radau,
        events::jump_of_a_drive,
        events::jump_of_a_drive_by_radau,
        events::impulsive_load,
        events::impulsive_load_by_radau,
        events::spin_through_the_first_frequency,
    ]
}

/// Those that take a minute or more.
pub fn long_cases() -> Vec<fn() -> HardCase> {
    vec![
        motions::whirling_bar_ten_thousand_turns,
        events::slider_crank_ten_thousand_turns,
    ]
}
