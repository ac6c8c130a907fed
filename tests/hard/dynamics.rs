//! Hard cases of the dynamics: each runs a plain method, which fails, and this project, which is right within a bound or refuses by name.
//! The long ones: `cargo test --release -p dcb-tests --test hard dynamics:: -- --ignored`.

use dcb_tests::hard::dynamics::{GROUP, events, loops, motions, scales, steps, weak_form_map};

use crate::held;

dcb_tests::hard_dynamics_cases!(tests);

#[test]
#[ignore = "a million steps"]
fn whirling_bar_ten_thousand_turns() {
    let case = motions::whirling_bar_ten_thousand_turns();
    held(&case, GROUP, "whirling_bar_ten_thousand_turns");
}

#[test]
#[ignore = "3.6 million steps"]
fn slider_crank_ten_thousand_turns() {
    let case = events::slider_crank_ten_thousand_turns();
    held(&case, GROUP, "slider_crank_ten_thousand_turns");
}
