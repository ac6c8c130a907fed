//! Is a part that can't be reduced as it is refused with words that say what to fix, and reduced where that is allowed?
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::needless_range_loop
)]

use dcb_formats::Component;
use dcb_formats::component::ComponentDraft;
use dcb_formats::mesh::{Dimension, DofMap};
use dcb_formats::superelement::FrameKind;
use dcb_reducer::model::rigid_body::MassProperties;
use dcb_reducer::{Grounding, LoosePieces, Reduction};
use dcb_samples::catalogue::CATALOGUE;
use dcb_samples::hard::{self, Hinge};
use dcb_samples::{PseudoRandom, SolidElement, UnitScale, in_units};
use dcb_tests::dense::{
    dense, diagonal_roots, difference, eigen, relative, scaled_difference, solve, sparse, symmetric,
};
use dcb_tests::oracle::Oracle;
use dcb_tests::{
    accuracy::basis, assert_says, localization::localization, lowest, nodal, parts, refusal, with,
};
use faer::{Mat, Side};

fn loosely(count: usize) -> Reduction {
    Reduction {
        loose_pieces: LoosePieces::Allow,
        ..Reduction::lowest(count)
    }
}

fn held(count: usize) -> Reduction {
    Reduction {
        grounding: Grounding::Allow,
        ..Reduction::lowest(count)
    }
}

#[test]
fn a_dof_without_stiffness_is_named() {
    assert_says(
        &refusal(&hard::orphan_dof_block()),
        &["1 dof(s) have no stiffness", "node 45 ux", "remove them"],
    );
}

#[test]
fn a_held_part_is_named_with_the_dofs_that_hold_it() {
    let message = refusal(&hard::grounded_block());
    assert_says(
        &message,
        &[
            "the part is held",
            "only 0 of 6 rigid motions",
            "27 dofs",
            "node 1",
            "--allow-grounded",
        ],
    );
    // Held at one node by its three translations: the rotations stay free.
    let free = parts::steel_box([3, 1, 1], SolidElement::Hexahedron);
    let rows: Vec<usize> = (0..free.dofs.len())
        .filter(|row| free.dofs.dof(*row).unwrap().node != 0)
        .collect();
    let dofs = rows
        .iter()
        .map(|row| free.dofs.dof(*row).unwrap())
        .collect();
    let pinned = Component::checked(ComponentDraft {
        dofs: dcb_formats::mesh::DofMap::new(dofs, free.mesh.node_count()).unwrap(),
        stiffness: parts::with_rows(&free.stiffness, &rows),
        mass: parts::with_rows(&free.mass, &rows),
        interfaces: free.interfaces[1..].to_vec(),
        ..free.into_draft()
    })
    .unwrap();
    assert_says(
        &refusal(&pinned),
        &["the part is held", "of 6 rigid motions are free"],
    );
}

#[test]
fn a_spring_to_ground_is_named_where_it_stands() {
    let part = parts::steel_box([3, 1, 1], SolidElement::Hexahedron);
    let mut stiffness = dense(&part.stiffness);
    stiffness[(3 * 7 + 1, 3 * 7 + 1)] *= 1.5;
    let part = part
        .changed(|draft| draft.stiffness = sparse(&stiffness))
        .unwrap();
    assert_says(
        &refusal(&part),
        &["the part is held", "only 5 of 6", "node 7 uy", "(1 dofs"],
    );
}

#[test]
fn pieces_and_mechanisms_are_told_apart() {
    let message = refusal(&hard::two_loose_blocks());
    assert_says(
        &message,
        &[
            "in 2 pieces",
            "piece 1 of 45 node(s), from node 0",
            "piece 2 of 45 node(s), from node 45",
            "--allow-loose",
        ],
    );
    let message = refusal(&hard::hinged_blocks(Hinge::Edge));
    assert_says(
        &message,
        &[
            "mechanism",
            "1 motion(s) beyond the rigid ones",
            "node ",
            "--allow-loose",
        ],
    );
    let message = refusal(&hard::hinged_blocks(Hinge::Node));
    assert_says(
        &message,
        &["mechanism", "3 motion(s) beyond the rigid ones"],
    );
}

#[test]
fn mechanisms_are_found_however_few_modes_are_wanted() {
    for (hinge, expected) in [(Hinge::Edge, "1 motion(s)"), (Hinge::Node, "3 motion(s)")] {
        for wanted in [0, 1, 2] {
            let result = dcb_reducer::reduce(
                &hard::hinged_blocks(hinge),
                &Reduction::lowest(wanted),
                &mut (),
            );
            assert_says(&result.err().unwrap().to_string(), &["mechanism", expected]);
        }
    }
}

#[test]
fn a_mesh_in_another_order_than_the_matrices_is_found() {
    let mut rotor = parts::rotor().into_draft();
    // Two nodes of the disc change places in the mesh, not in the matrices.
    let (a, b) = (28, 36);
    for axis in 0..3 {
        rotor.mesh.coordinates.swap(3 * a + axis, 3 * b + axis);
    }
    let message = refusal(&Component::checked(rotor).unwrap());
    assert_says(
        &message,
        &[
            "the mesh and the matrices don't belong together",
            "6 motions without energy",
            "dof table",
            "worst at node ",
        ],
    );
    // The nodes named are those that changed places or their neighbours.
    let worst = message.rsplit("worst at ").next().unwrap();
    assert!(
        worst.contains("node 28 ") || worst.contains("node 36 "),
        "{worst}"
    );
}

#[test]
fn wrong_signs_are_found() {
    let part = parts::steel_box([3, 1, 1], SolidElement::Hexahedron);
    let mut mass = dense(&part.mass);
    mass[(10, 10)] = -mass[(10, 10)];
    let message = refusal(
        &Component::checked(ComponentDraft {
            mass: sparse(&mass),
            ..part.clone().into_draft()
        })
        .unwrap(),
    );
    assert_says(
        &message,
        &[
            "mass matrix has 1 negative diagonal",
            "node 3 uy",
            "sign convention",
        ],
    );
    let negative = sparse(&(dense(&part.stiffness) * faer::Scale(-1.0)));
    let message = refusal(
        &Component::checked(ComponentDraft {
            stiffness: negative,
            ..part.clone().into_draft()
        })
        .unwrap(),
    );
    assert_says(&message, &["stiffness matrix has 48 negative diagonal"]);
}

#[test]
fn an_indefinite_stiffness_is_counted_and_located() {
    let part = parts::steel_box([3, 1, 1], SolidElement::Hexahedron);
    let oracle = Oracle::of(&part);
    for count in [1, 3] {
        // The first eigenvalues change sign; the rigid motions stay.
        let mut stiffness = oracle.stiffness.clone();
        for k in 0..count {
            let shape = &oracle.mass * oracle.shapes.as_ref().subcols(k, 1).to_owned();
            stiffness -= &shape * shape.transpose() * faer::Scale(2.0 * oracle.eigenvalues[k]);
        }
        let message = refusal(
            &Component::checked(ComponentDraft {
                stiffness: sparse(&symmetric(&stiffness)),
                ..part.clone().into_draft()
            })
            .unwrap(),
        );
        let pivots = format!("{count} negative pivot(s), at node ");
        assert_says(
            &message,
            &[
                "the stiffness matrix is indefinite",
                &pivots,
                "element orientation",
            ],
        );
    }
}

#[test]
fn numbers_that_smell_of_mixed_units_are_warned_about() {
    let part = parts::steel_box([3, 1, 1], SolidElement::Hexahedron);
    assert!(lowest(&part, 2).superelement.provenance.warnings.is_empty());
    let warned = |part: &Component, about: &str| {
        let warnings = lowest(part, 2).superelement.provenance.warnings;
        assert!(
            warnings
                .iter()
                .any(|w| w.contains(about) && w.contains("mixed units?")),
            "{about}: {warnings:?}"
        );
    };
    // Millimetres in the mesh, metres in the name.
    let mut millimetres = part.clone().into_draft();
    millimetres
        .mesh
        .coordinates
        .iter_mut()
        .for_each(|x| *x *= 1e3);
    millimetres
        .interfaces
        .iter_mut()
        .for_each(|i| i.position = i.position.map(|p| p.map(|x| x * 1e3)));
    let millimetres = Component::checked(millimetres).unwrap();
    warned(&millimetres, "lighter than a foam");
    // Kilograms where tonnes are named.
    let tonnes = in_units(&part, &UnitScale::mm_t_s())
        .changed(|draft| draft.mass.val_mut().iter_mut().for_each(|m| *m *= 1e3))
        .unwrap();
    warned(&tonnes, "denser than any material");
    let stiff = part
        .changed(|draft| draft.stiffness.val_mut().iter_mut().for_each(|k| *k *= 1e6))
        .unwrap();
    warned(&stiff, "wave speed");
}

fn unit_warnings(part: &Component) -> Vec<String> {
    let properties = MassProperties::of(part).unwrap();
    dcb_reducer::model::plausibility::unit_warnings(part, &properties, None)
}

#[test]
fn a_factor_of_a_thousand_is_warned_about() {
    let solid = parts::steel_box([3, 1, 1], SolidElement::Hexahedron);
    let scaled = |part: &Component, k: f64, m: f64, x: f64| {
        let mut part = part.clone().into_draft();
        part.component_masses = None;
        part.stiffness.val_mut().iter_mut().for_each(|v| *v *= k);
        part.mass.val_mut().iter_mut().for_each(|v| *v *= m);
        part.mesh.coordinates.iter_mut().for_each(|v| *v *= x);
        Component::checked(part).unwrap()
    };
    let beam = dcb_samples::spatial_beam(&dcb_samples::SpatialBeam::default());
    for part in [solid, beam, parts::skew_beam()] {
        let none = unit_warnings(&part);
        assert!(none.is_empty(), "{}: {none:?}", part.name);
        let millimetres = in_units(&part, &UnitScale::mm_t_s());
        assert!(unit_warnings(&millimetres).is_empty());
        for (k, m, x) in [
            (1e-3, 1.0, 1.0),
            (1e3, 1.0, 1.0),
            (1.0, 1e-3, 1.0),
            (1.0, 1e3, 1.0),
            (1.0, 1.0, 1e3),
        ] {
            let warnings = unit_warnings(&scaled(&part, k, m, x));
            let speed = k != 1.0;
            let says =
                |w: &String| w.contains("mixed units?") && (!speed || w.contains("wave speed"));
            assert!(
                warnings.iter().any(says),
                "{} {k} {m} {x}: {warnings:?}",
                part.name
            );
        }
    }
}

#[test]
fn samples_in_their_own_units_are_not_warned_about() {
    for sample in CATALOGUE.iter().filter(|s| s.name != "orphan-dof-block") {
        let warnings = unit_warnings(&sample.make(None));
        assert!(warnings.is_empty(), "{}: {warnings:?}", sample.name);
    }
}

#[test]
fn a_stray_point_without_dofs_changes_nothing() {
    let part = parts::steel_box([3, 1, 1], SolidElement::Hexahedron);
    let mut stray = part.clone().into_draft();
    stray.mesh.coordinates.extend([1e6, -1e6, 1e6]);
    stray.dofs = DofMap::new(part.dofs.nodal_dofs(), stray.mesh.node_count()).unwrap();
    let stray = Component::checked(stray).unwrap();
    assert_eq!(
        MassProperties::of(&stray).unwrap(),
        MassProperties::of(&part).unwrap()
    );
    let (with, without) = (lowest(&stray, 3), lowest(&part, 3));
    assert_eq!(
        with.superelement.modes.eigenvalues,
        without.superelement.modes.eigenvalues
    );
    assert!(with.superelement.provenance.warnings.is_empty());
}

/// The part as a program that prints this many decimals of the mantissa would export it.
fn printed(part: Component, decimals: usize) -> Component {
    let mut part = part.into_draft();
    for value in part.stiffness.val_mut() {
        *value = format!("{value:.decimals$e}").parse().unwrap();
    }
    Component::checked(part).unwrap()
}

#[test]
fn few_printed_digits_are_warned_about_or_refused() {
    let warned = lowest(
        &printed(parts::steel_box([3, 1, 1], SolidElement::Hexahedron), 8),
        2,
    );
    let warnings = warned.superelement.provenance.warnings;
    assert!(
        warnings.iter().any(|w| w.contains("few digits")),
        "{warnings:?}"
    );
    // In a thin part, bending is far softer than the rounding of ten digits.
    assert_says(
        &refusal(&printed(hard::thin_plate(), 9)),
        &[
            "too few digits",
            "of 1843 nodes",
            "first elastic eigenvalue",
            "at least 15",
        ],
    );
    let exact = lowest(&printed(hard::thin_plate(), 16), 2);
    assert!(exact.superelement.provenance.warnings.is_empty());
}

/// The slender block with a spring to ground at node 0 along z, relative to the stiffness there.
fn slender_block_on_a_spring(relative: f64) -> Component {
    let mut part = hard::slender_block().into_draft();
    let mut triplets = Vec::new();
    for column in 0..part.stiffness.ncols() {
        let rows = part.stiffness.row_idx_of_col_raw(column).iter();
        for (row, value) in rows.zip(part.stiffness.val_of_col(column)) {
            let spring = if (*row, column) == (2, 2) {
                relative * value
            } else {
                0.0
            };
            triplets.push(faer::sparse::Triplet::new(
                *row,
                column as u32,
                value + spring,
            ));
        }
    }
    let n = part.stiffness.nrows();
    part.stiffness = dcb_formats::SparseMatrix::try_new_from_triplets(n, n, &triplets).unwrap();
    Component::checked(part).unwrap()
}

#[test]
fn a_weak_spring_to_ground_is_named_where_it_stands() {
    for relative in [1e-7, 1e-9] {
        assert_says(
            &refusal(&slender_block_on_a_spring(relative)),
            &["the part is held", "node 0 uz", "--allow-grounded"],
        );
    }
    let warnings = lowest(&slender_block_on_a_spring(1e-10), 2)
        .superelement
        .provenance
        .warnings;
    assert!(
        warnings.iter().any(|w| w.contains("at node 0 uz")),
        "{warnings:?}"
    );
}

#[test]
fn a_part_without_elastic_motion_is_refused() {
    let mut part = parts::steel_box([3, 1, 1], SolidElement::Hexahedron).into_draft();
    let all: Vec<u32> = (0..part.mesh.node_count() as u32).collect();
    part.interfaces.truncate(1);
    part.interfaces[0].kind = dcb_formats::component::InterfaceKind::Rigid;
    part.interfaces[0].nodes = all;
    part.interfaces[0].directions = None;
    assert_says(
        &refusal(&Component::checked(part).unwrap()),
        &[
            "nothing elastic is left",
            "6 dofs remain",
            "rigid interface",
        ],
    );
}

#[test]
fn an_indefinite_mass_is_refused_with_its_place() {
    let part = parts::steel_box([3, 1, 1], SolidElement::Hexahedron);
    let mut mass = dense(&part.mass);
    let (a, b) = (3 * 5, 3 * 6);
    let strong = 3.0 * (mass[(a, a)] * mass[(b, b)]).sqrt();
    mass[(a, b)] = strong;
    mass[(b, a)] = strong;
    let part = part.changed(|draft| draft.mass = sparse(&mass)).unwrap();
    let message = refusal(&part);
    assert!(message.contains("mass matrix"), "{message}");
}

#[test]
fn a_held_part_is_reduced_as_it_is_where_that_is_allowed() {
    let part = hard::grounded_block();
    let (k, m) = (dense(&part.stiffness), dense(&part.mass));
    let oracle = Oracle::from_parts(k, m, Mat::zeros(part.dofs.len(), 0), localization(&part));
    for kept in [0, 1, 6] {
        let reduced = with(&part, &held(kept));
        let element = &reduced.superelement;
        assert_eq!(element.frame_kind, FrameKind::Given);
        assert!(
            element
                .provenance
                .warnings
                .iter()
                .any(|w| w.contains("the part is held"))
        );
        assert!(relative(&element.modes.eigenvalues, &oracle.eigenvalues[..kept]) < 1e-10);
        let f = oracle.residual_flexibility(kept);
        assert!(
            scaled_difference(&element.residual.flexibility, &f, &diagonal_roots(&f)) < 1e-9,
            "{kept} modes"
        );
        // The frame is no mean-axis frame: L1 and I3 are data.
        let expected = nodal::invariants(&part, element.origin, basis(&reduced).as_ref());
        assert!(
            difference(&element.inertia.l1, &expected.l1) < 1e-11
                && difference(&element.inertia.i3, &expected.i3) < 1e-11
        );
        if kept > 0 {
            assert!(dcb_tests::dense::largest(expected.l1.as_ref()) > 0.1);
        }
    }
    // Allowing a held part does not make a free one held.
    let free = parts::steel_box([3, 1, 1], SolidElement::Hexahedron);
    assert!(with(&free, &held(3)).superelement == lowest(&free, 3).superelement);
}

#[test]
fn loose_pieces_are_modes_of_zero_frequency_where_that_is_allowed() {
    for (part, extra) in [
        (hard::hinged_blocks(Hinge::Edge), 1),
        (hard::hinged_blocks(Hinge::Node), 3),
        (hard::two_loose_blocks(), 6),
    ] {
        let (k, m) = (dense(&part.stiffness), dense(&part.mass));
        // All motions without energy from the dense pencil.
        let lower = m.llt(Side::Lower).unwrap().L().to_owned();
        let half = solve(&lower, &k);
        let (values, vectors) = eigen(&symmetric(&solve(&lower, &half.transpose().to_owned())));
        assert!(
            values[5 + extra].abs() < 1e-6 * values[6 + extra],
            "{}: {values:?}",
            part.name
        );
        let mut null = solve(
            &lower.transpose().to_owned(),
            &vectors.as_ref().subcols(0, 6 + extra).to_owned(),
        );
        // Inverse iteration cleans them: each step removes 99 % of what is elastic.
        let shifted = &k + &m * faer::Scale(0.01 * values[6 + extra]);
        for _ in 0..5 {
            null = solve(&shifted, &(&m * &null)) * faer::Scale(0.01 * values[6 + extra]);
        }
        let oracle = Oracle::from_parts(k, m, null, localization(&part));
        let reduced = with(&part, &loosely(extra + 5));
        let element = &reduced.superelement;
        // Two equal blocks of square section have fourfold roots, which are not cut.
        let elastic = element.mode_count() - extra;
        assert!(
            elastic == 5 || (extra == 6 && elastic == 6),
            "{}: {elastic}",
            part.name
        );
        assert!(
            element.modes.eigenvalues[..extra]
                .iter()
                .all(|value| *value == 0.0)
        );
        assert!(
            relative(
                &element.modes.eigenvalues[extra..],
                &oracle.eigenvalues[..elastic]
            ) < 1e-9,
            "{}",
            part.name
        );
        let warning = format!("{extra} mode(s) without stiffness are kept");
        assert!(
            element
                .provenance
                .warnings
                .iter()
                .any(|w| w.contains(&warning)),
            "{:?}",
            element.provenance.warnings
        );
        let f = oracle.residual_flexibility(elastic);
        let error = scaled_difference(&element.residual.flexibility, &f, &diagonal_roots(&f));
        assert!(error < 1e-8, "{}: F_res {error:e}", part.name);
        // The zero modes cost nothing and are mass-orthonormal to the others.
        let phi = &reduced.recovery.modes;
        let product = phi.transpose() * &oracle.mass * phi;
        assert!(difference(&product, &dcb_tests::dense::identity(extra + elastic)) < 1e-11);
    }
}

#[test]
fn fewer_modes_than_loose_motions_are_not_kept_in_part() {
    // With no mode asked for, a zero mode would stay in the residual flexibility and make it infinite.
    for (part, extra) in [
        (hard::hinged_blocks(Hinge::Edge), 1),
        (hard::two_loose_blocks(), 6),
    ] {
        for wanted in [0, 1] {
            let element = with(&part, &loosely(wanted)).superelement;
            assert_eq!(
                element.mode_count(),
                extra.max(wanted),
                "{} with {wanted}",
                part.name
            );
            let longest = dcb_tests::dense::largest(element.residual.flexibility.as_ref());
            assert!(longest < 1e-3, "{}: {longest:e}", part.name);
        }
    }
}

/// Pieces of any size beside each other, equal ones too: each is as good as it would be alone.
#[test]
fn small_and_identical_loose_pieces_are_reduced() {
    use dcb_tests::random_parts::{Recipe, SpringMass, Springs};
    let network = |seed: u64, stiffness: f64, mass: f64, size: f64| {
        let mut random = PseudoRandom::new(seed);
        let mut about = |value: f64| value * (1.0 + 0.5 * random.number());
        let springs = Springs {
            dimension: Dimension::Spatial,
            points: (0..5)
                .map(|i| {
                    [
                        about(size),
                        about(size) * f64::from(i % 2),
                        about(size) * f64::from(i % 3),
                    ]
                })
                .collect(),
            stiffness: (0..10).map(|_| about(stiffness)).collect(),
            mass: SpringMass::Lumped((0..5).map(|_| about(mass)).collect()),
        };
        Recipe::Springs(springs).component()
    };
    let alike = || network(1, 1e6, 1.0, 1.0);
    let whole = network(2, 1e6, 1.0, 1.0);
    let cases = [
        ("identical", vec![alike(), alike(), alike()]),
        (
            "light and stiff",
            vec![whole.clone(), network(3, 1e8, 1e-6, 1.0)],
        ),
        ("small", vec![whole.clone(), network(4, 1e6, 1.0, 1e-3)]),
        (
            "soft",
            vec![
                whole,
                network(5, 1e2, 1e-3, 0.1),
                network(6, 1e4, 1e-4, 0.01),
            ],
        ),
    ];
    for (name, pieces) in cases {
        let part = dcb_tests::parts::side_by_side(&pieces);
        let extra = 6 * (pieces.len() - 1);
        for wanted in [0, extra + 4] {
            let reduced = with(&part, &loosely(wanted));
            let zero = |value: &&f64| **value == 0.0;
            let modes = &reduced.superelement.modes;
            assert_eq!(
                modes.eigenvalues.iter().filter(zero).count(),
                extra,
                "{name}, {wanted} modes"
            );
            assert!(
                reduced.quality.broken_limits().is_empty(),
                "{name}: {:?}",
                reduced.quality.broken_limits()
            );
            // With nothing but loose motions kept, each piece has the flexibility that it has alone.
            let mut first = 0;
            for piece in pieces.iter().filter(|_| wanted == 0) {
                let alone = lowest(piece, 0).superelement.residual.flexibility;
                let own = Mat::from_fn(alone.nrows(), alone.ncols(), |i, j| {
                    reduced.superelement.residual.flexibility[(first + i, first + j)]
                });
                let error = scaled_difference(&own, &alone, &diagonal_roots(&alone));
                assert!(error < 1e-8, "{name}: F_res {error:e}");
                first += alone.nrows();
            }
            for identity in dcb_formats::identities::in_full(&reduced.superelement) {
                assert!(identity.holds(), "{name}, {wanted} modes: {identity:?}");
            }
        }
    }
}

/// One in a hundred is refused where ω² of the pieces differ by 1e9; up to 1e6 none is.
#[test]
fn random_loose_pieces_are_reduced() {
    use dcb_tests::random_parts::{Recipe, SpringMass, Springs};
    let mut random = PseudoRandom::new(7);
    let mut network = |spread: f64| {
        let [stiffness, mass, size] =
            [1.5, 1.5, 1.5].map(|decades: f64| 10_f64.powf(spread * decades * random.number()));
        let count = 2 + (2.0 + 2.0 * random.number()) as usize;
        let springs = Springs {
            dimension: Dimension::Spatial,
            points: (0..count)
                .map(|_| std::array::from_fn(|_| size * random.number()))
                .collect(),
            stiffness: (0..count * (count - 1) / 2)
                .map(|_| 1e6 * stiffness * (1.0 + 0.5 * random.number()))
                .collect(),
            mass: SpringMass::Lumped(
                (0..count)
                    .map(|_| mass * (1.0 + 0.5 * random.number()))
                    .collect(),
            ),
        };
        Recipe::Springs(springs).component()
    };
    for case in 0..100 {
        let others = 1 + case % 3;
        let mut pieces = vec![network(0.0)];
        pieces.extend((0..others).map(|_| network(1.0)));
        let part = dcb_tests::parts::side_by_side(&pieces);
        for wanted in [0, 30] {
            let reduced = with(&part, &loosely(wanted));
            let broken = reduced.quality.broken_limits();
            assert!(broken.is_empty(), "case {case}, {wanted} modes: {broken:?}");
        }
    }
}
