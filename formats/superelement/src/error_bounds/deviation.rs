//! Deviation of a form at one λ: a known part, and bounds of the rest.
//!
//! With u = X g the motion that a form has for a force, the residual of mode μ is r = c (P + λ g/μ), P = I - g. For λ' = λ + σ, μ' = μ + σ
//!
//! ```text
//! L A(λ) Lᵀ = M_1 + λ A_2 + λ λ' (B_3 g + gᵀ B_3 P) - λ' σ Pᵀ B_3 P + λ λ'² gᵀ M_4 g + rest
//! rest = λ' Σ f(μ) r rᵀ/μ'²,   f(μ) = λ' / (μ - λ),   N = Σ r rᵀ/μ'² = Pᵀ B_2 P + λ (Pᵀ B_3 g + gᵀ B_3 P) + λ² gᵀ M_4 g
//! A_2 = M_2 - σ M_3,   B_2 = A_2 - σ B_3,   B_3 = M_3 - σ M_4
//! ```
//! whatever g is. For Re λ below the eigenvalue bound μ₁ all f(μ) lie in the disc with 0 and f(μ₁) at the ends of a diameter: its middle goes
//! to the known part, its radius times N bounds what is left. For a real λ that is a two-sided bound as a quadratic form.

use dcb_formats::superelement::Moments;
use faer::{Mat, c64};

use super::DENSE_ROUNDING;
use super::ErrorBounds;
use super::model::weighted_product;
use super::rows::Rows;

/// H of a form at one λ, and its error, between some rows and those of them that forces act on; rows are scaled.
pub(super) struct Deviation {
    /// H of the form.
    pub reduced: Mat<c64>,
    /// The known part of H - H of the form.
    pub known: Mat<c64>,
    /// A Hermitian form over all of the rows that bounds the rest: a block of the rest is not larger than the root of the product of the
    /// blocks on its diagonals.
    pub rest: Mat<c64>,
    /// Largest rounding of each entry, without that in the kept modes.
    pub rounding: Mat<f64>,
    /// Largest error of each entry by errors of the kept modes.
    pub of_modes: Mat<f64>,
}

/// Combinations of scaled moments in the sums, (n, n).
pub(super) struct ScaledMoments {
    /// σ
    shift: f64,
    /// M_1
    pub first: Mat<c64>,
    /// A_2
    second: Mat<c64>,
    /// B_2
    residual: Mat<c64>,
    /// B_3
    third: Mat<c64>,
    /// M_4
    fourth: Mat<c64>,
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
        let complex =
            |m: &Mat<f64>| Mat::from_fn(m.nrows(), m.ncols(), |i, j| c64::new(m[(i, j)], 0.0));
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
        let [first, second, third, fourth] = &moments.map(|moment| rows.seen(moment));
        let (second, third) = (less(second, third), less(third, fourth));
        Self {
            shift: *shift,
            first: complex(first),
            residual: complex(&less(&second, &third)),
            second: complex(&second),
            third: complex(&third),
            fourth: complex(fourth),
            roots,
        }
    }
}

/// Static shapes g that a form takes for forces on some rows, P = I - g, and their products with the moments; (n, rows) unless said otherwise.
struct Shapes {
    g: Mat<c64>,
    p: Mat<c64>,
    /// B_2 P
    residual_p: Mat<c64>,
    /// B_3 g
    third_g: Mat<c64>,
    /// B_3 P
    third_p: Mat<c64>,
    /// M_4 g
    fourth_g: Mat<c64>,
    /// gᵀ B_3 P, (rows, rows)
    g_third_p: Mat<c64>,
    /// gᵀ M_4 g, (rows, rows)
    g_fourth_g: Mat<c64>,
}

/// λ, and the disc that all f(μ) lie in.
struct Disc {
    lambda: c64,
    /// λ' = λ + σ
    shifted: c64,
    /// f(μ₁) of the eigenvalue bound.
    far: c64,
    middle: c64,
    radius: f64,
}

impl Shapes {
    /// N without its conjugates: Σ r rᵀ/μ'².
    fn bilinear(&self, lambda: c64) -> Mat<c64> {
        let p = &self.p;
        let p_third_g = p.transpose() * &self.third_g;
        let p_residual_p = p.transpose() * &self.residual_p;
        Mat::from_fn(p.ncols(), p.ncols(), |i, j| {
            p_residual_p[(i, j)]
                + lambda * (p_third_g[(i, j)] + self.g_third_p[(i, j)])
                + lambda * lambda * self.g_fourth_g[(i, j)]
        })
    }

    /// The bound of the rest: Σ r̄ rᵀ/μ'² times |λ'| and the radius of the disc.
    fn rest(&self, disc: &Disc) -> Mat<c64> {
        let Self { g, p, .. } = self;
        let (lambda, size) = (disc.lambda, disc.lambda.norm());
        let (pg, gp, gg, pp) = (
            p.adjoint() * &self.third_g,
            g.adjoint() * &self.third_p,
            g.adjoint() * &self.fourth_g,
            p.adjoint() * &self.residual_p,
        );
        Mat::from_fn(g.ncols(), g.ncols(), |i, j| {
            let form = pp[(i, j)]
                + lambda * pg[(i, j)]
                + lambda.conj() * gp[(i, j)]
                + gg[(i, j)] * (size * size);
            form * (disc.radius * disc.shifted.norm())
        })
    }
}

impl ErrorBounds {
    /// `rows` with those that forces act on, `forced`, all below the eigenvalue bound.
    pub(super) fn deviation(&self, rows: &[usize], forced: &[usize], lambda: c64) -> Deviation {
        let shapes = self.shapes(rows, lambda);
        let disc = self.disc(lambda);
        let places: Vec<usize> = forced
            .iter()
            .filter_map(|row| rows.iter().position(|known| known == row))
            .collect();
        let response = self.model.responses(rows, forced, lambda);
        let known = self.known(rows, &shapes, &disc);
        let known = Mat::from_fn(rows.len(), places.len(), |i, j| {
            known(i, places[j]) - response[(i, j)]
        });
        let (poles, of_modes) = self.of_modes(rows, forced, lambda);
        let size = disc.shifted.norm();
        let rounding = self.rounding(rows, &shapes.g, &shapes.p, size, disc.far.norm());
        Deviation {
            reduced: poles + response,
            known,
            rest: shapes.rest(&disc),
            rounding: Mat::from_fn(rows.len(), places.len(), |i, j| rounding[(i, places[j])]),
            of_modes,
        }
    }

    fn shapes(&self, rows: &[usize], lambda: c64) -> Shapes {
        let g = self.model.amounts(rows, lambda);
        let p = Mat::from_fn(g.nrows(), g.ncols(), |i, j| {
            let unit = f64::from(u8::from(i == rows[j]));
            c64::new(unit, 0.0) - g[(i, j)]
        });
        let m = &self.moments;
        let (third_p, fourth_g) = (&m.third * &p, &m.fourth * &g);
        Shapes {
            residual_p: &m.residual * &p,
            third_g: &m.third * &g,
            g_third_p: g.transpose() * &third_p,
            g_fourth_g: g.transpose() * &fourth_g,
            third_p,
            fourth_g,
            g,
            p,
        }
    }

    fn disc(&self, lambda: c64) -> Disc {
        let shifted = lambda + self.moments.shift;
        let far = match self.eigenvalue_bound.is_finite() {
            true => shifted / (c64::new(self.eigenvalue_bound, 0.0) - lambda),
            false => c64::new(0.0, 0.0),
        };
        Disc {
            lambda,
            shifted,
            far,
            middle: far * 0.5,
            radius: 0.5 * far.norm(),
        }
    }

    /// The known part of H - H of the kept modes, between two of the rows by their places.
    fn known<'a>(
        &'a self,
        rows: &'a [usize],
        shapes: &'a Shapes,
        disc: &'a Disc,
    ) -> impl Fn(usize, usize) -> c64 + 'a {
        let Disc {
            lambda,
            shifted,
            middle,
            ..
        } = *disc;
        let bilinear = shapes.bilinear(lambda);
        let p_third_p = shapes.p.transpose() * &shapes.third_p;
        let m = &self.moments;
        move |i, j| {
            let (row, column) = (rows[i], rows[j]);
            let series = m.first[(row, column)]
                + lambda * m.second[(row, column)]
                + lambda * shifted * (shapes.third_g[(row, j)] + shapes.g_third_p[(i, j)])
                - shifted * m.shift * p_third_p[(i, j)]
                + lambda * shifted * shifted * shapes.g_fourth_g[(i, j)];
            series + middle * shifted * bilinear[(i, j)]
        }
    }

    /// H of the kept modes between rows, and bounds of the error that these modes' own errors make in it.
    fn of_modes(&self, rows: &[usize], forced: &[usize], lambda: c64) -> (Mat<c64>, Mat<f64>) {
        let poles = self.rows.poles.len();
        let weights: Vec<c64> = (self.rows.poles.iter())
            .map(|square| c64::new(1.0, 0.0) / (c64::new(*square, 0.0) - lambda))
            .collect();
        let error_weights: Vec<f64> = (0..poles)
            .map(|pole| {
                if pole < self.rows.zero_count {
                    return 0.0;
                }
                let square = self.rows.poles[pole];
                let distance = (c64::new(square, 0.0) - lambda).norm();
                let error = self.rows.pole_errors[pole];
                (error * square / distance + 2.0 * error + DENSE_ROUNDING) / distance
            })
            .collect();
        let of =
            |rows: &[usize]| Mat::from_fn(rows.len(), poles, |i, k| self.rows.shapes[(rows[i], k)]);
        let (left, right) = (of(rows), of(forced));
        let weighted = Mat::from_fn(rows.len(), poles, |i, k| {
            left[(i, k)].abs() * error_weights[k]
        });
        let sizes = Mat::from_fn(poles, forced.len(), |k, j| right[(j, k)].abs());
        (weighted_product(&left, &weights, &right), weighted * sizes)
    }

    /// Rounding of every product that the known part and the rest are made of.
    fn rounding(
        &self,
        rows: &[usize],
        g: &Mat<c64>,
        p: &Mat<c64>,
        size: f64,
        far: f64,
    ) -> Mat<f64> {
        let [first, second, third, fourth] = &self.moments.roots;
        let own = |roots: &[f64], factor: f64| -> Vec<f64> {
            rows.iter().map(|row| factor * roots[*row]).collect()
        };
        let along = |amounts: &Mat<c64>, roots: &[f64], factor: f64| -> Vec<f64> {
            (0..rows.len())
                .map(|j| {
                    let sum: f64 = (0..roots.len())
                        .map(|i| amounts[(i, j)].norm() * roots[i])
                        .sum();
                    factor * sum
                })
                .collect()
        };
        let (half, whole) = (size.sqrt(), size);
        let disc = far.sqrt();
        let (g3, p3, g4) = (
            along(g, third, whole),
            along(p, third, whole),
            along(g, fourth, whole * half),
        );
        let p2 = along(p, second, half);
        let pairs = [
            (own(first, 1.0), own(first, 1.0), 1.0),
            (own(second, half), own(second, half), 1.0),
            (own(third, whole), g3.clone(), 1.0),
            (g3.clone(), p3.clone(), 1.0 + far),
            (p3, g3, far),
            (g4.clone(), g4, 1.0 + far),
            (p2.clone(), p2, disc * disc),
        ];
        Mat::from_fn(rows.len(), rows.len(), |i, j| {
            pairs
                .iter()
                .map(|(a, b, factor)| factor * a[i] * b[j])
                .sum()
        })
    }
}
