//! Hard cases of the dynamics: each runs a plain method, which fails, and this project, which is right within a bound or refuses by name.
//! The long ones: `cargo test --release -p dcb-tests --test hard dynamics:: -- --ignored`.

use dcb_tests::hard::case::HardCase;
use dcb_tests::hard::dynamics::{events, loops, motions, scales, springs, steps, weak_form_map};

fn hold(case: fn() -> HardCase) {
    let found = case();
    println!("{}", found.line());
    found.assert_held();
}

#[test]
fn tiny_steps() {
    hold(steps::tiny_steps);
}

#[test]
fn long_steps() {
    hold(steps::long_steps);
}

#[test]
fn no_numerical_damping() {
    hold(steps::no_numerical_damping);
}

#[test]
fn weak_form_below_its_window() {
    hold(steps::weak_form_below_its_window);
}

#[test]
fn forces_far_from_the_origin() {
    hold(steps::forces_far_from_the_origin);
}

#[test]
fn forces_far_from_the_origin_by_radau() {
    hold(steps::forces_far_from_the_origin_by_radau);
}

#[test]
fn unscaled_newton_matrix() {
    hold(steps::unscaled_newton_matrix);
}

#[test]
fn unscaled_newton_matrix_by_radau() {
    hold(steps::unscaled_newton_matrix_by_radau);
}

#[test]
fn bushing_on_steel() {
    hold(springs::bushing_on_steel);
}

#[test]
fn bushing_on_steel_by_radau() {
    hold(springs::bushing_on_steel_by_radau);
}

#[test]
fn coarse_map() {
    hold(weak_form_map::coarse_map);
}

#[test]
fn mass_ratio_1e8() {
    hold(scales::mass_ratio_1e8);
}

#[test]
fn mass_ratio_1e8_by_radau() {
    hold(scales::mass_ratio_1e8_by_radau);
}

#[test]
fn stiffness_ratio_1e10() {
    hold(springs::stiffness_ratio_1e10);
}

#[test]
fn stiffness_ratio_1e10_by_radau() {
    hold(springs::stiffness_ratio_1e10_by_radau);
}

#[test]
fn force_of_a_pin() {
    hold(scales::force_of_a_pin);
}

#[test]
fn force_of_a_pin_by_radau() {
    hold(scales::force_of_a_pin_by_radau);
}

#[test]
fn micrometre_beside_kilometre() {
    hold(scales::micrometre_beside_kilometre);
}

#[test]
fn micrometre_beside_kilometre_by_radau() {
    hold(scales::micrometre_beside_kilometre_by_radau);
}

#[test]
fn attachments_of_rounding() {
    hold(scales::attachments_of_rounding);
}

#[test]
fn nearly_redundant_loop() {
    hold(loops::nearly_redundant_loop);
}

#[test]
fn nearly_redundant_loop_by_radau() {
    hold(loops::nearly_redundant_loop_by_radau);
}

#[test]
fn closed_ring() {
    hold(loops::closed_ring);
}

#[test]
fn closed_ring_by_radau() {
    hold(loops::closed_ring_by_radau);
}

#[test]
fn dead_centre() {
    hold(loops::dead_centre);
}

#[test]
fn dead_centre_by_radau() {
    hold(loops::dead_centre_by_radau);
}

#[test]
fn long_chain() {
    hold(motions::long_chain);
}

#[test]
fn long_chain_by_radau() {
    hold(motions::long_chain_by_radau);
}

#[test]
fn whirling_bar_by_radau() {
    hold(motions::whirling_bar_by_radau);
}

#[test]
fn inconsistent_start_by_radau() {
    hold(motions::inconsistent_start_by_radau);
}

#[test]
fn jump_of_a_drive_by_radau() {
    hold(events::jump_of_a_drive_by_radau);
}

#[test]
fn whirling_bar() {
    hold(motions::whirling_bar);
}

#[test]
fn inconsistent_start() {
    hold(motions::inconsistent_start);
}

#[test]
fn jump_of_a_drive() {
    hold(events::jump_of_a_drive);
}

#[test]
fn impulsive_load() {
    hold(events::impulsive_load);
}

#[test]
fn impulsive_load_by_radau() {
    hold(events::impulsive_load_by_radau);
}

#[test]
fn spin_through_the_first_frequency() {
    hold(events::spin_through_the_first_frequency);
}

#[test]
#[ignore = "a million steps"]
fn whirling_bar_ten_thousand_turns() {
    hold(motions::whirling_bar_ten_thousand_turns);
}

#[test]
#[ignore = "3.6 million steps"]
fn slider_crank_ten_thousand_turns() {
    hold(events::slider_crank_ten_thousand_turns);
}
