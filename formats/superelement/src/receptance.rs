//! How interfaces move under forces at interfaces: the receptance H of a component, unreduced or reduced, as a sum over poles and a
//! short power series.
//!
//! ```text
//! H(λ) = Σ_p s_p f_p / (λ_p - λ)  +  Σ_j (λ/λ₀)^j S_j        λ = ω² / (1 + iη)
//! ```
//! Rigid motions are poles at zero. With a structural loss factor η the component's receptance is H(λ) / (1 + iη), because
//! K (1 + iη) - ω² M = (1 + iη) (K - λ M).

use faer::{Mat, Scale, c64};

/// H(λ) between rows that are seen and forces.
#[derive(Clone, Debug)]
pub struct Receptance {
    /// λ_p, (p).
    pub poles: Vec<f64>,
    /// s_p by columns, (m, p).
    pub seen: Mat<f64>,
    /// f_p by rows, (p, forces).
    pub driven: Mat<f64>,
    /// S_j, (m, forces) each.
    pub series: Vec<Mat<f64>>,
    /// λ₀: keeps high powers in range.
    pub unit: f64,
}

impl Receptance {
    /// Between m rows and forces on these rows, with S_j symmetric.
    pub fn symmetric(poles: Vec<f64>, shapes: Mat<f64>, series: Vec<Mat<f64>>, unit: f64) -> Self {
        Self {
            poles,
            driven: shapes.transpose().to_owned(),
            seen: shapes,
            series,
            unit,
        }
    }

    /// H at a complex λ, (m, forces).
    pub fn at(&self, lambda: c64) -> Mat<c64> {
        let one = c64::new(1.0, 0.0);
        let weights: Vec<c64> = (self.poles.iter())
            .map(|pole| one / (c64::new(*pole, 0.0) - lambda))
            .collect();
        let mut power = one;
        let powers: Vec<c64> = (self.series.iter())
            .map(|_| {
                let now = power;
                power *= lambda / self.unit;
                now
            })
            .collect();
        let real = self.weighted(|p| weights[p].re, |j| powers[j].re);
        let imaginary = self.weighted(|p| weights[p].im, |j| powers[j].im);
        Mat::from_fn(real.nrows(), real.ncols(), |i, j| {
            c64::new(real[(i, j)], imaginary[(i, j)])
        })
    }

    /// H at a real λ, (m, forces); not finite at a pole.
    pub fn at_real(&self, lambda: f64) -> Mat<f64> {
        self.weighted(
            |p| 1.0 / (self.poles[p] - lambda),
            |j| (lambda / self.unit).powi(j as i32),
        )
    }

    fn weighted(
        &self,
        of_pole: impl Fn(usize) -> f64,
        of_power: impl Fn(usize) -> f64,
    ) -> Mat<f64> {
        let weighted = Mat::from_fn(self.seen.nrows(), self.seen.ncols(), |i, p| {
            self.seen[(i, p)] * of_pole(p)
        });
        let mut sum = &weighted * &self.driven;
        for (j, term) in self.series.iter().enumerate() {
            sum += Scale(of_power(j)) * term;
        }
        sum
    }

    /// The same between combinations of rows: `Wᵀ H W` for W (m, k).
    pub fn between(&self, combinations: &Mat<f64>) -> Self {
        Self {
            poles: self.poles.clone(),
            seen: combinations.transpose() * &self.seen,
            driven: &self.driven * combinations,
            series: (self.series.iter())
                .map(|term| combinations.transpose() * term * combinations)
                .collect(),
            unit: self.unit,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two unit masses joined by a unit spring: K - λ M = [[1 - λ, -1], [-1, 1 - λ]], inverted by hand.
    #[test]
    fn two_masses_and_a_spring() {
        let half = 0.5_f64.sqrt();
        let response = Receptance::symmetric(
            vec![0.0, 2.0],
            Mat::from_fn(2, 2, |i, p| if (i, p) == (1, 1) { -half } else { half }),
            Vec::new(),
            1.0,
        );
        let lambda = c64::new(1.3, -0.2);
        let one = c64::new(1.0, 0.0);
        let diagonal = one - lambda;
        let determinant = diagonal * diagonal - one;
        let found = response.at(lambda);
        for (i, j, expected) in [
            (0, 0, diagonal / determinant),
            (0, 1, one / determinant),
            (1, 1, diagonal / determinant),
        ] {
            assert!((found[(i, j)] - expected).norm_sqr().sqrt() < 1e-14);
        }
        let real = response.at_real(1.3);
        assert!((real[(0, 1)] - 1.0 / (0.09 - 1.0)).abs() < 1e-14);
        // The higher pole as its power series about zero, 1/(2 - λ) = ½ Σ (λ/2)^j.
        let series = Receptance::symmetric(
            vec![0.0],
            Mat::from_fn(2, 1, |_, _| half),
            (0..60)
                .map(|_| Mat::from_fn(2, 2, |i, j| if i == j { 0.25 } else { -0.25 }))
                .collect(),
            2.0,
        );
        let difference = &series.at(c64::new(0.9, -0.1)) - &response.at(c64::new(0.9, -0.1));
        assert!(difference.norm_max() < 1e-14);
    }
}
