//! Is a reduction what dense algebra on K and M gives?
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::needless_range_loop
)]

use dcb_tests::accuracy::cases;
use dcb_tests::dense::{dense, relative, symmetric};
use dcb_tests::lowest;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Par, Side};

#[test]
fn every_quantity_agrees_with_dense_algebra() {
    let mut failures = Vec::new();
    for case in cases() {
        for line in case.measure() {
            // Also true for NaN.
            if line.error.is_nan() || line.error > line.bound {
                failures.push(line.line().to_string());
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn frequencies_of_the_symmetric_ring() {
    // Too large for the whole comparison: eigenvalues of L⁻¹ K L⁻ᵀ only.
    let ring = dcb_samples::hard::symmetric_ring(8);
    let lower = dense(&ring.mass).llt(Side::Lower).unwrap().L().to_owned();
    let mut half = dense(&ring.stiffness);
    solve_lower_triangular_in_place(lower.as_ref(), half.as_mut(), Par::Seq);
    let mut matrix = half.transpose().to_owned();
    solve_lower_triangular_in_place(lower.as_ref(), matrix.as_mut(), Par::Seq);
    let expected = symmetric(&matrix)
        .self_adjoint_eigenvalues(Side::Lower)
        .unwrap();
    let found = lowest(&ring, 20).superelement.modes.eigenvalues;
    // The dense values are good to ε times the largest.
    let rounding = 1e-15 * expected.last().unwrap() / found[0];
    let error = relative(&found, &expected[6..6 + found.len()]);
    assert!(error < rounding.max(1e-9), "{error:e} {rounding:e}");
    assert!(rounding < 1e-6);
}
