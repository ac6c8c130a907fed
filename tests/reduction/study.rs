//! `reduce study` against dense algebra that shares nothing with it: complex solutions with the whole matrices at every frequency,
//! null spaces for held interfaces, projections of the whole matrices for the reduced parts.

use dcb_formats::Component;
use dcb_formats::mesh::Direction;
use dcb_reducer::EnrichmentSource::{Krylov, Spin};
use dcb_reducer::resources::memory_limit::MemoryLimit;
use dcb_reducer::{Reduced, Reduction};
use dcb_report::{Ledger, Start};
use dcb_runtime::{Compatibility, FlexibleBody};
use dcb_samples::SolidElement;
use dcb_tests::dense::{dense, eigen, solve, symmetric};
use dcb_tests::localization::localization;
use dcb_tests::oracle::{Oracle, centre_of_mass, rigid_motions};
use dcb_tests::{parts, with};
use dcb_workflow::part_study::progress::Progress;
use dcb_workflow::part_study::record::{ComponentEntry, ComponentRow, Measure};
use dcb_workflow::part_study::reference::{BandChoice, ComponentReference};
use dcb_workflow::part_study::sources::Sources;
use dcb_workflow::part_study::sweep::Sweep;
use dcb_workflow::part_study::variant::Variant;
use dcb_workflow::part_study::{ComponentStudy, recorded, run};
use dcb_workflow::progress_bar::Display;
use dcb_workflow::shard::Shard;
use faer::linalg::solvers::Solve as _;
use faer::{Mat, Side, c64};

const LOSS_FACTOR: f64 = 0.02;
const POINTS: usize = 40;

/// A box of 60 dofs with a frame at each end.
fn part() -> Component {
    parts::steel_box([4, 1, 1], SolidElement::Hexahedron)
}

fn study(modes: &[usize], band: BandChoice) -> ComponentStudy {
    ComponentStudy {
        sweep: Sweep {
            modes: modes.to_vec(),
            variants: Variant::ALL.to_vec(),
            interface_modes: Vec::new(),
            enrichments: [&[Krylov][..], &[Spin], &[Spin, Krylov]]
                .map(Sources::of)
                .to_vec(),
        },
        band,
        points: POINTS,
        loss_factor: LOSS_FACTOR,
        memory: MemoryLimit::default(),
        shard: Shard::WHOLE,
    }
}

fn rows(component: &Component, study: &ComponentStudy) -> Vec<ComponentRow> {
    let folder = tempfile::tempdir().unwrap();
    let settings = serde_json::Value::Null;
    let path = folder.path().join("rows.jsonl");
    let mut ledger: Ledger<ComponentEntry> =
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

    /// `whole` over rigid motions, modes and (strong) attachments and further columns of a row's reduction.
    fn reduced(component: &Component, row: &ComponentRow) -> Self {
        let whole = Self::whole(component);
        let (variant, reduced) = (row.variant, reduction(component, row));
        let rigid = rigid_motions(component, centre_of_mass(component).1);
        let residual = &reduced.recovery.residual;
        let attached = residual * &reduced.superelement.residual.transform;
        let mut columns = vec![rigid, reduced.recovery.modes.clone()];
        if variant == Variant::Strong {
            columns.push(attached);
            columns.extend(reduced.recovery.enrichment.clone());
        }
        let basis = orthonormal(&columns, &whole.mass);
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

/// Gram and Schmidt, twice, in the norm of a matrix; without columns of which less than 1e-10 of that norm squared is their own.
fn orthonormal(blocks: &[Mat<f64>], metric: &Mat<f64>) -> Mat<f64> {
    let n = metric.nrows();
    let mut basis = Mat::zeros(n, 0);
    for block in blocks {
        for j in 0..block.ncols() {
            let column = block.subcols(j, 1).to_owned();
            let square = |u: &Mat<f64>| (u.transpose() * metric * u)[(0, 0)];
            let mut own = column.clone();
            for _ in 0..2 {
                own -= &basis * (basis.transpose() * (metric * &own));
            }
            if square(&own) > 1e-10 * square(&column) {
                let own = faer::Scale(1.0 / square(&own).sqrt()) * own;
                basis = faer::concat![[basis, own]];
            }
        }
    }
    basis
}

/// The reduction that a row was made with.
fn reduction(component: &Component, row: &ComponentRow) -> Reduced {
    let options = Reduction {
        enrichment: row.enrichment.as_slice().to_vec(),
        ..Reduction::lowest(row.asked_modes)
    };
    with(component, &options)
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
            ComponentReference::compute(&component, modes, band, POINTS, &memory, &mut ()).unwrap();
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
        ComponentReference::compute(&component, 10, study.band, POINTS, &memory, &mut ()).unwrap();
    let exact: Vec<Mat<c64>> = (reference.band.squares.iter())
        .map(|square| whole.response(*square, &scale))
        .collect();
    let held = whole.held(&scale);
    let rows = rows(&component, &study);
    assert_eq!(rows.len(), 14);
    for row in &rows {
        assert_eq!(row.modes, row.asked_modes, "no multiple root is cut here");
        let reduced = Dense::reduced(&component, row);
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
            // Ten degrees of freedom can't move twelve rows.
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
    let of_form = |form: &str| -> Vec<&ComponentRow> {
        rows.iter().filter(|row| row.form() == form).collect()
    };
    let of = |variant: Variant| of_form(variant.name());
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
    } // Two blocks of a Krylov space leave out λ⁴, an error of the order ω¹⁰; nearer to zero it is rounding.
    let row = of_form("strong+krylov")[0];
    let at = |index: usize| row.curves.error[index].unwrap();
    let (low, high) = (11, 17);
    let found = (at(high) / at(low)).log2() / (points[high] / points[low]).log2();
    println!("{:e} {:e} {found}", at(low), at(high));
    assert!((found - 10.0).abs() < 0.6, "order {found}");
}

/// A reader of the file has as many coordinates as a row says, and its frequencies are those that the row's poles have.
#[test]
fn unknowns_are_the_coordinates_of_a_simulation() {
    let component = part();
    for row in rows(&component, &study(&[4, 10], BandChoice::HalfOfHighest)) {
        let compatibility = match row.variant {
            Variant::Strong => Compatibility::Strong,
            Variant::Static => Compatibility::Static,
            Variant::Weak => Compatibility::Weak,
            Variant::Free => continue,
        };
        let element = reduction(&component, &row).superelement;
        let body = FlexibleBody::from_superelement(&element, compatibility).unwrap();
        assert_eq!(row.unknowns, body.coordinate_count(), "{}", row.title());
        if let Some(error) = row.errors.next_free_frequency {
            let lowest = body.stiffness[row.modes..].iter().copied();
            let lowest = lowest.fold(f64::INFINITY, f64::min);
            let exact = Oracle::of(&component).eigenvalues[row.modes];
            let expected = (lowest / exact).sqrt() - 1.0;
            assert!(
                (error - expected).abs() < 1e-8,
                "{}: {error:e} {expected:e}",
                row.title()
            );
        }
    }
}

/// What modes and further columns lack of u = G f, f = M S r, in the norm of strain energy: least squares over all dofs.
#[test]
fn what_a_basis_lacks_of_the_response_to_spin_is_that_of_the_whole_part() {
    let component = part();
    let oracle = Oracle::of(&component);
    let (_, centre) = centre_of_mass(&component);
    let patterns: Vec<Mat<f64>> = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)]
        .iter()
        .map(|(a, b)| {
            let field = Mat::from_fn(component.dofs.len(), 1, |row, _| {
                let dof = component.dofs.dof(row).unwrap();
                let r = component.mesh.position(dof.node);
                let along = |c: usize, d: usize| match dof.direction == Direction::ALL[c] {
                    true => r[d] - centre[d],
                    false => 0.0,
                };
                along(*a, *b) + if a == b { 0.0 } else { along(*b, *a) }
            });
            let response = &oracle.inverse * (&oracle.mass * field);
            let norm = (response.transpose() * &oracle.mass * &response)[(0, 0)].sqrt();
            faer::Scale(1.0 / norm) * response
        })
        .collect();
    let energy = |u: &Mat<f64>| (u.transpose() * &oracle.stiffness * u)[(0, 0)];
    let rows = rows(&component, &study(&[4, 10], BandChoice::HalfOfHighest));
    for row in &rows {
        let recovery = reduction(&component, row).recovery;
        let blocks = [Some(&recovery.modes), recovery.enrichment.as_ref()];
        let blocks: Vec<Mat<f64>> = blocks.into_iter().flatten().cloned().collect();
        let basis = orthonormal(&blocks, &oracle.stiffness);
        let beyond = |u: &Mat<f64>| {
            let once = u - &basis * (basis.transpose() * (&oracle.stiffness * u));
            &once - &basis * (basis.transpose() * (&oracle.stiffness * &once))
        };
        let lacking: f64 = patterns.iter().map(|u| energy(&beyond(u))).sum();
        let whole: f64 = patterns.iter().map(energy).sum();
        let expected = (lacking / whole).sqrt();
        let found = row.spin_error.unwrap();
        println!("{}: {found:.3e} {expected:.3e}", row.title());
        assert!(
            (found - expected).abs() < 1e-7 + 1e-6 * expected,
            "{}: {found:e} {expected:e}",
            row.title()
        );
        let has_columns = row.enrichment.as_slice().contains(&Spin);
        assert_eq!(found < 1e-6, has_columns, "{}", row.title());
    }
}
