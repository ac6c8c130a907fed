//! The residual filter of `docs/theory.md` §6: which residual directions become dynamic coordinates.

use dcb_dense::{symmetric_eigen, symmetric_eigenvalues, symmetrized};
use faer::Mat;

use crate::error::Error;

/// T_r and σ²: the directions of D M_res D above `tolerance` times the largest eigenvalue of D M_res D with no mode kept,
/// D = diag(M_res with no mode kept)^(-1/2), and among them the eigenvectors of F_res.
///
/// # Errors
/// [`Error::NoEigenvalues`] if a matrix isn't finite.
pub(crate) fn filtered(
    tolerance: f64,
    mass_diagonal0: &[f64],
    flexibility: &Mat<f64>,
    mass: &Mat<f64>,
    mass0: &Mat<f64>,
) -> Result<(Mat<f64>, Vec<f64>), Error> {
    let scale = scale(mass_diagonal0);
    let least = tolerance * largest_mass(mass_diagonal0, mass0)?;
    let (masses, vectors) =
        symmetric_eigen(scaled(mass, &scale).as_ref()).ok_or(Error::NoEigenvalues)?;
    let kept: Vec<usize> = (0..masses.len()).filter(|i| masses[*i] > least).collect();
    let normalised = Mat::from_fn(scale.len(), kept.len(), |i, j| {
        scale[i] * vectors[(i, kept[j])] / masses[kept[j]].sqrt()
    });
    let stiffness = symmetrized((normalised.transpose() * flexibility * &normalised).as_ref());
    let (squares, rotation) = symmetric_eigen(stiffness.as_ref()).ok_or(Error::NoEigenvalues)?;
    let sigma_squared = squares.into_iter().map(|square| square.max(0.0)).collect();
    Ok((normalised * rotation, sigma_squared))
}

/// The largest eigenvalue of D M_res D with no mode kept.
///
/// # Errors
/// [`Error::NoEigenvalues`] if it isn't finite.
pub(super) fn largest_mass(mass_diagonal0: &[f64], mass0: &Mat<f64>) -> Result<f64, Error> {
    let all = scaled(mass0, &scale(mass_diagonal0));
    let all = symmetric_eigenvalues(all.as_ref()).ok_or(Error::NoEigenvalues)?;
    Ok(all.last().copied().unwrap_or(0.0))
}

/// diag(D), zero for rows without mass.
fn scale(mass_diagonal0: &[f64]) -> Vec<f64> {
    let masses = mass_diagonal0.iter();
    masses
        .map(|mass| {
            if *mass > 0.0 {
                mass.sqrt().recip()
            } else {
                0.0
            }
        })
        .collect()
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
                let (transform, squares) =
                    filtered(1e-10, &diagonal, &flexibility, &mass, &mass).unwrap();
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
