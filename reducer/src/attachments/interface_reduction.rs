//! Interface reduction: the residual flexibility cut down to its softest directions, with what that leaves out.
//!
//! With E = diag(F₀)^(-1/2), F₀ = F_res with no mode kept, the scaled matrix has no unit (`docs/theory.md`, section 6):
//!
//! ```text
//! E F_res E = U Λ Uᵀ            Λ descending; E F₀ E has a unit diagonal
//! P = E U_N U_Nᵀ E⁻¹            projector of interface forces
//! X' = X P,  F' = F_res P = E⁻¹ U_N Λ_N U_Nᵀ E⁻¹,  M' = Pᵀ M_res P
//! ```
//! F' is the best approximation of rank N in that scaling, and F_res - F' is positive semi-definite: the part becomes stiffer.

use dcb_dense::{symmetric_eigen, symmetrized};
use dcb_sparse::block_algebra::{column_norms, combination};
use dcb_superelement::CLUSTER_TOLERANCE;
use faer::{Mat, MatRef};
use serde::{Deserialize, Serialize};

use crate::attachments::residual::ResidualFlexibility;
use crate::error::Error;
use crate::model::localization::Localization;
use dcb_superelement::MASS_TOLERANCE;

/// A row of whose motion less than this part is kept has kept rounding.
const NOTHING_KEPT: f64 = 1e-12;

/// How many directions of their residual flexibility the interfaces keep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "Option<usize>", into = "Option<usize>")]
pub enum InterfaceModes {
    /// All that they have.
    #[default]
    All,
    /// This many of the softest (a multiple eigenvalue is never cut, so it may be more).
    Softest(usize),
}

impl InterfaceModes {
    /// As an option says it.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        match (text, text.parse()) {
            ("all", _) => Ok(Self::All),
            (_, Ok(count)) => Ok(Self::Softest(count)),
            (_, Err(_)) => Err("a number of interface modes is wanted, 0 or more".into()),
        }
    }
}

impl From<Option<usize>> for InterfaceModes {
    fn from(count: Option<usize>) -> Self {
        count.map_or(Self::All, Self::Softest)
    }
}

impl From<InterfaceModes> for Option<usize> {
    fn from(modes: InterfaceModes) -> Self {
        match modes {
            InterfaceModes::All => None,
            InterfaceModes::Softest(count) => Some(count),
        }
    }
}

/// Contents that an interface reduction kept, and contents that it left out. Errors are relative and have no unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InterfaceReduction {
    /// Directions asked for.
    pub wanted: usize,
    /// Directions kept: more than asked for where that would cut a multiple eigenvalue, fewer where there are fewer.
    pub kept: usize,
    /// Directions that F_res has.
    pub available: usize,
    /// Largest share of its residual flexibility, (F_res - F')_ii / (F_res)_ii, that a row loses.
    pub residual_error: f64,
    /// Largest share of its whole static flexibility, (F_res - F')_ii / (F₀)_ii, that a row loses.
    pub flexibility_error: f64,
    /// The row that loses the latter; `None` if nothing is left out.
    pub stiffened_most: Option<String>,
    /// Largest eigenvalue of E (F_res - F') E: gᵀ (F_res - F') g is at most this times Σ (F₀)_ii g_i² for any interface forces g.
    pub largest_left_out: f64,
    /// Largest gᵀ (F_res - F') g / gᵀ F₀ g over all interface forces; 1 if some combination of forces meets no flexibility at all.
    pub worst_direction_error: f64,
    /// Lowest frequency of the attachment coordinates left out, cycles per time unit; `None` if none has mass.
    pub lowest_left_out: Option<f64>,
}

impl InterfaceReduction {
    /// Whether a direction was left out.
    pub fn leaves_out(&self) -> bool {
        self.kept < self.available
    }
}

/// The projector P and what it leaves out.
pub struct Truncation {
    /// E U_N, (n_b, kept).
    forces: Mat<f64>,
    /// U_Nᵀ E⁻¹, (kept, n_b).
    amounts: Mat<f64>,
    /// For people and for the quality report.
    pub report: InterfaceReduction,
}

impl Truncation {
    /// Keeps the `wanted` softest directions of the residual flexibility.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if an eigenproblem fails.
    pub fn of(
        residual: &ResidualFlexibility,
        localization: &Localization,
        wanted: usize,
    ) -> Result<Self, Error> {
        let spectrum = ScaledSpectrum::of(residual)?;
        let kept = spectrum.uncut(wanted);
        let n_b = spectrum.scale.len();
        let inverse = |d: f64| if d > 0.0 { 1.0 / d } else { 0.0 };
        let forces = Mat::from_fn(n_b, kept, |i, j| {
            spectrum.scale[i] * spectrum.vectors[(i, j)]
        });
        let amounts = Mat::from_fn(kept, n_b, |i, j| {
            inverse(spectrum.scale[j]) * spectrum.vectors[(j, i)]
        });
        let report = spectrum.report(residual, localization, wanted, kept)?;
        Ok(Self {
            forces,
            amounts,
            report,
        })
    }

    /// X' = X P, shaped like the columns X, (n, n_b). Rows of which nothing is kept but rounding have no motion.
    pub fn project(&self, columns: MatRef<'_, f64>) -> Mat<f64> {
        let kept = combination(columns, self.forces.as_ref());
        let mut projected = combination(kept.as_ref(), self.amounts.as_ref());
        let sizes = column_norms(projected.as_ref()).into_iter();
        for (row, (left, whole)) in sizes.zip(column_norms(columns)).enumerate() {
            if left <= NOTHING_KEPT * whole {
                projected.as_mut().col_mut(row).fill(0.0);
            }
        }
        projected
    }
}

/// Eigenvalues and eigenvectors of E F_res E that are not rounding, softest first.
struct ScaledSpectrum {
    /// diag(E), zero for rows without flexibility.
    scale: Vec<f64>,
    /// Λ, descending.
    values: Vec<f64>,
    /// U, (n_b, available).
    vectors: Mat<f64>,
    /// Eigenvalues and eigenvectors of E F₀ E that are not rounding.
    whole: (Vec<f64>, Mat<f64>),
}

fn failed() -> Error {
    Error::NotFinite {
        what: "the interface reduction",
    }
}

/// Eigenpairs above the tolerance times `reference` (the largest eigenvalue if `None`), descending.
fn significant(
    matrix: MatRef<'_, f64>,
    reference: Option<f64>,
) -> Result<(Vec<f64>, Mat<f64>), Error> {
    let (values, vectors) = symmetric_eigen(matrix).ok_or_else(failed)?;
    let reference = reference.or(values.last().copied()).unwrap_or(0.0);
    let chosen: Vec<usize> = (0..values.len())
        .rev()
        .filter(|k| values[*k] > MASS_TOLERANCE * reference)
        .collect();
    let columns = Mat::from_fn(vectors.nrows(), chosen.len(), |i, j| {
        vectors[(i, chosen[j])]
    });
    Ok((chosen.iter().map(|k| values[*k]).collect(), columns))
}

impl ScaledSpectrum {
    fn of(residual: &ResidualFlexibility) -> Result<Self, Error> {
        let n_b = residual.flexibility.nrows();
        let scale: Vec<f64> = (0..n_b)
            .map(|i| residual.flexibility0[(i, i)])
            .map(|f0| if f0 > 0.0 { 1.0 / f0.sqrt() } else { 0.0 })
            .collect();
        let scaled = |matrix: &Mat<f64>| {
            let raw = Mat::from_fn(n_b, n_b, |i, j| scale[i] * matrix[(i, j)] * scale[j]);
            symmetrized(raw.as_ref())
        };
        let whole = significant(scaled(&residual.flexibility0).as_ref(), None)?;
        let reference = whole.0.first().copied();
        let (values, vectors) = significant(scaled(&residual.flexibility).as_ref(), reference)?;
        Ok(Self {
            scale,
            values,
            vectors,
            whole,
        })
    }

    /// `wanted`, or as many more as close a gap that is rounding.
    fn uncut(&self, wanted: usize) -> usize {
        let available = self.values.len();
        let mut kept = wanted.min(available);
        while 0 < kept
            && kept < available
            && self.values[kept] > (1.0 - CLUSTER_TOLERANCE) * self.values[kept - 1]
        {
            kept += 1;
        }
        kept
    }

    fn report(
        &self,
        residual: &ResidualFlexibility,
        localization: &Localization,
        wanted: usize,
        kept: usize,
    ) -> Result<InterfaceReduction, Error> {
        let available = self.values.len();
        let lost = |i: usize| -> f64 {
            (kept..available)
                .map(|k| self.values[k] * self.vectors[(i, k)].powi(2))
                .sum()
        };
        let of_residual = |i: usize| {
            let own = residual.flexibility[(i, i)] * self.scale[i].powi(2);
            if own > MASS_TOLERANCE {
                (lost(i) / own).min(1.0)
            } else {
                0.0
            }
        };
        let worst = (0..self.scale.len())
            .map(|i| (i, lost(i)))
            .filter(|(_, share)| *share > 0.0)
            .max_by(|a, b| a.1.total_cmp(&b.1));
        Ok(InterfaceReduction {
            wanted,
            kept,
            available,
            residual_error: (0..self.scale.len()).map(of_residual).fold(0.0, f64::max),
            flexibility_error: worst.map_or(0.0, |(_, share)| share.min(1.0)),
            stiffened_most: worst.map(|(row, _)| localization.row_name(row)),
            largest_left_out: self.values.get(kept).copied().unwrap_or(0.0),
            worst_direction_error: self.worst_direction(kept)?,
            lowest_left_out: self.lowest_left_out(residual, kept)?,
        })
    }

    /// Largest eigenvalue of E (F_res - F') E relative to E F₀ E, on the range of the latter.
    fn worst_direction(&self, kept: usize) -> Result<f64, Error> {
        let left = self.values.len() - kept;
        let (whole, directions) = &self.whole;
        // H Hᵀ with H = B^(-1/2) U' Λ'^(1/2) has the eigenvalues wanted; Hᵀ H is smaller.
        let half = Mat::from_fn(whole.len(), left, |i, k| {
            let column = kept + k;
            let along: f64 = (0..directions.nrows())
                .map(|row| directions[(row, i)] * self.vectors[(row, column)])
                .sum();
            along * (self.values[column] / whole[i]).sqrt()
        });
        let product = symmetrized((half.transpose() * &half).as_ref());
        let (values, _) = symmetric_eigen(product.as_ref()).ok_or_else(failed)?;
        Ok(values.last().copied().unwrap_or(0.0).clamp(0.0, 1.0))
    }

    /// Lowest eigenvalue of (F_res, M_res) over the forces E U', as a frequency.
    fn lowest_left_out(
        &self,
        residual: &ResidualFlexibility,
        kept: usize,
    ) -> Result<Option<f64>, Error> {
        let left = self.values.len() - kept;
        // Unit strain energy: what is left has 1/σ² as eigenvalues.
        let forces = Mat::from_fn(self.scale.len(), left, |i, k| {
            self.scale[i] * self.vectors[(i, kept + k)] / self.values[kept + k].sqrt()
        });
        let mass = symmetrized((forces.transpose() * &residual.mass * &forces).as_ref());
        let (values, _) = symmetric_eigen(mass.as_ref()).ok_or_else(failed)?;
        Ok(values
            .last()
            .filter(|largest| **largest > 0.0)
            .map(|largest| 1.0 / (largest.sqrt() * 2.0 * std::f64::consts::PI)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spectrum(values: &[f64]) -> ScaledSpectrum {
        ScaledSpectrum {
            scale: vec![1.0; values.len()],
            values: values.to_vec(),
            vectors: Mat::identity(values.len(), values.len()),
            whole: (
                vec![1.0; values.len()],
                Mat::identity(values.len(), values.len()),
            ),
        }
    }

    #[test]
    fn a_multiple_eigenvalue_is_kept_whole() {
        let spectrum = spectrum(&[0.9, 0.5, 0.5 - 1e-9, 0.5 - 2e-9, 0.1]);
        let kept: Vec<usize> = (0..8).map(|wanted| spectrum.uncut(wanted)).collect();
        assert_eq!(kept, [0, 1, 4, 4, 4, 5, 5, 5]);
    }

    #[test]
    fn the_worst_direction_is_the_largest_eigenvalue_left_out() {
        let spectrum = spectrum(&[0.9, 0.5, 0.1]);
        let worst: Vec<f64> = (0..4)
            .map(|kept| spectrum.worst_direction(kept).unwrap_or(f64::NAN))
            .collect();
        for (found, expected) in worst.iter().zip([0.9, 0.5, 0.1, 0.0]) {
            assert!((found - expected).abs() < 1e-14, "{worst:?}");
        }
    }
}
