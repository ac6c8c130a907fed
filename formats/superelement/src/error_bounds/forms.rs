//! Bilinear forms of the moments between the static shapes of some rows, prepared for many λ.
//!
//! g = G + T D(λ) and P = P₀ - T D(λ), where only D, the amounts of the dynamic coordinates, changes with λ. A form of a moment M between two of them,
//! say P and g, is then
//!
//! ```text
//! Pᵀ M g = P₀ᵀ M G + P₀ᵀ M T D - Dᵀ Tᵀ M G - Dᵀ Tᵀ M T D
//! ```
//! with real products that are made once: those of the coordinates for all rows, the others for those of interest. Any sum of forms is a constant, a linear and a quadratic part in D: two products for each λ.

use faer::{Mat, c64};

use super::amounts::Amounts;
use super::model::Model;
use super::scaled_moments::ScaledMoments;
use super::split::Split;

/// One moment M, M T and Tᵀ M T, whichever the rows.
struct Coordinates {
    moment: Mat<f64>,
    of_t: Mat<f64>,
    between_t: Mat<f64>,
}

/// B_2, B_3 and M_4 with the products that don't depend on the rows.
pub(super) struct CoordinateForms {
    residual: Coordinates,
    third: Coordinates,
    fourth: Coordinates,
}

/// Products of one moment with P₀, G and T; rows of P₀ and G, coordinates of T.
struct Products<'a> {
    between_p: Mat<f64>,
    p_with_g: Mat<f64>,
    /// P₀ with G, and G with P₀.
    mixed: Mat<f64>,
    between_g: Mat<f64>,
    t_with_p: Mat<f64>,
    t_with_g: Mat<f64>,
    between_t: &'a Mat<f64>,
}

/// The forms of B_2, B_3 and M_4 between some rows.
pub(super) struct Forms<'a> {
    /// G, (n, rows).
    g: Mat<f64>,
    /// P₀, (n, rows).
    p: Mat<f64>,
    residual: Products<'a>,
    third: Products<'a>,
    fourth: Products<'a>,
}

/// How much of each form a symmetric sum has.
pub(super) struct KnownWeights {
    /// Of Pᵀ B_2 P.
    pub residual: c64,
    /// Of Pᵀ B_3 P.
    pub third_between_p: c64,
    /// Of Pᵀ B_3 g + gᵀ B_3 P.
    pub third_mixed: c64,
    /// Of gᵀ B_3 g.
    pub third_between_g: c64,
    /// Of gᵀ M_4 g.
    pub fourth: c64,
}

impl Coordinates {
    fn of(moment: Mat<f64>, t: &Mat<f64>) -> Self {
        let of_t = &moment * t;
        Self {
            between_t: t.transpose() * &of_t,
            of_t,
            moment,
        }
    }
}

impl CoordinateForms {
    pub(super) fn of(model: &Model, moments: &ScaledMoments) -> Self {
        let of = |moment: &Mat<f64>| Coordinates::of(moment.clone(), model.combinations());
        Self {
            residual: of(&moments.residual),
            third: of(&moments.third),
            fourth: of(&moments.fourth),
        }
    }
}

impl<'a> Products<'a> {
    fn of(of: &'a Coordinates, g: &Mat<f64>, p: &Mat<f64>) -> Self {
        let of_g = &of.moment * g;
        let p_with_g = p.transpose() * &of_g;
        Self {
            between_p: p.transpose() * (&of.moment * p),
            mixed: &p_with_g + p_with_g.transpose(),
            p_with_g,
            between_g: g.transpose() * &of_g,
            t_with_p: of.of_t.transpose() * p,
            t_with_g: of.of_t.transpose() * g,
            between_t: &of.between_t,
        }
    }
}

impl<'a> Forms<'a> {
    pub(super) fn of(model: &Model, coordinates: &'a CoordinateForms, rows: &[usize]) -> Self {
        let g = model.static_amounts(rows);
        let p = Mat::from_fn(g.nrows(), g.ncols(), |i, j| {
            f64::from(u8::from(i == rows[j])) - g[(i, j)]
        });
        Self {
            residual: Products::of(&coordinates.residual, &g, &p),
            third: Products::of(&coordinates.third, &g, &p),
            fourth: Products::of(&coordinates.fourth, &g, &p),
            g,
            p,
        }
    }

    /// G and P₀.
    pub(super) fn bases(&self) -> [&Mat<f64>; 2] {
        [&self.g, &self.p]
    }

    /// The sum of forms with these weights, without conjugates, (rows, rows), as what doesn't depend on the dynamic coordinates, to be summed,
    /// and half of the rest, to which its transpose is to be added.
    pub(super) fn symmetric(
        &self,
        weights: KnownWeights,
        amounts: &Amounts<'_>,
    ) -> ([(c64, &Mat<f64>); 5], Split) {
        let Self {
            residual: two,
            third: three,
            fourth: four,
            ..
        } = self;
        let KnownWeights {
            residual,
            third_between_p: pp,
            third_mixed: pg,
            third_between_g: gg,
            fourth,
        } = weights;
        let (coordinates, rows) = two.t_with_p.shape();
        let quadratic = Split::sum(
            coordinates,
            coordinates,
            &[
                (residual, two.between_t),
                (pp - pg * 2.0 + gg, three.between_t),
                (fourth, four.between_t),
            ],
        );
        let mut half = Split::sum(
            coordinates,
            rows,
            &[
                (pg - pp, &three.t_with_p),
                (-residual, &two.t_with_p),
                (gg - pg, &three.t_with_g),
                (fourth, &four.t_with_g),
            ],
        );
        half.add(0.5, &amounts.after(quadratic));
        let still = [
            (residual, &two.between_p),
            (pp, &three.between_p),
            (pg, &three.mixed),
            (gg, &three.between_g),
            (fourth, &four.between_g),
        ];
        (still, amounts.transposed_before(half))
    }

    /// Pᴴ B_2 P + λ Pᴴ B_3 g + λ̄ gᴴ B_3 P + |λ|² gᴴ M_4 g at D = 0, between two rows by their places.
    pub(super) fn hermitian_base(&self, lambda: c64, i: usize, j: usize) -> c64 {
        lambda * self.third.p_with_g[(i, j)]
            + lambda.conj() * self.third.p_with_g[(j, i)]
            + self.residual.between_p[(i, j)]
            + lambda.norm_sqr() * self.fourth.between_g[(i, j)]
    }

    /// Half of the rest of that form: Dᴴ times this, and its adjoint; (coordinates, rows).
    pub(super) fn hermitian_half(&self, lambda: c64, amounts: &Amounts<'_>) -> Split {
        let Self {
            residual: two,
            third: three,
            fourth: four,
            ..
        } = self;
        let (coordinates, rows) = two.t_with_p.shape();
        let real = |value: f64| c64::new(value, 0.0);
        let square = real(lambda.norm_sqr());
        let quadratic = Split::sum(
            coordinates,
            coordinates,
            &[
                (real(1.0), two.between_t),
                (real(-2.0 * lambda.re), three.between_t),
                (square, four.between_t),
            ],
        );
        let mut half = Split::sum(
            coordinates,
            rows,
            &[
                (lambda.conj(), &three.t_with_p),
                (-lambda, &three.t_with_g),
                (square, &four.t_with_g),
                (real(-1.0), &two.t_with_p),
            ],
        );
        half.add(0.5, &Split::after(&quadratic.re, &amounts.values));
        half
    }
}
