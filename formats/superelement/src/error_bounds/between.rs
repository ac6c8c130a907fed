//! Errors entry by entry between some rows of a superelement, in the file's units.

use faer::{Mat, c64};

use super::deviation::{Deviations, RestBetween};
use super::split::Split;
use crate::Error;

/// H of a superelement between rows at one frequency, with its error. All are in the file's units; forces act on the columns' rows.
#[derive(Clone, Debug)]
pub struct ErrorMatrices {
    /// Rows that forces act on, which the columns belong to.
    pub forced: Vec<usize>,
    /// H(λ) of the superelement.
    pub reduced: Mat<c64>,
    /// H - H of the superelement is this,
    pub difference: Mat<c64>,
    /// give or take this, entry by entry.
    pub radius: Mat<f64>,
}

/// The same for any frequency: what doesn't depend on it is computed once.
pub struct ErrorsBetween<'a> {
    pub(super) deviations: Deviations<'a>,
}

impl ErrorsBetween<'_> {
    /// At ω², with a structural loss factor.
    ///
    /// # Errors
    /// [`Error::BandTooHigh`] if it isn't below the eigenvalue bound.
    pub fn at(&self, square: f64, loss_factor: f64) -> Result<ErrorMatrices, Error> {
        let of = &self.deviations;
        of.bounds.refuse_beyond(square)?;
        let damping = c64::new(1.0, loss_factor);
        let lambda = c64::new(square, 0.0) / damping;
        let found = of.at(lambda, RestBetween::RowsOfAnInterface);
        let (rows, forced, places) = (&of.rows, &of.forced, &of.places);
        let scale = &of.bounds.rows.scale;
        // Back from scaled rows, and H / (1 + iη) is the damped component's.
        let unscaled = |i: usize, j: usize| {
            let whole = scale[rows[i]] * scale[forced[j]];
            if whole > 0.0 { 1.0 / whole } else { 0.0 }
        };
        let damped = |matrix: &Split| {
            Mat::from_fn(rows.len(), forced.len(), |i, j| {
                matrix.at(i, j) * unscaled(i, j) / damping
            })
        };
        let radius = Mat::from_fn(rows.len(), forced.len(), |i, j| {
            let rest =
                found.rest[(i, i)].re.max(0.0) * found.rest[(places[j], places[j])].re.max(0.0);
            (rest.sqrt() + found.rounding[(i, j)] + found.of_modes[(i, j)]) * unscaled(i, j)
                / damping.norm()
        });
        Ok(ErrorMatrices {
            reduced: damped(&found.reduced),
            difference: damped(&found.known),
            radius,
            forced: forced.clone(),
        })
    }
}
