//! `reduce verify --component`: an interface reduction against the same one made anew.

use dcb_formats::Superelement;
use dcb_sparse::block_algebra::largest_entry;
use faer::Mat;

use super::findings::{AGREEMENT, Findings, SHAPE_AGREEMENT};
use crate::attachments::interface_reduction::InterfaceReduction;
use crate::attachments::residual::ResidualFlexibility;
use crate::quality::Quality;

/// Errors of an interface reduction agree as closely as its eigenvalues; the worst direction divides by small ones.
const REPORT_AGREEMENT: f64 = 1e-4;

/// Stored report of an interface reduction.
pub fn reported_reduction(element: &Superelement) -> Option<InterfaceReduction> {
    Quality::stored(element).and_then(|quality| quality.interface_reduction)
}

/// The reported interface reduction against the same one made anew, and the stored columns against its columns.
pub fn check_interface_reduction(
    reported: &InterfaceReduction,
    expected: &ResidualFlexibility,
    stored: &Mat<f64>,
    findings: &mut Findings,
) {
    let Some(found) = &expected.interface_reduction else {
        return;
    };
    let same = (reported.kept, reported.available) == (found.kept, found.available);
    findings.require(
        "directions of the interface reduction",
        same,
        &format!(
            "{} of {}, recomputed {} of {}",
            reported.kept, reported.available, found.kept, found.available
        ),
    );
    let errors = |of: &InterfaceReduction| {
        [
            of.residual_error,
            of.flexibility_error,
            of.largest_left_out,
            of.worst_direction_error,
        ]
    };
    let apart = errors(reported)
        .iter()
        .zip(errors(found))
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    findings.check("errors of the interface reduction", apart, REPORT_AGREEMENT);
    let apart = stored - &expected.shapes;
    let scale = |j: usize| largest_entry(expected.shapes.as_ref().subcols(j, 1));
    let worst = (0..stored.ncols())
        .map(|j| {
            let unit = scale(j).max(AGREEMENT * largest_entry(expected.shapes.as_ref()));
            largest_entry(apart.as_ref().subcols(j, 1)) / unit.max(f64::MIN_POSITIVE)
        })
        .fold(0.0, f64::max);
    findings.check(
        "G_res L_bᵀ of the interface reduction",
        worst,
        SHAPE_AGREEMENT,
    );
}
