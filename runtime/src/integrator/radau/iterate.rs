//! The iteration over all stages of a step.

use faer::c64;
use nalgebra::Vector3;

use super::Radau;
use super::stage::{Stage, integrate};
use crate::error::Error;
use crate::integrator::larger;
use crate::integrator::newton::Corrector;
use crate::integrator::profile::Watch;
use crate::integrator::{Effort, Profile};
use crate::system::body_factor::Elastic;
use crate::system::condensed::{Blend, Interfaces};
use crate::system::number::Number;
use crate::system::{State, System};

/// Iterations of a step before it has failed.
const MOST_ITERATIONS: usize = 10;
/// What an iteration may leave, in parts of the error that the motion may have.
const LEFT: f64 = 0.003;
/// An error beyond that doesn't let it leave more: the next steps start from what it leaves, and fail.
const LOOSEST: f64 = 0.01;
/// Factors that leave more than this of the error are made again at the next step.
const SLOW: f64 = 0.15;
/// What an iteration is taken to leave at least, before it has shown that.
const LEAST: f64 = 0.02;
/// An iteration that leaves more than this doesn't end.
const FAILING: f64 = 0.9;

impl Radau {
    /// Brings the stages to their equations.
    pub(super) fn iterate(
        &mut self,
        corrector: &mut Corrector,
        system: &System,
        start: &State,
        step: f64,
        watch: &mut Watch,
    ) -> Result<Effort, Error> {
        let mut effort = Effort::default();
        corrector.was_singular = false;
        let allowed = LEFT * self.accuracy.tolerance.min(LOOSEST);
        let floor = corrector.rounding(system) * self.scale.by_length();
        let mut last = f64::INFINITY;
        let mut is_fresh = false;
        // An earlier step tells no more of this one than that.
        let mut left_before = self.contraction.max(LEAST).powf(0.8);
        loop {
            self.evaluate(system, start);
            watch.lap(&mut corrector.profile, Profile::of_evaluations);
            let is_slow = self.contraction > SLOW;
            if self.factored_step != Some(step) || (is_slow && !is_fresh) {
                self.factor(corrector, system, step)?;
                effort.factorizations += 1;
                is_fresh = true;
                watch.lap(&mut corrector.profile, Profile::of_factors);
            }
            let correction = self.correct(corrector, system, step);
            watch.lap(&mut corrector.profile, Profile::of_solves);
            integrate(&mut self.stages, &self.coefficients, system, start, step);
            watch.lap(&mut corrector.profile, Profile::of_corrections);
            effort.iterations += 1;
            if !correction.is_finite() {
                self.factored_step = None;
                corrector.trial.copy_from(&self.stages[0].state);
                return Err(corrector.not_finite(system));
            }
            // Rounding doesn't contract.
            if effort.iterations > 1 && correction > 10.0 * floor {
                self.contraction = correction / last;
                left_before = self.contraction;
            }
            let left = correction * left_before / (1.0 - left_before).max(0.05);
            if left <= allowed || correction <= floor {
                return Ok(effort);
            }
            let is_hopeless = effort.iterations > 1
                && (self.contraction > FAILING || effort.iterations >= MOST_ITERATIONS);
            if is_hopeless {
                self.factored_step = None;
                self.contraction = 1.0;
                return Err(Error::NotConverged {
                    time: start.time + step,
                    iterations: effort.iterations,
                    residual: correction,
                    tolerance: allowed.max(floor),
                    worst: corrector.worst_body(system),
                });
            }
            last = correction;
        }
    }

    /// All stages, angles counted on from one to the next.
    fn evaluate(&mut self, system: &System, start: &State) {
        for i in 0..self.stages.len() {
            let (before, rest) = self.stages.split_at_mut(i);
            let stage = &mut rest[0];
            if !stage.state.angles.is_empty() {
                match before.last() {
                    Some(before) => stage.state.angles.copy_from_slice(&before.state.angles),
                    None => stage.state.angles.copy_from_slice(&start.angles),
                }
            }
            stage.evaluate(system);
            if !stage.state.angles.is_empty() {
                stage.evaluation.count_turns(system, &mut stage.state);
            }
        }
    }

    /// Factors at all shifts, made at the stage in the middle.
    fn factor(
        &mut self,
        corrector: &mut Corrector,
        system: &System,
        step: f64,
    ) -> Result<(), Error> {
        self.factored_step = None;
        let middle = &self.stages[self.stages.len() / 2];
        let real = blend(1.0 / (step * self.coefficients.real.value));
        corrector.factor_at(system, (&middle.state, &middle.evaluation), &real, step)?;
        for (factor, pair) in self.pairs.iter_mut().zip(&self.coefficients.pairs) {
            let blend = blend(c64::new(1.0, 0.0) / (pair.value * step));
            let (state, evaluation) = (&middle.state, &middle.evaluation);
            factor.factor_beside(system, state, evaluation, &blend, &corrector.condensed)?;
        }
        self.factored_step = Some(step);
        self.contraction = SLOW;
        Ok(())
    }

    /// One iteration; the largest correction of a place, in [`super::scale::Scale`].
    fn correct(&mut self, corrector: &mut Corrector, system: &System, step: f64) -> f64 {
        let middle = self.stages.len() / 2;
        let Self {
            stages,
            coefficients,
            pairs,
            real,
            complex,
            scratch,
            scale,
            accuracy,
            ..
        } = self;
        let of_forces = accuracy.tolerance / accuracy.of_forces;
        let condensed = &mut corrector.condensed;
        let shift = 1.0 / (step * coefficients.real.value);
        let [residual, changes] = real;
        gather(stages, &coefficients.real.gather, residual, changes);
        condensed.scale_defects(system, changes, 1.0 / (shift * shift));
        condensed.solve_held(system, &stages[middle].evaluation, changes, residual);
        let [residual, changes] = complex;
        for (pair, factor) in coefficients.pairs.iter().zip(pairs.iter_mut()) {
            let of_position = pair.value * pair.value * (step * step);
            gather(stages, &pair.gather, residual, changes);
            factor.scale_defects(system, changes, of_position);
            factor.solve_held(system, &stages[middle].evaluation, changes, residual);
        }
        let mut largest: f64 = 0.0;
        for (i, stage) in stages.iter_mut().enumerate() {
            let [place, rate, _] = &mut *scratch;
            let of_real = coefficients.real.spread[i];
            for (k, x) in condensed.step.iter().enumerate() {
                place[k] = of_real * x;
                rate[k] = of_real * shift * shift * x;
            }
            for (force, change) in stage.state.forces.iter_mut().zip(&condensed.force_step) {
                *force += of_real * change;
            }
            for (pair, factor) in coefficients.pairs.iter().zip(pairs.iter()) {
                let spread = pair.spread[i];
                let shift = c64::new(1.0, 0.0) / (pair.value * step);
                let second = spread * shift * shift;
                for (k, x) in factor.step.iter().enumerate() {
                    place[k] += spread.re * x.re - spread.im * x.im;
                    rate[k] += second.re * x.re - second.im * x.im;
                }
                for (force, change) in stage.state.forces.iter_mut().zip(&factor.force_step) {
                    *force += spread.re * change.re - spread.im * change.im;
                }
            }
            for (index, body) in system.bodies.iter().enumerate() {
                let own = &mut rate[body.velocities.clone()];
                let linear =
                    stage.evaluation.poses[index].axes * Vector3::from_column_slice(&own[..3]);
                own[..3].copy_from_slice(linear.as_slice());
            }
            for (acceleration, change) in stage.state.accelerations.iter_mut().zip(rate.iter()) {
                *acceleration += change;
            }
            let size = scale.size(system, place);
            largest = larger(size, largest);
            if of_forces > 0.0 {
                largest = larger(of_forces * scale.force(system, place), largest);
            }
        }
        largest
    }
}

/// The right-hand side that belongs to an eigenvalue.
fn gather<T: Number>(stages: &[Stage], weights: &[T], residual: &mut [T], changes: &mut [T]) {
    residual.fill(T::of(0.0));
    changes.fill(T::of(0.0));
    for (stage, weight) in stages.iter().zip(weights) {
        for (sum, entry) in residual.iter_mut().zip(&stage.evaluation.residual) {
            *sum += weight.times(*entry);
        }
        for (sum, defect) in changes.iter_mut().zip(&stage.defects) {
            *sum += weight.times(*defect);
        }
    }
}

/// The iteration matrix at a shift.
fn blend<T: Number>(shift: T) -> Blend<T> {
    Blend {
        mass: shift * shift,
        damping: shift,
        stiffness: 1.0,
        elastic: Elastic::Moving,
        interfaces: Interfaces::Held,
    }
}
