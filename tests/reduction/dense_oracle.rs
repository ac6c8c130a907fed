//! Is a reduction what dense algebra on K and M gives?
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use dcb_tests::accuracy::cases;

#[test]
fn every_quantity_agrees_with_dense_algebra() {
    let mut failures = Vec::new();
    for case in cases() {
        for line in case.measure() {
            // Also true for NaN.
            if !(line.error <= line.bound) {
                failures.push(line.line().to_string());
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
