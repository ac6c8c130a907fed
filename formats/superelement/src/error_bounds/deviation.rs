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
//!
//! A band asks for many λ, and g changes with λ by the weights of the dynamic coordinates alone ([`Model`]). So the products of the moments
//! with the shapes are made once for some rows ([`Forms`]).

use faer::{Mat, c64};

use super::DENSE_ROUNDING;
use super::ErrorBounds;
use super::amounts::{Amounts, DynamicRows};
use super::forms::{Forms, KnownWeights};
use super::split::{Split, vectorized};

/// H of a form at one λ, and its error, between some rows and those of them that forces act on; rows are scaled.
pub(super) struct Deviation {
    /// H of the form.
    pub reduced: Split,
    /// The known part of H - H of the form.
    pub known: Split,
    /// A Hermitian form over the rows that bounds the rest: a block of the rest is not larger than the root of the product of the
    /// blocks on its diagonals. Zero between rows that it isn't asked for.
    pub rest: Mat<c64>,
    /// Largest rounding of each entry, without that in the kept modes.
    pub rounding: Mat<f64>,
    /// Largest error of each entry by errors of the kept modes.
    pub of_modes: Mat<f64>,
}

/// Pairs of rows that the bound of the rest is wanted for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum RestBetween {
    /// All.
    AllRows,
    /// Rows of one interface.
    RowsOfAnInterface,
}

/// Deviations between some rows and those of them that forces act on, for any λ below the eigenvalue bound.
pub(super) struct Deviations<'a> {
    pub bounds: &'a ErrorBounds,
    pub rows: Vec<usize>,
    pub forced: Vec<usize>,
    /// Of the rows that forces act on among the rows.
    pub places: Vec<usize>,
    /// Rows of each interface, by their places.
    pub interfaces: Vec<Vec<usize>>,
    forms: Forms<'a>,
    dynamic: DynamicRows<'a>,
    /// M_1 and A_2 between the rows.
    static_moments: [Mat<f64>; 2],
    pub shapes: Shapes,
}

/// Motions of the kept modes and their sizes.
pub(super) struct Shapes {
    /// At the rows that forces act on, (poles, forced).
    pub forced: Mat<f64>,
    /// At all rows, (rows, poles).
    pub rows: Mat<f64>,
    pub forced_sizes: Mat<f64>,
    pub row_sizes: Mat<f64>,
}

/// How much each kept mode moves at one λ.
pub(super) struct ModeWeights {
    /// 1 / (ω² - λ)
    pub motions: Vec<c64>,
    /// Bounds of what these are off.
    pub errors: Vec<f64>,
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

impl ErrorBounds {
    /// Between `rows` and those that forces act on, `forced`.
    pub(super) fn deviations(&self, rows: &[usize], forced: &[usize]) -> Deviations<'_> {
        let poles = self.rows.poles.len();
        let at_rows = Mat::from_fn(rows.len(), poles, |i, k| self.rows.shapes[(rows[i], k)]);
        let at_forced = Mat::from_fn(poles, forced.len(), |k, j| self.rows.shapes[(forced[j], k)]);
        let sizes = |of: &Mat<f64>| Mat::from_fn(of.nrows(), of.ncols(), |i, j| of[(i, j)].abs());
        let between = |moment: &Mat<f64>| {
            Mat::from_fn(rows.len(), rows.len(), |i, j| moment[(rows[i], rows[j])])
        };
        let count = self.rows.interface.iter().max().map_or(0, |most| most + 1);
        let mut interfaces = vec![Vec::new(); count];
        for (place, row) in rows.iter().enumerate() {
            interfaces[self.rows.interface[*row]].push(place);
        }
        Deviations {
            bounds: self,
            places: (forced.iter())
                .filter_map(|row| rows.iter().position(|known| known == row))
                .collect(),
            interfaces,
            forms: Forms::of(&self.model, &self.coordinates, rows),
            dynamic: self.model.dynamic_rows(rows),
            static_moments: [&self.moments.first, &self.moments.second].map(between),
            shapes: Shapes {
                forced_sizes: sizes(&at_forced),
                row_sizes: sizes(&at_rows),
                forced: at_forced,
                rows: at_rows,
            },
            rows: rows.to_vec(),
            forced: forced.to_vec(),
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
}

impl Disc {
    /// What the bound of the rest is multiplied with.
    fn rest_size(&self) -> f64 {
        self.radius * self.shifted.norm()
    }
}

impl Deviations<'_> {
    pub(super) fn at(&self, lambda: c64, between: RestBetween) -> Deviation {
        let mut found = self.without_modes(lambda, between);
        let (of_modes, errors) = self.of_modes(lambda);
        found.reduced.add(1.0, &of_modes);
        found.of_modes = errors;
        found
    }

    /// The same without the kept modes: what changes slowly with λ.
    pub(super) fn without_modes(&self, lambda: c64, between: RestBetween) -> Deviation {
        let disc = self.bounds.disc(lambda);
        let amounts = self.dynamic.at(lambda);
        let response = self.dynamic.responses(&amounts, &self.places);
        let mut known = self.known(&disc, &amounts);
        known.add(-1.0, &response);
        Deviation {
            known,
            reduced: response,
            rest: self.rest(&disc, &amounts, between),
            rounding: self.rounding(&amounts, &disc),
            of_modes: Mat::zeros(self.rows.len(), self.forced.len()),
        }
    }

    /// Columns of the forces at an interface.
    pub(super) fn columns_of(&self, interface: usize) -> Vec<usize> {
        let own = |column: &usize| self.bounds.rows.interface[self.forced[*column]] == interface;
        (0..self.forced.len()).filter(own).collect()
    }

    /// What the bound of the rest is multiplied with at λ; all else in it is analytic in ω².
    pub(super) fn rest_size(&self, lambda: c64) -> f64 {
        self.bounds.disc(lambda).rest_size()
    }

    /// The known part of H - H of the kept modes.
    fn known(&self, disc: &Disc, amounts: &Amounts<'_>) -> Split {
        let Disc {
            lambda,
            shifted,
            middle,
            ..
        } = *disc;
        let m = &self.bounds.moments;
        // B_3 g of a row is (g + P)ᵀ B_3 g.
        let far = middle * shifted;
        let products = lambda * shifted;
        let weights = KnownWeights {
            residual: far,
            third_between_p: -shifted * m.shift,
            third_mixed: products + far * lambda,
            third_between_g: products,
            fourth: products * shifted + far * lambda * lambda,
        };
        let (still, half) = self.forms.symmetric(weights, amounts);
        let [first, second] = &self.static_moments;
        let mut terms = vec![(c64::new(1.0, 0.0), first), (lambda, second)];
        terms.extend(still);
        let rows = self.rows.len();
        let known = Split::sum(rows, rows, &terms);
        let symmetric = |known: &Mat<f64>, half: &Mat<f64>| {
            Mat::from_fn(rows, self.places.len(), |i, j| {
                let column = self.places[j];
                known[(i, column)] + half[(i, column)] + half[(column, i)]
            })
        };
        Split {
            re: symmetric(&known.re, &half.re),
            im: symmetric(&known.im, &half.im),
        }
    }

    /// The bound of the rest: Σ r̄ rᵀ/μ'² times |λ'| and the radius of the disc.
    fn rest(&self, disc: &Disc, amounts: &Amounts<'_>, between: RestBetween) -> Mat<c64> {
        let size = disc.rest_size();
        let half = self.forms.hermitian_half(disc.lambda, amounts);
        let rows = self.rows.len();
        let mut rest = Mat::zeros(rows, rows);
        let all: Vec<usize>;
        let groups: &[Vec<usize>] = match between {
            RestBetween::RowsOfAnInterface => &self.interfaces,
            RestBetween::AllRows => {
                all = (0..rows).collect();
                &[all]
            }
        };
        let product = amounts.adjoint_before(half);
        for places in groups {
            for column in places {
                for row in places {
                    let still = self.forms.hermitian_base(disc.lambda, *row, *column);
                    let moving = product.at(*row, *column) + product.at(*column, *row).conj();
                    rest[(*row, *column)] = (still + moving) * size;
                }
            }
        }
        rest
    }

    /// How much the kept modes move at λ.
    pub(super) fn mode_weights(&self, lambda: c64) -> ModeWeights {
        let of = &self.bounds.rows;
        let error = |pole: usize| {
            if pole < of.zero_count {
                return 0.0;
            }
            let distance = (c64::new(of.poles[pole], 0.0) - lambda).norm();
            let error = of.pole_errors[pole];
            (error * of.poles[pole] / distance + 2.0 * error + DENSE_ROUNDING) / distance
        };
        ModeWeights {
            motions: (of.poles.iter())
                .map(|square| c64::new(1.0, 0.0) / (c64::new(*square, 0.0) - lambda))
                .collect(),
            errors: (0..of.poles.len()).map(error).collect(),
        }
    }

    /// H of the kept modes between rows, and bounds of the error that these modes' own errors make in it.
    fn of_modes(&self, lambda: c64) -> (Split, Mat<f64>) {
        let ModeWeights { motions, errors } = self.mode_weights(lambda);
        let Shapes {
            forced,
            rows,
            forced_sizes,
            row_sizes,
        } = &self.shapes;
        let weighted = Split::weighted_rows(&motions, forced);
        let weighted_sizes = Mat::from_fn(forced.nrows(), forced.ncols(), |k, j| {
            forced_sizes[(k, j)] * errors[k]
        });
        (Split::after(rows, &weighted), row_sizes * weighted_sizes)
    }

    /// Rounding of every product that the known part and the rest are made of, between the rows and those that forces act on.
    fn rounding(&self, amounts: &Amounts<'_>, disc: &Disc) -> Mat<f64> {
        let [first, second, third, fourth] = &self.bounds.moments.roots;
        let (size, far) = (disc.shifted.norm(), disc.far.norm());
        let dynamic = Split::after(self.bounds.model.combinations(), &amounts.values);
        let own = |roots: &[f64], factor: f64| -> Vec<f64> {
            self.rows.iter().map(|row| factor * roots[*row]).collect()
        };
        // |g|ᵀ and |P|ᵀ, each times roots of some moments.
        let along = |base: &Mat<f64>, sign: f64, roots: [(&[f64], f64); 2]| -> [Vec<f64>; 2] {
            let mut sizes = vec![0.0; base.nrows()];
            let mut sums = [Vec::new(), Vec::new()];
            for j in 0..base.ncols() {
                vectorized(
                    #[inline(always)]
                    || {
                        let (re, im) = dynamic.column(j);
                        let parts = re.iter().zip(im).zip(base.col_as_slice(j));
                        for (size, ((re, im), base)) in sizes.iter_mut().zip(parts) {
                            let re = re * sign + base;
                            *size = (re * re + im * im).sqrt();
                        }
                    },
                );
                for (sums, (roots, factor)) in sums.iter_mut().zip(roots) {
                    let sum: f64 = sizes
                        .iter()
                        .zip(roots)
                        .map(|(size, root)| size * root)
                        .sum();
                    sums.push(factor * sum);
                }
            }
            sums
        };
        let (half, whole) = (size.sqrt(), size);
        let disc = far.sqrt();
        let [g, p] = self.forms.bases();
        let [g3, g4] = along(g, 1.0, [(third, whole), (fourth, whole * half)]);
        let [p3, p2] = along(p, -1.0, [(third, whole), (second, half)]);
        let pairs = [
            (own(first, 1.0), own(first, 1.0), 1.0),
            (own(second, half), own(second, half), 1.0),
            (own(third, whole), g3.clone(), 1.0),
            (g3.clone(), p3.clone(), 1.0 + far),
            (p3, g3, far),
            (g4.clone(), g4, 1.0 + far),
            (p2.clone(), p2, disc * disc),
        ];
        let left = Mat::from_fn(self.rows.len(), pairs.len(), |i, k| {
            pairs[k].2 * pairs[k].0[i]
        });
        let right = Mat::from_fn(pairs.len(), self.places.len(), |k, j| {
            pairs[k].1[self.places[j]]
        });
        left * right
    }
}
