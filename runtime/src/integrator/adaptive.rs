//! Steps as large as a tolerance allows.
//!
//! The error of the positions that a step adds is, to leading order in the step, a multiple of h³ q'''; the change of the
//! accelerations over the step is h q''' to the same order:
//!
//! ```text
//! e = h² |β + (α_m - α_f)/2 - 1/6| (q''_{n+1} - q''_n)
//! ```
//! measured as a length: translation, turn times the body's length, deflection by √mass. Steps with a larger error than allowed are
//! made again, smaller. The step changes only where that pays, because the iteration matrix depends on it.

use super::larger;
use crate::error::Error;
use crate::system::{State, System};
use dcb_formats::scene::Scheme;

/// Room that a new step leaves below the tolerance.
const SAFETY: f64 = 0.8;
/// Steps grow only by more than this, so that the factor is kept.
const WORTH_GROWING: f64 = 1.5;
/// Steps of one size before they grow: a change makes the joints' forces ring, which the error would be mistaken for.
const SETTLING: usize = 3;
/// Largest growth.
const LARGEST_GROWTH: f64 = 2.0;
/// Limits of the cut of a refused step; small cuts in succession would feed the ringing.
const LARGEST_CUT: f64 = 0.1;
const SMALLEST_CUT: f64 = 0.5;
/// Cut after a step whose iteration failed.
const CUT_AFTER_FAILURE: f64 = 0.25;
/// A leftover of the time up to the end below this many steps is spread over two.
const LAST_STEPS: f64 = 2.0;

/// How steps are chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptiveStep {
    /// Error that one step may add to a position, a length.
    pub tolerance: f64,
    /// First step.
    pub first: f64,
    /// Smallest step.
    pub smallest: f64,
    /// Largest step.
    pub largest: f64,
}

/// The step to be tried next, carried from step to step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepSize {
    settings: AdaptiveStep,
    step: f64,
    /// Steps accepted since the step changed.
    settled: usize,
}

impl StepSize {
    /// Starts with the first step.
    pub fn new(settings: AdaptiveStep) -> Self {
        Self {
            step: settings.first.clamp(settings.smallest, settings.largest),
            settings,
            settled: 0,
        }
    }

    /// Goes on where another one was: its [`StepSize::reached`].
    pub fn resumed(settings: AdaptiveStep, (step, settled): (f64, usize)) -> Self {
        Self {
            settings,
            step: step.clamp(settings.smallest, settings.largest),
            settled,
        }
    }

    /// The step to be tried next, and how many were accepted since it changed.
    pub fn reached(&self) -> (f64, usize) {
        (self.step, self.settled)
    }

    /// The settings it was made with.
    pub fn settings(&self) -> &AdaptiveStep {
        &self.settings
    }

    /// The step to try when `left` remains; the last two share what is left evenly.
    pub fn up_to(&self, left: f64) -> f64 {
        up_to(left, self.step)
    }

    /// Judges a step by its error; returns whether it is accepted.
    ///
    /// # Errors
    /// [`Error::StepTooSmall`] if the smallest step is refused.
    pub fn judge(&mut self, time: f64, tried: f64, error: f64) -> Result<bool, Error> {
        let relative = error / self.settings.tolerance;
        let wanted = SAFETY / relative.max(1e-9).cbrt();
        if relative <= 1.0 {
            let growth = wanted.min(LARGEST_GROWTH);
            let is_full = tried >= self.step * (1.0 - 1e-9);
            self.settled += 1;
            if is_full && growth >= WORTH_GROWING && self.settled >= SETTLING {
                self.step = (tried * growth).min(self.settings.largest);
                self.settled = 0;
            }
            return Ok(true);
        }
        self.refuse(
            time,
            tried,
            wanted.clamp(LARGEST_CUT, SMALLEST_CUT),
            relative,
        )?;
        Ok(false)
    }

    /// After a step whose iteration failed.
    ///
    /// # Errors
    /// [`Error::StepTooSmall`] if it was the smallest.
    pub fn failed(&mut self, time: f64, tried: f64) -> Result<(), Error> {
        self.refuse(time, tried, CUT_AFTER_FAILURE, f64::INFINITY)
    }

    fn refuse(&mut self, time: f64, tried: f64, cut: f64, error: f64) -> Result<(), Error> {
        let smallest = self.settings.smallest;
        if tried <= smallest * (1.0 + 1e-9) {
            return Err(Error::StepTooSmall {
                time,
                smallest,
                error,
            });
        }
        self.step = (tried * cut).max(smallest);
        self.settled = 0;
        Ok(())
    }
}

/// A step when `left` remains; the last two share what is left evenly.
pub(super) fn up_to(left: f64, step: f64) -> f64 {
    if left <= step * (1.0 + 1e-9) {
        left
    } else if left < LAST_STEPS * step {
        0.5 * left
    } else {
        step
    }
}

/// Error of the positions that the step from `start` to `end` added, a length.
pub fn local_error(system: &System, scheme: &Scheme, start: &State, end: &State, step: f64) -> f64 {
    let mut largest: f64 = 0.0;
    for body in &system.bodies {
        let own = body.velocities.clone();
        let (before, after) = (&start.accelerations[own.clone()], &end.accelerations[own]);
        let change = |range: std::ops::Range<usize>| {
            let squares = range.map(|i| (after[i] - before[i]).powi(2));
            squares.sum::<f64>().sqrt()
        };
        let size = change(0..3)
            + body.length * change(3..6)
            + change(6..before.len()) / body.flexible.inertia.mass().sqrt();
        largest = larger(largest, size);
    }
    scheme.increment_error().abs() * step * step * largest
}
