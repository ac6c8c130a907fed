//! One step: predict, then correct until what is left is below the tolerance.

mod correct;
mod judge;
mod jump;
mod predict;

use nalgebra::Vector3;

use super::method::{Effort, Formulation, Method};
use super::profile::{Profile, Watch};
use crate::error::Error;
use crate::initial::REGULARIZATION;
use crate::system::body_factor::Elastic;
use crate::system::condensed::{Blend, Condensed, Interfaces};
use crate::system::evaluation::Evaluation;
use crate::system::{State, System};
use dcb_formats::scene::Scheme;

/// The solver of steps: trial state, factor and what it remembers of earlier steps.
pub struct Corrector {
    /// The state at the end of the step.
    pub trial: State,
    /// The equations at the trial state.
    pub evaluation: Evaluation,
    /// The iteration matrix.
    pub condensed: Condensed,
    /// The matrix of efforts that jump, once there were some: the factor of the steps stays.
    jumping: Option<Box<Condensed>>,
    /// Where the time goes, if it is to be known.
    pub profile: Option<Profile>,
    /// Whether the last step met a singular configuration, and passed it with regularized constraints.
    pub was_singular: bool,
    /// δq of the accelerations' change, where positions have one of their own beside.
    moving: Vec<f64>,
    zeros: Vec<f64>,
    /// Change of the velocities at the start of a step that differs from the one before.
    offset: Vec<f64>,
    /// Δq of the prediction.
    increments: Vec<f64>,
    changes: Vec<f64>,
    force_changes: Vec<f64>,
    force_step: Vec<f64>,
    /// Δφ of each body since the start of the step.
    turns: Vec<Vector3<f64>>,
    /// The step that the factor was made for; `None` without a factor.
    factored_step: Option<f64>,
    /// What the factor was made of.
    blend: Option<Blend>,
    /// Steps since the factor was made.
    factor_age: usize,
    /// How much of the error an iteration with the present factor leaves.
    contraction: f64,
    /// Whether forces of redundant constraints that the last step carried on have been shared out.
    has_shared: bool,
    /// Steps still to begin with a new factor.
    wary: usize,
    /// Size of the accelerations in the run so far: length/time², by bodies' lengths.
    acceleration_scale: f64,
}

/// An iteration that leaves more than this of the error asks for a new factor.
const SLOW: f64 = 0.05;
/// One that leaves more than this asks for a new factor each time, and if the factor is [`YOUNG`] so do the next [`WARY`] steps from their
/// start: near singular positions, where joint forces grow and change sign, a factor serves nowhere but where it was made.
const FAILING: f64 = 0.3;
/// Steps up to which a factor should serve.
const YOUNG: usize = 5;
/// Steps that begin with a new factor after one has failed.
const WARY: usize = 50;
/// Corrections below this many units in the last place of the positions are rounding.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

impl Corrector {
    /// For a system, starting anywhere.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn of(system: &System) -> Result<Self, Error> {
        Ok(Self {
            trial: State::at_rest(system),
            evaluation: Evaluation::of(system),
            condensed: Condensed::of(system)?,
            jumping: None,
            profile: None,
            was_singular: false,
            moving: vec![0.0; system.velocity_count()],
            zeros: vec![0.0; system.velocity_count()],
            offset: vec![0.0; system.velocity_count()],
            increments: vec![0.0; system.velocity_count()],
            changes: vec![0.0; system.rows.len()],
            force_changes: vec![0.0; system.rows.len()],
            force_step: vec![0.0; system.rows.len()],
            turns: vec![Vector3::zeros(); system.bodies.len()],
            factored_step: None,
            blend: None,
            factor_age: 0,
            contraction: 1.0,
            has_shared: false,
            wary: 0,
            acceleration_scale: 0.0,
        })
    }

    /// Forgets the factor alone, after a step that failed.
    pub fn forget_factor(&mut self) {
        self.factored_step = None;
    }

    /// Forgets the factor, so that what follows depends on the state alone.
    pub fn forget(&mut self) {
        self.factored_step = None;
        self.condensed.forget_redundant();
        self.contraction = 1.0;
        self.wary = 0;
        self.acceleration_scale = 0.0;
    }

    /// Advances `start` by `step` into `trial`. The start has a past: `earlier_step` is above zero.
    ///
    /// # Errors
    /// [`Error::NotConverged`], [`Error::NotFinite`], and those of [`Condensed::factor`].
    pub fn step(
        &mut self,
        system: &System,
        method: &Method,
        start: &State,
        step: f64,
    ) -> Result<Effort, Error> {
        let (scheme, tolerance) = (&method.scheme, &method.tolerance);
        let mut watch = Watch::start(self.profile.as_ref());
        self.was_singular = false;
        self.has_shared = false;
        self.factor_age += 1;
        let mut effort = Effort::default();
        self.offset.fill(0.0);
        if method.formulation == Formulation::Index3 && step > start.earlier_step {
            self.find_offset(system, method, start, step)?;
            effort.factorizations += 1;
        }
        self.predict(system, scheme, start, step);
        let scale = self.rescale(system, start);
        let mut last = f64::INFINITY;
        let allowed = tolerance.relative * scheme.beta * step * step * scale;
        let mut fresh = false;
        if self.wary > 0 {
            self.wary -= 1;
            self.factored_step = None;
        }
        watch.lap(&mut self.profile, |profile| &mut profile.predict);
        loop {
            self.evaluate(system, method.formulation);
            watch.lap(&mut self.profile, |profile| &mut profile.evaluate);
            // One more iteration may be enough.
            let next =
                last * self.contraction * self.contraction / (1.0 - self.contraction).max(0.05);
            let is_slow = self.contraction > SLOW && next > allowed;
            let stale = !fresh && is_slow || self.contraction > FAILING;
            if effort.iterations > 0 && self.contraction > FAILING && self.factor_age <= YOUNG {
                self.wary = WARY;
            }
            // A factor of redundant constraints of which nothing is taken out serves the gradients that it was made of only.
            if effort.iterations > 0 && stale
                || self.factored_step != Some(step)
                || self.condensed.regularization > 0.0 && !self.condensed.carries_redundant()
            {
                self.factor(system, method, step)?;
                effort.factorizations += 1;
                fresh = true;
                watch.lap(&mut self.profile, |profile| &mut profile.factor);
            }
            self.solve(system, method, step);
            watch.lap(&mut self.profile, |profile| &mut profile.solve);
            let correction = self.apply(system, scheme, start, step);
            watch.lap(&mut self.profile, |profile| &mut profile.correct);
            effort.iterations += 1;
            if !correction.is_finite() {
                return Err(self.not_finite(system));
            }
            if effort.iterations > 1 && last > 0.0 {
                self.contraction = (correction / last).max(0.2 * self.contraction);
            }
            let floor = ROUNDING * self.reach(system);
            let left = correction * (self.contraction / (1.0 - self.contraction).max(0.05));
            if left.min(correction) <= allowed.max(floor) && self.contraction < 0.9
                || correction <= floor
                || (correction > 0.5 * last && correction < 100.0 * floor)
            {
                self.refuse_contradiction(system, correction.max(allowed).max(floor))?;
                self.refuse_long_turns(system, step)?;
                return Ok(effort);
            }
            if effort.iterations >= tolerance.max_iterations {
                self.factored_step = None;
                if self.is_as_good_as_possible(correction, floor) {
                    self.was_singular = true;
                    self.refuse_contradiction(system, correction.max(allowed))?;
                    return Ok(effort);
                }
                return Err(Error::NotConverged {
                    time: self.trial.time,
                    iterations: effort.iterations,
                    residual: correction,
                    tolerance: allowed.max(floor),
                    worst: self.worst_body(system),
                });
            }
            last = correction;
        }
    }

    fn evaluate(&mut self, system: &System, formulation: Formulation) {
        self.evaluation.place(system, &self.trial);
        if system.is_damped || formulation == Formulation::StabilizedIndex2 {
            self.evaluation.add_velocities(system, &self.trial);
        }
        self.evaluation.measure(system, &self.trial);
        self.evaluation.load(system, &self.trial);
        self.evaluation.resist(system, &self.trial);
    }

    /// δq in `condensed.step`, the part of it that comes from accelerations in `moving`.
    fn solve(&mut self, system: &System, method: &Method, step: f64) {
        let (state, evaluation) = (&self.trial, &self.evaluation);
        self.condensed
            .demand(system, state, evaluation, &mut self.changes);
        match method.formulation {
            Formulation::Index3 => {
                let residual = &evaluation.residual;
                self.condensed
                    .solve(system, state, evaluation, &self.changes, residual);
                self.moving.copy_from_slice(&self.condensed.step);
            }
            Formulation::StabilizedIndex2 => {
                let to_position = 1.0 / method.scheme.velocity_slope(step);
                let mut of_velocity = std::mem::take(&mut self.force_changes);
                of_velocity.copy_from_slice(&self.changes);
                for (index, change) in of_velocity.iter_mut().enumerate() {
                    if self.condensed.is_compliant(index) {
                        continue;
                    }
                    if let Some(defect) = evaluation.velocity_defect(system, state, index) {
                        *change = -to_position * defect - self.condensed.yielding(state, index);
                    }
                }
                let residual = &evaluation.residual;
                self.condensed
                    .solve(system, state, evaluation, &of_velocity, residual);
                self.moving.copy_from_slice(&self.condensed.step);
                self.force_step.copy_from_slice(&self.condensed.force_step);
                // What positions lack after that, in the metric of the iteration matrix.
                for (index, row) in system.rows.iter().enumerate() {
                    self.changes[index] = if row.is_constraint() {
                        self.changes[index] - of_velocity[index]
                    } else {
                        0.0
                    };
                }
                self.force_changes = of_velocity;
                self.condensed
                    .solve_positions(system, evaluation, &self.changes, &self.zeros);
                self.condensed.force_step.copy_from_slice(&self.force_step);
                for (total, moving) in self.condensed.step.iter_mut().zip(&self.moving) {
                    *total += moving;
                }
            }
        }
    }

    /// Shares the forces of redundant constraints out in the minimum-norm sense, after the step that led to a state and with the evaluation
    /// there. Steps carry on what does nothing, so that a factor serves them as long as without. Returns whether forces changed.
    pub fn share_redundant(&mut self, system: &System, state: &mut State) -> bool {
        if self.has_shared {
            return false;
        }
        self.has_shared = self.share_redundant_within(system, state);
        self.has_shared
    }

    /// The same at a state within the step.
    pub fn share_redundant_within(&mut self, system: &System, state: &mut State) -> bool {
        let is_known = self.condensed.carries_redundant() && self.factored_step.is_some();
        let Some(blend) = self.blend.filter(|_| is_known) else {
            return false;
        };
        let turns = Some(&self.turns[..]);
        let factored = self
            .condensed
            .factor(system, state, &self.evaluation, &blend, turns);
        if factored.is_err() {
            self.factored_step = None;
            return false;
        }
        (self.contraction, self.factor_age) = (SLOW, 0);
        self.condensed.share_redundant(&mut state.forces);
        true
    }

    fn factor(&mut self, system: &System, method: &Method, step: f64) -> Result<(), Error> {
        let blend = blend(&method.scheme, step);
        let is_redundant = self.condensed.regularization > 0.0;
        self.pass_dead_centre(|corrector| corrector.factor_once(system, &blend))?;
        if is_redundant && !self.condensed.carries_redundant() {
            self.condensed.regularization = self.sharing_regularization(system, method, step);
            let shared = self.factor_once(system, &blend);
            self.condensed.regularization = REGULARIZATION;
            self.condensed.forget_redundant();
            shared?;
        }
        (self.factored_step, self.blend) = (Some(step), Some(blend));
        (self.contraction, self.factor_age) = (SLOW, 0);
        Ok(())
    }

    /// A factorization that is made again with regularized constraints where those that are independent elsewhere meet, at a dead centre.
    fn pass_dead_centre(
        &mut self,
        factor: impl Fn(&mut Self) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let is_redundant = self.condensed.regularization > 0.0;
        match factor(self) {
            Err(Error::SingularJoints { .. }) if !is_redundant => {
                self.was_singular = true;
                self.condensed.regularization = REGULARIZATION;
                let regularized = factor(self);
                self.condensed.regularization = 0.0;
                regularized
            }
            other => other,
        }
    }

    /// A factor for a step of another method, at one of its states.
    ///
    /// # Errors
    /// Those of [`Condensed::factor`].
    pub(in crate::integrator) fn factor_at(
        &mut self,
        system: &System,
        (state, evaluation): (&State, &Evaluation),
        blend: &Blend,
        step: f64,
    ) -> Result<(), Error> {
        self.pass_dead_centre(|corrector| {
            let condensed = &mut corrector.condensed;
            condensed.factor_straight(system, state, evaluation, blend)
        })?;
        (self.factored_step, self.blend) = (Some(step), Some(*blend));
        self.has_shared = false;
        Ok(())
    }

    /// The last factor made again at the trial state.
    ///
    /// # Errors
    /// Those of [`Condensed::factor`].
    pub(in crate::integrator) fn factor_here(&mut self, system: &System) -> Result<(), Error> {
        let Self {
            trial,
            evaluation,
            condensed,
            blend,
            ..
        } = self;
        let Some(blend) = blend else {
            return Ok(());
        };
        evaluation.refresh(system, trial);
        condensed.factor_straight(system, trial, evaluation, blend)
    }

    fn factor_once(&mut self, system: &System, blend: &Blend) -> Result<(), Error> {
        self.condensed.factor(
            system,
            &self.trial,
            &self.evaluation,
            blend,
            Some(&self.turns),
        )
    }
}

/// The iteration matrix of a step.
fn blend(scheme: &Scheme, step: f64) -> Blend {
    Blend {
        mass: scheme.acceleration_slope(step),
        damping: scheme.velocity_slope(step),
        stiffness: 1.0,
        elastic: Elastic::Moving,
        interfaces: Interfaces::Following,
    }
}
