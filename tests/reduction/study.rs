//! `reduce study` against dense algebra that shares nothing with it: complex solutions with the whole matrices at every frequency,
//! null spaces for held interfaces, projections of the whole matrices for the reduced parts.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use dcb_formats::Component;
use dcb_formats::report::{Ledger, Start};
use dcb_reducer::memory_limit::MemoryLimit;
use dcb_reducer::study::progress::Progress;
use dcb_reducer::study::record::{Entry, Measure, Row};
use dcb_reducer::study::reference::{BandChoice, Reference};
use dcb_reducer::study::sweep::Sweep;
use dcb_reducer::study::variant::Variant;
use dcb_reducer::study::{Study, recorded, run};
use dcb_reducer::timing::Display;
use dcb_samples::SolidElement;
use dcb_tests::dense::{dense, eigen, solve, symmetric};
use dcb_tests::localization::localization;
use dcb_tests::oracle::{Oracle, centre_of_mass, rigid_motions};
use dcb_tests::{lowest, parts};
use faer::linalg::solvers::Solve as _;
use faer::{Mat, Side, c64};

const LOSS_FACTOR: f64 = 0.02;
const POINTS: usize = 40;

/// A box of 60 dofs with a frame at each end.
fn part() -> Component {
    parts::steel_box([4, 1, 1], SolidElement::Hexahedron)
}

fn study(modes: &[usize], band: BandChoice) -> Study {
    Study {
        sweep: Sweep {
            modes: modes.to_vec(),
            variants: Variant::ALL.to_vec(),
            interface_modes: Vec::new(),
        },
        band,
        points: POINTS,
        loss_factor: LOSS_FACTOR,
        memory: MemoryLimit::default(),
    }
}

fn rows(component: &Component, study: &Study) -> Vec<Row> {
    let folder = tempfile::tempdir().unwrap();
    let settings = serde_json::Value::Null;
    let path = folder.path().join("rows.jsonl");
    let mut ledger: Ledger<Entry> =
        Ledger::open(&path, "reduction", &settings, Start::Anew).unwrap();
    let mut progress = Progress::new(Display::Silent, std::iter::empty());
    let scratch = folder.path().join("scratch.dcb.h5");
    let complete = Default::default();
    run(
        study,
        component,
        &mut ledger,
        &scratch,
        &mut progress,
        &complete,
    )
    .unwrap();
    recorded(study, &ledger).unwrap().1
}

/// Dense matrices of a part, whole or projected, and what its interfaces see of its coordinates.
struct Dense {
    stiffness: Mat<f64>,
    mass: Mat<f64>,
    interface: Mat<f64>,
    /// Flexibility and, per λ, mass that follow without coordinates.
    constant: Mat<f64>,
    linear: Mat<f64>,
}

impl Dense {
    fn whole(component: &Component) -> Self {
        let interface = localization(component);
        let zero = Mat::zeros(interface.nrows(), interface.nrows());
        Self {
            stiffness: dense(&component.stiffness),
            mass: dense(&component.mass),
            interface,
            constant: zero.clone(),
            linear: zero,
        }
    }

    /// `whole` over rigid motions, modes and (strong) attachments of a reduction with this number of modes.
    fn reduced(component: &Component, variant: Variant, modes: usize) -> Self {
        let whole = Self::whole(component);
        let reduced = lowest(component, modes);
        let rigid = rigid_motions(component, centre_of_mass(component).1);
        let residual = &reduced.recovery.residual;
        let attached = residual * &reduced.superelement.residual.transform;
        let mut columns = vec![rigid, reduced.recovery.modes.clone()];
        if variant == Variant::Strong {
            columns.push(attached);
        }
        let count = columns.iter().map(Mat::ncols).sum();
        let mut basis = Mat::zeros(whole.stiffness.nrows(), count);
        let mut at = 0;
        for block in &columns {
            for j in 0..block.ncols() {
                // Columns of one size, so that the projected matrices are well scaled.
                let norm = block.col(j).norm_l2();
                for i in 0..block.nrows() {
                    basis[(i, at)] = block[(i, j)] / norm;
                }
                at += 1;
            }
        }
        let n_b = whole.interface.nrows();
        let (constant, linear) = match variant {
            Variant::Strong | Variant::Free => (Mat::zeros(n_b, n_b), Mat::zeros(n_b, n_b)),
            Variant::Static => (&whole.interface * residual, Mat::zeros(n_b, n_b)),
            Variant::Weak => (
                &whole.interface * residual,
                residual.transpose() * &whole.mass * residual,
            ),
        };
        Self {
            stiffness: basis.transpose() * &whole.stiffness * &basis,
            mass: basis.transpose() * &whole.mass * &basis,
            interface: &whole.interface * &basis,
            constant,
            linear,
        }
    }

    /// H(ω) = L (K (1 + iη) - ω² M)⁻¹ Lᵀ, rows scaled.
    fn response(&self, square: f64, scale: &[f64]) -> Mat<c64> {
        let damped = c64::new(1.0, LOSS_FACTOR);
        let lambda = c64::new(square, 0.0) / damped;
        let n = self.stiffness.nrows();
        let real = |value: f64| c64::new(value, 0.0);
        let matrix = Mat::from_fn(n, n, |i, j| {
            damped * self.stiffness[(i, j)] - real(square * self.mass[(i, j)])
        });
        let n_b = self.interface.nrows();
        let forces = Mat::from_fn(n, n_b, |i, j| real(self.interface[(j, i)]));
        let lu = matrix.partial_piv_lu();
        let mut motion = lu.solve(&forces);
        let left = &forces - &matrix * &motion;
        motion += lu.solve(&left);
        let seen = Mat::from_fn(n_b, n, |i, j| real(self.interface[(i, j)])) * motion;
        Mat::from_fn(n_b, n_b, |i, j| {
            let follows = real(self.constant[(i, j)]) + lambda * self.linear[(i, j)];
            (seen[(i, j)] + follows / damped) * scale[i] * scale[j]
        })
    }

    /// ω² with L u = 0, ascending; with a compliance between coordinates and ground where there is one.
    fn held(&self, scale: &[f64]) -> Vec<f64> {
        let n = self.stiffness.nrows();
        let interface = Mat::from_fn(scale.len(), n, |i, j| scale[i] * self.interface[(i, j)]);
        let (stiffness, motions) = if self.constant.norm_max() > 0.0 {
            let compliance = Mat::from_fn(scale.len(), scale.len(), |i, j| {
                scale[i] * self.constant[(i, j)] * scale[j]
            });
            let springs = interface.transpose() * solve(&symmetric(&compliance), &interface);
            (&self.stiffness + springs, dcb_tests::dense::identity(n))
        } else {
            let rank = scale.len().min(n);
            let q = interface.transpose().qr().compute_Q();
            let motions = q.subcols(rank, n - rank).to_owned();
            (self.stiffness.clone(), motions)
        };
        if motions.ncols() == 0 {
            return Vec::new();
        }
        let projected = |matrix: &Mat<f64>| symmetric(&(motions.transpose() * matrix * &motions));
        let root = projected(&self.mass)
            .llt(Side::Lower)
            .unwrap()
            .L()
            .to_owned();
        let half = solve(&root, &projected(&stiffness));
        let whole = solve(&root, &half.transpose().to_owned());
        eigen(&symmetric(&whole)).0
    }
}

/// One over the root of a row's flexibility with the inertia relieved, plus the square of its rigid motion over ω₁².
fn scale(component: &Component, oracle: &Oracle) -> Vec<f64> {
    let l = &oracle.localization;
    let flexibility = l * &oracle.inverse * l.transpose();
    let x = &oracle.rigid;
    let inertia = x.transpose() * &oracle.mass * x;
    let seen = l * x;
    let moved = &seen * solve(&inertia, &seen.transpose().to_owned());
    assert_eq!(component.dofs.len(), oracle.mass.nrows());
    (0..l.nrows())
        .map(|i| 1.0 / (flexibility[(i, i)] + moved[(i, i)] / oracle.eigenvalues[0]).sqrt())
        .collect()
}

/// Frobenius norm over the blocks on the diagonal, of six rows each, or over the others.
fn norm(h: &Mat<c64>, diagonal: bool) -> f64 {
    let mut sum = 0.0;
    for j in 0..h.ncols() {
        for i in 0..h.nrows() {
            if (i / 6 == j / 6) == diagonal {
                sum += h[(i, j)].norm_sqr();
            }
        }
    }
    sum.sqrt()
}

#[test]
fn the_reference_is_the_whole_part() {
    let component = part();
    let oracle = Oracle::of(&component);
    let scale = scale(&component, &oracle);
    let whole = Dense::whole(&component);
    // Far above the modes asked for, and within them.
    for (modes, band) in [
        (
            4,
            BandChoice::Between {
                from: 0.3 * oracle.eigenvalues[0],
                to: 0.9 * oracle.eigenvalues[9],
            },
        ),
        (8, BandChoice::HalfOfHighest),
    ] {
        let memory = MemoryLimit::default();
        let reference =
            Reference::compute(&component, modes, band, POINTS, &memory, &mut ()).unwrap();
        assert!(reference.residual < 1e-9, "{:e}", reference.residual);
        assert_eq!(reference.loose, 0);
        let damped = c64::new(1.0, LOSS_FACTOR);
        for (square, lambda) in
            (reference.band.squares.iter()).zip(reference.band.damped(LOSS_FACTOR))
        {
            let expected = whole.response(*square, &scale);
            let found = reference.response.at(lambda);
            let mut worst = 0.0_f64;
            for j in 0..12 {
                for i in 0..12 {
                    worst = worst.max(
                        (found[(i, j)] / damped - expected[(i, j)])
                            .norm_sqr()
                            .sqrt(),
                    );
                }
            }
            let error = worst / expected.norm_max();
            assert!(error < 1e-9, "ω² = {square:e}: {error:e}");
        }
        let held: Vec<f64> = whole.held(&scale);
        let below = held.iter().filter(|value| **value < reference.band.top());
        let below: Vec<f64> = below.copied().collect();
        assert_eq!(reference.held.len(), below.len());
        for (found, expected) in reference.held.iter().zip(&below) {
            assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
        }
        let elastic = reference.flexibility.diagonal().column_vector().to_owned();
        let l = &oracle.localization;
        let flexibility = l * &oracle.inverse * l.transpose();
        for i in 0..12 {
            let expected = scale[i] * flexibility[(i, i)] * scale[i];
            assert!((elastic[i] - expected).abs() < 1e-10, "row {i}");
        }
    }
}

#[test]
fn every_error_is_that_of_a_projection_of_the_whole_matrices() {
    let component = part();
    let oracle = Oracle::of(&component);
    let scale = scale(&component, &oracle);
    let whole = Dense::whole(&component);
    let modes = [4, 10];
    let study = study(&modes, BandChoice::HalfOfHighest);
    let memory = MemoryLimit::default();
    let reference =
        Reference::compute(&component, 10, study.band, POINTS, &memory, &mut ()).unwrap();
    let exact: Vec<Mat<c64>> = (reference.band.squares.iter())
        .map(|square| whole.response(*square, &scale))
        .collect();
    let held = whole.held(&scale);
    let rows = rows(&component, &study);
    assert_eq!(rows.len(), 8);
    for row in &rows {
        assert_eq!(row.modes, row.asked_modes, "no multiple root is cut here");
        let reduced = Dense::reduced(&component, row.variant, row.modes);
        let (mut collocated, mut transfer, mut force) = (0.0_f64, 0.0_f64, 0.0_f64);
        for (square, exact) in reference.band.squares.iter().zip(&exact) {
            let found = reduced.response(*square, &scale);
            let difference = &found - exact;
            collocated = collocated.max(norm(&difference, true) / norm(exact, true));
            transfer = transfer.max(norm(&difference, false) / norm(exact, false));
            let unit = Mat::from_fn(12, 12, |i, j| c64::new(f64::from(u8::from(i == j)), 0.0));
            let stiffness = exact.partial_piv_lu().solve(&unit);
            let off = found.partial_piv_lu().solve(&unit) - &stiffness;
            force = force.max(off.norm_l2() / stiffness.norm_l2());
        }
        let agree = |what: &str, found: f64, expected: f64| {
            let limit = 1e-8 + 1e-6 * expected;
            assert!(
                (found - expected).abs() < limit,
                "{}: {what} {found:e}, dense {expected:e}",
                row.title()
            );
        };
        agree("collocated", row.errors.collocated.largest, collocated);
        agree("transfer", row.errors.transfer.unwrap().largest, transfer);
        match row.errors.interface_force {
            Some(found) => agree("force", found.largest, force),
            // Ten freedoms can't move twelve rows.
            None => assert!(row.variant == Variant::Free && row.modes == 4),
        }
        if row.variant == Variant::Weak {
            continue;
        }
        let found = row.errors.held_frequencies.as_ref().unwrap();
        let reduced = reduced.held(&scale);
        for (index, found) in found.iter().enumerate() {
            let expected = match reduced.get(index) {
                Some(value) => (value / held[index]).sqrt() - 1.0,
                None => 1.0,
            };
            agree("held frequency", *found, expected.abs());
        }
    }
}

#[test]
fn errors_follow_the_order_of_each_form() {
    let component = part();
    // Up to half the highest mode of the smallest row, as the rule goes for all of them.
    let to = 0.25 * Oracle::of(&component).eigenvalues[5];
    let from = to / (POINTS * POINTS) as f64;
    let study = study(&[6, 12, 20], BandChoice::Between { from, to });
    let rows = rows(&component, &study);
    let of = |variant: Variant| -> Vec<&Row> {
        rows.iter().filter(|row| row.variant == variant).collect()
    };
    for variant in [Variant::Strong, Variant::Static, Variant::Weak] {
        for row in of(variant) {
            let error = row.error(Measure::StaticResponse).unwrap();
            assert!(error < 1e-10, "{}: static {error:e}", row.title());
        }
    }
    for row in of(Variant::Free) {
        assert!(row.error(Measure::StaticResponse).unwrap() > 1e-3);
    }
    for measure in [Measure::CollocatedResponse, Measure::TransferResponse] {
        let errors = |variant| -> Vec<f64> {
            (of(variant).iter())
                .map(|row| row.error(measure).unwrap())
                .collect()
        };
        let (strong, fixed) = (errors(Variant::Strong), errors(Variant::Static));
        for index in 0..3 {
            assert!(strong[index] < fixed[index], "{strong:?} {fixed:?}");
        }
        assert!(
            strong[2] < strong[0] && fixed[2] < fixed[0],
            "{strong:?} {fixed:?}"
        );
    }
    // Far below the first mode the rigid motion rules, H ~ 1/λ: what is left out of H at the order λ (static), λ² (strong)
    // is an error of the order ω⁴, ω⁶.
    let points: Vec<f64> = (1..=POINTS)
        .map(|point| point as f64 / POINTS as f64)
        .collect();
    let (low, high) = (1, 3);
    let step = (points[high] / points[low]).log2();
    for (variant, order) in [
        (Variant::Static, 4.0),
        (Variant::Strong, 6.0),
        (Variant::Weak, 6.0),
    ] {
        let row = of(variant)[0];
        let at = |index: usize| row.curves.error[index].unwrap();
        let found = (at(high) / at(low)).log2() / step;
        assert!(
            (found - order).abs() < 0.4,
            "{}: order {found}",
            row.title()
        );
    }
}
