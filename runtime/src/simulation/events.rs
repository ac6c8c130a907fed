//! What happens within steps and between them: contacts with end stops, samples of controllers.

use super::{Sight, Simulation};
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
        self.corrector.jump(&self.system, &mut self.state)?;
        self.corrector.evaluation.refresh(&self.system, &self.state);
        self.works
            .go_on(&self.system, &self.state, &self.corrector.evaluation);
        Ok(())
    }
}
