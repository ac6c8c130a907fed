//! How much each mode matters to what is selected.
//!
//! Leaving out one mode φ takes one direction z out of the span of φ and the attachments ζ = G_res L_bᵀ T: with w = c / ω²
//!
//! ```text
//! z  = (1, -v),   v = (P T)ᵀ w                     on (φ, ζ), orthogonal in M to what is left
//! ΔH = p pᵀ / q,  p = L D⁻¹ z,  q = zᵀ D⁻¹ z       D = diag(ω² - λ, σ² - λ)
//! ```
//! so a mode costs only a few products. Where w has a part that no attachment has, absorbing φ adds as much to the attachments as it takes away,
//! and nothing changes at all.

use crate::ResidualFilter;
use dcb_formats::superelement::Superelement;
use faer::{Mat, c64};

use super::Selection;
use super::ports::ScaledPorts;
use super::receptance::{damped, ratio, receptance};
use crate::DynamicCoordinates;
use crate::{Error, Receptance};
use dcb_formats::scene::Compatibility;

impl Selection {
    /// For each mode that is selected, in their order: largest ‖ΔH‖ / ‖H‖ over the given squares of angular frequencies if this mode alone were left out
    /// besides, H the receptance between the forces and rows that are selected, as in [`Selection::receptance_difference`]. Infinite for motions without
    /// stiffness, which can't be left out. Further columns don't count as coordinates here.
    ///
    /// # Errors
    /// Those of [`Selection::superelement`] and [`DynamicCoordinates::of`].
    pub fn participation(&self, whole: &Superelement, squares: &[f64]) -> Result<Vec<f64>, Error> {
        let selection = Self {
            enrichment: Vec::new(),
            truncation: None,
            ..self.clone()
        };
        let basis = selection.basis(whole)?;
        let part = basis.superelement(whole)?;
        let coordinates = DynamicCoordinates::of(&part, Compatibility::Strong)?;
        if coordinates.residual_flexibility.is_some() {
            return selection.participation_one_by_one(whole, squares);
        }
        let ports = ScaledPorts::of(whole, &selection)?;
        let receptance = receptance(&part, &ports, &basis.rows)?;
        let eigenvalues = &part.modes.eigenvalues;
        let rank = coordinates.attached.ncols();
        // What every mode does statically to the rows of the whole.
        let acting = &basis.statics.acting;
        let responses = Mat::from_fn(acting.len(), eigenvalues.len(), |row, k| {
            match acting[row] && eigenvalues[k] > 0.0 {
                true => basis.shapes[(row, selection.modes[k])] / eigenvalues[k],
                false => 0.0,
            }
        });
        let transform = &basis.forces * &coordinates.attached;
        let along = transform.transpose() * &responses;
        let beyond = &responses - &basis.statics.mass * &transform * &along;
        let beyond = basis.forces.transpose() * beyond;
        let masses = &part.residual.mass_diagonal0;
        let mass0 = basis.mass0(whole, &part.residual.mass);
        let least = part.residual.tolerance * ResidualFilter::of(masses, &mass0)?.largest_mass();
        let adds_as_much = |mode: usize| {
            let rows = (0..masses.len()).filter(|row| masses[*row] > 0.0);
            let own: f64 = rows
                .map(|row| beyond[(row, mode)].powi(2) / masses[row])
                .sum();
            own > least
        };

        let mut largest: Vec<f64> = (eigenvalues.iter())
            .map(|value| if *value > 0.0 { 0.0 } else { f64::INFINITY })
            .collect();
        let counted: Vec<usize> = (0..eigenvalues.len())
            .filter(|mode| eigenvalues[*mode] > 0.0 && !adds_as_much(*mode))
            .collect();
        let first = receptance.poles.len() - eigenvalues.len() - rank;
        let missing = Missing {
            receptance: &receptance,
            along: &along,
            first,
            attachments: first + eigenvalues.len(),
        };
        for square in squares {
            let lambda = damped(*square);
            let all = receptance.at(lambda).squared_norm_l2();
            let changes = missing.squares(lambda);
            for mode in &counted {
                largest[*mode] = largest[*mode].max(ratio(changes[*mode], all));
            }
        }
        Ok(largest)
    }

    /// The same by making each superelement: where attachments have flexibility without mass, which z doesn't know of.
    fn participation_one_by_one(
        &self,
        whole: &Superelement,
        squares: &[f64],
    ) -> Result<Vec<f64>, Error> {
        let ports = ScaledPorts::of(whole, self)?;
        let with = |modes: Vec<usize>| -> Result<Vec<Mat<c64>>, Error> {
            let part = Self {
                modes,
                ..self.clone()
            };
            let receptance = receptance(&part.superelement(whole)?, &ports, &ports.rows)?;
            Ok(squares
                .iter()
                .map(|square| receptance.at(damped(*square)))
                .collect())
        };
        let all = with(self.modes.clone())?;
        let without = |mode: &usize| {
            if self.eigenvalues[*mode] <= 0.0 {
                return Ok(f64::INFINITY);
            }
            let others = self.modes.iter().copied().filter(|other| other != mode);
            let found = with(others.collect())?;
            let changes = found
                .iter()
                .zip(&all)
                .map(|(found, all)| ratio((found - all).squared_norm_l2(), all.squared_norm_l2()));
            Ok(changes.fold(0.0, f64::max))
        };
        self.modes.iter().map(without).collect()
    }
}

/// Loss without a mode, for each mode.
struct Missing<'a> {
    receptance: &'a Receptance,
    /// v of each mode, (rank, n_k).
    along: &'a Mat<f64>,
    /// Place of the first mode among the poles.
    first: usize,
    /// Place of the first attachment.
    attachments: usize,
}

impl Missing<'_> {
    /// ‖ΔH‖² of each mode.
    fn squares(&self, lambda: c64) -> Vec<f64> {
        let Receptance {
            poles,
            seen,
            driven,
            ..
        } = self.receptance;
        let (rank, count) = (self.along.nrows(), self.along.ncols());
        let one = c64::new(1.0, 0.0);
        let weights: Vec<c64> = (poles.iter())
            .map(|pole| one / (c64::new(*pole, 0.0) - lambda))
            .collect();
        let part = |take: fn(&c64) -> f64| {
            let z = Mat::from_fn(self.attachments - self.first + rank, count, |i, mode| {
                let weight = take(&weights[self.first + i]);
                match i.checked_sub(self.attachments - self.first) {
                    Some(at) => -weight * self.along[(at, mode)],
                    None if i == mode => weight,
                    None => 0.0,
                }
            });
            let elastic = z.nrows();
            (
                seen.as_ref().subcols(self.first, elastic) * &z,
                driven.as_ref().subrows(self.first, elastic).transpose() * &z,
            )
        };
        let (real, imaginary) = (part(|z| z.re), part(|z| z.im));
        let size = |real: &Mat<f64>, imaginary: &Mat<f64>, mode: usize| {
            real.col(mode).squared_norm_l2() + imaginary.col(mode).squared_norm_l2()
        };
        (0..count)
            .map(|mode| {
                let of_attachments = (0..rank)
                    .map(|i| weights[self.attachments + i] * self.along[(i, mode)].powi(2));
                let q = of_attachments.fold(weights[self.first + mode], |sum, term| sum + term);
                let (seen, driven) = (
                    size(&real.0, &imaginary.0, mode),
                    size(&real.1, &imaginary.1, mode),
                );
                seen * driven / q.norm_sqr()
            })
            .collect()
    }
}
