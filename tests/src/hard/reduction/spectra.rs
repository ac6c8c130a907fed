//! Hard cases of the spectrum: infinite, double, triple, 51-fold and clustered eigenvalues.

use dcb_formats::Component;
use dcb_formats::component::{ComponentDraft, InterfaceKind};
use dcb_samples::spatial_beam::{BeamMass, BeamTheory};
use dcb_samples::{Material, SolidElement, box_block};
use faer::Mat;

use crate::dense::{dense, diagonal, diagonal_roots, relative, scaled_difference, sparse};
use crate::hard::case::{Bounded, HardCase};
use crate::hard::reduction::GROUP;
use crate::hard::reduction::massless::Massless;
use crate::hard::reduction::plain_methods::{block_lanczos, eigenpairs};
use crate::oracle::Oracle;
use crate::{lowest, parts};

fn roots(values: &[f64]) -> Vec<f64> {
    values.iter().map(|value| value.sqrt()).collect()
}

/// Every finite frequency against those of static condensation.
fn against_condensation(component: &Component) -> Bounded {
    let expected = roots(&Massless::of(component).eigenvalues()[6..]);
    let element = lowest(component, component.dofs.len()).superelement;
    Bounded {
        found: relative(&roots(&element.modes.eigenvalues), &expected),
        bound: 1e-8,
    }
}

/// A beam with point masses and roll inertia: the rotations of bending are massless.
pub fn massless_rotations() -> HardCase {
    let beam = parts::beam(6, BeamTheory::EulerBernoulli, BeamMass::LumpedWithRoll);
    let plain = eigenpairs(&dense(&beam.stiffness), &dense(&beam.mass));
    assert!(plain.is_none());
    let massless = Massless::of(&beam).without.len();
    HardCase {
        group: GROUP,
        name: "massless_rotations",
        naive_method: "dense eigenvalues by Cholesky of M",
        naive: format!(
            "no factor: {massless} of {} pivots are zero",
            beam.dofs.len()
        ),
        ours: "every finite frequency of the statically condensed beam".into(),
        error: Some(against_condensation(&beam)),
    }
}

/// Quadratic tetrahedra with their mass lumped at the middle nodes: row sums at the corners are negative, so these get none.
fn corners_without_mass() -> Component {
    let block = parts::steel_box([2, 1, 1], SolidElement::Tetra10);
    let mass = dense(&block.mass);
    let n = mass.nrows();
    let sums: Vec<f64> = (0..n).map(|i| (0..n).map(|j| mass[(i, j)]).sum()).collect();
    let (total, positive): (f64, f64) = (
        sums.iter().sum(),
        sums.iter().filter(|sum| **sum > 0.0).sum(),
    );
    let lumped: Vec<f64> = sums
        .iter()
        .map(|sum| sum.max(0.0) * total / positive)
        .collect();
    Component::checked(ComponentDraft {
        mass: sparse(&diagonal(&lumped)),
        ..block.into_draft()
    })
    .expect("a component")
}

/// A diagonal mass with zeros.
pub fn lumped_mass_with_zeros() -> HardCase {
    let block = corners_without_mass();
    let (stiffness, mass) = (dense(&block.stiffness), dense(&block.mass));
    let n = mass.nrows();
    let scaled = Mat::from_fn(n, n, |i, j| {
        stiffness[(i, j)] / (mass[(i, i)] * mass[(j, j)]).sqrt()
    });
    let entries = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
    let broken = entries.filter(|at| !scaled[*at].is_finite()).count();
    assert!(broken > 0);
    HardCase {
        group: GROUP,
        name: "lumped_mass_with_zeros",
        naive_method: "M^(-1/2) K M^(-1/2) entry by entry, since M is diagonal",
        naive: format!("{broken} of {} entries are not finite", n * n),
        ours: "every finite frequency of the statically condensed part".into(),
        error: Some(against_condensation(&block)),
    }
}

/// The shift of the plain Lanczos, that of 100 Hz.
const SHIFT: f64 = (100.0 * std::f64::consts::TAU) * (100.0 * std::f64::consts::TAU);

/// A bar of square section: every bending frequency is double.
pub fn double_roots() -> HardCase {
    let bar = box_block(
        [4, 2, 2],
        [0.4, 0.1, 0.1],
        SolidElement::Hexahedron,
        &Material::STEEL,
    );
    let oracle = Oracle::of(&bar);
    // The first pair. Rounding lets copies in when many more steps are made, some of them and late.
    let pair = &oracle.eigenvalues[..2];
    let found = block_lanczos(
        &oracle.stiffness,
        &oracle.mass,
        &oracle.rigid,
        SHIFT,
        (1, pair.len()),
    );
    let high = (found[1] / pair[1]).sqrt() - 1.0;
    assert!(high > 0.01, "{found:?}");

    let expected = &oracle.eigenvalues[..8];
    let element = lowest(&bar, expected.len()).superelement;
    let error = relative(
        &roots(&element.modes.eigenvalues[..expected.len()]),
        &roots(expected),
    );
    HardCase {
        group: GROUP,
        name: "double_roots",
        naive_method: "Lanczos with a single vector, until the modes wanted have converged",
        naive: format!(
            "one of the first pair missed: the second frequency is {:.0} % too high",
            100.0 * high
        ),
        ours: "every pair among the eight lowest found whole".into(),
        error: Some(Bounded {
            found: error,
            bound: 1e-10,
        }),
    }
}

/// Where the first run of three equal eigenvalues begins.
fn first_triple(eigenvalues: &[f64]) -> usize {
    let equal = |i: usize| eigenvalues[i + 1] / eigenvalues[i] - 1.0 < 1e-8;
    (0..eigenvalues.len() - 3)
        .find(|i| equal(*i) && equal(i + 1) && !equal(i + 2) && (*i == 0 || !equal(i - 1)))
        .expect("a triple root")
}

/// A cube with one corner as interface: its three directions are alike, and so must their flexibilities be.
pub fn triple_root_at_the_cut() -> HardCase {
    let cube = box_block(
        [2, 2, 2],
        [0.1, 0.1, 0.1],
        SolidElement::Hexahedron,
        &Material::STEEL,
    );
    let corner = parts::interface("corner", InterfaceKind::Nodes, vec![0]);
    let cube = parts::with_interfaces(&cube, vec![corner]);
    let oracle = Oracle::of(&cube);
    let first = first_triple(&oracle.eigenvalues);
    let spread = |f: &Mat<f64>| {
        let direct = [f[(0, 0)], f[(1, 1)], f[(2, 2)]];
        let (low, high) = direct
            .iter()
            .fold((f64::INFINITY, 0.0_f64), |(low, high), f| {
                (low.min(*f), high.max(*f))
            });
        high / low - 1.0
    };
    // Which directions a library gives the three modes is up to the machine.
    let cuts = [first + 1, first + 2].map(|kept| spread(&oracle.residual_flexibility(kept)));
    let uneven = cuts.into_iter().fold(0.0, f64::max);
    assert!(uneven > 0.01, "{uneven:e}");

    let element = lowest(&cube, first + 1).superelement;
    assert_eq!(element.mode_count(), first + 3);
    let f = &element.residual.flexibility;
    let expected = oracle.residual_flexibility(first + 3);
    let error = scaled_difference(f, &expected, &diagonal_roots(&expected));
    HardCase {
        group: GROUP,
        name: "triple_root_at_the_cut",
        naive_method: "as many modes as asked for, whatever they are cut from",
        naive: format!(
            "F_res of a cube's corner differs by {:.0} % between x, y and z",
            100.0 * uneven
        ),
        ours: "the root kept whole, the same in x, y and z".into(),
        error: Some(Bounded {
            found: error.max(spread(f)),
            bound: 1e-9,
        }),
    }
}

/// Eighteen equal oscillators: 51 motions with the same frequency.
pub fn fifty_fold_root() -> HardCase {
    let (component, root) = parts::with_oscillators(18);
    let oracle = Oracle::of(&component);
    let near = |values: &[f64]| {
        let copies = values
            .iter()
            .filter(|value| (*value / root - 1.0).abs() < 1e-8);
        copies.count()
    };
    assert_eq!(near(&oracle.eigenvalues), 51);
    let wanted = 51
        + oracle
            .eigenvalues
            .partition_point(|v| *v < root * (1.0 - 1e-8));
    let found = block_lanczos(
        &oracle.stiffness,
        &oracle.mass,
        &oracle.rigid,
        SHIFT,
        (8, wanted),
    );
    let copies = near(&found);
    assert!(copies < 51);

    let element = lowest(&component, wanted - 30).superelement;
    assert_eq!(element.mode_count(), wanted);
    assert_eq!(near(&element.modes.eigenvalues), 51);
    let f = oracle.residual_flexibility(wanted);
    let frequencies = relative(
        &roots(&element.modes.eigenvalues),
        &roots(&oracle.eigenvalues[..wanted]),
    );
    let flexibility = scaled_difference(&element.residual.flexibility, &f, &diagonal_roots(&f));
    HardCase {
        group: GROUP,
        name: "fifty_fold_root",
        naive_method: "block Lanczos with 8 vectors, until the modes wanted have converged",
        naive: format!("{copies} of 51 copies found"),
        ours: "51 copies, though 30 fewer modes were asked for".into(),
        error: Some(Bounded {
            found: frequencies.max(flexibility),
            bound: 1e-9,
        }),
    }
}

/// A nearly square bar: its two first bending frequencies differ by 1e-6, in one order or the other.
pub fn cluster_at_the_cut() -> HardCase {
    let flexibilities = [1e-6, -1e-6].map(|difference| {
        let bar = box_block(
            [6, 2, 2],
            [0.4, 0.1, 0.1 * (1.0 + difference)],
            SolidElement::Hexahedron,
            &Material::STEEL,
        );
        let oracle = Oracle::of(&bar);
        let element = lowest(&bar, 1).superelement;
        assert_eq!(element.mode_count(), 2);
        (oracle.residual_flexibility(1), element.residual.flexibility)
    });
    let [(plain_a, ours_a), (plain_b, ours_b)] = flexibilities;
    // The right end across, along y.
    let at = (7, 7);
    let ratio = plain_a[at] / plain_b[at];
    let jump = ratio.max(1.0 / ratio);
    assert!(jump > 2.0, "{jump}");
    HardCase {
        group: GROUP,
        name: "cluster_at_the_cut",
        naive_method: "one mode, as asked for",
        naive: format!(
            "F_res of an end jumps by a factor of {jump:.0} when a side changes by 2e-6"
        ),
        ours: "both modes kept; F_res changes as the side does".into(),
        error: Some(Bounded {
            found: scaled_difference(&ours_a, &ours_b, &diagonal_roots(&ours_b)),
            bound: 1e-4,
        }),
    }
}
