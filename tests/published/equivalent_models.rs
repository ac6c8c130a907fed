//! The same mechanism described in different ways has the same motion.

use std::f64::consts::FRAC_PI_2;

use dcb_tests::mechanism::equivalent_models::{
    flexible_in_space, other_component_axes, other_order, other_units, rigid_linkage_in_space,
};
use dcb_tests::mechanism::{method, stabilized};

fn assert_below(apart: f64, limit: f64) {
    println!("{apart:.1e}");
    assert!(apart < limit, "{apart:.1e}");
}

#[test]
fn in_the_plane_and_in_space() {
    assert_below(flexible_in_space(), 1e-9);
}

#[test]
fn rigid_linkage_in_the_plane_and_in_space() {
    for method in [method(0.9), stabilized(0.9)] {
        assert_below(rigid_linkage_in_space(method), 1e-9);
    }
}

#[test]
fn in_other_units() {
    assert_below(other_units(), 1e-8);
}

#[test]
fn in_other_component_axes() {
    for angle in [0.7, FRAC_PI_2, -2.5] {
        assert_below(other_component_axes(angle), 1e-9);
    }
}

#[test]
fn in_another_order() {
    assert_below(other_order(), 1e-9);
}
