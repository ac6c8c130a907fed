//! The length of steps by their errors.

use super::Accuracy;
use super::scale::Scale;
use crate::error::Error;
use crate::integrator::adaptive::up_to;
use crate::integrator::larger;
use crate::system::System;

/// Room that a new step leaves below what is allowed.
const SAFETY: f64 = 0.85;
/// A step that would grow by less stays as it is, with its factors.
const WORTH_GROWING: f64 = 1.2;
/// One that would shrink by less stays, too.
const WORTH_CUTTING: f64 = 0.9;
/// Limits of a change.
const LARGEST_GROWTH: f64 = 3.0;
const LARGEST_CUT: f64 = 0.15;
/// Cut after a step whose iteration failed.
const CUT_AFTER_FAILURE: f64 = 0.4;
/// Where the iteration failed, the next steps stay below that length by this.
const BELOW_FAILURE: f64 = 0.8;
const REMEMBERED: usize = 10;
/// What a step that was made takes off the number of those whose iteration failed.
const MADE: f64 = 0.25;
/// More failures than that, less what steps between them took off, at steps shorter than [`SHRUNK`] of the longest one lately, where joints take more
/// than [`ENLARGED`] times the forces of lately for the same accelerations: shorter steps won't get past what they fail at.
const STUCK: f64 = 1.9;
const SHRUNK: f64 = 0.2;
const ENLARGED: f64 = 10.0;
/// What is left after a step of the longest one lately; as much more may be usual.
const FADING: f64 = 0.9;
/// The shortest step, in parts of the longest or of the horizon.
const SHORTEST: f64 = 1e-10;
/// Angle by which an oscillation that a step follows turns in it for each stage, rad: its order is seen up to there.
const FOLLOWED: f64 = 0.7;
/// The estimate is of a formula of lower order: it may be as large as this times a power of the accuracy by which the method itself has that.
const OF_ESTIMATE: f64 = 0.1;

/// The step to be tried next.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepControl {
    /// What the estimate may be, of places and of forces.
    allowed: f64,
    allowed_of_forces: f64,
    tolerances: [f64; 2],
    /// One over the power of the estimate that the method's own error is.
    power: f64,
    /// One over the order of the estimate's error.
    exponent: f64,
    /// Angle by which oscillations that the method follows turn in a step, rad.
    followed: f64,
    longest: f64,
    shortest: f64,
    next: Option<f64>,
    /// Length and error of the step accepted last.
    before: Option<(f64, f64)>,
    /// Whether the last step was refused.
    was_refused: bool,
    /// A length at which the iteration failed, and for how many steps that is kept in mind.
    failed: (f64, usize),
    /// Failures of the iteration, less what steps since took off.
    failures: f64,
    /// The longest step lately.
    usual: f64,
    /// The largest force of a joint for a unit of acceleration, in the last step and at least lately.
    force: [f64; 2],
    /// Error of forces in the step that was judged last, and in the worst one that was made.
    lost_forces: f64,
    worst_forces: f64,
}

impl StepControl {
    pub(super) fn of(accuracy: &Accuracy, stages: usize) -> Self {
        let s = stages as f64;
        // The method's own error is of the power 2s of the step, that of the estimate of the power s + 1.
        let power = (s + 1.0) / (2.0 * s);
        let allowed = |tolerance: f64| OF_ESTIMATE * tolerance.powf(power);
        Self {
            allowed: allowed(accuracy.tolerance),
            allowed_of_forces: allowed(accuracy.of_forces),
            tolerances: [accuracy.tolerance, accuracy.of_forces],
            power,
            lost_forces: 0.0,
            worst_forces: 0.0,
            exponent: 1.0 / (s + 1.0),
            followed: FOLLOWED * s,
            longest: accuracy.longest,
            shortest: SHORTEST * accuracy.longest.min(accuracy.horizon),
            next: None,
            before: None,
            was_refused: false,
            failed: (f64::INFINITY, 0),
            failures: 0.0,
            usual: 0.0,
            force: [0.0, f64::INFINITY],
        }
    }

    /// An error of places and one of rates, in tolerances. Coordinates whose own oscillation the step doesn't follow are compared with the tolerance itself;
    /// they are taken out of both.
    pub(super) fn in_tolerances(
        &mut self,
        system: &System,
        step: f64,
        scale: &Scale,
        places: &mut [f64],
        rates: &mut [f64],
    ) -> f64 {
        let fastest = (self.followed / step).powi(2);
        let [tolerance, of_forces] = self.tolerances;
        let (mut lost, mut lost_forces): (f64, f64) = (0.0, 0.0);
        for (index, body) in system.bodies.iter().enumerate() {
            let own = body.velocities.start + 6..body.velocities.end;
            let (mut squares, mut squares_of_forces) = (0.0, 0.0);
            for (at, stiffness) in own.zip(&body.flexible.stiffness) {
                if *stiffness > fastest {
                    squares += places[at] * places[at];
                    squares_of_forces += (stiffness * places[at]).powi(2);
                    (places[at], rates[at]) = (0.0, 0.0);
                }
            }
            lost = larger(lost, scale.deflection(index, squares.sqrt()) / tolerance);
            let force = scale.force_in(index, squares_of_forces.sqrt());
            lost_forces = larger(lost_forces, force);
        }
        let places_and_rates = scale.size(system, places).max(scale.size(system, rates));
        let forces = scale.force(system, places);
        self.lost_forces = lost_forces.max((forces / OF_ESTIMATE).powf(1.0 / self.power));
        let followed = (places_and_rates / self.allowed).max(forces / self.allowed_of_forces);
        followed.max(lost).max(lost_forces / of_forces)
    }

    /// Error of the forces in bodies by the worst step so far, relative to the largest forces: about, of one step.
    pub fn error_of_forces(&self) -> f64 {
        self.worst_forces
    }

    pub(super) fn forget(&mut self) {
        (self.next, self.before, self.was_refused) = (None, None, false);
        self.failed = (f64::INFINITY, 0);
        (self.failures, self.usual) = (0.0, 0.0);
        self.force = [0.0, f64::INFINITY];
    }

    /// Forgets how errors changed, after a jump.
    pub fn forget_trend(&mut self) {
        self.before = None;
    }

    /// The step to be tried next where none is known: `size` is that of the accelerations, in lengths.
    pub fn begin(&mut self, earlier_step: f64, size: f64) {
        if self.next.is_none() {
            let by_acceleration = (2.0 * self.allowed / size).sqrt();
            let first = if earlier_step > 0.0 {
                earlier_step
            } else {
                by_acceleration
            };
            self.next = Some(first.clamp(self.shortest, self.longest));
        }
    }

    /// The step to try when `left` remains; the last two share what is left evenly.
    pub fn up_to(&self, left: f64, longest: f64) -> f64 {
        let step = self.next.unwrap_or(self.shortest).min(longest);
        up_to(left, step)
    }

    /// Judges a step by its error and how many iterations it took; returns whether it is accepted.
    ///
    /// # Errors
    /// [`Error::StepTooSmall`] if the shortest step is refused.
    pub fn judge(&mut self, time: f64, tried: f64, error: f64) -> Result<bool, Error> {
        let relative = error.max(1e-12);
        let mut wanted = SAFETY / relative.powf(self.exponent);
        if relative.is_nan() || relative > 1.0 {
            let cut = if wanted.is_nan() {
                LARGEST_CUT
            } else {
                wanted.clamp(LARGEST_CUT, 0.9)
            };
            self.refuse(time, tried, cut, relative)?;
            return Ok(false);
        }
        // What the change of the last two errors tells of the next one (Gustafsson 1994).
        if let Some((step, before)) = self.before {
            let trend = (tried / step) * (before / relative).powf(self.exponent);
            wanted = wanted.min(wanted * trend);
        }
        let mut growth = wanted.clamp(LARGEST_CUT, LARGEST_GROWTH);
        if self.was_refused {
            growth = growth.min(1.0);
        }
        let next = self.next.unwrap_or(tried);
        // A step that was cut short by an end says nothing against a longer one.
        let mut wanted = (tried * growth).min(self.longest);
        let (failed, steps) = self.failed;
        if steps > 0 {
            wanted = wanted.min(BELOW_FAILURE * failed);
            self.failed.1 = steps - 1;
        }
        let is_whole = tried >= next * (1.0 - 1e-9);
        self.next = Some(match is_whole {
            true if (WORTH_CUTTING..WORTH_GROWING).contains(&growth) => tried,
            true => wanted,
            false => wanted.max(next),
        });
        self.before = is_whole.then_some((tried, relative.max(1e-2)));
        self.was_refused = false;
        self.failures = (self.failures - MADE).max(0.0);
        self.worst_forces = larger(self.worst_forces, self.lost_forces);
        self.usual = tried.max(FADING * self.usual);
        Ok(true)
    }

    /// Whether shorter steps won't get past what the iteration fails at: near a dead centre they lead to it, each by a part of the way.
    pub fn is_stuck(&self, tried: f64) -> bool {
        let [now, least] = self.force;
        self.failures > STUCK && tried < SHRUNK * self.usual && now > ENLARGED * least
    }

    /// Told about the largest force of a joint for a unit of acceleration in a step that was made.
    pub fn saw_force(&mut self, force: f64) {
        let [_, least] = self.force;
        self.force = [force, force.min(least / FADING)];
    }

    /// Steps of another method took over, or ended, with steps of this length.
    pub fn begin_anew(&mut self, step: f64) {
        (self.next, self.before, self.was_refused) = (Some(step), None, false);
        self.failed = (f64::INFINITY, 0);
        self.failures = 0.0;
    }

    /// After a step whose iteration failed.
    ///
    /// # Errors
    /// [`Error::StepTooSmall`] if it was the shortest.
    pub fn failed(&mut self, time: f64, tried: f64) -> Result<(), Error> {
        self.failures += 1.0;
        self.failed = (tried, REMEMBERED);
        self.refuse(time, tried, CUT_AFTER_FAILURE, f64::INFINITY)
    }

    fn refuse(&mut self, time: f64, tried: f64, cut: f64, error: f64) -> Result<(), Error> {
        if tried <= self.shortest * (1.0 + 1e-9) {
            return Err(Error::StepTooSmall {
                time,
                smallest: self.shortest,
                error,
            });
        }
        self.next = Some((tried * cut).max(self.shortest));
        self.before = None;
        self.was_refused = true;
        Ok(())
    }
}
