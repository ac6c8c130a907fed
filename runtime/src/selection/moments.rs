//! What the error estimate of a smaller superelement knows: the moments of `docs/error-estimate.md` with the modes that were left out among the omitted.
//!
//! ```text
//! M_j' = M_j + Σ c cᵀ / ω^(2j)        c = L φ of the modes left out
//! ```

use dcb_formats::component::Role;
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
    /// What each of these rows is for from now on.
    pub roles: Vec<Role>,
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
    let is_output = |place: usize| place < rows && kept.roles[place] == Role::Output;
    let with = |moment: &Mat<f64>, power: i32, is_known: &dyn Fn(bool, bool) -> bool| {
        let weighted = Mat::from_fn(shapes.nrows(), shapes.ncols(), |i, k| {
            shapes[(i, k)] / squares[kept.left_out[k]].powi(power)
        });
        let added = symmetrized(weighted * shapes.transpose());
        Mat::from_fn(places.len(), places.len(), |i, j| {
            match is_known(is_output(i), is_output(j)) {
                true => moment[(places[i], places[j])] + added[(i, j)],
                false => 0.0,
            }
        })
    };
    let error = |mode: &usize| of.eigenvalue_errors[*mode];
    let least = (kept.left_out.iter()).map(|mode| squares[*mode] * (1.0 - error(mode)));
    Moments {
        eigenvalue_bound: least.fold(of.eigenvalue_bound, f64::min),
        eigenvalue_errors: kept.modes.iter().map(error).collect(),
        rigid_shapes: Mat::from_fn(rows, of.rigid_shapes.ncols(), |i, k| {
            of.rigid_shapes[(kept.rows[i], k)]
        }),
        first: with(&of.first, 1, &|_, _| true),
        second: with(&of.second, 2, &|_, _| true),
        third: with(&of.third, 3, &|a, b| !(a && b)),
        fourth: with(&of.fourth, 4, &|a, b| !(a || b)),
        rounding: places.iter().map(|place| of.rounding[*place]).collect(),
    }
}
