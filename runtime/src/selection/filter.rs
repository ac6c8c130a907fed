//! The residual filter of `docs/theory.md` §6: which residual directions become dynamic coordinates.

use faer::Mat;

use super::statics::symmetrized;
use super::symmetric_eigen::symmetric_eigen;
use crate::error::Error;

/// T_r and σ²: the directions of D M_res D above `tolerance` times the largest eigenvalue of D M_res D with no mode kept,
/// D = diag(M_res with no mode kept)^(-1/2), and among them the eigenvectors of F_res.
///
/// # Errors
/// [`Error::NoEigenvalues`] if a matrix isn't finite.
pub(super) fn filtered(
    tolerance: f64,
    mass_diagonal0: &[f64],
    flexibility: &Mat<f64>,
    mass: &Mat<f64>,
    mass0: &Mat<f64>,
) -> Result<(Mat<f64>, Vec<f64>), Error> {
    let scale = scale(mass_diagonal0);
    let least = tolerance * largest_mass(mass_diagonal0, mass0)?;
    let (masses, vectors) = symmetric_eigen(&scaled(mass, &scale))?;
    let kept: Vec<usize> = (0..masses.len()).filter(|i| masses[*i] > least).collect();
    let normalised = Mat::from_fn(scale.len(), kept.len(), |i, j| {
        scale[i] * vectors[(i, kept[j])] / masses[kept[j]].sqrt()
    });
    let stiffness = symmetrized(normalised.transpose() * flexibility * &normalised);
    let (squares, rotation) = symmetric_eigen(&stiffness)?;
    let sigma_squared = squares.into_iter().map(|square| square.max(0.0)).collect();
    Ok((normalised * rotation, sigma_squared))
}

/// The largest eigenvalue of D M_res D with no mode kept.
///
/// # Errors
/// [`Error::NoEigenvalues`] if it isn't finite.
pub(super) fn largest_mass(mass_diagonal0: &[f64], mass0: &Mat<f64>) -> Result<f64, Error> {
    let (all, _) = symmetric_eigen(&scaled(mass0, &scale(mass_diagonal0)))?;
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
