//! Errors of a superelement, from the superelement alone: rigorous bounds of its receptance, static response and held frequencies.
//!
//! The file's power moments ([`dcb_formats::superelement::Moments`]) bound the omitted motions on both sides:
//! no finer reduction and no further solution is needed, whatever the band and whichever rows are of interest. `docs/error-estimate.md` has
//! the derivation. Measures, scales and norms are those of `reduce study`.

mod amounts;
mod between;
mod blocks;
mod deviation;
mod forms;
mod held_eigenvalues;
mod interpolation;
mod model;
mod ports;
mod responses;
mod rows;
mod scaled_moments;
mod screening;
mod split;

use dcb_formats::Superelement;
use dcb_formats::scene::Compatibility;
use faer::{Mat, c64};
use serde::{Deserialize, Serialize};

pub use self::between::{ErrorMatrices, ErrorsBetween};
pub use self::held_eigenvalues::HeldEigenvalue;
pub use self::responses::ResponseError;

use self::forms::CoordinateForms;
use self::model::Model;
use self::rows::Rows;
use self::scaled_moments::ScaledMoments;
use crate::Error;
use crate::FrequencyBand;

/// Equally spaced points of a usual band: those of a study.
pub const POINTS: usize = 400;
/// Relative rounding of a moment.
pub const DENSE_ROUNDING: f64 = 64.0 * f64::EPSILON;

/// An error between its bounds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bracket {
    /// The error is not below this.
    pub lower: f64,
    /// The error is not above this.
    pub upper: f64,
}

impl Bracket {
    /// No error.
    const ZERO: Self = Self {
        lower: 0.0,
        upper: 0.0,
    };

    fn including(self, other: Self) -> Self {
        Self {
            lower: self.lower.max(other.lower),
            upper: self.upper.max(other.upper),
        }
    }
}

/// Errors of a superelement over a band. All are relative; rows are scaled by their own flexibility.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Largest error of a frequency with the rows held, within the band; 1 for one that the superelement lacks. Absent if no such frequency
    /// can be there.
    pub held_frequency: Option<Bracket>,
    /// Those frequencies.
    pub held: Vec<HeldEigenvalue>,
    /// Static response with the inertia relieved, of the worst interface.
    pub static_response: Bracket,
    /// Receptance of each interface at itself.
    pub collocated: ResponseError,
    /// Receptance between different interfaces; absent with one.
    pub transfer: Option<ResponseError>,
    /// Upper bound of the relative errors of the kept free frequencies.
    pub free_frequency: f64,
}

/// Errors of a superelement with one compatibility, as far as they are known.
pub struct ErrorBounds {
    compatibility: Compatibility,
    eigenvalue_bound: f64,
    rows: Rows,
    moments: ScaledMoments,
    model: Model,
    coordinates: CoordinateForms,
    /// ω² of the highest kept mode.
    highest: Option<f64>,
}

impl ErrorBounds {
    /// Of a superelement that has moments; `None` if it hasn't, as files before format 1.2, and for weak compatibility, whose errors have no such bounds.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if a dense eigenproblem fails.
    pub fn of(element: &Superelement, compatibility: Compatibility) -> Result<Option<Self>, Error> {
        let moments = match (&element.moments, compatibility) {
            (Some(moments), Compatibility::Strong | Compatibility::Static) => moments,
            _ => return Ok(None),
        };
        let rows = Rows::of(element, moments);
        let model = Model::of(element, moments, &rows, compatibility).ok_or(Error::NotFinite)?;
        let scaled = ScaledMoments::of(moments, &rows);
        let of_forces = (moments.loaded.as_ref()).map(|loaded| loaded.eigenvalue_bound);
        Ok(Some(Self {
            compatibility,
            eigenvalue_bound: of_forces.unwrap_or(moments.eigenvalue_bound),
            coordinates: CoordinateForms::of(&model, &scaled),
            moments: scaled,
            model,
            rows,
            highest: element.modes.eigenvalues.last().copied(),
        }))
    }

    /// How the superelement is used.
    pub fn compatibility(&self) -> Compatibility {
        self.compatibility
    }

    /// No omitted ω² that the rows see is below this: errors are known for ω² below it.
    pub fn eigenvalue_bound(&self) -> f64 {
        self.eigenvalue_bound
    }

    /// The forces of unit amount that the rows stand for, over the rows of the file, (n_b of the file, rows). The rows are those of the file, unless it is made
    /// for some forces only ([`dcb_formats::superelement::Moments::loaded`]): then an attachment has one for each of these, orthonormal in units of the rows'
    /// flexibility, and its motion is what does work on them.
    pub fn forces(&self) -> Mat<f64> {
        self.rows.forces()
    }

    /// Interfaces of a superelement, by their places, that have fewer rows here than in its file, with both numbers.
    pub fn loaded_along(&self, element: &Superelement) -> Vec<(usize, [usize; 2])> {
        (0..element.interfaces.len())
            .filter_map(|interface| {
                let (here, all) = self.rows.counts(interface, element);
                (here < all).then_some((interface, [here, all]))
            })
            .collect()
    }

    /// Rows that forces act on.
    pub fn attached_rows(&self) -> Vec<usize> {
        (0..self.rows.count())
            .filter(|row| self.rows.attached[*row])
            .collect()
    }

    /// The band of a study: so many points up to half the frequency of the highest kept mode, with the resonances; up to half of the lowest one
    /// that was left out where that is less, or no mode is kept. `None` if there is neither.
    pub fn usual_band(&self, points: usize) -> Option<FrequencyBand> {
        let highest = self.highest.filter(|highest| *highest > 0.0);
        let limits = [
            highest,
            Some(self.eigenvalue_bound).filter(|bound| bound.is_finite()),
        ];
        let limit = limits.into_iter().flatten().reduce(f64::min)?;
        Some(self.band(None, 0.25 * limit, points))
    }

    /// So many points between two ω², with the resonances between them.
    pub fn band(&self, from: Option<f64>, to: f64, points: usize) -> FrequencyBand {
        FrequencyBand::new(from, to, points, &self.rows.poles[self.rows.zero_count..])
    }

    /// Errors between some rows ([`ErrorBounds::forces`]) over a band, with a structural loss factor η of the responses: λ = ω² / (1 + iη). Rows of output
    /// interfaces move, but no force acts on them.
    ///
    /// # Errors
    /// [`Error::BandTooHigh`] if the band isn't below the eigenvalue bound; [`Error::NoForce`] if no force acts on the rows; [`Error::NotFinite`].
    pub fn over(
        &self,
        rows: &[usize],
        band: &FrequencyBand,
        loss_factor: f64,
    ) -> Result<Estimate, Error> {
        let [collocated, transfer] = self.responses(rows, band, loss_factor)?;
        let held = self.held(rows, band.top()).ok_or(Error::NotFinite)?;
        let pole_error = self
            .rows
            .pole_errors
            .iter()
            .fold(0.0, |a: f64, b| a.max(*b));
        Ok(Estimate {
            held_frequency: largest_held(&held, band.top()),
            held,
            static_response: self.static_response(rows)?,
            collocated,
            transfer: self.are_several(rows).then_some(transfer),
            free_frequency: 0.5 * pole_error,
        })
    }

    /// The error of the static response alone: the largest over the interfaces, of the responses to forces at its rows.
    ///
    /// # Errors
    /// [`Error::NoForce`] if no force acts on the rows.
    pub fn static_response(&self, rows: &[usize]) -> Result<Bracket, Error> {
        let forced = self.forced(rows)?;
        let still = c64::new(0.0, 0.0);
        let mut worst = Bracket::ZERO;
        let mut interfaces: Vec<usize> = (forced.iter())
            .map(|row| self.rows.interface[*row])
            .collect();
        interfaces.dedup();
        let elastic = self.rows.zero_count..self.rows.poles.len();
        for interface in interfaces {
            let (mut off, mut whole, mut margin) = (0.0_f64, 0.0_f64, 0.0_f64);
            for column in forced
                .iter()
                .filter(|row| self.rows.interface[**row] == interface)
            {
                for row in rows {
                    let exact = self.moments.first[(*row, *column)];
                    let roots = &self.moments.roots[0];
                    let mut rounding = roots[*row] * roots[*column];
                    let mut of_modes = 0.0;
                    for pole in elastic.clone() {
                        let part = self.rows.shapes[(*row, pole)]
                            * self.rows.shapes[(*column, pole)]
                            / self.rows.poles[pole];
                        of_modes += part;
                        rounding +=
                            part.abs() * (3.0 * self.rows.pole_errors[pole] + DENSE_ROUNDING);
                    }
                    let found = self.model.response(*row, *column, still).re;
                    off += (exact - found).powi(2);
                    whole += (exact + of_modes).powi(2);
                    margin += rounding.powi(2);
                }
            }
            worst = worst.including(bracket(off.sqrt(), margin.sqrt(), whole.sqrt()));
        }
        Ok(worst)
    }

    /// Whether the rows belong to more than one interface.
    fn are_several(&self, rows: &[usize]) -> bool {
        let interface = |row: &usize| self.rows.interface[*row];
        rows.iter()
            .map(interface)
            .any(|one| one != interface(&rows[0]))
    }

    /// H and its errors between some rows, at any frequency.
    ///
    /// # Errors
    /// [`Error::NoForce`] if no force acts on the rows.
    pub fn between(&self, rows: &[usize]) -> Result<ErrorsBetween<'_>, Error> {
        let forced = self.forced(rows)?;
        Ok(ErrorsBetween {
            deviations: self.deviations(rows, &forced),
        })
    }

    /// The same at one ω².
    ///
    /// # Errors
    /// As [`ErrorBounds::over`].
    pub fn at(
        &self,
        rows: &[usize],
        square: f64,
        loss_factor: f64,
    ) -> Result<ErrorMatrices, Error> {
        self.between(rows)?.at(square, loss_factor)
    }

    fn forced(&self, rows: &[usize]) -> Result<Vec<usize>, Error> {
        let forced: Vec<usize> = (rows.iter().copied())
            .filter(|row| self.rows.attached.get(*row) == Some(&true))
            .collect();
        let known = rows.iter().all(|row| *row < self.rows.count());
        if forced.is_empty() || !known {
            return Err(Error::NoForce {
                rows: rows.to_vec(),
                count: self.rows.count(),
            });
        }
        Ok(forced)
    }

    fn refuse_beyond(&self, square: f64) -> Result<(), Error> {
        if square > 0.0 && square < self.eigenvalue_bound {
            return Ok(());
        }
        let cycles = |square: f64| square.max(0.0).sqrt() / std::f64::consts::TAU;
        Err(Error::BandTooHigh {
            end: cycles(square),
            limit: cycles(self.eigenvalue_bound),
        })
    }
}

/// ‖known ± margin‖ over ‖whole ± margin‖.
fn bracket(known: f64, margin: f64, whole: f64) -> Bracket {
    if whole + margin <= 0.0 {
        return Bracket::ZERO;
    }
    Bracket {
        lower: (known - margin).max(0.0) / (whole + margin),
        upper: match whole > margin {
            true => (known + margin) / (whole - margin),
            false => f64::INFINITY,
        },
    }
}

/// Errors of held frequencies: those that may be in the band bound it from above, those that surely are from below.
fn largest_held(held: &[HeldEigenvalue], top: f64) -> Option<Bracket> {
    let mut worst: Option<Bracket> = None;
    for one in held.iter().filter(|one| one.lower < top) {
        let (lower, upper) = one.error();
        let error = Bracket {
            lower: if one.upper < top { lower } else { 0.0 },
            upper,
        };
        worst = Some(worst.map_or(error, |worst| worst.including(error)));
    }
    worst
}
