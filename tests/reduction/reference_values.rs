//! Does the reduction give the numbers that independent programs gave?
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::needless_range_loop
)]

use dcb_formats::Component;
use dcb_samples::{reference_hexahedra, reference_tetrahedra};
use dcb_tests::dense::{diagonal_roots, relative, scaled_difference};
use dcb_tests::reference::{matrix, numbers, reference};
use dcb_tests::{lowest, parts};
use faer::Mat;

/// The reference files hold twelve digits.
const DIGITS: f64 = 1e-11;

fn frequencies(eigenvalues: &[f64]) -> Vec<f64> {
    eigenvalues.iter().map(|value| value.sqrt()).collect()
}

#[test]
fn planar_rods() {
    let file = reference("ref_planar.json");
    for elements in [1, 2, 4, 8, 16] {
        let expected = &file["invariants"][elements.to_string()];
        let omega = numbers(&expected["omega"]);
        let all = lowest(&parts::rod(elements), omega.len()).superelement;
        // Rounding in K reaches the first frequency of 16 elements with 3e-11.
        assert!(
            relative(&frequencies(&all.modes.eigenvalues), &omega) < 2e-10,
            "{elements} elements"
        );
        assert!((all.inertia.mass / expected["m"].as_f64().unwrap() - 1.0).abs() < 1e-13);
        assert!((all.inertia.tensor[2][2] / expected["Iz"].as_f64().unwrap() - 1.0).abs() < 1e-12);
        let none = lowest(&parts::rod(elements), 0).superelement.residual;
        let (f, m) = (
            matrix(&expected["F_full"], 4),
            matrix(&expected["Mres_nk0"], 4),
        );
        assert!(
            scaled_difference(&none.flexibility, &f, &diagonal_roots(&f)) < 1e-10,
            "{elements} elements"
        );
        assert!(
            scaled_difference(&none.mass, &m, &diagonal_roots(&m)) < 1e-10,
            "{elements} elements"
        );
        let first = numbers(&expected["I1Phi_abs_first8"]);
        for (k, value) in first.iter().enumerate() {
            assert!(
                (all.inertia.i1[k][2][2].abs() - value).abs() < 1e-11,
                "I1 of mode {k}, {elements} elements"
            );
        }
        let l3 = matrix(&expected["L3modal_abs_first8"], first.len());
        for j in 0..first.len() {
            for i in 0..first.len() {
                let found = all.inertia.l3[0][(i, j)].abs();
                assert!(
                    (found - l3[(i, j)]).abs() < 1e-9,
                    "L3({i}, {j}) of {elements} elements: {found} {}",
                    l3[(i, j)]
                );
            }
        }
    }
}

#[test]
fn residuals_of_the_rod_for_every_number_of_modes() {
    let file = reference("ref_planar.json");
    let expected = &file["invariants"]["4"]["residual"];
    let rod = parts::rod(4);
    let whole = lowest(&rod, 0).superelement.residual;
    for kept in [0, 1, 2, 3, 5, 8, 9, 12] {
        let found = lowest(&rod, kept).superelement.residual;
        let here = &expected[kept.to_string()];
        let (f, m) = (matrix(&here["F_res"], 4), matrix(&here["M_res"], 4));
        // The reference subtracts modes from the whole, so it is as accurate as the whole is large.
        let (scale_f, scale_m) = (
            diagonal_roots(&whole.flexibility),
            diagonal_roots(&whole.mass),
        );
        assert!(
            scaled_difference(&found.flexibility, &f, &scale_f) < 1e-10,
            "F_res with {kept} modes"
        );
        assert!(
            scaled_difference(&found.mass, &m, &scale_m) < 1e-10,
            "M_res with {kept} modes"
        );
        let sigma = numbers(&here["sigma"]);
        assert_eq!(
            found.sigma_squared.len(),
            sigma.len(),
            "rank with {kept} modes"
        );
        assert!(
            relative(&frequencies(&found.sigma_squared), &sigma) < 1e-8,
            "σ with {kept} modes"
        );
    }
}

#[test]
fn boxes() {
    let file = reference("ref_spatial.json");
    // The reference cuts its boxes into tetrahedra along the mirrored diagonal: z points the other way.
    let mut mirrored = reference_tetrahedra().into_draft();
    (mirrored.interfaces[0].nodes, mirrored.interfaces[1].nodes) = (vec![1], vec![14]);
    let mirrored = Component::checked(mirrored).unwrap();
    for (name, component, z) in [("hex", reference_hexahedra(), 1.0), ("tet", mirrored, -1.0)] {
        let sign = |row: usize| if row % 3 == 2 { z } else { 1.0 };
        let flipped = |m: Mat<f64>| Mat::from_fn(6, 6, |i, j| sign(i) * m[(i, j)] * sign(j));
        let expected = &file[name];
        let element = lowest(&component, 6).superelement;
        let (residual, inertia) = (&element.residual, &element.inertia);
        let omega = numbers(&expected["omega_first12"]);
        let twelve = lowest(&component, 12).superelement;
        let error = relative(&frequencies(&twelve.modes.eigenvalues), &omega);
        assert!(error < DIGITS, "{name}: {error:e}");
        let sigma = numbers(&expected["sigma_residual"]);
        let error = relative(&frequencies(&residual.sigma_squared), &sigma);
        assert!(error < 10.0 * DIGITS, "{name}: σ {error:e}");
        let (f, m) = (
            flipped(matrix(&expected["F_res"], 6)),
            flipped(matrix(&expected["M_res"], 6)),
        );
        let (f, m) = (
            scaled_difference(&residual.flexibility, &f, &diagonal_roots(&f)),
            scaled_difference(&residual.mass, &m, &diagonal_roots(&m)),
        );
        assert!(
            f < 10.0 * DIGITS && m < 10.0 * DIGITS,
            "{name}: F_res {f:e}, M_res {m:e}"
        );
        let tensor = matrix(&expected["I0"], 3);
        for i in 0..3 {
            assert!((element.origin[i] - numbers(&expected["com"])[i]).abs() < 1e-14);
            for j in 0..3 {
                assert!(
                    (inertia.tensor[i][j] - tensor[(i, j)]).abs() < DIGITS,
                    "{name}: I({i}, {j})"
                );
            }
        }
        // The reference basis is [Φ, G_res L_bᵀ T_r].
        let to_reference = Mat::from_fn(12, 12, |i, j| match (i < 6, j < 6) {
            (true, true) if i == j => 1.0,
            (false, false) => residual.transform[(i - 6, j - 6)],
            _ => 0.0,
        });
        let j1 = |a: usize, b: usize, k: usize| -> f64 {
            (0..12)
                .map(|i| inertia.i1[i][a][b] * to_reference[(i, k)])
                .sum()
        };
        let size = |k: usize| {
            (0..9)
                .map(|at| j1(at / 3, at % 3, k).powi(2))
                .sum::<f64>()
                .sqrt()
        };
        for (k, value) in numbers(&expected["J1_first3_frob"])
            .iter()
            .enumerate()
            .take(3)
        {
            assert!(
                (size(k) - value).abs() < 1e-10,
                "{name}: J1 of column {k}: {} {value}",
                size(k)
            );
        }
        for (k, value) in numbers(&expected["J1_trace"]).iter().enumerate() {
            let trace = j1(0, 0, k) + j1(1, 1, k) + j1(2, 2, k);
            assert!(
                (trace.abs() - value.abs()).abs() < 1e-10,
                "{name}: tr J1 of column {k}: {trace} {value}"
            );
        }
        for (at, value) in numbers(&expected["L3_abs"]).iter().enumerate() {
            let found = inertia.l3[at / 16][(at / 4 % 4, at % 4)].abs();
            assert!(
                (found - value).abs() < 1e-10,
                "{name}: L3 at {at}: {found} {value}"
            );
        }
        let j2: f64 = (0..6)
            .map(|pair| {
                let block = to_reference.transpose() * &inertia.i2[pair] * &to_reference;
                let twice = if pair < 3 { 1.0 } else { 2.0 };
                twice * block.norm_l2().powi(2)
            })
            .sum();
        assert!(
            (j2.sqrt() / expected["J2_frob"].as_f64().unwrap() - 1.0).abs() < 1e-10,
            "{name}: J2 {}",
            j2.sqrt()
        );
    }
}

#[test]
fn the_published_rotor() {
    let file = reference("reference.json");
    let expected = file
        .as_array()
        .unwrap()
        .iter()
        .find(|case| case["name"].as_str().unwrap().starts_with("rotorAnsys"))
        .unwrap();
    let reduced = lowest(&parts::rotor(), 10);
    let element = &reduced.superelement;
    let hertz: Vec<f64> = element
        .modes
        .eigenvalues
        .iter()
        .map(|v| v.sqrt() / (2.0 * std::f64::consts::PI))
        .collect();
    assert!((hertz[0] / 104.637011 - 1.0).abs() < 1e-8 && (hertz[1] / hertz[0] - 1.0).abs() < 1e-9);
    assert!(relative(&hertz[..10], &numbers(&expected["freq_first10_elastic"])) < 1e-9);
    // Six rigid motions lie below every kept mode.
    assert_eq!(reduced.quality.mode_count.counted, element.mode_count() + 6);
    assert!(
        reduced
            .quality
            .rigid_defects
            .iter()
            .all(|defect| *defect < 1e-11)
            && reduced.quality.rigid_defects.len() == 6
    );
    assert!((element.inertia.mass / expected["mass"].as_f64().unwrap() - 1.0).abs() < 1e-12);
    let com = numbers(&expected["com"]);
    assert!((0..3).all(|i| (element.origin[i] - com[i]).abs() < 1e-10));
    let about_origin = matrix(&expected["RtMR_origin"], 6);
    for i in 0..3 {
        for j in 0..3 {
            // Steiner: I_origin = I + m (|c|² 1 - c cᵀ).
            let square: f64 = com.iter().map(|c| c * c).sum();
            let shift =
                element.inertia.mass * (if i == j { square } else { 0.0 } - com[i] * com[j]);
            let found = element.inertia.tensor[i][j] + shift;
            assert!(
                (found - about_origin[(3 + i, 3 + j)]).abs() < 1e-9,
                "I({i}, {j}): {found}"
            );
        }
    }
}
