//! Which residual directions become dynamic coordinates: the transform T_r, found in a scaling that has no unit.

use dcb_dense::{symmetric_eigen, symmetric_eigenvalues, symmetrized};
use dcb_superelement::{MASS_TOLERANCE, ResidualFilter};
use faer::Mat;

use crate::error::Error;

/// Eigenvalues of F_res may be negative by rounding, up to this fraction of the largest with no mode kept.
const NEGATIVE_FLEXIBILITY: f64 = 1e-11;

/// The unit-free filter of `docs/theory.md`: which residual directions become dynamic coordinates.
pub struct Filter {
    /// F_res, negative rounding removed, (n_b, n_b).
    pub flexibility: Mat<f64>,
    /// T_r, (n_b, rank).
    pub transform: Mat<f64>,
    /// σ², ascending.
    pub sigma_squared: Vec<f64>,
    /// Directions with flexibility that the transform leaves out.
    pub static_directions: usize,
    /// Rank of the scaled F_res.
    pub flexibility_rank: usize,
    /// Condition number of the scaled F_res over its rank.
    pub condition: f64,
}

impl Filter {
    /// Filters, given the matrices now and with no mode kept.
    ///
    /// # Errors
    /// [`Error::NotPositive`] if F_res has a negative eigenvalue beyond rounding.
    pub fn of(
        flexibility: &Mat<f64>,
        mass: &Mat<f64>,
        flexibility0: &Mat<f64>,
        mass0: &Mat<f64>,
    ) -> Result<Self, Error> {
        let failed = || Error::NotFinite {
            what: "the residual filter",
        };
        let n_b = flexibility.nrows();
        let scale = |matrix: &Mat<f64>| -> Vec<f64> {
            (0..n_b)
                .map(|i| {
                    if matrix[(i, i)] > 0.0 {
                        1.0 / matrix[(i, i)].sqrt()
                    } else {
                        0.0
                    }
                })
                .collect()
        };
        let scaled = |matrix: &Mat<f64>, e: &[f64]| {
            Mat::from_fn(n_b, n_b, |i, j| e[i] * matrix[(i, j)] * e[j])
        };
        // Rows without any mass but with flexibility are scaled by that.
        let e = scale(flexibility0);
        let whole = symmetric_eigenvalues(scaled(flexibility0, &e).as_ref()).ok_or_else(failed)?;
        let flexibility_reference = whole.last().copied().unwrap_or(0.0);
        let (flexibility, values) = clipped(flexibility, &e, flexibility_reference)?;
        let present: Vec<f64> = values
            .into_iter()
            .filter(|v| *v > MASS_TOLERANCE * flexibility_reference)
            .collect();
        let condition = match (present.first(), present.last()) {
            (Some(smallest), Some(largest)) => largest / smallest,
            _ => 1.0,
        };

        let diagonal: Vec<f64> = (0..n_b).map(|i| mass0[(i, i)]).collect();
        let (transform, sigma_squared) = ResidualFilter::of(&diagonal, mass0)
            .and_then(|filter| filter.directions(MASS_TOLERANCE, &flexibility, mass))
            .map_err(|_| failed())?;
        let static_directions = static_directions(
            &scaled(&flexibility, &e),
            &transform,
            &e,
            flexibility_reference,
        )
        .ok_or_else(failed)?;
        Ok(Self {
            flexibility,
            transform,
            sigma_squared,
            static_directions,
            flexibility_rank: present.len(),
            condition,
        })
    }
}

/// Number of directions of F_res that the transform leaves out: the rank of F - F T (Tᵀ F T)⁻¹ Tᵀ F, scaled.
///
/// With F = S S that is S (I - Q Qᵀ) S, Q an orthonormal basis of S T. Its accuracy does not depend on how far the σ² lie
/// apart, where a sum over F t tᵀ F / σ² would.
fn static_directions(
    flexibility: &Mat<f64>,
    transform: &Mat<f64>,
    e: &[f64],
    reference: f64,
) -> Option<usize> {
    let (values, vectors) = symmetric_eigen(flexibility.as_ref())?;
    let half = Mat::from_fn(values.len(), values.len(), |i, j| {
        values[i].max(0.0).sqrt() * vectors[(j, i)]
    });
    let unscaled = Mat::from_fn(transform.nrows(), transform.ncols(), |i, j| {
        if e[i] > 0.0 {
            transform[(i, j)] / e[i]
        } else {
            0.0
        }
    });
    let mut image = &half * &unscaled;
    for column in image.as_mut().col_iter_mut() {
        let norm = column.norm_l2();
        if norm > 0.0 {
            column.iter_mut().for_each(|entry| *entry /= norm);
        }
    }
    let basis = image.qr().compute_thin_Q();
    let covered = half.transpose() * basis;
    let (rest, _) = symmetric_eigen(
        symmetrized((flexibility - &covered * covered.transpose()).as_ref()).as_ref(),
    )?;
    Some(
        rest.iter()
            .filter(|value| **value > MASS_TOLERANCE * reference)
            .count(),
    )
}

/// F_res with negative eigenvalues (of the scaled matrix) set to zero where they are rounding, and the scaled eigenvalues.
fn clipped(
    flexibility: &Mat<f64>,
    e: &[f64],
    reference: f64,
) -> Result<(Mat<f64>, Vec<f64>), Error> {
    let n_b = flexibility.nrows();
    let scaled = Mat::from_fn(n_b, n_b, |i, j| e[i] * flexibility[(i, j)] * e[j]);
    let (values, vectors) = symmetric_eigen(scaled.as_ref()).ok_or(Error::NotFinite {
        what: "the residual flexibility",
    })?;
    let smallest = values.first().copied().unwrap_or(0.0);
    if smallest < -NEGATIVE_FLEXIBILITY * reference {
        return Err(Error::NotPositive {
            what: "the residual flexibility",
            smallest,
            largest: reference,
            tolerance: NEGATIVE_FLEXIBILITY,
        });
    }
    if smallest >= 0.0 {
        return Ok((flexibility.clone(), values));
    }
    let mut clipped = flexibility.clone();
    for (k, value) in values
        .iter()
        .enumerate()
        .take_while(|(_, value)| **value < 0.0)
    {
        for j in (0..n_b).filter(|j| e[*j] > 0.0) {
            for i in (0..n_b).filter(|i| e[*i] > 0.0) {
                clipped[(i, j)] -= value * vectors[(i, k)] * vectors[(j, k)] / (e[i] * e[j]);
            }
        }
    }
    Ok((symmetrized(clipped.as_ref()), values))
}
