//! `reduce verify --component`: what a file says of the motions that its modes leave out, against the same made anew.

use dcb_formats::Superelement;
use dcb_formats::identities::flexibilities;
use dcb_formats::superelement::Moments;
use dcb_sparse::block_algebra::largest_entry;
use faer::Mat;

use super::findings::{AGREEMENT, Findings};

/// A stored eigenvalue bound may be above a counted one by rounding.
const BOUND_AGREEMENT: f64 = 1e-6;
/// Factor by which rounding may differ between runs.
const ROUNDING_AGREEMENT: f64 = 10.0;

/// What is left of a row's flexibility is compared to this part of the whole at least: below is rounding.
const LEFT_OF_A_ROW: f64 = 1e-6;

/// Stored moments and bounds of a superelement against computed ones; `certified` says whether an eigenvalue count has confirmed the
/// computed bound.
pub fn check_moments(
    element: &Superelement,
    stored: &Moments,
    computed: &Moments,
    certified: bool,
    findings: &mut Findings,
) {
    findings.require(
        "no eigenvalue left out is below the stored bound",
        certified && stored.eigenvalue_bound <= computed.eigenvalue_bound * (1.0 + BOUND_AGREEMENT),
        &format!(
            "{:.6e}, counted {:.6e}",
            stored.eigenvalue_bound, computed.eigenvalue_bound
        ),
    );
    let whole = flexibilities(element);
    let least = |i: usize| whole.get(i).map_or(0.0, |whole| LEFT_OF_A_ROW * whole);
    let first = apart(&stored.first, &computed.first, least);
    findings.check("M_1 of the error estimate", first, AGREEMENT);
    // Without a mode left out the others are zero, to rounding.
    let higher = [
        (
            "M_2 of the error estimate",
            &stored.second,
            &computed.second,
        ),
        ("M_3 of the error estimate", &stored.third, &computed.third),
        (
            "M_4 of the error estimate",
            &stored.fourth,
            &computed.fourth,
        ),
    ];
    for (what, a, b) in higher {
        if computed.eigenvalue_bound.is_finite() {
            findings.check(what, apart(a, b, |_| 0.0), AGREEMENT);
        }
    }
    // Rigid motions may be turned among each other.
    let seen = |of: &Moments| &of.rigid_shapes * of.rigid_shapes.transpose();
    findings.check(
        "rigid motions at the rows",
        apart(&seen(stored), &seen(computed), |_| 0.0),
        AGREEMENT,
    );
    let exceeded = |stored: &[f64], computed: &[f64]| {
        let pairs = stored.iter().zip(computed);
        let ratios = pairs.map(|(a, b)| (b + f64::EPSILON) / (a + f64::EPSILON));
        ratios.fold(0.0, f64::max)
    };
    findings.check(
        "rounding and eigenvalue errors over the stored ones",
        exceeded(&stored.rounding, &computed.rounding).max(exceeded(
            &stored.eigenvalue_errors,
            &computed.eigenvalue_errors,
        )),
        ROUNDING_AGREEMENT,
    );
}

/// Largest difference of an entry over the root of both diagonals, which bound it, or of the least that they count as.
fn apart(a: &Mat<f64>, b: &Mat<f64>, least: impl Fn(usize) -> f64) -> f64 {
    let largest = (0..b.nrows()).map(|i| b[(i, i)]).fold(0.0, f64::max);
    let size = |i: usize| {
        let counted = (AGREEMENT * largest).max(least(i));
        b[(i, i)].max(counted).sqrt()
    };
    let scaled = Mat::from_fn(b.nrows(), b.ncols(), |i, j| match size(i) * size(j) {
        size if size > 0.0 => (a[(i, j)] - b[(i, j)]) / size,
        _ => a[(i, j)] - b[(i, j)],
    });
    largest_entry(scaled.as_ref())
}
