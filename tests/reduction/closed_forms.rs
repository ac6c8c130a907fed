//! Does the reduction approach what mechanics gives in closed form, at the order that the elements promise?
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::needless_range_loop
)]

use std::f64::consts::PI;

use dcb_samples::solid::solid_component;
use dcb_samples::{Material, RodSection, SolidElement, box_block};
use dcb_tests::{lowest, parts};

/// Roots of cos β cosh β = 1.
const FREE_FREE: [f64; 3] = [
    4.730_040_744_862_704,
    7.853_204_624_095_838,
    10.995_607_838_001_671,
];

fn omegas(elements: usize) -> Vec<f64> {
    lowest(&parts::rod(elements), 3 * elements)
        .superelement
        .modes
        .eigenvalues
        .iter()
        .map(|v| v.sqrt())
        .collect()
}

fn nearest(values: &[f64], target: f64) -> f64 {
    *values
        .iter()
        .min_by(|a, b| (*a - target).abs().total_cmp(&(*b - target).abs()))
        .unwrap()
}

fn order(errors: &[f64]) -> Vec<f64> {
    errors
        .windows(2)
        .map(|pair| (pair[0] / pair[1]).log2())
        .collect()
}

#[test]
fn bending_frequencies_converge_with_order_four_and_from_above() {
    let rod = RodSection::default();
    let speed = (rod.youngs_modulus * rod.second_moment / (rod.density * rod.area)).sqrt();
    for (mode, root) in FREE_FREE.iter().enumerate() {
        let exact = (root / rod.length).powi(2) * speed;
        let errors: Vec<f64> = [4, 8, 16]
            .iter()
            .map(|n| omegas(*n)[mode] / exact - 1.0)
            .collect();
        assert!(errors.iter().all(|error| *error > 0.0), "{errors:?}");
        // Only for the first mode are four elements in the asymptotic range.
        let orders = order(&errors[usize::from(mode > 0)..]);
        assert!(
            orders.iter().all(|order| (order - 4.0).abs() < 0.25),
            "mode {mode}: {orders:?} {errors:?}"
        );
    }
}

#[test]
fn axial_frequencies_converge_with_order_two() {
    let rod = RodSection::default();
    let exact = PI / rod.length * (rod.youngs_modulus / rod.density).sqrt();
    let errors: Vec<f64> = [4, 8, 16]
        .iter()
        .map(|n| nearest(&omegas(*n), exact * (1.0 + 0.4 / (*n * n) as f64)) / exact - 1.0)
        .collect();
    // Linear elements with consistent mass: ω²h² = 6 (1 - cos kh)/(2 + cos kh) E/ρ, so the error is (kh)²/24.
    for (error, n) in errors.iter().zip([4.0, 8.0, 16.0]) {
        let expected = (PI / n).powi(2) / 24.0;
        assert!((error / expected - 1.0).abs() < 0.05, "{error} {expected}");
    }
    assert!(
        order(&errors)
            .iter()
            .all(|order| (order - 2.0).abs() < 0.05)
    );
}

#[test]
fn a_free_bar_pulled_at_its_end_stretches_as_inertia_relief_says() {
    let rod = RodSection::default();
    let stiffness = rod.youngs_modulus * rod.area;
    for n in [1, 2, 4, 8, 16] {
        let f = lowest(&parts::rod(n), 0).superelement.residual.flexibility;
        // Uniform deceleration: u(0) - u(L) = L/(2EA) exactly, F_11 = L/(3EA), F_12 = -L/(6EA) up to how linear
        // elements see the mean of a parabola.
        let between = f[(0, 0)] - f[(0, 2)];
        assert!(
            (between / (rod.length / (2.0 * stiffness)) - 1.0).abs() < 1e-10,
            "{n} elements"
        );
        let expected = rod.length / (3.0 * stiffness) * (1.0 - 0.25 / (n * n) as f64);
        assert!(
            (f[(0, 0)] / expected - 1.0).abs() < 1e-10,
            "{n} elements: {} {expected}",
            f[(0, 0)]
        );
    }
    // Bending: tip deflection under a tip force, L³/(105 EI) for inertia relief of a uniform beam.
    let f = lowest(&parts::rod(16), 0).superelement.residual.flexibility;
    let expected = rod.length.powi(3) / (105.0 * rod.youngs_modulus * rod.second_moment);
    assert!(
        (f[(1, 1)] / expected - 1.0).abs() < 1e-4,
        "{} {expected}",
        f[(1, 1)]
    );
}

#[test]
fn quadratic_hexahedra_converge_from_above() {
    let first = |n: usize| {
        let block = box_block(
            [4 * n, n, n],
            [0.4, 0.1, 0.08],
            SolidElement::Hexahedron20,
            &Material::STEEL,
        );
        lowest(&block, 1).superelement.modes.eigenvalues[0].sqrt()
    };
    let (coarse, middle, fine) = (first(1), first(2), first(4));
    assert!(coarse > middle && middle > fine, "{coarse} {middle} {fine}");
    let order = ((coarse - middle) / (middle - fine)).log2();
    assert!((2.5..5.5).contains(&order), "order {order}");
    // A Timoshenko beam of these proportions: 0.4 % is what warping and the anticlastic curvature leave.
    assert!((middle / fine - 1.0) < 2e-3);
}

#[test]
fn a_box_has_the_inertia_of_a_box() {
    let [a, b, c] = [0.4, 0.1, 0.08];
    for element in [
        SolidElement::Hexahedron,
        SolidElement::Hexahedron20,
        SolidElement::Tetra,
        SolidElement::Tetra10,
    ] {
        let inertia = lowest(
            &box_block([2, 1, 1], [a, b, c], element, &Material::STEEL),
            0,
        )
        .superelement
        .inertia;
        let mass = a * b * c * Material::STEEL.density;
        assert!((inertia.mass / mass - 1.0).abs() < 1e-13);
        let expected = [b * b + c * c, a * a + c * c, a * a + b * b].map(|sum| mass * sum / 12.0);
        for (i, row) in inertia.tensor.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                let target = if i == j { expected[i] } else { 0.0 };
                assert!(
                    (value - target).abs() < 1e-12 * expected[2],
                    "I({i}, {j}) of {element:?}"
                );
            }
        }
    }
}

#[test]
fn a_ball_has_the_inertia_of_a_ball() {
    let radius = 0.05;
    let error = |n: usize| {
        let mut mesh = box_block(
            [n; 3],
            [2.0; 3],
            SolidElement::Hexahedron20,
            &Material::STEEL,
        )
        .into_draft()
        .mesh;
        for point in mesh.coordinates.chunks_exact_mut(3) {
            let [x, y, z] = [point[0] - 1.0, point[1] - 1.0, point[2] - 1.0];
            let stretch =
                |b: f64, c: f64| (1.0 - b * b / 2.0 - c * c / 2.0 + b * b * c * c / 3.0).sqrt();
            // Away from the origin, so that the centre of mass has to be found.
            point[0] = 0.3 + radius * x * stretch(y, z);
            point[1] = -0.2 + radius * y * stretch(z, x);
            point[2] = 0.1 + radius * z * stretch(x, y);
        }
        mesh.point_sets.clear();
        let element = lowest(
            &solid_component("ball", mesh, &Material::STEEL, Vec::new()),
            0,
        )
        .superelement;
        for (found, placed) in element.origin.iter().zip([0.3, -0.2, 0.1]) {
            assert!((found - placed).abs() < 1e-12);
        }
        let mass = 4.0 / 3.0 * PI * radius.powi(3) * Material::STEEL.density;
        let moments = [0, 1, 2].map(|i| element.inertia.tensor[i][i]);
        assert!(
            moments
                .iter()
                .all(|moment| (moment / moments[0] - 1.0).abs() < 1e-12)
        );
        assert!((0..9).all(|at| at / 3 == at % 3
            || element.inertia.tensor[at / 3][at % 3].abs() < 1e-12 * moments[0]));
        (
            (element.inertia.mass / mass - 1.0).abs(),
            (moments[0] / (0.4 * mass * radius * radius) - 1.0).abs(),
        )
    };
    let (coarse, fine) = (error(2), error(4));
    assert!(fine.0 < 2e-3 && fine.1 < 3e-3, "{coarse:?} {fine:?}");
    assert!(
        fine.0 < coarse.0 / 6.0 && fine.1 < coarse.1 / 6.0,
        "{coarse:?} {fine:?}"
    );
}
