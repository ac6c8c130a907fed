//! What the error estimate of a smaller superelement knows: the moments of `docs/error-estimate.md` with the modes that were left out among the omitted.
//!
//! ```text
//! M_1' = M_1 + Σ c cᵀ / ω²                  M_2' = M_2 + Σ c cᵀ / ω⁴                    c = L φ of the modes left out
//! M_3' = M_3 + Σ c cᵀ / (ω⁴ (ω² + σ))       M_4' = M_4 + Σ c cᵀ / (ω⁴ (ω² + σ)²)
//! ```

use dcb_formats::superelement::{Moments, Superelement};
use faer::{Mat, MatRef};

use super::statics::symmetrized;

/// What stays of a superelement, by places in it.
pub(super) struct Kept<'a> {
    /// L_b Φ, (n_b, n_k).
    pub shapes: MatRef<'a, f64>,
    pub modes: &'a [usize],
    pub left_out: &'a [usize],
    pub rows: &'a [usize],
    pub further: &'a [usize],
}

/// The moments of what is kept. Further columns stay with all modes only, so that no mode's work on their loads is needed.
pub(super) fn moments(whole: &Superelement, of: &Moments, kept: &Kept) -> Moments {
    let (n_b, rows) = (whole.rows.len(), kept.rows.len());
    let further = kept.further.iter().map(|place| n_b + place);
    let places: Vec<usize> = kept.rows.iter().copied().chain(further).collect();
    let squares = &whole.modes.eigenvalues;
    let shapes = Mat::from_fn(places.len(), kept.left_out.len(), |i, k| {
        match places[i] < n_b {
            true => kept.shapes[(places[i], kept.left_out[k])],
            false => 0.0,
        }
    });
    let with = |moment: &Mat<f64>, weight: &dyn Fn(f64) -> f64| {
        let weighted = Mat::from_fn(shapes.nrows(), shapes.ncols(), |i, k| {
            shapes[(i, k)] * weight(squares[kept.left_out[k]])
        });
        let added = symmetrized(weighted * shapes.transpose());
        Mat::from_fn(places.len(), places.len(), |i, j| {
            moment[(places[i], places[j])] + added[(i, j)]
        })
    };
    let shifted = |square: f64| square + of.shift;
    let error = |mode: &usize| of.eigenvalue_errors[*mode];
    let least = (kept.left_out.iter()).map(|mode| squares[*mode] * (1.0 - error(mode)));
    Moments {
        eigenvalue_bound: least.fold(of.eigenvalue_bound, f64::min),
        eigenvalue_errors: kept.modes.iter().map(error).collect(),
        rigid_shapes: Mat::from_fn(rows, of.rigid_shapes.ncols(), |i, k| {
            of.rigid_shapes[(kept.rows[i], k)]
        }),
        shift: of.shift,
        first: with(&of.first, &|square| 1.0 / square),
        second: with(&of.second, &|square| square.powi(-2)),
        third: with(&of.third, &|square| {
            1.0 / (square.powi(2) * shifted(square))
        }),
        fourth: with(&of.fourth, &|square| (square * shifted(square)).powi(-2)),
        rounding: places.iter().map(|place| of.rounding[*place]).collect(),
    }
}
