//! Are multiple, clustered, missing and infinite eigenvalues treated as they should be?
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::needless_range_loop
)]

use dcb_formats::Component;
use dcb_formats::component::InterfaceKind;
use dcb_reducer::{ModeSelection, Reduction};
use dcb_samples::spatial_beam::{BeamMass, BeamTheory};
use dcb_samples::{Material, SolidElement, box_block, hard};
use dcb_tests::dense::{
    dense, diagonal_roots, relative, scaled_difference, solve, sparse, symmetric,
};
use dcb_tests::hard::reduction::massless::Massless;
use dcb_tests::oracle::{Oracle, centre_of_mass, rigid_motions};
use dcb_tests::{lowest, parts, refusal, with};
use faer::Side;

fn roots(values: &[f64]) -> Vec<f64> {
    values.iter().map(|value| value.sqrt()).collect()
}

/// Runs of equal eigenvalues as their lengths.
fn multiplicities(eigenvalues: &[f64]) -> Vec<usize> {
    let mut runs = Vec::new();
    for (i, value) in eigenvalues.iter().enumerate() {
        match runs.last_mut() {
            Some(count) if value - eigenvalues[i - 1] < 1e-8 * value => *count += 1,
            _ => runs.push(1),
        }
    }
    runs
}

#[test]
fn double_roots_are_found_whole_and_never_cut() {
    for (component, wanted) in [(hard::square_block(), 12), (hard::symmetric_ring(8), 9)] {
        let all = lowest(&component, wanted + 2).superelement;
        let runs = multiplicities(&all.modes.eigenvalues);
        assert!(
            runs.iter().all(|count| *count <= 2)
                && runs.iter().filter(|count| **count == 2).count() >= 3
        );
        let mut first = 0;
        for count in &runs {
            if *count == 2 {
                // Asking for the first of a pair gives both, and says so; asking for both adds nothing.
                let cut = lowest(&component, first + 1);
                assert_eq!(
                    cut.superelement.mode_count(),
                    first + 2,
                    "{}",
                    component.name
                );
                assert_eq!(cut.quality.added_modes, 1);
                let whole = lowest(&component, first + 2);
                assert_eq!(whole.superelement.mode_count(), first + 2);
                assert_eq!(whole.quality.added_modes, 0);
            }
            first += count;
            if first >= 6 {
                break;
            }
        }
    }
}

#[test]
fn nearly_double_roots_are_two_roots() {
    // The two bending frequencies differ by 0.03 %.
    let block = box_block(
        [6, 2, 2],
        [0.4, 0.1, 0.10003],
        SolidElement::Hexahedron,
        &Material::STEEL,
    );
    let pair = lowest(&block, 2).superelement.modes.eigenvalues;
    let split = (pair[1] / pair[0]).sqrt() - 1.0;
    assert!((1e-4..4e-4).contains(&split), "{split}");
    let one = lowest(&block, 1);
    assert_eq!(one.superelement.mode_count(), 1);
    assert!(
        one.superelement.provenance.warnings.is_empty(),
        "{:?}",
        one.superelement.provenance.warnings
    );
}

#[test]
fn a_root_of_multiplicity_51_is_found_completely() {
    let (component, root) = parts::with_oscillators(18);
    // Differences of the oscillators leave the box at rest: 17 x 3 copies of k/m.
    let oracle = Oracle::of(&component);
    let near = |values: &[f64]| {
        values
            .iter()
            .filter(|value| (*value / root - 1.0).abs() < 1e-9)
            .count()
    };
    assert_eq!(near(&oracle.eigenvalues), 51);
    let first = oracle
        .eigenvalues
        .iter()
        .position(|value| (value / root - 1.0).abs() < 1e-9)
        .unwrap();
    for wanted in [first + 1, first + 20, first + 51, first + 53] {
        let reduced = lowest(&component, wanted);
        let eigenvalues = &reduced.superelement.modes.eigenvalues;
        assert_eq!(near(eigenvalues), 51, "{wanted} wanted");
        assert_eq!(eigenvalues.len(), wanted.max(first + 51));
        assert_eq!(
            reduced.quality.added_modes,
            (first + 51).saturating_sub(wanted)
        );
        assert_eq!(reduced.quality.mode_count.counted, eigenvalues.len() + 6);
        let f = oracle.residual_flexibility(eigenvalues.len());
        let error = scaled_difference(
            &reduced.superelement.residual.flexibility,
            &f,
            &diagonal_roots(&f),
        );
        assert!(error < 1e-9, "{wanted} wanted: F_res {error:e}");
    }
}

/// A beam whose mass is at the nodes' translations, with one rotary inertia against roll.
fn lumped_beam(elements: usize) -> Component {
    let mut beam = parts::beam(
        elements,
        BeamTheory::EulerBernoulli,
        BeamMass::LumpedTranslations,
    )
    .into_draft();
    let mut mass = dense(&beam.mass);
    mass[(3, 3)] = 1e-3;
    beam.mass = sparse(&mass);
    beam.component_masses = None;
    Component::checked(beam).unwrap()
}

#[test]
fn a_line_of_point_masses_has_no_inertia_against_roll() {
    let message = refusal(&parts::beam(
        6,
        BeamTheory::EulerBernoulli,
        BeamMass::LumpedTranslations,
    ));
    dcb_tests::assert_says(&message, &["no inertia", "point or line", "rotary inertia"]);
}

#[test]
fn the_lumped_sample_is_reduced() {
    let sample = dcb_samples::catalogue::find("lumped-beam").unwrap();
    let beam = sample.make(None);
    let oracle = Oracle::of(&beam);
    let element = lowest(&beam, 5).superelement;
    let found = roots(&element.modes.eigenvalues);
    assert!(relative(&found, &roots(&oracle.eigenvalues[..5])) < 1e-8);
}

#[test]
fn massless_rotations_follow_statically() {
    let beam = lumped_beam(6);
    let massless = Massless::of(&beam);
    assert_eq!(massless.with_mass.len(), 22);
    let values = massless.eigenvalues();
    let expected = roots(&values[6..]);
    let oracle = Oracle::of(&beam);
    assert_eq!(oracle.eigenvalues.len(), expected.len());
    for kept in [0, 1, 5, expected.len()] {
        let reduced = lowest(&beam, kept);
        let element = &reduced.superelement;
        assert_eq!(element.mode_count(), kept);
        assert!(
            relative(&roots(&element.modes.eigenvalues), &expected[..kept]) < 1e-8,
            "{kept} modes"
        );
        let f = oracle.residual_flexibility(kept);
        let whole = diagonal_roots(&oracle.residual_flexibility(0));
        let error = scaled_difference(&element.residual.flexibility, &f, &whole);
        assert!(error < 1e-9, "{kept} modes: F_res {error:e}");
        if kept == expected.len() {
            // What is left is the flexibility of the massless rotations, and it has no mass of its own.
            assert!(element.modes.first_omitted_eigenvalue.is_infinite());
            assert!(
                f[(4, 4)] > 1e-3 * whole[4].powi(2),
                "{} of {}",
                f[(4, 4)],
                whole[4].powi(2)
            );
            assert!(element.residual.sigma_squared.is_empty());
            assert!(reduced.quality.static_directions > 0);
        }
    }
    // More modes than there are finite ones gives the finite ones.
    assert_eq!(
        lowest(&beam, 1000).superelement.mode_count(),
        expected.len()
    );
}

#[test]
fn one_mode_no_mode_no_interface() {
    let block = parts::steel_box([3, 1, 1], SolidElement::Hexahedron);
    let oracle = Oracle::of(&block);
    let one = lowest(&block, 1).superelement;
    assert_eq!(one.modes.interface_shapes.ncols(), 1);
    assert!((one.modes.eigenvalues[0] / oracle.eigenvalues[0] - 1.0).abs() < 1e-10);
    let none = lowest(&block, 0);
    assert_eq!(
        (none.recovery.modes.ncols(), none.recovery.residual.ncols()),
        (0, 12)
    );
    assert!(
        (none.superelement.modes.first_omitted_eigenvalue / oracle.eigenvalues[0] - 1.0).abs()
            < 1e-6
    );
    let alone = lowest(&parts::with_interfaces(&block, Vec::new()), 4);
    assert_eq!(alone.superelement.rows.len(), 0);
    assert_eq!(alone.superelement.basis_count(), 4);
    assert!(
        relative(
            &alone.superelement.modes.eigenvalues,
            &oracle.eigenvalues[..4]
        ) < 1e-10
    );
    let rigid = lowest(&parts::with_interfaces(&block, Vec::new()), 0).superelement;
    assert_eq!(rigid.basis_count(), 0);
    assert!(rigid.inertia.mass > 0.0 && rigid.inertia.l3.iter().all(|l3| l3.nrows() == 0));
}

#[test]
fn hundreds_of_interface_dofs() {
    let block = parts::steel_box([5, 3, 2], SolidElement::Hexahedron);
    let nodes: Vec<u32> = (0..50).collect();
    let component = parts::with_interfaces(
        &block,
        vec![parts::interface("patch", InterfaceKind::Nodes, nodes)],
    );
    let oracle = Oracle::of(&component);
    let reduced = lowest(&component, 10);
    assert_eq!(reduced.superelement.rows.len(), 150);
    let f = oracle.residual_flexibility(10);
    assert!(
        scaled_difference(
            &reduced.superelement.residual.flexibility,
            &f,
            &diagonal_roots(&f)
        ) < 1e-9
    );
    let m = oracle.residual_mass(10);
    assert!(scaled_difference(&reduced.superelement.residual.mass, &m, &diagonal_roots(&m)) < 1e-9);
    // Stiff directions without mass worth integrating are kept statically; none is lost.
    assert!(reduced.quality.residual_rank >= 140);
    assert_eq!(
        reduced.quality.residual_rank + reduced.quality.static_directions,
        150
    );
    assert_eq!(reduced.quality.flexibility_rank, 150);
}

#[test]
fn a_limit_keeps_every_mode_below_it() {
    for component in [
        parts::rod(8),
        parts::skew_beam(),
        parts::rotor(),
        parts::steel_box([4, 2, 1], SolidElement::Tetra10),
    ] {
        let oracle = Oracle::of(&component);
        for between in [1, 2, 5, 9] {
            let (low, high) = (oracle.eigenvalues[between - 1], oracle.eigenvalues[between]);
            if high - low < 1e-4 * high {
                continue;
            }
            let modes = ModeSelection::Below {
                eigenvalue: 0.5 * (low + high),
            };
            let reduced = with(
                &component,
                &Reduction {
                    modes,
                    ..Reduction::lowest(0)
                },
            );
            assert_eq!(
                reduced.superelement.mode_count(),
                between,
                "{}",
                component.name
            );
        }
        let modes = ModeSelection::Below {
            eigenvalue: 0.5 * oracle.eigenvalues[0],
        };
        assert_eq!(
            with(
                &component,
                &Reduction {
                    modes,
                    ..Reduction::lowest(0)
                }
            )
            .superelement
            .mode_count(),
            0
        );
    }
}

#[test]
fn kept_modes_stay_orthogonal_to_rigid_motion_inside_a_cluster() {
    let component = hard::square_block();
    let reduced = lowest(&component, 5);
    let (_, centre) = centre_of_mass(&component);
    let mass = dense(&component.mass);
    let coupling = rigid_motions(&component, centre).transpose() * mass * &reduced.recovery.modes;
    assert!(dcb_tests::dense::largest(coupling.as_ref()) < 1e-12);
}

#[test]
fn small_eigenproblems_are_solved_to_rounding_whatever_repeats() {
    // M^(-1/2) K M^(-1/2) of two blocks hinged at an edge: 261 rows, seven zeros, many close pairs.
    let part = hard::hinged_blocks(hard::Hinge::Edge);
    let lower = dense(&part.mass).llt(Side::Lower).unwrap().L().to_owned();
    let half = solve(&lower, &dense(&part.stiffness));
    let matrix = symmetric(&solve(&lower, &half.transpose().to_owned()));
    let (values, vectors) = dcb_dense::symmetric_eigen(matrix.as_ref()).unwrap();
    let defect = &matrix * &vectors - &vectors * dcb_tests::dense::diagonal(&values);
    let size = values.last().unwrap();
    assert!(dcb_tests::dense::largest(defect.as_ref()) < 1e-13 * size);
    let zeros = values
        .iter()
        .filter(|value| value.abs() < 1e-13 * size)
        .count();
    assert_eq!(zeros, 7, "{:?}", &values[..9]);
}
