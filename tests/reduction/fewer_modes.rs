//! Modes left out of a superelement: is it the one that the reducer makes with fewer modes?
//!
//! The reducer solves for the attachments of fewer modes in the finite element model; `ModeTruncation` only does algebra on
//! interface matrices. They share no code.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use dcb_formats::Component;
use dcb_formats::component::{InterfaceKind, Role};
use dcb_formats::superelement::{FrameKind, Superelement};
use dcb_reducer::{Grounding, InterfaceModes, LoosePieces, Reduction};
use dcb_runtime::{Compatibility, FlexibleBody, ModeTruncation};
use dcb_samples::{SolidElement, hard};
use dcb_tests::dense::largest;
use dcb_tests::same_superelement::{compare, compare_fields};
use dcb_tests::{parts, with};

/// Reduces with many modes and with few, and compares the few with what is left of the many.
fn check(component: &Component, options: &Reduction, many: usize, few: usize) -> Superelement {
    let reduced = |modes: usize| {
        let modes = Reduction::lowest(modes).modes;
        with(
            component,
            &Reduction {
                modes,
                ..options.clone()
            },
        )
    };
    let (whole, expected) = (reduced(many), reduced(few));
    let truncation = ModeTruncation::of(&whole.superelement, few).unwrap();
    let found = truncation.superelement(&whole.superelement).unwrap();
    let name = format!("{} with {few} of {many} modes", component.name);
    assert!(
        whole.superelement.mode_count() > expected.superelement.mode_count(),
        "{name}: nothing is left out"
    );
    assert_eq!(
        truncation.kept(),
        expected.superelement.mode_count(),
        "{name}"
    );
    compare(&name, &found, &expected.superelement);
    let fields = truncation.recovery(&whole.recovery);
    compare_fields(&name, &fields, &expected.recovery);
    for compatibility in [
        Compatibility::Strong,
        Compatibility::Static,
        Compatibility::Weak,
    ] {
        let body = |superelement| FlexibleBody::from_superelement(superelement, compatibility);
        let (found, expected) = (body(&found).unwrap(), body(&expected.superelement).unwrap());
        assert_eq!(
            found.coordinate_count(),
            expected.coordinate_count(),
            "{name}"
        );
        assert_eq!(
            found.residual_flexibility.is_some(),
            expected.residual_flexibility.is_some(),
            "{name}"
        );
    }
    found
}

fn free() -> Reduction {
    Reduction::lowest(1)
}

#[test]
fn planar_and_spatial_parts_lose_modes_as_if_reduced_with_fewer() {
    for few in [0, 1, 2, 5, 8] {
        check(&parts::tilted_rod(4), &free(), 9, few);
    }
    for few in [0, 3, 7] {
        check(&parts::skew_beam(), &free(), 12, few);
    }
    check(&parts::rotor(), &free(), 14, 6);
}

#[test]
fn all_that_the_modes_gave_up_comes_back_where_nothing_was_left() {
    // 12 modes are all there are: F_res is rounding, and the truncation has to make it from the modes alone.
    check(&parts::tilted_rod(4), &free(), 12, 4);
}

#[test]
fn observed_and_rigid_interfaces_follow() {
    let part = parts::steel_box([5, 2, 2], SolidElement::Hexahedron);
    let [left, right] = ["x_min", "x_max"].map(|set| part.mesh.point_sets[set].clone());
    let inner: Vec<u32> = (0..part.mesh.node_count() as u32)
        .filter(|node| !left.contains(node) && !right.contains(node))
        .step_by(7)
        .take(2)
        .collect();
    let mut watched = parts::interface("watched", InterfaceKind::Nodes, inner);
    watched.role = Role::Output;
    let interfaces = vec![
        parts::interface("left", InterfaceKind::Rigid, left),
        watched,
        parts::interface("right", InterfaceKind::Average, right),
    ];
    let found = check(&parts::with_interfaces(&part, interfaces), &free(), 15, 4);
    let shapes = found.residual.output_shapes.unwrap();
    assert!(
        (6..12).any(|row| shapes[(row, 0)].abs() > 0.0),
        "nothing is observed"
    );
}

#[test]
fn a_frame_that_is_given_keeps_its_momentum_terms() {
    let held = Reduction {
        grounding: Grounding::Allow,
        ..free()
    };
    let found = check(&hard::grounded_block(), &held, 12, 3);
    assert_eq!(found.frame_kind, FrameKind::Given);
    assert!(
        largest(found.inertia.l1.as_ref()) > 1e-3,
        "there are no such terms"
    );
}

#[test]
fn motions_without_stiffness_and_multiple_roots_are_not_cut() {
    let loosely = Reduction {
        loose_pieces: LoosePieces::Allow,
        ..free()
    };
    let found = check(&hard::two_loose_blocks(), &loosely, 12, 2);
    assert_eq!(
        found.mode_count(),
        6,
        "six motions of one block against the other"
    );
    let found = check(&hard::square_block(), &free(), 10, 1);
    assert_eq!(found.mode_count(), 2, "bending in both directions");
}

#[test]
fn nothing_changes_where_nothing_is_left_out() {
    let whole = with(&parts::tilted_rod(4), &Reduction::lowest(5)).superelement;
    for wanted in [5, 6, 100] {
        let truncation = ModeTruncation::of(&whole, wanted).unwrap();
        assert_eq!(truncation.superelement(&whole).unwrap(), whole);
    }
}

#[test]
fn a_reduced_number_of_interface_directions_is_refused() {
    let options = Reduction {
        interface_modes: InterfaceModes::Softest(3),
        ..Reduction::lowest(8)
    };
    let part = parts::steel_box([5, 2, 2], SolidElement::Hexahedron);
    let whole = with(&part, &options).superelement;
    let refused = ModeTruncation::of(&whole, 4).unwrap_err().to_string();
    assert!(refused.contains("interface directions"), "{refused}");
    assert!(
        ModeTruncation::of(&whole, 8).is_ok(),
        "nothing is left out of it"
    );
}
