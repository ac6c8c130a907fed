//! Does every part, whatever its shape, satisfy the identities of the method, and stay the same part in other axes and another order?
//! The parts are random, the same ones every time.

use crate::identity_defects::{column_norms, identity_defects, modal_sum};
use dcb_formats::Component;
use dcb_formats::mesh::Dimension;
use dcb_reducer::Reduced;
use dcb_samples::spatial_beam::{BeamMass, BeamSection, BeamTheory, SpatialBeam};
use dcb_samples::{Material, RodSection, SolidElement};
use dcb_tests::dense::{diagonal_roots, relative, scaled_difference};
use dcb_tests::nodal::PAIRS;
use dcb_tests::random_parts::{Recipe, SpringMass, Springs, shuffled};
use dcb_tests::turned::{turned, turned_rows};
use dcb_tests::{lowest, parts};
use faer::Mat;
use nalgebra::{Matrix3, Rotation3, Vector3};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// The same parts every time, and no file about the last failure.
fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(20_260_701),
        max_shrink_iters: 64,
        ..ProptestConfig::default()
    }
}

/// Places of points that neither lie in a plane nor close together, before they are moved a little.
const PLACES: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.1],
    [0.2, 0.1, 1.0],
    [1.0, 1.0, 1.0],
    [1.3, 0.9, 0.1],
    [-0.1, 1.4, 1.2],
    [1.9, 0.2, 0.7],
];

fn springs() -> impl Strategy<Value = Recipe> {
    let numbers = (
        vec(-0.15..0.15_f64, 24),
        vec(4.0..6.0_f64, 28),
        vec(0.5..2.0_f64, 28),
    );
    (any::<bool>(), any::<bool>(), 5..=8_usize, numbers).prop_map(
        |(planar, lumped, count, (moves, exponents, masses))| {
            let point = |i: usize| std::array::from_fn(|a| PLACES[i][a] + moves[3 * i + a]);
            Recipe::Springs(Springs {
                dimension: match planar {
                    true => Dimension::Planar,
                    false => Dimension::Spatial,
                },
                points: (0..count).map(point).collect(),
                stiffness: exponents.iter().map(|e| 10.0_f64.powf(*e)).collect(),
                mass: match lumped {
                    true => SpringMass::Lumped(masses),
                    false => SpringMass::Consistent(masses),
                },
            })
        },
    )
}

fn rods() -> impl Strategy<Value = Recipe> {
    (1..=6_usize, 0.1..2.0_f64, 10.0..60.0_f64, -3.0..3.0_f64).prop_map(
        |(elements, length, slenderness, angle)| {
            let section = RodSection::round(length, length / slenderness, 0.2e12, 7870.0);
            Recipe::Rod(elements, RodSection { angle, ..section })
        },
    )
}

fn beams() -> impl Strategy<Value = Recipe> {
    let shape = (
        2..=5_usize,
        prop::array::uniform3(-0.5..0.5_f64),
        prop::array::uniform3(0.2..0.8_f64),
        -3.0..3.0_f64,
        (10.0..40.0_f64, 1.0..2.0_f64),
    );
    (shape, any::<bool>(), any::<bool>()).prop_map(
        |((elements, start, span, roll, (slenderness, ratio)), sheared, lumped)| {
            let width = Vector3::from(span).norm() / slenderness;
            Recipe::Beam(SpatialBeam {
                elements,
                start,
                end: std::array::from_fn(|a| start[a] + span[a]),
                roll,
                section: BeamSection::rectangle(width, width * ratio),
                material: Material::STEEL,
                theory: match sheared {
                    true => BeamTheory::Timoshenko,
                    false => BeamTheory::EulerBernoulli,
                },
                mass: match lumped {
                    true => BeamMass::LumpedWithRoll,
                    false => BeamMass::Consistent,
                },
            })
        },
    )
}

fn boxes() -> impl Strategy<Value = Recipe> {
    let element = prop::sample::select(vec![
        SolidElement::Hexahedron,
        SolidElement::Hexahedron20,
        SolidElement::Tetra,
        SolidElement::Tetra10,
    ]);
    let material = (9.0..11.5_f64, 0.0..0.4_f64, 1000.0..8000.0_f64).prop_map(
        |(exponent, poisson_ratio, density)| Material {
            youngs_modulus: 10.0_f64.powf(exponent),
            poisson_ratio,
            density,
        },
    );
    let cells = (1..=3_usize, 1..=2_usize, 1..=1_usize);
    let size = prop::array::uniform3(0.05..0.4_f64);
    (cells, size, element, material).prop_map(|(cells, size, element, material)| Recipe::Box {
        cells: cells.into(),
        size,
        element,
        material,
    })
}

fn recipes() -> impl Strategy<Value = Recipe> {
    prop_oneof![springs(), rods(), beams(), boxes()]
}

/// A share of all modes.
fn some_modes(component: &Component, share: f64) -> usize {
    (share * component.dofs.len() as f64).round() as usize
}

proptest! {
    #![proptest_config(config(96))]

    #[test]
    fn the_identities_of_the_method_hold(recipe in recipes(), share in 0.0..1.1_f64) {
        let component = recipe.component();
        let reduced = lowest(&component, some_modes(&component, share));
        let none = lowest(&component, 0);
        for defect in identity_defects(&component, &reduced, &none) {
            prop_assert!(defect.value < defect.limit, "{}: {:?}", defect.identity, defect);
        }
    }

    #[test]
    fn neither_order_nor_axes_change_the_part(
        recipe in recipes(),
        share in 0.0..0.7_f64,
        seed in 0..1000_u64,
        axis in prop::array::uniform3(-1.0..1.0_f64),
        by in prop::array::uniform3(-5.0..5.0_f64),
    ) {
        let component = recipe.component();
        let (turn, by) = match component.dimension() {
            Dimension::Planar => (Vector3::z() * axis[2], [by[0], by[1], 0.0]),
            Dimension::Spatial => (Vector3::from(axis), by),
        };
        let turn = Rotation3::new(3.0 * turn);
        let order = shuffled(component.mesh.node_count(), seed);
        let other = parts::renumbered(&turned(&component, &turn, by), &order);
        let count = some_modes(&component, share);
        let pair = Pair {
            here: lowest(&component, count),
            there: lowest(&other, count),
            none_there: lowest(&other, 0),
            turn,
            by: Vector3::from(by),
        };
        for (what, value) in pair.differences() {
            prop_assert!(value < 1e-8, "{} differ by {:e}", what, value);
        }
    }
}

/// A reduced part, and the same part in other axes.
struct Pair {
    here: Reduced,
    there: Reduced,
    none_there: Reduced,
    turn: Rotation3<f64>,
    by: Vector3<f64>,
}

impl Pair {
    /// Everything that has to agree, by name, without unit.
    fn differences(&self) -> Vec<(&'static str, f64)> {
        let (a, b) = (&self.here.superelement, &self.there.superelement);
        let roots = |values: &[f64]| values.iter().map(|v| v.sqrt()).collect::<Vec<_>>();
        let mut differences = vec![(
            "frequencies",
            relative(&roots(&b.modes.eigenvalues), &roots(&a.modes.eigenvalues)),
        )];
        differences.extend(self.rigid_inertia());
        differences.extend(self.residuals());
        differences.extend(self.invariants());
        differences
    }

    /// Largest moment of inertia, and the length of the part that follows from it.
    fn sizes(&self) -> (f64, f64) {
        let inertia = &self.here.superelement.inertia;
        let moment = (0..3).map(|a| inertia.tensor[a][a]).fold(0.0, f64::max);
        (moment, (moment / inertia.mass).sqrt())
    }

    /// R A Rᵀ
    fn turned(&self, tensor: &Matrix3<f64>) -> Matrix3<f64> {
        self.turn.matrix() * tensor * self.turn.matrix().transpose()
    }

    fn rigid_inertia(&self) -> Vec<(&'static str, f64)> {
        let (a, b) = (&self.here.superelement, &self.there.superelement);
        let (moment, length) = self.sizes();
        let tensor = |t: &[[f64; 3]; 3]| Matrix3::from_fn(|i, j| t[i][j]);
        let placed = self.turn * Vector3::from(a.origin) + self.by;
        let apart = Vector3::from(b.origin) - placed;
        let turned = self.turned(&tensor(&a.inertia.tensor));
        vec![
            ("masses", (b.inertia.mass / a.inertia.mass - 1.0).abs()),
            ("centres of mass", apart.norm() / length),
            (
                "inertia tensors",
                (tensor(&b.inertia.tensor) - turned).norm() / moment,
            ),
        ]
    }

    fn residuals(&self) -> Vec<(&'static str, f64)> {
        let (a, b) = (&self.here.superelement, &self.there.superelement);
        let rows = turned_rows(a, &self.turn);
        let seen = |matrix: &Mat<f64>| &rows * matrix * rows.transpose();
        let f0 = diagonal_roots(&self.none_there.superelement.residual.flexibility);
        let m0 = diagonal_roots(&self.none_there.superelement.residual.mass);
        let sum = seen(&modal_sum(&self.here, 2));
        vec![
            (
                "F_res",
                scaled_difference(&b.residual.flexibility, &seen(&a.residual.flexibility), &f0),
            ),
            (
                "M_res",
                scaled_difference(&b.residual.mass, &seen(&a.residual.mass), &m0),
            ),
            (
                "modal flexibilities",
                scaled_difference(&modal_sum(&self.there, 2), &sum, &f0),
            ),
        ]
    }

    /// J1, L3 and J2 of the attachments, whose columns turn with their rows; of the modes, which are any basis of the kept space,
    /// what no choice of it changes.
    fn invariants(&self) -> Vec<(&'static str, f64)> {
        let (a, b) = (&self.here.superelement, &self.there.superelement);
        let (n_k, rows) = (a.mode_count(), turned_rows(a, &self.turn));
        let n = a.basis_count();
        let (moment, _) = self.sizes();
        let norms = column_norms(&self.there, &self.none_there);
        let attached = |matrix: &Mat<f64>| {
            matrix
                .as_ref()
                .submatrix(n_k, n_k, n - n_k, n - n_k)
                .to_owned()
        };
        let first_order = |element: &dcb_formats::Superelement, k: usize| {
            Matrix3::from_fn(|i, j| element.inertia.i1[k][i][j])
        };
        let mut j1 = 0.0_f64;
        for k in 0..n - n_k {
            let mut sum = Matrix3::zeros();
            for l in 0..n - n_k {
                sum += first_order(a, n_k + l) * rows[(k, l)];
            }
            let apart = (first_order(b, n_k + k) - self.turned(&sum)).norm();
            j1 = j1.max(apart / (moment.sqrt() * norms[n_k + k].max(f64::MIN_POSITIVE)));
        }
        let squared = |element: &dcb_formats::Superelement| -> f64 {
            (0..n_k)
                .map(|k| first_order(element, k).norm_squared())
                .sum()
        };
        let coupling = |element: &dcb_formats::Superelement| -> f64 {
            let modal = element
                .inertia
                .l3
                .iter()
                .map(|l3| l3.as_ref().submatrix(0, 0, n_k, n_k).squared_norm_l2());
            modal.sum()
        };
        let scale = (n_k as f64).max(1.0);
        let mut differences = vec![
            ("J1 of the attachments", j1),
            (
                "sizes of J1 of the modes",
                (squared(a) - squared(b)).abs() / (moment * scale),
            ),
            (
                "sizes of L3 of the modes",
                (coupling(a) - coupling(b)).abs() / (scale * scale),
            ),
        ];
        let spatial = a.inertia.l3.len() == 3;
        for (axis, found) in b.inertia.l3.iter().enumerate() {
            let mut sum = Mat::zeros(n - n_k, n - n_k);
            for (other, l3) in a.inertia.l3.iter().enumerate() {
                let share = if spatial {
                    self.turn[(axis, other)]
                } else {
                    1.0
                };
                sum += &rows * attached(l3) * rows.transpose() * faer::Scale(share);
            }
            let apart = scaled_difference(&attached(found), &sum, &norms[n_k..]);
            differences.push(("L3 of the attachments", apart));
        }
        for (pair, found) in PAIRS.iter().zip(&b.inertia.i2) {
            let (mut sum, mut trace) = (Mat::zeros(n - n_k, n - n_k), 0.0);
            for c in 0..3 {
                for d in 0..3 {
                    let at = PAIRS.iter().position(|p| *p == (c, d) || *p == (d, c));
                    let old = &a.inertia.i2[at.expect("a pair of axes")];
                    let share = self.turn[(pair.0, c)] * self.turn[(pair.1, d)];
                    sum += &rows * attached(old) * rows.transpose() * faer::Scale(share);
                    trace += share * (0..n_k).map(|k| old[(k, k)]).sum::<f64>();
                }
            }
            let apart = scaled_difference(&attached(found), &sum, &norms[n_k..]);
            let modal: f64 = (0..n_k).map(|k| found[(k, k)]).sum();
            differences.push(("J2 of the attachments", apart));
            differences.push(("traces of J2 of the modes", (modal - trace).abs() / scale));
        }
        differences
    }
}
