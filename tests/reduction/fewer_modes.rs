//! Modes left out of a superelement: is it the one that the reducer makes with fewer modes?
//!
//! The reducer solves for the attachments of fewer modes in the finite element model; `ModeTruncation` only does algebra on
//! interface matrices. They share no code.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use dcb_formats::Component;
use dcb_formats::component::{InterfaceKind, Role};
use dcb_formats::superelement::{FrameKind, Inertia, Superelement};
use dcb_reducer::{Grounding, InterfaceModes, LoosePieces, Reduced, Reduction};
use dcb_runtime::{Compatibility, FlexibleBody, ModeTruncation};
use dcb_samples::{SolidElement, hard};
use dcb_tests::dense::{difference, identity, largest, relative, scaled_difference};
use dcb_tests::{parts, with};
use faer::Mat;

/// What may differ by rounding: eigenvectors by the rounding of their eigenvalues over the gaps between these.
const ROUNDING: f64 = 1e-7;

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
    compare(&name, &found, &expected);
    compare_fields(&name, &truncation, &whole, &expected);
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

fn compare(name: &str, found: &Superelement, expected: &Reduced) {
    let expected = &expected.superelement;
    let close = |quantity: &str, error: f64| {
        assert!(
            error < ROUNDING,
            "{name}: {quantity} differs by {error:.1e}"
        );
    };
    let (modes, all) = (&found.modes, &expected.modes);
    let elastic = all
        .eigenvalues
        .iter()
        .take_while(|value| **value <= 0.0)
        .count();
    close(
        "ω²",
        relative(&modes.eigenvalues[elastic..], &all.eigenvalues[elastic..]),
    );
    close(
        "the first ω² left out",
        (modes.first_omitted_eigenvalue / all.first_omitted_eigenvalue - 1.0).abs(),
    );
    assert_eq!(modes.damping, all.damping, "{name}");
    close(
        "L_b Φ",
        difference(&modes.interface_shapes, &all.interface_shapes),
    );
    // Rows of one unit each: by what they are with no mode kept.
    let (residual, all) = (&found.residual, &expected.residual);
    let masses: Vec<f64> = all.mass_diagonal0.iter().map(|mass| mass.sqrt()).collect();
    let flexibilities = flexibilities0(expected);
    close(
        "diag(M_res) with no mode kept",
        relative(
            &nonzero(&residual.mass_diagonal0),
            &nonzero(&all.mass_diagonal0),
        ),
    );
    close(
        "M_res",
        scaled_difference(&residual.mass, &all.mass, &masses),
    );
    close(
        "F_res",
        scaled_difference(&residual.flexibility, &all.flexibility, &flexibilities),
    );
    close("σ²", relative(&residual.sigma_squared, &all.sigma_squared));
    let t = &residual.transform;
    close(
        "T_rᵀ M_res T_r",
        largest((t.transpose() * &all.mass * t - identity(t.ncols())).as_ref()),
    );
    let stiffness = t.transpose() * &all.flexibility * t;
    let roots: Vec<f64> = all
        .sigma_squared
        .iter()
        .map(|square| square.sqrt())
        .collect();
    let squares = Mat::from_fn(t.ncols(), t.ncols(), |i, j| {
        if i == j { all.sigma_squared[i] } else { 0.0 }
    });
    close(
        "T_rᵀ F_res T_r",
        scaled_difference(&stiffness, &squares, &roots),
    );
    assert_eq!(
        residual.output_shapes.is_some(),
        all.output_shapes.is_some(),
        "{name}"
    );
    if let (Some(found), Some(all)) = (&residual.output_shapes, &all.output_shapes) {
        // Observed rows have no flexibility of their own: against the largest entry of each column.
        for column in 0..all.ncols() {
            let of =
                |matrix: &Mat<f64>| Mat::from_fn(matrix.nrows(), 1, |i, _| matrix[(i, column)]);
            close("L_b G_res L_bᵀ", difference(&of(found), &of(all)));
        }
    }
    let mut columns = vec![1.0; expected.mode_count()];
    columns.extend(&masses);
    compare_inertia(name, &found.inertia, &expected.inertia, &columns);
}

/// Columns are scaled to unit mass with no mode kept.
fn compare_inertia(name: &str, found: &Inertia, expected: &Inertia, columns: &[f64]) {
    let scaled = |matrix: &Mat<f64>| {
        Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| match columns[j] {
            0.0 => 0.0,
            scale => matrix[(i, j)] / scale,
        })
    };
    let largest_moment = (0..3).map(|a| expected.tensor[a][a]).fold(0.0, f64::max);
    for (quantity, found, all, size) in [
        ("L1", &found.l1, &expected.l1, expected.mass.sqrt()),
        ("I3", &found.i3, &expected.i3, largest_moment.sqrt()),
    ] {
        let error = largest((scaled(found) - scaled(all)).as_ref()) / size;
        assert!(
            error < ROUNDING,
            "{name}: {quantity} differs by {error:.1e}"
        );
    }
    let blocks = |inertia: &Inertia| {
        Mat::from_fn(9, inertia.i1.len(), |entry, column| {
            inertia.i1[column][entry / 3][entry % 3]
        })
    };
    let (i1, all) = (scaled(&blocks(found)), scaled(&blocks(expected)));
    let error = largest((i1 - all).as_ref()) / largest_moment.sqrt();
    assert!(error < ROUNDING, "{name}: I1 differs by {error:.1e}");
    let lists = [
        ("L3", &found.l3, &expected.l3),
        ("J2", &found.i2, &expected.i2),
    ];
    for (quantity, found, all) in lists {
        assert_eq!(found.len(), all.len(), "{name}: {quantity}");
        for (found, all) in found.iter().zip(all) {
            // The entries are cosines, so to say: at most one in size.
            let error = scaled_difference(found, all, columns);
            assert!(
                error < ROUNDING,
                "{name}: {quantity} differs by {error:.1e}"
            );
        }
    }
}

fn compare_fields(name: &str, truncation: &ModeTruncation, whole: &Reduced, expected: &Reduced) {
    let (found, all) = (truncation.recovery(&whole.recovery), &expected.recovery);
    assert_eq!(found.dofs, all.dofs, "{name}");
    let error = difference(&found.modes, &all.modes);
    assert!(error < ROUNDING, "{name}: Φ differs by {error:.1e}");
    // Against the whole static response of each row.
    for column in 0..all.residual.ncols() {
        let of = |matrix: &Mat<f64>| Mat::from_fn(matrix.nrows(), 1, |i, _| matrix[(i, column)]);
        let apart = largest((of(&found.residual) - of(&all.residual)).as_ref());
        let response =
            largest(of(&found.residual).as_ref()).max(largest(of(&all.residual).as_ref()));
        assert!(
            apart <= ROUNDING * response.max(f64::MIN_POSITIVE),
            "{name}: column {column} of G_res L_bᵀ differs by {apart:.1e} of {response:.1e}"
        );
    }
}

/// √diag(F_res) with no mode kept.
fn flexibilities0(superelement: &Superelement) -> Vec<f64> {
    let (modes, residual) = (&superelement.modes, &superelement.residual);
    (0..superelement.boundary_row_count())
        .map(|row| {
            if residual.mass_diagonal0[row] == 0.0 {
                return 0.0;
            }
            let elastic = modes
                .eigenvalues
                .iter()
                .enumerate()
                .filter(|(_, value)| **value > 0.0);
            let modal = elastic.map(|(k, value)| modes.interface_shapes[(row, k)].powi(2) / value);
            (residual.flexibility[(row, row)] + modal.sum::<f64>()).sqrt()
        })
        .collect()
}

fn nonzero(values: &[f64]) -> Vec<f64> {
    values
        .iter()
        .copied()
        .filter(|value| *value > 0.0)
        .collect()
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
