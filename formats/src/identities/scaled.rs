//! Defects measured on the scale of rows and columns.

use dcb_dense::symmetric_eigenvalues;
use faer::{Mat, MatRef};

use crate::superelement::Superelement;

/// Stands for the reciprocal of a column's norm that is zero: an entry there must be zero as well.
const NO_NORM: f64 = 1e100;

/// M norm of each column of Ψ.
pub(super) fn norms(of: &Superelement) -> Vec<f64> {
    (0..of.basis_count())
        .map(|k| of.reduced_mass(k, k).max(0.0).sqrt())
        .collect()
}

/// One over a size; 0 for what has none and isn't compared.
pub(super) fn reciprocal(size: f64) -> f64 {
    if size > 0.0 { size.recip() } else { 0.0 }
}

/// Reciprocals of norms.
pub(super) fn reciprocals(norms: &[f64]) -> Vec<f64> {
    let reciprocal = |norm: &f64| match *norm > 0.0 {
        true => norm.recip(),
        false => NO_NORM,
    };
    norms.iter().map(reciprocal).collect()
}

/// The larger one; what is no number is largest.
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if b.is_nan() || b > a { b } else { a }
}

/// How far D A D is from positive semi-definite, D = diag(`scale`): its lowest eigenvalue, if that is negative, with the sign changed.
pub(super) fn negative_part(matrix: MatRef<'_, f64>, scale: &[f64]) -> f64 {
    let n = scale.len();
    let scaled = Mat::from_fn(n, n, |i, j| {
        0.5 * (matrix[(i, j)] + matrix[(j, i)]) * scale[i] * scale[j]
    });
    match symmetric_eigenvalues(scaled.as_ref()) {
        Some(values) => values.first().map_or(0.0, |lowest| (-lowest).max(0.0)),
        None => f64::NAN,
    }
}
