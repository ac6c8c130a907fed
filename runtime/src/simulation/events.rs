//! What happens within steps and between them: contacts with end stops, samples of controllers.

use super::{Sight, Simulation, Stepper};
use crate::actuator::{End, Source};
use crate::error::Error;
use crate::system::System;

/// Halvings of a step in which a contact is looked for.
const HALVINGS: usize = 60;

/// A coordinate that came to an end stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// When, by the cubic through the coordinate and its rate at both ends of the step.
    pub time: f64,
    /// Index of the actuator.
    pub actuator: usize,
    /// Which stop.
    pub end: End,
    /// Rate of the coordinate then.
    pub rate: f64,
}

impl Contact {
    /// What happened, for people.
    pub fn message(&self, system: &System) -> String {
        let row = &system.rows[system.actuators[self.actuator].row];
        format!(
            "actuator {:?}: contact with the {} end at a rate of {:.4e}",
            system.connections[row.connection].name,
            self.end.name(),
            self.rate
        )
    }
}

impl Simulation {
    /// Contacts with end stops so far, in the order of time within each step.
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// Contacts within the step that led to the state, before it is remembered.
    pub(super) fn find_contacts(&mut self, step: f64) {
        let state = &self.state;
        for (index, actuator) in self.system.actuators.iter().enumerate() {
            let Source::EndStop(stop) = &actuator.source else {
                continue;
            };
            let evaluation = &self.corrector.evaluation;
            let after = evaluation.values[actuator.row] - actuator.zero;
            let rate_after = evaluation.value_rates[actuator.row];
            let [before, rate_before] = [0, 1].map(|place| state.memory[actuator.memory + place]);
            let Some((end, _)) = stop.beyond(after) else {
                continue;
            };
            if stop.beyond(before).is_some_and(|(other, _)| other == end) {
                continue;
            }
            let at = |x: f64| {
                let y = 1.0 - x;
                let [a, b] = [y * y * (1.0 + 2.0 * x), step * x * y * y];
                let [c, d] = [x * x * (1.0 + 2.0 * y), -step * x * x * y];
                a * before + b * rate_before + c * after + d * rate_after
            };
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                match stop
                    .beyond(at(middle))
                    .is_some_and(|(other, _)| other == end)
                {
                    true => high = middle,
                    false => low = middle,
                }
            }
            self.contacts.push(Contact {
                time: state.time - (1.0 - high) * step,
                actuator: index,
                end,
                rate: rate_before + high * (rate_after - rate_before),
            });
        }
    }

    /// A step that would pass a sample.
    ///
    /// # Errors
    /// [`Error::PassesSample`].
    pub(super) fn refuse_passing(&self, step: f64) -> Result<(), Error> {
        let next = self.system.next_sample(&self.state);
        let end = self.state.time + step;
        match next.time < end - next.rounding {
            true => Err(Error::PassesSample {
                time: self.state.time,
                step,
                sample: next.time,
            }),
            false => Ok(()),
        }
    }

    /// Computes what is to be computed at this time, and gives the accelerations and forces the jump that follows.
    ///
    /// # Errors
    /// Those of a factorization.
    pub(super) fn sample(&mut self) -> Result<(), Error> {
        let next = self.system.next_sample(&self.state);
        if self.state.time < next.time - next.rounding {
            return Ok(());
        }
        self.refresh();
        if let Some(mut senses) = self.senses.take() {
            let (energy, works, defect) = self.energy();
            let sight = Sight {
                system: &self.system,
                state: &self.state,
                evaluation: &self.corrector.evaluation,
                energy,
                works,
                defect,
            };
            senses(&sight, &mut self.arguments);
            self.senses = Some(senses);
        }
        let evaluation = &self.corrector.evaluation;
        self.system
            .sample(evaluation, &self.arguments, &mut self.state);
        self.jump()
    }

    /// Makes a step with the jump of accelerations and forces that belongs to inputs which were set since the last one: what is held acts in full from
    /// the start of the step on. A step that fails leaves all as it was.
    pub(super) fn feeling_inputs<T>(
        &mut self,
        step: impl FnOnce(&mut Self) -> Result<T, Error>,
    ) -> Result<T, Error> {
        if self.state.inputs == self.state.felt_inputs {
            return step(self);
        }
        let (state, works) = &mut self.unfelt;
        state.copy_from(&self.state);
        *works = self.works;
        let changed = |input: &usize| self.state.inputs[*input] != self.state.felt_inputs[*input];
        let mut changed = (0..self.state.inputs.len()).filter(changed);
        let has_jumped = changed.any(|input| self.system.is_effort(input));
        self.state.felt_inputs.copy_from_slice(&self.state.inputs);
        if has_jumped {
            let evaluation = &mut self.corrector.evaluation;
            evaluation.place(&self.system, &self.state);
            evaluation.add_velocities(&self.system, &self.state);
            evaluation.add_accelerations(&self.system, &self.state);
            // At a dead centre forces have no accelerations of their own; there the change is a ramp over the step.
            if self.jump().is_err() {
                self.go_back();
                self.state.felt_inputs.copy_from_slice(&self.state.inputs);
            }
        }
        let made = step(self);
        if made.is_err() {
            self.go_back();
        }
        made
    }

    /// To the state before inputs were felt.
    fn go_back(&mut self) {
        let (state, works) = &self.unfelt;
        self.state.copy_from(state);
        self.works = *works;
        self.corrector.forget_factor();
    }

    /// Efforts that have changed at this time.
    pub(super) fn jump(&mut self) -> Result<(), Error> {
        let (system, state) = (&self.system, &mut self.state);
        match &mut self.stepper {
            Stepper::GeneralizedAlpha(method) => {
                self.corrector.jump(system, &method.scheme, state)?;
            }
            Stepper::Radau(radau) => radau.restart(&mut self.corrector, system, state)?,
        }
        // Places and velocities are as they were.
        let evaluation = &mut self.corrector.evaluation;
        evaluation.add_accelerations(&self.system, &self.state);
        evaluation.load(&self.system, &self.state);
        evaluation.resist(&self.system, &self.state);
        self.works.go_on(&self.system, &self.state, evaluation);
        Ok(())
    }
}
