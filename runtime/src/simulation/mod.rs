//! A run: the system, its state, and what advances it.

mod events;
mod observation;
mod sight;
mod snapshot;
mod tolerance;

pub use self::events::Contact;
pub use self::sight::{Senses, Sight};
pub use self::snapshot::Snapshot;
use crate::energy::{Energy, Works};
use crate::error::Error;
use crate::initial::{InitialReport, REGULARIZATION, Starter};
use crate::integrator::adaptive::{StepSize, local_error};
use crate::integrator::equal_steps::EqualSteps;
use crate::integrator::newton::Corrector;
use crate::integrator::radau::Radau;
use crate::integrator::resolution::{Resolution, Unresolved};
use crate::integrator::{Effort, Formulation, Method, Profile, Rule};
use crate::system::{State, System};
use dcb_formats::scene::RedundantConstraints;

/// Forces of which rounding is a smaller part are there by themselves.
const MOSTLY_ROUNDING: f64 = 0.3;
/// Rounding is estimated to this factor: forces below it by more don't have it.
const ALL_ROUNDING: f64 = 20.0;
/// Where gravity and motion ask for less than this part of it, the joints have nothing to do.
const NEGLIGIBLE: f64 = 1e-3;
/// The interval of the differences that tell the rate of the accelerations at the start, in first steps.
const LOOKED_BACK: f64 = 0.01;
/// A step that is this many times longer than the one before needs more of the past than that tells: the change of the accelerations over a short
/// step is mostly rounding, and would be enlarged.
const LARGEST_GROWTH: f64 = 4.0;

/// What advances a motion.
enum Stepper {
    GeneralizedAlpha(Method),
    Radau(Box<Radau>),
}

/// A mechanism in motion.
pub struct Simulation {
    system: System,
    stepper: Stepper,
    state: State,
    corrector: Corrector,
    resolution: Resolution,
    works: Works,
    /// Those before the last step.
    earlier_works: Works,
    reference_energy: f64,
    /// Effort so far.
    effort: Effort,
    steps: usize,
    /// Largest acceleration that joints' forces belonged to, and largest that is sure to be no rounding.
    accelerations: [f64; 2],
    contacts: Vec<Contact>,
    senses: Option<Senses>,
    /// Outputs that sampled controllers use; no numbers without senses.
    arguments: Vec<f64>,
    /// State and works before inputs made efforts jump: a step that fails goes back to them.
    unfelt: (State, Works),
}

impl Simulation {
    /// Makes the start consistent.
    ///
    /// # Errors
    /// Those of [`Starter::start`].
    pub fn start(
        system: System,
        state: State,
        rule: impl Into<Rule>,
        redundancy: RedundantConstraints,
    ) -> Result<(Self, InitialReport), Error> {
        Self::start_holding(system, state, rule, redundancy, &[])
    }

    /// Makes the start consistent without moving some of the bodies, by index: the others are placed to fit them.
    ///
    /// # Errors
    /// Those of [`Starter::start`].
    pub fn start_holding(
        system: System,
        mut state: State,
        rule: impl Into<Rule>,
        redundancy: RedundantConstraints,
        held: &[usize],
    ) -> Result<(Self, InitialReport), Error> {
        state.felt_inputs.copy_from_slice(&state.inputs);
        let report = Starter::of(&system)?
            .holding(held)
            .start(&mut state, redundancy)?;
        let mut corrector = Corrector::of(&system)?;
        if !report.redundant.is_empty() {
            let rows = report.redundant.iter().map(|(_, count)| count).sum();
            corrector.condensed.expect_redundant(rows, REGULARIZATION);
        }
        let stepper = match rule.into() {
            Rule::GeneralizedAlpha(method) => Stepper::GeneralizedAlpha(method),
            Rule::Radau(accuracy) => Stepper::Radau(Box::new(Radau::of(&system, accuracy)?)),
        };
        let mut simulation = Self {
            stepper,
            corrector,
            resolution: Resolution::of(&system),
            works: Works::default(),
            earlier_works: Works::default(),
            reference_energy: 0.0,
            effort: Effort::default(),
            steps: 0,
            accelerations: [0.0; 2],
            contacts: Vec::new(),
            senses: None,
            arguments: vec![f64::NAN; system.argument_count],
            unfelt: (State::at_rest(&system), Works::default()),
            state,
            system,
        };
        simulation.refresh();
        let evaluation = &mut simulation.corrector.evaluation;
        simulation.works = Works::at_start(&simulation.system, &simulation.state, evaluation);
        simulation.reference_energy =
            Energy::at(&simulation.system, &simulation.state, evaluation).total();
        let evaluation = &simulation.corrector.evaluation;
        simulation
            .system
            .remember(evaluation, &mut simulation.state);
        // Controllers that use outputs wait for their senses.
        if simulation.arguments.is_empty() {
            simulation.sample()?;
        }
        Ok((simulation, report))
    }

    /// Gives sampled controllers the outputs that they use, and takes the first samples: once, at the start.
    ///
    /// # Errors
    /// Those of a factorization.
    pub fn control(&mut self, senses: Senses) -> Result<(), Error> {
        self.senses = Some(senses);
        self.sample()
    }

    /// One step; with Radau as many as the accuracy needs in this time.
    ///
    /// # Errors
    /// [`Error::BadNumber`] for a step that isn't positive, [`Error::PassesSample`] for one beyond the next sample of a controller or servo,
    /// [`Error::StepTooLong`] after several steps that follow nothing of a body's
    /// motion, and those of [`Corrector::step`]; the state stays where it was.
    pub fn step(&mut self, step: f64) -> Result<Effort, Error> {
        if !(step > 0.0 && step.is_finite()) {
            return Err(Error::BadNumber {
                quantity: "the step".into(),
                found: step,
                expected: "a positive time",
            });
        }
        if let Stepper::GeneralizedAlpha(_) = self.stepper {
            self.refuse_passing(step)?;
        }
        self.feeling_inputs(|simulation| simulation.make_step(step))
    }

    fn make_step(&mut self, step: f64) -> Result<Effort, Error> {
        let method = match self.stepper {
            Stepper::GeneralizedAlpha(method) => method,
            Stepper::Radau(_) => return self.follow_over(step),
        };
        self.know_past(&method, step)?;
        let effort = self
            .corrector
            .step(&self.system, &method, &self.state, step)?;
        if let Some(lost) = self.watch(&method, step) {
            return Err(Error::StepTooLong {
                time: self.corrector.trial.time,
                body: self.system.bodies[lost.body].name.clone(),
                steps_per_period: lost.steps_per_period,
                step,
                advised: lost.advised_step(),
            });
        }
        self.accept(step, effort)?;
        Ok(effort)
    }

    /// One of equal steps, counted from 1; its length, and what it took. The last one ends exactly at the end.
    ///
    /// # Errors
    /// As [`Simulation::step`].
    pub fn step_equally(&mut self, steps: &EqualSteps, index: u64) -> Result<(f64, Effort), Error> {
        let length = steps.length(index);
        let effort = self.step(length)?;
        if index == steps.count() {
            (self.state.time, self.state.time_rest) = (steps.time(index), 0.0);
        }
        Ok((length, effort))
    }

    /// Steps up to `end` as large as the tolerance allows, and tells the observer after each. The step goes on from call to call
    /// with `size`.
    ///
    /// # Errors
    /// [`Error::StepTooSmall`], and those of the system that no step could put right; the state stays at the last
    /// accepted step.
    pub fn advance_to(
        &mut self,
        end: f64,
        size: &mut StepSize,
        observe: &mut dyn FnMut(&State),
    ) -> Result<(), Error> {
        while self.state.time < end {
            self.step_adaptively(end, size)?;
            observe(&self.state);
        }
        Ok(())
    }

    /// One step towards `end`, as large as the tolerance allows; its size, and what it took.
    ///
    /// # Errors
    /// As [`Simulation::advance_to`].
    pub fn step_adaptively(
        &mut self,
        end: f64,
        size: &mut StepSize,
    ) -> Result<(f64, Effort), Error> {
        self.feeling_inputs(|simulation| simulation.make_step_adaptively(end, size))
    }

    fn make_step_adaptively(
        &mut self,
        end: f64,
        size: &mut StepSize,
    ) -> Result<(f64, Effort), Error> {
        let method = match self.stepper {
            Stepper::GeneralizedAlpha(method) => method,
            Stepper::Radau(_) => return self.follow_towards(end),
        };
        // Steps end at samples.
        let end = end.min(self.system.next_sample(&self.state).time);
        loop {
            let left = end - self.state.time;
            let step = size.up_to(left);
            self.know_past(&method, step)?;
            let system = &self.system;
            match self.corrector.step(system, &method, &self.state, step) {
                Ok(effort) => {
                    let trial = &mut self.corrector.trial;
                    let error = local_error(system, &method.scheme, &self.state, trial, step);
                    if size.judge(trial.time, step, error)? {
                        if step == left {
                            (trial.time, trial.time_rest) = (end, 0.0);
                        }
                        // What is lost here, the tolerance allows to be.
                        self.watch(&method, step);
                        self.accept(step, effort)?;
                        return Ok((step, effort));
                    }
                    self.effort.iterations += effort.iterations;
                    self.effort.factorizations += effort.factorizations;
                }
                Err(
                    Error::NotConverged { .. }
                    | Error::LongTurn { .. }
                    | Error::NotFinite { .. }
                    | Error::SingularBody { .. }
                    | Error::SingularJoints { .. },
                ) => {
                    size.failed(self.state.time + step, step)?;
                    self.corrector.forget_factor();
                }
                Err(other) => return Err(other),
            }
        }
    }

    /// Looks whether the step to the trial state follows the motion.
    fn watch(&mut self, method: &Method, step: f64) -> Option<Unresolved> {
        let (scheme, trial) = (&method.scheme, &self.corrector.trial);
        self.resolution
            .observe(&self.system, scheme, &self.state, trial, step)
    }

    /// Makes the trial state the present one.
    fn accept(&mut self, step: f64, effort: Effort) -> Result<(), Error> {
        let [of_forces, of_motion] = &mut self.accelerations;
        *of_forces = of_forces.max(self.corrector.accelerations_of_forces(&self.system));
        *of_motion = of_motion.max(self.corrector.accelerations_of_motion(&self.system));
        let trial = &mut self.corrector.trial;
        trial
            .earlier_accelerations
            .copy_from_slice(&self.state.accelerations);
        trial.earlier_forces.copy_from_slice(&self.state.forces);
        trial.earlier_step = step;
        self.corrector.evaluation.count_turns(&self.system, trial);
        std::mem::swap(&mut self.state, trial);
        let is_actuated = !self.system.actuators.is_empty();
        if is_actuated {
            self.find_contacts(step);
            self.system
                .remember(&self.corrector.evaluation, &mut self.state);
        }
        self.earlier_works = self.works;
        match &self.stepper {
            Stepper::Radau(radau) if !radau.has_crossed() => {
                radau.add_works(&self.system, step, &mut self.works);
                self.works
                    .go_on(&self.system, &self.state, &self.corrector.evaluation);
            }
            Stepper::GeneralizedAlpha(_) | Stepper::Radau(_) => {
                self.works
                    .advance(&self.system, &self.state, &self.corrector.evaluation, step);
            }
        }
        self.effort.iterations += effort.iterations;
        self.effort.factorizations += effort.factorizations;
        self.steps += 1;
        if is_actuated {
            self.sample()?;
        }
        Ok(())
    }

    /// Starts to measure where the time goes.
    pub fn start_profile(&mut self) {
        self.corrector.profile = Some(Profile::default());
    }

    /// Where the time went since [`Simulation::start_profile`].
    pub fn profile(&self) -> Option<&Profile> {
        self.corrector.profile.as_ref()
    }

    /// Rounding in the joints' forces at a step of this size, as a fraction of the largest forces of the run so far; zero where
    /// constraints are on velocities too, and where it isn't there or there is nothing else: no forces that stand out, and no motion.
    pub fn rounding_of_forces(&self, step: f64) -> f64 {
        let Stepper::GeneralizedAlpha(method) = &self.stepper else {
            return 0.0;
        };
        match method.formulation {
            Formulation::Index3 => {
                let scheme = &method.scheme;
                let rounding = self
                    .corrector
                    .rounding_of_accelerations(&self.system, scheme, step);
                let [of_forces, of_motion] = self.accelerations;
                let share = rounding / of_forces;
                let is_part = share < MOSTLY_ROUNDING;
                let matters = share < ALL_ROUNDING && of_motion > NEGLIGIBLE * rounding;
                if is_part || matters { share } else { 0.0 }
            }
            Formulation::StabilizedIndex2 => 0.0,
        }
    }

    /// Motions that the steps are too long for.
    pub fn resolution(&self) -> &Resolution {
        &self.resolution
    }

    /// Whether the last step met a singular configuration, a dead centre, and passed it.
    pub fn was_singular(&self) -> bool {
        self.corrector.was_singular
    }

    /// The past that a step of this size needs.
    fn know_past(&mut self, method: &Method, step: f64) -> Result<(), Error> {
        let earlier = self.state.earlier_step;
        if earlier == 0.0 {
            return self.look_back(method, LOOKED_BACK * step);
        }
        if step > LARGEST_GROWTH * earlier {
            let mut state = self.state.clone();
            // At a dead centre there are no accelerations by themselves; those of the last step stay.
            if Starter::of(&self.system)?.accelerate(&mut state).is_ok() {
                std::mem::swap(&mut self.state, &mut state);
                if self.look_back(method, LOOKED_BACK * step).is_err() {
                    self.state = state;
                }
            }
        }
        Ok(())
    }

    /// The past of a start, and the algorithmic accelerations that belong to it: without them the joints' forces are of first
    /// order only in the first steps.
    fn look_back(&mut self, method: &Method, interval: f64) -> Result<(), Error> {
        Starter::of(&self.system)?.look_back(&mut self.state, interval)?;
        let State {
            algorithmic,
            accelerations,
            earlier_accelerations,
            ..
        } = &mut self.state;
        let ahead = method.scheme.time_ahead();
        for (i, algorithmic) in algorithmic.iter_mut().enumerate() {
            let change = accelerations[i] - earlier_accelerations[i];
            *algorithmic = accelerations[i] + ahead * change;
        }
        Ok(())
    }

    /// Sets an input from now on.
    ///
    /// # Errors
    /// [`Error::UnknownInput`]; [`Error::BadNumber`] for a value that isn't finite.
    pub fn set_input(&mut self, name: &str, value: f64) -> Result<(), Error> {
        if !value.is_finite() {
            return Err(Error::BadNumber {
                quantity: format!("input {name:?}"),
                found: value,
                expected: "a finite number",
            });
        }
        let found = self
            .system
            .inputs
            .iter()
            .position(|(input, _)| input == name);
        match found {
            Some(index) => {
                self.state.inputs[index] = value;
                Ok(())
            }
            None => Err(Error::UnknownInput {
                name: name.to_owned(),
                known: self
                    .system
                    .inputs
                    .iter()
                    .map(|(name, _)| name.clone())
                    .collect(),
            }),
        }
    }
}
