//! Modes left out of a superelement: is it the one that the reducer makes with fewer modes?
//!
//! The reducer solves for the attachments of fewer modes in the finite element model; `Selection` only does algebra on
//! interface matrices. They share no code.

use dcb_formats::Component;
use dcb_formats::component::{ComponentDraft, InterfaceKind, NamedLoad, Role};
use dcb_formats::superelement::{FrameKind, Superelement};
use dcb_reducer::{EnrichmentSource, Grounding, InterfaceModes, LoosePieces, Reduction};
use dcb_runtime::{Compatibility, FlexibleBody};
use dcb_samples::{PseudoRandom, SolidElement, hard};
use dcb_superelement::Selection;
use dcb_superelement::selection::InterfaceSelection;
use dcb_tests::dense::largest;
use dcb_tests::{parts, with};
use faer::Mat;

use super::same_superelement::{compare, compare_fields};

/// What frequencies beyond the modes may: a reader's filter magnifies the rounding of further columns that hardly differ.
const FREQUENCY_ROUNDING: f64 = 1e-5;

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
    let truncation = Selection::lowest_modes(&whole.superelement, few).unwrap();
    let found = truncation.superelement(&whole.superelement).unwrap();
    let name = format!("{} with {few} of {many} modes", component.name);
    assert!(
        whole.superelement.mode_count() > expected.superelement.mode_count(),
        "{name}: nothing is left out"
    );
    assert_eq!(
        truncation.modes().len(),
        expected.superelement.mode_count(),
        "{name}"
    );
    compare(&name, &found, &expected.superelement);
    let fields = truncation.recovery(&whole.superelement, &whole.recovery);
    compare_fields(&name, &fields.unwrap(), &expected.recovery);
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
        if compatibility == Compatibility::Strong {
            let error = relative_beyond(&found.stiffness, &expected.stiffness);
            assert!(
                error < FREQUENCY_ROUNDING,
                "{name}: frequencies differ by {error:.1e}"
            );
        }
    }
    found
}

/// Largest relative difference; motions without stiffness have none.
fn relative_beyond(found: &[f64], expected: &[f64]) -> f64 {
    let least = 1e-9 * expected.iter().copied().fold(0.0, f64::max);
    let pairs = found.iter().zip(expected);
    pairs
        .map(|(found, expected)| (found - expected).abs() / expected.max(least))
        .fold(0.0, f64::max)
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

/// A rigid interface, an averaged one, and one that is observed only.
fn watched() -> Component {
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
    parts::with_interfaces(&part, interfaces)
}

#[test]
fn observed_and_rigid_interfaces_follow() {
    let found = check(&watched(), &free(), 15, 4);
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
    for options in [Reduction::lowest(5), enriched(&EnrichmentSource::ALL)] {
        let part = loaded(parts::tilted_rod(4));
        let modes = Reduction::lowest(5).modes;
        let whole = with(&part, &Reduction { modes, ..options });
        for wanted in [5, 6, 100] {
            let truncation = Selection::lowest_modes(&whole.superelement, wanted).unwrap();
            let left = truncation.superelement(&whole.superelement).unwrap();
            assert_eq!(left, whole.superelement);
            let fields = truncation.recovery(&whole.superelement, &whole.recovery);
            assert_eq!(fields.unwrap(), whole.recovery);
        }
    }
}

/// A file that lost a low mode and directions of force in an earlier selection.
#[test]
fn fewer_modes_follow_an_earlier_selection() {
    let whole = with(&parts::skew_beam(), &Reduction::lowest(12)).superelement;
    let first = whole.interfaces[0].name.clone();
    let rows = whole.rows.iter().filter(|row| row.interface == 0).count();
    let along = Mat::from_fn(rows, 2, |i, j| f64::from(u8::from(i == j)));
    let earlier = Selection::everything(&whole)
        .with_modes((0..12).filter(|mode| *mode != 2))
        .and_then(|of| of.with_interface(&first, InterfaceSelection::LoadedAlong(along)))
        .unwrap();
    let small = earlier.superelement(&whole).unwrap();
    let fewer = Selection::lowest_modes(&small, 6).unwrap();
    let found = fewer.superelement(&small).unwrap();
    assert_eq!(found.mode_count(), 6);
    assert_eq!(
        found.modes.first_omitted_eigenvalue,
        whole.modes.eigenvalues[2]
    );
    assert_eq!(found.derivation, small.derivation);
    // Statically nothing is lost along the directions that are left.
    let statically = |of: &Superelement, row: usize| {
        let modes = of.modes.eigenvalues.iter().enumerate();
        let of_modes =
            modes.map(|(k, square)| of.modes.interface_shapes[(row, k)].powi(2) / square);
        of.residual.flexibility[(row, row)] + of_modes.sum::<f64>()
    };
    for row in [0, 1, rows, rows + 5] {
        let ratio = statically(&found, row) / statically(&whole, row);
        assert!((ratio - 1.0).abs() < 1e-12, "row {row}: {ratio}");
    }
    // With other modes it is a selection like any other.
    let refused = fewer.with_modes(0..5).unwrap().superelement(&small);
    let refused = refused.unwrap_err().to_string();
    assert!(
        refused.contains("loaded along some forces only"),
        "{refused}"
    );
}

fn enriched(sources: &[EnrichmentSource]) -> Reduction {
    Reduction {
        enrichment: sources.to_vec(),
        ..free()
    }
}

/// With two loads inside the part.
fn loaded(part: Component) -> Component {
    let mut random = PseudoRandom::new(3);
    let loads = ["wind", "heat"].map(|name| NamedLoad {
        name: name.into(),
        forces: (0..part.dofs.len()).map(|_| random.number()).collect(),
    });
    Component::checked(ComponentDraft {
        loads: loads.to_vec(),
        ..part.into_draft()
    })
    .unwrap()
}

#[test]
fn further_columns_take_what_the_modes_did_of_their_responses() {
    use EnrichmentSource::{Krylov, Loads, Spin};
    for sources in [&[Spin][..], &[Loads], &[Krylov], &EnrichmentSource::ALL] {
        for few in [0, 2, 5] {
            check(&loaded(parts::tilted_rod(4)), &enriched(sources), 7, few);
        }
        for few in [0, 3, 7] {
            check(&loaded(parts::skew_beam()), &enriched(sources), 12, few);
        }
        let box_of_steel = parts::steel_box([5, 2, 2], SolidElement::Hexahedron);
        for few in [0, 4, 11] {
            check(&loaded(box_of_steel.clone()), &enriched(sources), 15, few);
        }
    }
    check(&parts::rotor(), &enriched(&[Spin, Krylov]), 14, 6);
}

#[test]
fn further_columns_of_held_parts_and_beside_observed_and_rigid_interfaces_follow() {
    let sources = enriched(&EnrichmentSource::ALL);
    let held = Reduction {
        grounding: Grounding::Allow,
        ..sources.clone()
    };
    check(&loaded(hard::grounded_block()), &held, 12, 3);
    let loosely = Reduction {
        loose_pieces: LoosePieces::Allow,
        ..sources.clone()
    };
    check(&loaded(hard::two_loose_blocks()), &loosely, 12, 7);
    check(&loaded(watched()), &sources, 15, 4);
}

/// Where the modes carry a response whole there is no column for it in the file; with fewer there would have to be one.
#[test]
fn a_column_that_more_modes_made_superfluous_is_missed() {
    for (source, modes) in [(EnrichmentSource::Spin, 12), (EnrichmentSource::Krylov, 9)] {
        let options = Reduction {
            modes: Reduction::lowest(modes).modes,
            ..enriched(&[source])
        };
        let whole = with(&parts::rod(4), &options).superelement;
        let left_out = &whole.derivation.as_ref().unwrap().left_out_columns;
        assert!(!left_out.is_empty(), "{source:?}");
        let listed = &whole.provenance.quality["enrichment"]["left_out"];
        assert_eq!(*listed, serde_json::json!(left_out));
        let refused = Selection::lowest_modes(&whole, 4).unwrap_err().to_string();
        assert!(refused.contains("needs a further column"), "{refused}");
    }
}

/// Columns of other programs, and names that don't fit.
#[test]
fn columns_that_are_something_else_are_refused() {
    let options = Reduction {
        modes: Reduction::lowest(8).modes,
        ..enriched(&[EnrichmentSource::Spin, EnrichmentSource::Loads])
    };
    let whole = with(&loaded(parts::skew_beam()), &options).superelement;
    let renamed = |change: &dyn Fn(&mut Vec<String>)| {
        let mut other = whole.clone();
        change(&mut other.enrichment.as_mut().unwrap().names);
        Selection::lowest_modes(&other, 4).unwrap_err().to_string()
    };
    for refused in [
        renamed(&|names| names.clear()),
        renamed(&|names| names[0] = "gust".into()),
        renamed(&|names| names[0] = "load snow".into()),
        renamed(&|names| names[0] = "krylov nowhere/ux".into()),
    ] {
        assert!(
            refused.contains("other than those of `reduce --enrich`"),
            "{refused}"
        );
    }
    for refused in [
        renamed(&|names| names.swap(0, 1)),
        renamed(&|names| names.reverse()),
    ] {
        assert!(refused.contains("don't answer to"), "{refused}");
    }
    // Where the invariants don't tell the centrifugal forces: rotations, and no component masses.
    let bare = Component::checked(ComponentDraft {
        component_masses: None,
        ..parts::skew_beam().into_draft()
    })
    .unwrap();
    let options = Reduction {
        enrichment: vec![EnrichmentSource::Spin],
        ..options
    };
    let whole = with(&bare, &options).superelement;
    let refused = Selection::lowest_modes(&whole, 4).unwrap_err().to_string();
    assert!(refused.contains("don't answer to"), "{refused}");
}

#[test]
fn a_reduced_number_of_interface_directions_is_refused() {
    let options = Reduction {
        interface_modes: InterfaceModes::Softest(3),
        ..Reduction::lowest(8)
    };
    let part = parts::steel_box([5, 2, 2], SolidElement::Hexahedron);
    let whole = with(&part, &options).superelement;
    let refused = Selection::lowest_modes(&whole, 4).unwrap_err().to_string();
    assert!(refused.contains("interface directions"), "{refused}");
    assert!(
        Selection::lowest_modes(&whole, 8).is_ok(),
        "nothing is left out of it"
    );
}
