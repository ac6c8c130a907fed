//! Frequencies with the interfaces held, between bounds.
//!
//! Below λ the component has as many held eigenvalues as free ones, less the negative eigenvalues of H(λ) between independent combinations of
//! rows ([`crate::held_frequencies`]). With H between two quadratic forms the count is between two counts, and where the upper one is at most i
//! the held eigenvalue i isn't below λ; where the lower one is above i it isn't above λ.

use dcb_dense::{symmetric_eigen, symmetric_eigenvalues, symmetrized};
use faer::{Mat, c64};
use serde::{Deserialize, Serialize};

use super::ErrorBounds;
use super::deviation::{Deviations, RestBetween};
use crate::MASS_TOLERANCE;
use crate::held_frequencies::ReducedCoordinates;

/// Directions of the interfaces' flexibility below this fraction of the largest are dependent rows.
const DEPENDENT: f64 = 1e-10;
/// Decades below the reduced eigenvalue that are looked through, and the steps of a bisection over them.
const DECADES: f64 = 15.0;
const STEPS: usize = 12;
/// A count at a pole is made this far beside it, relatively.
const BESIDE: f64 = 1e-13;
/// A search that ends above this isn't told from the whole.
const WHOLE: f64 = 1.0 - 1e-3;

/// A held eigenvalue of the unreduced component between its bounds, ω² in 1/time².
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeldEigenvalue {
    /// Of the superelement; absent if it lacks this one.
    pub reduced: Option<f64>,
    /// Not below this.
    pub lower: f64,
    /// Not above this; infinite if nothing is known.
    pub upper: f64,
}

impl HeldEigenvalue {
    /// Relative error of the superelement's frequency, between its bounds; 1 for one that it lacks.
    pub(super) fn error(&self) -> (f64, f64) {
        match self.reduced {
            Some(found) => {
                let above = |bound: f64| ((found / bound).sqrt() - 1.0).abs();
                let lower = match self.upper < found {
                    true => above(self.upper),
                    false => 0.0,
                };
                (lower, above(self.lower))
            }
            None => (f64::from(u8::from(self.upper.is_finite())), 1.0),
        }
    }
}

/// Side of a two-sided bound of H.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    /// H is not below this.
    Below,
    /// H is not above this.
    Above,
}

/// Rows to be held: independent combinations of them, and the motions that this leaves free.
struct Holding<'a> {
    rows: Vec<usize>,
    deviations: Deviations<'a>,
    independent: Mat<f64>,
    loose: usize,
}

impl ErrorBounds {
    /// Held eigenvalues that are, or may be, below `top`, which is below the eigenvalue bound; ascending.
    ///
    /// `None` if a dense eigenproblem fails, which only numbers that aren't finite cause.
    pub(super) fn held(&self, rows: &[usize], top: f64) -> Option<Vec<HeldEigenvalue>> {
        let holding = self.holding(rows)?;
        let reduced = self.reduced_held(&holding)?;
        let most = self.count(&holding, top, Side::Above)?;
        let certain = self.count(&holding, top, Side::Below)?;
        let error = (self.rows.pole_errors.iter()).fold(0.0, |most: f64, one| most.max(*one));
        let mut found = Vec::new();
        for index in holding.loose..most {
            let reduced = reduced.get(index - holding.loose).copied();
            let start = reduced.map_or(top, |value| value.min(top));
            let below = |share: f64| start * (1.0 - share);
            // As far below as the upper count still has it there.
            let reaches = |share: f64, side: Side| -> Option<bool> {
                Some(self.count(&holding, below(share), side)? > index)
            };
            let lower = match last_share(|share| reaches(share, Side::Above))? {
                Some((_, not)) if not >= WHOLE => 0.0,
                Some((_, not)) => below(not),
                None => below(10_f64.powf(-DECADES)),
            };
            let upper = match (certain > index, reduced) {
                (true, _) => match last_share(|share| reaches(share, Side::Below))? {
                    Some((still, _)) => below(still),
                    None => start,
                },
                (false, Some(value)) => value,
                (false, None) => f64::INFINITY,
            };
            found.push(HeldEigenvalue {
                reduced,
                lower: lower * (1.0 - error),
                upper: upper * (1.0 + error),
            });
        }
        Some(found)
    }

    fn holding(&self, rows: &[usize]) -> Option<Holding<'_>> {
        let part = &self.rows;
        let rows: Vec<usize> = (rows.iter().copied())
            .filter(|row| part.attached[*row])
            .collect();
        let whole = Mat::from_fn(rows.len(), rows.len(), |i, j| {
            let (i, j) = (rows[i], rows[j]);
            let of_poles: f64 = (part.poles.iter().enumerate())
                .map(|(pole, square)| {
                    let weight = if pole < part.zero_count {
                        part.first_elastic
                    } else {
                        *square
                    };
                    part.shapes[(i, pole)] * part.shapes[(j, pole)] / weight
                })
                .sum();
            self.moments.first[(i, j)] + of_poles
        });
        let (values, vectors) = symmetric_eigen(symmetrized(whole.as_ref()).as_ref())?;
        let limit = DEPENDENT * values.last().copied().unwrap_or(0.0);
        let first = values.iter().filter(|value| **value <= limit).count();
        let rigid = Mat::from_fn(rows.len(), part.zero_count, |i, pole| {
            part.shapes[(rows[i], pole)]
        });
        let (motions, _) = symmetric_eigen((rigid.transpose() * &rigid).as_ref())?;
        let limit = DEPENDENT * motions.last().copied().unwrap_or(0.0);
        Some(Holding {
            independent: vectors.subcols(first, values.len() - first).to_owned(),
            loose: motions.iter().filter(|motion| **motion <= limit).count(),
            deviations: self.deviations(&rows, &rows),
            rows,
        })
    }

    /// Held eigenvalues of the superelement.
    fn reduced_held(&self, holding: &Holding<'_>) -> Option<Vec<f64>> {
        let (squares, seen) = self.model.dynamic();
        let rows = &holding.rows;
        let massless = self.model.massless(rows);
        let (values, vectors) = symmetric_eigen(massless.as_ref())?;
        let kept: Vec<usize> = (0..values.len())
            .filter(|k| values[*k] > MASS_TOLERANCE)
            .collect();
        let unit = self.rows.first_elastic;
        let (poles, r) = (self.rows.poles.len(), squares.len());
        let shapes = Mat::from_fn(rows.len(), poles + r + kept.len(), |i, j| match j {
            _ if j < poles => self.rows.shapes[(rows[i], j)],
            _ if j < poles + r => seen[(rows[i], j - poles)],
            _ => {
                let k = kept[j - poles - r];
                vectors[(i, k)] * (values[k] * unit).sqrt()
            }
        });
        let mut stiffness = self.rows.poles.clone();
        stiffness.extend(squares);
        stiffness.extend(std::iter::repeat_n(unit, kept.len()));
        let coordinates = ReducedCoordinates {
            stiffness,
            massless: kept.len(),
            shapes,
        };
        coordinates.held(holding.loose)
    }

    /// Held eigenvalues below λ, the motions that are left free included: at most (from above) or at least (from below). Where λ is a pole a
    /// count beside it serves, on the side on which it can only be worse.
    fn count(&self, holding: &Holding<'_>, lambda: f64, side: Side) -> Option<usize> {
        if holding.independent.ncols() == 0 {
            return Some(self.free_below(lambda));
        }
        let beside = match side {
            Side::Above => lambda * (1.0 + BESIDE),
            Side::Below => lambda * (1.0 - BESIDE),
        };
        let counted = self.counted(holding, lambda, side);
        counted.or_else(|| self.counted(holding, beside, side))
    }

    fn counted(&self, holding: &Holding<'_>, lambda: f64, side: Side) -> Option<usize> {
        let rows = &holding.rows;
        let found = (holding.deviations).at(c64::new(lambda, 0.0), RestBetween::AllRows);
        let margin = |i: usize| -> f64 { (0..rows.len()).map(|j| found.rounding[(i, j)]).sum() };
        let sign = match side {
            Side::Above => 1.0,
            Side::Below => -1.0,
        };
        let bound = Mat::from_fn(rows.len(), rows.len(), |i, j| {
            let own = if i == j { margin(i) } else { 0.0 };
            found.reduced.re[(i, j)] + found.known.re[(i, j)] + sign * (found.rest[(i, j)].re + own)
        });
        let held = holding.independent.transpose() * bound * &holding.independent;
        let values = symmetric_eigenvalues(symmetrized(held.as_ref()).as_ref())?;
        let negative = values.iter().filter(|value| **value < 0.0).count();
        Some(self.free_below(lambda).saturating_sub(negative))
    }

    fn free_below(&self, lambda: f64) -> usize {
        let poles = self.rows.poles.iter();
        poles.filter(|pole| **pole < lambda).count()
    }
}

/// The largest share for which something holds and the smallest for which it doesn't, as a bisection over decades finds them; `None` if it
/// doesn't hold for the smallest share.
fn last_share(holds: impl Fn(f64) -> Option<bool>) -> Option<Option<(f64, f64)>> {
    let share = |decades: f64| 10_f64.powf(-decades);
    let (mut still, mut not) = (DECADES, 0.0);
    if !holds(share(still))? {
        return Some(None);
    }
    for _ in 0..STEPS {
        let middle = 0.5 * (still + not);
        match holds(share(middle))? {
            true => still = middle,
            false => not = middle,
        }
    }
    Some(Some((share(still), share(not))))
}
