//! Efforts of a system's actuators, and what they remember from step to step.

use super::evaluation::Evaluation;
use super::{Demand, Row, State, System};
use crate::actuator::{Actuator, Effort, Integral, Source, Timing};

/// Part of a period by which a sample may be off: rounding of written numbers.
const SAME_SAMPLE: f64 = 1e-8;

/// When something is to be computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NextSample {
    /// The time.
    pub time: f64,
    /// Times that differ by less are the same.
    pub rounding: f64,
}

impl System {
    /// The effort of an actuator at a state, where its row's measure and the rate have these values.
    pub fn effort(&self, actuator: &Actuator, state: &State, measured: f64, rate: f64) -> Effort {
        let value = measured - actuator.zero;
        match &actuator.source {
            Source::Given(signal) => Effort {
                force: self.signal(*signal, state).value,
                ..Effort::default()
            },
            Source::Servo(servo, _) if servo.sample.is_some() => Effort {
                force: state.memory[actuator.memory],
                ..Effort::default()
            },
            Source::Servo(servo, target) => {
                let target = self.signal(*target, state);
                servo.effort(&target, value, rate, &integral(actuator, state))
            }
            // Known to an evaluation only.
            Source::Controlled(_) => Effort::default(),
            Source::Friction(friction) => friction.effort(rate),
            Source::EndStop(stop) => stop.effort(value, rate),
        }
    }

    /// The controller of a row.
    pub fn controller_of(&self, row: &Row) -> Option<usize> {
        match &row.demand {
            Demand::Actuate(actuator) => match self.actuators[*actuator].source {
                Source::Controlled(controller) => Some(controller),
                _ => None,
            },
            Demand::Hold(_) | Demand::Follow(_) | Demand::Answer(_) => None,
        }
    }

    /// The effort that a controller asks for, with those of the continuous ones as evaluated.
    pub fn controlled(&self, controller: usize, state: &State, continuous: &[f64]) -> f64 {
        match &self.controllers[controller].timing {
            Timing::Continuous { .. } => continuous[controller],
            Timing::Sampled { memory, .. } => state.memory[*memory],
        }
    }

    /// Energy that an actuator stores.
    pub fn stored_by(&self, actuator: &Actuator, measured: f64) -> f64 {
        match &actuator.source {
            Source::EndStop(stop) => stop.potential(measured - actuator.zero),
            Source::Given(_) | Source::Controlled(_) | Source::Servo(..) | Source::Friction(_) => {
                0.0
            }
        }
    }

    /// Power that an actuator puts in, and power that it turns into heat.
    pub fn power_of(&self, actuator: &Actuator, force: f64, measured: f64, rate: f64) -> [f64; 2] {
        match &actuator.source {
            Source::Given(_) | Source::Controlled(_) | Source::Servo(..) => [force * rate, 0.0],
            Source::Friction(friction) => [0.0, friction.dissipation(rate)],
            Source::EndStop(stop) => [0.0, stop.dissipation(measured - actuator.zero, rate)],
        }
    }

    /// The next time at which something is to be computed and held: infinite where nothing is.
    pub fn next_sample(&self, state: &State) -> NextSample {
        let mut next = NextSample {
            time: f64::INFINITY,
            rounding: 0.0,
        };
        for (period, count) in self.sampled() {
            let time = state.memory[count] * period;
            if time < next.time {
                next = NextSample {
                    time,
                    rounding: SAME_SAMPLE * period,
                };
            }
        }
        next
    }

    /// Computes the efforts that are due at a state and holds them, after its evaluation.
    ///
    /// `arguments` are the outputs that sampled controllers use.
    pub fn sample(&self, evaluation: &Evaluation, arguments: &[f64], state: &mut State) {
        for controller in &self.controllers {
            let Timing::Sampled {
                period,
                arguments: own,
                memory,
            } = &controller.timing
            else {
                continue;
            };
            if is_due(*period, state.memory[memory + 1], state.time) {
                let own = &arguments[own.clone()];
                state.memory[*memory] = controller.formula.evaluate(state.time, own);
                state.memory[memory + 1] += 1.0;
            }
        }
        for actuator in &self.actuators {
            let Source::Servo(servo, target) = &actuator.source else {
                continue;
            };
            let Some(period) = servo.sample else { continue };
            let memory = actuator.memory;
            if !is_due(period, state.memory[memory + 2], state.time) {
                continue;
            }
            let target = self.signal(*target, state);
            let value = evaluation.values[actuator.row] - actuator.zero;
            let rate = evaluation.value_rates[actuator.row];
            let z = state.memory[memory + 1];
            let (force, next) = servo.sampled(period, &target, value, rate, z);
            state.memory[memory] = force;
            state.memory[memory + 1] = next;
            state.memory[memory + 2] += 1.0;
        }
    }

    /// Periods, and where the numbers of samples are remembered.
    fn sampled(&self) -> impl Iterator<Item = (f64, usize)> {
        let servos = self
            .actuators
            .iter()
            .filter_map(|actuator| match &actuator.source {
                Source::Servo(servo, _) => Some((servo.sample?, actuator.memory + 2)),
                _ => None,
            });
        let controllers = self.controllers.iter().filter_map(|one| match &one.timing {
            Timing::Sampled { period, memory, .. } => Some((*period, memory + 1)),
            Timing::Continuous { .. } => None,
        });
        servos.chain(controllers)
    }

    /// What actuators remember at a state that is accepted, after its evaluation.
    pub fn remember(&self, evaluation: &Evaluation, state: &mut State) {
        for actuator in &self.actuators {
            let value = evaluation.values[actuator.row] - actuator.zero;
            let rate = evaluation.value_rates[actuator.row];
            let memory = actuator.memory;
            match &actuator.source {
                Source::Given(_) | Source::Controlled(_) | Source::Friction(_) => {}
                Source::Servo(servo, _) if !servo.remembers() || servo.sample.is_some() => {}
                Source::Servo(servo, target) => {
                    let target = self.signal(*target, state);
                    let before = integral(actuator, state);
                    let (z, z_rate) = servo.carried(&target, value, rate, &before);
                    state.memory[memory..memory + 3].copy_from_slice(&[z, z_rate, state.time]);
                }
                Source::EndStop(_) => {
                    state.memory[memory..memory + 2].copy_from_slice(&[value, rate]);
                }
            }
        }
    }
}

/// Whether a sample, counted from zero, is due.
fn is_due(period: f64, count: f64, time: f64) -> bool {
    time >= (count - SAME_SAMPLE) * period
}

/// The integral of a servo's deviation where it was remembered last.
fn integral(actuator: &Actuator, state: &State) -> Integral {
    match &actuator.source {
        Source::Servo(servo, _) if servo.remembers() => {
            let memory = &state.memory[actuator.memory..];
            Integral {
                value: memory[0],
                rate: memory[1],
                elapsed: state.time - memory[2],
            }
        }
        _ => Integral::default(),
    }
}
