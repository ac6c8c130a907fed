//! The residual filter of `docs/theory.md` §6: which residual directions become dynamic coordinates.

use dcb_dense::{symmetric_eigen, symmetric_eigenvalues, symmetrized};
use faer::Mat;

/// A matrix has an entry that is no number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("numbers overflowed")]
pub struct NotFinite;

/// Directions with mass: those of D M_res D above a tolerance times the largest eigenvalue of D M_res D with no mode kept, with
/// D = diag(M_res with no mode kept)^(-1/2), which has no unit.
pub struct ResidualFilter {
    /// diag(D), (n_b); zero for rows without mass.
    scale: Vec<f64>,
    /// The largest eigenvalue of D M_res D with no mode kept.
    largest: f64,
}

impl ResidualFilter {
    /// In the scale of M_res with no mode kept, (n_b, n_b), and its diagonal, where rows that don't take part have zeros.
    ///
    /// # Errors
    /// [`NotFinite`].
    pub fn of(mass_diagonal0: &[f64], mass0: &Mat<f64>) -> Result<Self, NotFinite> {
        let scale: Vec<f64> = mass_diagonal0
            .iter()
            .map(|mass| match *mass > 0.0 {
                true => mass.sqrt().recip(),
                false => 0.0,
            })
            .collect();
        let values = symmetric_eigenvalues(scaled(mass0, &scale).as_ref()).ok_or(NotFinite)?;
        Ok(Self {
            scale,
            largest: values.last().copied().unwrap_or(0.0),
        })
    }

    /// The largest eigenvalue of D M_res D with no mode kept.
    pub fn largest_mass(&self) -> f64 {
        self.largest
    }

    /// T_r, (n_b, rank), and σ², ascending: the directions of M_res above the tolerance, and among them the eigenvectors of F_res, so that
    /// T_rᵀ M_res T_r = I and T_rᵀ F_res T_r = diag(σ²).
    ///
    /// # Errors
    /// [`NotFinite`].
    pub fn directions(
        &self,
        tolerance: f64,
        flexibility: &Mat<f64>,
        mass: &Mat<f64>,
    ) -> Result<(Mat<f64>, Vec<f64>), NotFinite> {
        let scale = &self.scale;
        let least = tolerance * self.largest;
        let (masses, vectors) = symmetric_eigen(scaled(mass, scale).as_ref()).ok_or(NotFinite)?;
        let kept: Vec<usize> = (0..masses.len()).filter(|i| masses[*i] > least).collect();
        let normalised = Mat::from_fn(scale.len(), kept.len(), |i, j| {
            scale[i] * vectors[(i, kept[j])] / masses[kept[j]].sqrt()
        });
        let stiffness = symmetrized(normalised.transpose() * flexibility * &normalised);
        let (squares, rotation) = symmetric_eigen(stiffness.as_ref()).ok_or(NotFinite)?;
        let sigma_squared = squares.into_iter().map(|square| square.max(0.0)).collect();
        Ok((normalised * rotation, sigma_squared))
    }
}

fn scaled(matrix: &Mat<f64>, scale: &[f64]) -> Mat<f64> {
    Mat::from_fn(scale.len(), scale.len(), |i, j| {
        scale[i] * matrix[(i, j)] * scale[j]
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// σ² of 1, 2 and 7, each many times, of rows whose masses differ by 1e16: T_rᵀ M T_r = I, T_rᵀ F T_r = diag(σ²).
    #[test]
    fn directions_of_repeated_roots_are_orthogonal() {
        for n in [60, 130, 300] {
            for size in [1.0, 1e-30, 1e30] {
                let v = |i: usize| (1.0 + i as f64).sqrt().fract() - 0.5;
                let square: f64 = (0..n).map(|i| v(i).powi(2)).sum();
                let turn = Mat::from_fn(n, n, |i, j| {
                    f64::from(u8::from(i == j)) - 2.0 * v(i) * v(j) / square
                });
                let row = |i: usize| 10_f64.powi((i % 5) as i32 * 2 - 4);
                let root = |k: usize| [1.0_f64, 2.0, 7.0][3 * k / n];
                let of = |power: i32| {
                    let sum = |i: usize, j: usize| -> f64 {
                        (0..n)
                            .map(|k| turn[(i, k)] * root(k).powi(power) * turn[(j, k)])
                            .sum()
                    };
                    Mat::from_fn(n, n, |i, j| {
                        size * row(i) * row(j) * sum(i.min(j), i.max(j))
                    })
                };
                let (mass, flexibility) = (of(0), of(1));
                let diagonal: Vec<f64> = (0..n).map(|i| mass[(i, i)]).collect();
                let filter = ResidualFilter::of(&diagonal, &mass).unwrap();
                let (transform, squares) = filter.directions(1e-10, &flexibility, &mass).unwrap();
                assert_eq!(squares.len(), n);
                let unit = transform.transpose() * &mass * &transform - Mat::<f64>::identity(n, n);
                let stiffness = transform.transpose() * &flexibility * &transform;
                let defect = Mat::from_fn(n, n, |i, j| {
                    stiffness[(i, j)] - if i == j { squares[i] } else { 0.0 }
                });
                let defect = unit.norm_max().max(defect.norm_max());
                assert!(defect < 1e-11, "{n} rows of size {size:e}: {defect:e}");
                for (k, square) in squares.iter().enumerate() {
                    assert!((square - root(k)).abs() < 1e-11, "{n}: {square}");
                }
            }
        }
    }
}
