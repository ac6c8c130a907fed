//! The largest errors of responses over a band. Ceilings of the errors say at which of its points they can be ([`super::screening`]); these are looked at.

use std::cmp::Ordering;

use faer::c64;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::blocks::{Blocks, InterfacePairs};
use super::deviation::{Deviations, RestBetween};
use super::screening::ceilings;
use super::{Bracket, ErrorBounds};
use crate::{Error, FrequencyBand};

/// Points looked at together, for each kind of response and each side of its error.
const AT_ONCE: usize = 2;
/// Nothing is known of a point.
const NO_CEILING: Bracket = Bracket {
    lower: f64::INFINITY,
    upper: f64::INFINITY,
};

/// The largest error of a response over a band.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResponseError {
    /// Largest ‖H - H_ref‖ / ‖H_ref‖ of the frequencies, over all entries concerned.
    pub largest: Bracket,
    /// ω² where the upper bound is largest.
    pub at: f64,
}

impl ErrorBounds {
    /// The errors of responses alone, which cost least: of each interface at itself, and between different ones (zero with one).
    ///
    /// # Errors
    /// As [`ErrorBounds::over`].
    pub fn responses(
        &self,
        rows: &[usize],
        band: &FrequencyBand,
        loss_factor: f64,
    ) -> Result<[ResponseError; 2], Error> {
        let forced = self.forced(rows)?;
        self.refuse_beyond(band.top())?;
        let deviations = self.deviations(rows, &forced);
        let errors = largest_errors(&deviations, band, loss_factor);
        Ok(InterfacePairs::ALL.map(|kind| {
            let mut most = ResponseError {
                largest: Bracket::ZERO,
                at: band.top(),
            };
            for (error, square) in errors.iter().zip(&band.squares) {
                let Some(error) = error.map(|of| of[kind as usize]) else {
                    continue;
                };
                if error.upper > most.largest.upper {
                    most.at = *square;
                }
                most.largest = most.largest.including(error);
            }
            most
        }))
    }
}

/// Errors at the points of a band; `None` where they are below some that are found.
fn largest_errors(
    of: &Deviations<'_>,
    band: &FrequencyBand,
    loss_factor: f64,
) -> Vec<Option<[Bracket; 2]>> {
    let lambdas: Vec<c64> = band.damped(loss_factor).collect();
    let ceilings =
        ceilings(of, band, loss_factor).unwrap_or_else(|| vec![[NO_CEILING; 2]; lambdas.len()]);
    let mut found: Vec<Option<[Bracket; 2]>> = vec![None; lambdas.len()];
    loop {
        let known = found.iter().flatten();
        let most = known.fold([Bracket::ZERO; 2], |most, of| {
            InterfacePairs::ALL.map(|kind| most[kind as usize].including(of[kind as usize]))
        });
        let points = next_points(&ceilings, &found, &most);
        if points.is_empty() {
            return found;
        }
        let errors: Vec<[Bracket; 2]> = points
            .par_iter()
            .map(|point| of.blocks(lambdas[*point]).errors())
            .collect();
        for (point, errors) in points.into_iter().zip(errors) {
            found[point] = Some(errors);
        }
    }
}

/// The points that may have more than is found, the highest ceilings first; all of them where nothing tells them apart.
fn next_points(
    ceilings: &[[Bracket; 2]],
    found: &[Option<[Bracket; 2]>],
    most: &[Bracket; 2],
) -> Vec<usize> {
    let mut next = Vec::new();
    for kind in InterfacePairs::ALL.map(|kind| kind as usize) {
        let sides: [fn(&Bracket) -> f64; 2] = [|of| of.upper, |of| of.lower];
        for side in sides {
            let ceiling = |point: &usize| side(&ceilings[*point][kind]);
            // A ceiling that isn't a number tells nothing.
            let may_exceed = |point: &usize| {
                let compared = ceiling(point).partial_cmp(&side(&most[kind]));
                compared.is_none_or(Ordering::is_gt)
            };
            let mut open: Vec<usize> = (0..found.len())
                .filter(|point| found[*point].is_none() && may_exceed(point))
                .collect();
            open.sort_by(|a, b| ceiling(b).total_cmp(&ceiling(a)));
            let unlimited = open.partition_point(|point| ceiling(point) == f64::INFINITY);
            open.truncate(unlimited.max(AT_ONCE));
            next.extend(open);
        }
    }
    next.sort_unstable();
    next.dedup();
    next
}

impl Deviations<'_> {
    /// Norms of the deviation at one λ.
    fn blocks(&self, lambda: c64) -> Blocks {
        let deviation = self.at(lambda, RestBetween::RowsOfAnInterface);
        let interface = &self.bounds.rows.interface;
        Blocks::of(&deviation, interface, &self.rows, &self.forced)
    }
}
