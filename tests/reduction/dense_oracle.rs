//! Is a reduction what dense algebra on K and M gives?

use dcb_tests::accuracy::cases::{cases, ring};

#[test]
fn every_quantity_agrees_with_dense_algebra() {
    let mut failures = Vec::new();
    for case in cases() {
        for line in case.measure() {
            if line.error.is_nan() || line.error > line.bound {
                failures.push(line.line().to_string());
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn frequencies_of_the_symmetric_ring() {
    let line = ring();
    assert!(
        line.error < line.bound && line.bound < 1e-6,
        "{}",
        line.line()
    );
}
