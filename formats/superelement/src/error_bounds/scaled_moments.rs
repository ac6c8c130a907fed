//! Combinations of the power moments that the deviation of a form is made of (`super::deviation`), in scaled rows.

use dcb_formats::superelement::Moments;
use faer::Mat;

use super::rows::Rows;

/// Combinations of scaled moments in the sums, (n, n).
pub(super) struct ScaledMoments {
    /// σ
    pub shift: f64,
    /// M_1
    pub first: Mat<f64>,
    /// A_2
    pub second: Mat<f64>,
    /// B_2
    pub residual: Mat<f64>,
    /// B_3
    pub third: Mat<f64>,
    /// M_4
    pub fourth: Mat<f64>,
    /// Root of the rounding in each row of M_1 to M_4.
    pub roots: [Vec<f64>; 4],
}

impl ScaledMoments {
    pub(super) fn of(of: &Moments, rows: &Rows) -> Self {
        let Moments {
            shift,
            rounding,
            eigenvalue_bound,
            ..
        } = of;
        let moments =
            [&of.first, &of.second, &of.third, &of.fourth].map(|moment| rows.scaled(moment));
        let less = |a: &Mat<f64>, b: &Mat<f64>| {
            Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] - *shift * b[(i, j)])
        };
        let root = |moment: usize| -> Vec<f64> {
            let of_rows = (0..rounding.len())
                .map(|i| {
                    // Where a higher moment isn't known it is below the one before over the bound.
                    let own = (0..=moment)
                        .rev()
                        .map(|m| {
                            let steps = (moment - m) as i32;
                            moments[m][(i, i)] / eigenvalue_bound.powi(steps)
                        })
                        .find(|size| *size > 0.0);
                    (rounding[i] * own.unwrap_or(0.0)).sqrt()
                })
                .collect();
            rows.seen_roots(of_rows)
        };
        let roots = [root(0), root(1), root(2), root(3)];
        let [first, second, third, fourth] = moments.map(|moment| rows.seen(moment));
        let (second, third) = (less(&second, &third), less(&third, &fourth));
        Self {
            shift: *shift,
            first,
            residual: less(&second, &third),
            second,
            third,
            fourth,
            roots,
        }
    }
}
