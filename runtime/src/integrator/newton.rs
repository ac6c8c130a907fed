//! One step: predict, then correct until what is left is below the tolerance.

use std::time::Instant;

use nalgebra::{UnitQuaternion, Vector3};

use super::scheme::Scheme;
use crate::error::Error;
use crate::initial::REGULARIZATION;
use crate::rotation::right_jacobian_inverse;
use crate::system::body_factor::Elastic;
use crate::system::condensed::{Blend, Condensed};
use crate::system::evaluation::Evaluation;
use crate::system::{Demand, State, System};

/// At which level constraints are met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Formulation {
    /// Positions only.
    #[default]
    Index3,
    /// Positions and velocities: Gear, Gupta and Leimkuhler's stabilized index 2. Velocities meet the constraints by λ, positions by a
    /// second set of multipliers that vanishes with the step.
    StabilizedIndex2,
}

/// When an iteration is good enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Error of the accelerations that a step may leave, relative to their size in the run.
    pub relative: f64,
    /// Iterations after which a step has failed.
    pub max_iterations: usize,
}

/// How steps are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Method {
    /// The member of the family.
    pub scheme: Scheme,
    /// The level of the constraints.
    pub formulation: Formulation,
    /// When a step is good enough.
    pub tolerance: Tolerance,
}

/// What a step took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Newton iterations.
    pub iterations: usize,
    /// Factorizations of the iteration matrix.
    pub factorizations: usize,
}

/// Where the time of steps goes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Profile {
    /// Predicting the state at the end of the step, s.
    pub predict: f64,
    /// Evaluating frames, rows and forces.
    pub evaluate: f64,
    /// Assembling and factoring the iteration matrix.
    pub factor: f64,
    /// Solving with it.
    pub solve: f64,
    /// Correcting the state.
    pub correct: f64,
}

impl Profile {
    /// Time in all stages.
    pub fn total(&self) -> f64 {
        self.predict + self.evaluate + self.factor + self.solve + self.correct
    }
}

/// A clock that runs only where somebody wants to know.
struct Watch {
    running: Option<Instant>,
}

impl Watch {
    fn start(profile: Option<&Profile>) -> Self {
        Self {
            running: profile.map(|_| Instant::now()),
        }
    }

    /// Adds the time since the last call to a stage.
    fn lap(&mut self, profile: &mut Option<Profile>, stage: fn(&mut Profile) -> &mut f64) {
        if let (Some(since), Some(profile)) = (self.running, profile) {
            let now = Instant::now();
            *stage(profile) += (now - since).as_secs_f64();
            self.running = Some(now);
        }
    }
}

/// The solver of steps: trial state, factor and what it remembers of earlier steps.
pub struct Corrector {
    /// The state at the end of the step.
    pub trial: State,
    /// The equations at the trial state.
    pub evaluation: Evaluation,
    /// The iteration matrix.
    pub condensed: Condensed,
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
    /// How much of the error an iteration with the present factor leaves.
    contraction: f64,
    /// Steps still to begin with a new factor.
    wary: usize,
    /// Size of the accelerations in the run so far: length/time², by bodies' lengths.
    acceleration_scale: f64,
}

/// An iteration that leaves more than this of the error asks for a new factor.
const SLOW: f64 = 0.05;
/// A constraint that stays this many times further open than the iteration's accuracy contradicts others.
const VIOLATED: f64 = 1e4;
/// One that leaves more than this asks for a new factor each time, and so do the next [`WARY`] steps from their start: near
/// singular positions, where joint forces grow and change sign, a factor serves nowhere but where it was made.
const FAILING: f64 = 0.3;
/// Steps that begin with a new factor after one has failed.
const WARY: usize = 50;
/// The joints' system enlarges its right-hand side by more than this only near a dead centre.
const NEARLY_SINGULAR: f64 = 1e5;
/// Rounding is taken to be enlarged by no more: a dead centre leaves half the digits of a position.
const LARGEST_AMPLIFICATION: f64 = 1e8;
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
            contraction: 1.0,
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
            // A factor of redundant constraints serves the gradients that it was made of only: which share of λ does nothing turns
            // with them.
            let stale = !fresh && self.contraction > SLOW || self.contraction > FAILING;
            if effort.iterations > 0 && self.contraction > FAILING {
                self.wary = WARY;
            }
            if effort.iterations > 0 && stale
                || self.factored_step != Some(step)
                || self.condensed.regularization > 0.0
            {
                self.factor(system, scheme, step)?;
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

    /// The change of the velocities that a larger step asks for.
    ///
    /// An increment lacks `h³ c` of the motion. Constraints on positions put that right in their own directions, by velocities that are
    /// off by `h² c` there. Where the step is the same from step to step this is smooth and of second order; where it grows, and at the
    /// start, the velocities have to be given it, or the accelerations jump by `h c` and the joints' forces with them
    /// (Arnold, Brüls and Cardona 2015). Not where it shrinks: c comes from the change of the accelerations, and steps that are cut
    /// again and again would feed on its rounding and ringing.
    fn find_offset(
        &mut self,
        system: &System,
        method: &Method,
        start: &State,
        step: f64,
    ) -> Result<(), Error> {
        self.trial.copy_from(start);
        self.turns.fill(Vector3::zeros());
        self.evaluate(system, method.formulation);
        self.factor(system, &method.scheme, step)?;
        let of_rate = method.scheme.increment_error() / start.earlier_step;
        for (index, body) in system.bodies.iter().enumerate() {
            let own = body.velocities.clone();
            let (spin, spin_rate) = (
                three(&start.velocities[own.clone()], 3),
                three(&start.accelerations[own.clone()], 3),
            );
            let lack = &mut self.moving[own.clone()];
            for (k, lack) in lack.iter_mut().enumerate() {
                let i = own.start + k;
                *lack = of_rate * (start.accelerations[i] - start.earlier_accelerations[i]);
            }
            // The rotation vector of a turn with changing spin.
            let conical = spin.cross(&spin_rate) / 12.0;
            let linear = self.evaluation.poses[index].axes.tr_mul(&three(lack, 0));
            lack[..3].copy_from_slice(linear.as_slice());
            for k in 0..3 {
                lack[3 + k] += conical[k];
            }
        }
        let squares = step * step - start.earlier_step * start.earlier_step;
        self.condensed
            .row_changes(system, &self.evaluation, &self.moving, &mut self.changes);
        for change in &mut self.changes {
            *change *= squares;
        }
        self.condensed
            .solve_positions(system, &self.evaluation, &self.changes, &self.zeros);
        self.offset.copy_from_slice(&self.condensed.step);
        for (body, pose) in system.bodies.iter().zip(&self.evaluation.poses) {
            let own = &mut self.offset[body.velocities.clone()];
            let linear = pose.axes * three(own, 0);
            own[..3].copy_from_slice(linear.as_slice());
        }
        Ok(())
    }

    /// The trial state at the end of the step, as far as the start tells it.
    fn predict(&mut self, system: &System, scheme: &Scheme, start: &State, step: f64) {
        let trial = &mut self.trial;
        trial.time = start.time + step;
        trial.angles.copy_from_slice(&start.angles);
        trial.inputs.copy_from_slice(&start.inputs);
        let ahead = step / start.earlier_step;
        let carried = |now: f64, before: f64| now + ahead * (now - before);
        for (i, acceleration) in trial.accelerations.iter_mut().enumerate() {
            let before = start.accelerations[i];
            // It belongs to a time ahead of the start by a part of the step.
            let a = before + ahead * (start.algorithmic[i] - before);
            *acceleration = carried(before, start.earlier_accelerations[i]);
            let after = scheme.algorithmic(a, before, *acceleration);
            let velocity = start.velocities[i] + self.offset[i];
            trial.algorithmic[i] = after;
            trial.velocities[i] = scheme.velocity(step, velocity, a, after);
            self.increments[i] = scheme.increment(step, velocity, a, after);
        }
        for (i, force) in trial.forces.iter_mut().enumerate() {
            *force = carried(start.forces[i], start.earlier_forces[i]);
        }
        for (i, x) in trial.residual_displacements.iter_mut().enumerate() {
            let (rate, a) = (start.residual_rates[i], start.residual_accelerations[i]);
            *x = start.residual_displacements[i] + scheme.increment(step, rate, a, a);
            trial.residual_rates[i] = scheme.velocity(step, rate, a, a);
            trial.residual_accelerations[i] = a;
        }
        for (index, body) in system.bodies.iter().enumerate() {
            let increments = &self.increments[body.velocities.clone()];
            trial.origins[index] = start.origins[index] + three(increments, 0);
            self.turns[index] = three(increments, 3);
            trial.orientations[index] =
                start.orientations[index] * UnitQuaternion::new(self.turns[index]);
            for (k, y) in trial.coordinates[body.coordinates.clone()]
                .iter_mut()
                .enumerate()
            {
                *y = start.coordinates[body.coordinates.start + k] + increments[6 + k];
            }
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
                    self.changes[index] = match &row.demand {
                        Demand::Answer(_) => 0.0,
                        _ => self.changes[index] - of_velocity[index],
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

    fn factor(&mut self, system: &System, scheme: &Scheme, step: f64) -> Result<(), Error> {
        let blend = Blend {
            mass: scheme.acceleration_slope(step),
            damping: scheme.velocity_slope(step),
            stiffness: 1.0,
            elastic: Elastic::Moving,
        };
        let factored = self.factor_once(system, &blend);
        match factored {
            // A dead centre: constraints that are independent elsewhere meet here.
            Err(Error::SingularJoints { .. }) if self.condensed.regularization == 0.0 => {
                self.was_singular = true;
                self.condensed.regularization = REGULARIZATION;
                let regularized = self.factor_once(system, &blend);
                self.condensed.regularization = 0.0;
                regularized?;
            }
            other => other?,
        }
        self.factored_step = Some(step);
        self.contraction = SLOW;
        Ok(())
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

    /// With redundant constraints an iteration converges also where they contradict each other; then they stay violated.
    fn refuse_contradiction(&self, system: &System, accuracy: f64) -> Result<(), Error> {
        if self.condensed.regularization == 0.0 && !self.was_singular {
            return Ok(());
        }
        for (index, row) in system.rows.iter().enumerate() {
            if matches!(row.demand, Demand::Answer(_)) {
                continue;
            }
            let term = &system.terms[row.terms.start];
            let unit = if term.measure.is_length() {
                1.0
            } else {
                system.bodies.iter().map(|b| b.length).fold(0.0, f64::max)
            };
            let misfit = self.evaluation.answers[index];
            if misfit.abs() * unit > VIOLATED * accuracy {
                return Err(Error::Contradiction {
                    time: self.trial.time,
                    joint: system.connections[row.connection].name.clone(),
                    misfit,
                });
            }
        }
        Ok(())
    }

    /// Adds the correction to the trial state; its size, as a length.
    fn apply(&mut self, system: &System, scheme: &Scheme, start: &State, step: f64) -> f64 {
        let (beta, gamma) = (scheme.acceleration_slope(step), scheme.velocity_slope(step));
        let to_algorithmic = 1.0 / (scheme.beta * step * step);
        let trial = &mut self.trial;
        let mut largest: f64 = 0.0;
        for (index, body) in system.bodies.iter().enumerate() {
            let first = body.velocities.start;
            let correction = &self.condensed.step[body.velocities.clone()];
            let moving = &self.moving[body.velocities.clone()];
            let axes = &self.evaluation.poses[index].axes;
            let follow = right_jacobian_inverse(&self.turns[index]);
            let (shift, turn) = (three(correction, 0), three(correction, 3));
            trial.origins[index] += axes * shift;
            self.turns[index] += follow * turn;
            trial.orientations[index] =
                start.orientations[index] * UnitQuaternion::new(self.turns[index]);
            let mut deflection = 0.0;
            let coordinates = &mut trial.coordinates[body.coordinates.clone()];
            for (y, change) in coordinates.iter_mut().zip(&correction[6..]) {
                *y += change;
            }
            for change in &correction[6..6 + body.flexible.displacement_count()] {
                deflection += change * change;
            }
            let (linear, angular) = (axes * three(moving, 0), follow * three(moving, 3));
            for (k, change) in moving.iter().enumerate() {
                let change = match k {
                    0..3 => linear[k],
                    3..6 => angular[k - 3],
                    _ => *change,
                };
                trial.accelerations[first + k] += beta * change;
                trial.velocities[first + k] += gamma * change;
                trial.algorithmic[first + k] += to_algorithmic * change;
            }
            let deflection = (deflection / body.flexible.inertia.mass()).sqrt();
            let size = shift.norm() + body.length * turn.norm() + deflection;
            // `max` would drop a NaN.
            largest = if size > largest || size.is_nan() {
                size
            } else {
                largest
            };
        }
        for (i, change) in self.condensed.residual_step.iter().enumerate() {
            trial.residual_displacements[i] += change;
            trial.residual_rates[i] += gamma * change;
            trial.residual_accelerations[i] += to_algorithmic * change;
        }
        for (force, change) in trial.forces.iter_mut().zip(&self.condensed.force_step) {
            *force += change;
        }
        largest
    }

    /// The size of accelerations that corrections are compared with.
    fn rescale(&mut self, system: &System, start: &State) -> f64 {
        let mut scale = system.gravity.norm();
        for body in &system.bodies {
            let a = &start.accelerations[body.velocities.clone()];
            let v = &start.velocities[body.velocities.clone()];
            let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
            let size = norm(&a[..3])
                + body.length * (norm(&a[3..6]) + norm(&v[3..6]).powi(2))
                + norm(&a[6..6 + body.flexible.displacement_count()])
                    / body.flexible.inertia.mass().sqrt();
            scale = scale.max(size);
        }
        self.acceleration_scale = scale.max(0.999 * self.acceleration_scale);
        self.acceleration_scale
    }

    /// How far from the world's origin positions are, for their rounding.
    fn reach(&self, system: &System) -> f64 {
        system
            .bodies
            .iter()
            .zip(&self.trial.origins)
            .fold(0.0, |most: f64, (body, origin)| {
                most.max(origin.amax() + body.length)
            })
    }

    /// Whether a correction is what rounding leaves at a dead centre: there the constraints nearly depend on each other, and
    /// positions are known by so much less.
    /// Redundant constraints always look like that, so that nothing is forgiven where there are some.
    fn is_as_good_as_possible(&mut self, correction: f64, floor: f64) -> bool {
        if self.condensed.regularization > 0.0 {
            return false;
        }
        let amplification = self.condensed.amplification();
        amplification > NEARLY_SINGULAR
            && correction < 100.0 * floor * amplification.min(LARGEST_AMPLIFICATION)
    }

    /// Why a correction is not finite: a function of time that has no value there, or the motion itself.
    fn not_finite(&self, system: &System) -> Error {
        let time = self.trial.time;
        let bad = |signal: usize| {
            Some(system.signal(signal, &self.trial).value).filter(|v| !v.is_finite())
        };
        let drives = system.rows.iter().filter_map(|row| match &row.demand {
            Demand::Follow(signal) => {
                Some((bad(*signal)?, &system.connections[row.connection].name))
            }
            Demand::Hold(_) | Demand::Answer(_) => None,
        });
        let loads = system.loads.iter().filter_map(|load| {
            let signals = load.force.iter().chain(&load.torque).flatten();
            let found = signals.copied().find_map(bad)?;
            Some((found, &load.name))
        });
        match drives.chain(loads).next() {
            Some((found, name)) => Error::FunctionNotFinite {
                time,
                name: name.clone(),
                found,
            },
            None => Error::NotFinite {
                time,
                body: self.worst_body(system),
            },
        }
    }

    /// The body with the largest correction.
    fn worst_body(&self, system: &System) -> String {
        let size = |body: &crate::system::Body| {
            self.condensed.step[body.velocities.clone()]
                .iter()
                .map(|x| x.abs())
                .fold(0.0, |most: f64, x| {
                    if x.is_nan() {
                        f64::INFINITY
                    } else {
                        most.max(x)
                    }
                })
        };
        system
            .bodies
            .iter()
            .max_by(|a, b| size(a).total_cmp(&size(b)))
            .map_or_else(String::new, |body| body.name.clone())
    }
}

fn three(values: &[f64], first: usize) -> Vector3<f64> {
    Vector3::from_column_slice(&values[first..first + 3])
}
