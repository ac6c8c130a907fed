//! The moments of the modes left out, among each other and with the residual matrices.
//!
//! ```text
//! M_1 ≥ λ M_2      M_2 ≥ (λ + σ) M_3      M_3 ≥ (λ + σ) M_4      [M_2 M_3; M_3 M_4] ≥ 0        λ = eigenvalue_bound, σ = shift
//! M_1 ≥ F_res; where nothing of F_res was left out, M_1 and M_2 are F_res, M_res and the blocks of the reduced matrices
//! ```
//! because M_i = ∫ μ^(-a) (μ + σ)^(-b) dC(μ) over one positive measure on μ ≥ λ.

use faer::{Mat, MatRef, Scale};

use super::Identity;
use super::residual::{is_attached, may_be_cut};
use super::scaled::{larger, negative_part, reciprocal};
use crate::superelement::{Moments, Superelement};

/// Largest rounding in the moments of a row that is compared.
const TRUSTED: f64 = 1e-7;
const ORDER_LIMIT: f64 = 1e-6;

pub(super) fn in_full(of: &Superelement) -> Vec<Identity> {
    let Some(moments) = &of.moments else {
        return Vec::new();
    };
    let mut all = among_each_other(moments);
    all.extend(with_the_residual(of, moments));
    all
}

fn sizes(matrix: &Mat<f64>) -> Vec<f64> {
    (0..matrix.nrows())
        .map(|i| matrix[(i, i)].max(0.0).sqrt())
        .collect()
}

fn reciprocals(sizes: &[f64]) -> Vec<f64> {
    sizes.iter().copied().map(reciprocal).collect()
}

/// Scales of rows by their sizes. A row whose moments are rounding isn't compared: its scale is zero.
fn scales(moments: &Moments, sizes: &[f64]) -> Vec<f64> {
    let scales = reciprocals(sizes).into_iter();
    let trusted = scales.zip(&moments.rounding);
    trusted
        .map(|(scale, rounding)| if *rounding <= TRUSTED { scale } else { 0.0 })
        .collect()
}

/// Size of each row: the larger one of both matrices.
fn larger_sizes(a: &Mat<f64>, b: &Mat<f64>, by: f64) -> Vec<f64> {
    (0..a.nrows())
        .map(|i| a[(i, i)].abs().max(by * b[(i, i)].abs()).sqrt())
        .collect()
}

/// Negative part of `[M_2 M_3; M_3 M_4]`.
fn hankel_defect(moments: &Moments) -> f64 {
    let Moments {
        second,
        third,
        fourth,
        ..
    } = moments;
    let n = second.nrows();
    let hankel = Mat::from_fn(2 * n, 2 * n, |i, j| {
        let of = match (i < n, j < n) {
            (true, true) => second,
            (false, false) => fourth,
            _ => third,
        };
        of[(i % n, j % n)]
    });
    // M_4 is at least as large as M_2 and M_3 demand.
    let fourths = (0..n).map(|i| {
        let (second, third) = (second[(i, i)].abs(), third[(i, i)]);
        let least = if second > 0.0 {
            third * third / second
        } else {
            0.0
        };
        fourth[(i, i)].abs().max(least).sqrt()
    });
    let both = [
        scales(moments, &larger_sizes(second, second, 1.0)),
        scales(moments, &fourths.collect::<Vec<_>>()),
    ]
    .concat();
    negative_part(hankel.as_ref(), &both)
}

fn among_each_other(moments: &Moments) -> Vec<Identity> {
    let Moments {
        first,
        second,
        third,
        fourth,
        ..
    } = moments;
    let bound = match moments.eigenvalue_bound {
        finite if finite.is_finite() => finite,
        // Nothing with mass was left out.
        _ => 0.0,
    };
    let shifted = bound + moments.shift;
    let falls = |upper: &Mat<f64>, lower: &Mat<f64>, by: f64| {
        let difference = upper - lower * Scale(by);
        let sizes = larger_sizes(upper, lower, by);
        negative_part(difference.as_ref(), &scales(moments, &sizes))
    };
    let identity = |path, what, defect| Identity {
        path,
        what,
        defect,
        limit: ORDER_LIMIT,
    };
    vec![
        identity(
            "/error/moment_1",
            "M_1 ≥ λ M_2 with eigenvalue_bound λ (negative part)",
            falls(first, second, bound),
        ),
        identity(
            "/error/moment_2",
            "M_2 ≥ (λ + σ) M_3 with the shift σ (negative part)",
            falls(second, third, shifted),
        ),
        identity(
            "/error/moment_3",
            "M_3 ≥ (λ + σ) M_4 (negative part)",
            falls(third, fourth, shifted),
        ),
        identity(
            "/error/moment_4",
            "M_2, M_3 and M_4 are moments of one measure (negative part)",
            hankel_defect(moments),
        ),
    ]
}

fn with_the_residual(of: &Superelement, moments: &Moments) -> Vec<Identity> {
    let (n_k, n_b) = (of.mode_count(), of.rows.len());
    let attached: Vec<usize> = (0..n_b).filter(|row| is_attached(of, *row)).collect();
    let flexibility = sizes(&moments.first);
    let mass = sizes(&moments.second);
    if may_be_cut(of) {
        let rest = Mat::from_fn(attached.len(), attached.len(), |i, j| {
            let at = (attached[i], attached[j]);
            moments.first[at] - of.residual.flexibility[at]
        });
        let scale: Vec<f64> = attached.iter().map(|row| flexibility[*row]).collect();
        return vec![Identity {
            path: "/error/moment_1",
            what: "M_1 ≥ F_res (negative part)",
            defect: negative_part(rest.as_ref(), &reciprocals(&scale)),
            limit: ORDER_LIMIT,
        }];
    }
    // Columns of attachments and further columns, by their places in the moments.
    let columns: Vec<usize> = attached
        .iter()
        .copied()
        .chain(n_b..flexibility.len())
        .collect();
    let compared =
        |moment: MatRef<'_, f64>, sizes: &[f64], stored: &dyn Fn(usize, usize) -> Option<f64>| {
            let mut defect = 0.0;
            for &j in &columns {
                for i in 0..sizes.len() {
                    if let Some(stored) = stored(i, j) {
                        let found = (moment[(i, j)] - stored).abs();
                        if found > 0.0 {
                            defect = larger(defect, found / (sizes[i] * sizes[j]));
                        }
                    }
                }
            }
            defect
        };
    let residual = &of.residual;
    let further = of.enrichment.as_ref();
    let flexible = |i: usize, j: usize| match (i < n_b, j < n_b, further) {
        (true, true, _) if is_attached(of, i) => Some(residual.flexibility[(i, j)]),
        (true, true, _) => residual.output_shapes.as_ref().map(|shapes| shapes[(i, j)]),
        (true, false, Some(further)) => Some(further.interface_shapes[(i, j - n_b)]),
        (false, _, Some(further)) if j >= n_b || is_attached(of, j) => {
            Some(further.reduced_stiffness[(n_k + i, n_k + j)])
        }
        _ => None,
    };
    let massive = |i: usize, j: usize| match (i < n_b && j < n_b, further) {
        (true, _) if is_attached(of, i) => Some(residual.mass[(i, j)]),
        (false, Some(further)) if i >= n_b || is_attached(of, i) => {
            Some(further.reduced_mass[(n_k + i, n_k + j)])
        }
        _ => None,
    };
    vec![
        Identity {
            path: "/error/moment_1",
            what: "M_1 is F_res, L_b X and the stiffness of further columns",
            defect: compared(moments.first.as_ref(), &flexibility, &flexible),
            limit: ORDER_LIMIT,
        },
        Identity {
            path: "/error/moment_2",
            what: "M_2 is M_res and the mass of further columns",
            defect: compared(moments.second.as_ref(), &mass, &massive),
            limit: ORDER_LIMIT,
        },
    ]
}
