//! Steps of a method that is given an accuracy.

use super::{Simulation, Stepper};
use crate::error::Error;
use crate::integrator::Effort;

impl Simulation {
    /// One step towards an end, as long as the accuracy of the method allows; its length, and what it took.
    ///
    /// # Errors
    /// [`Error::NotConverged`] and others of a step, where no shorter one puts it right; the motion stays where it was.
    pub fn step_towards(&mut self, end: f64) -> Result<(f64, Effort), Error> {
        self.feeling_inputs(|simulation| simulation.follow_towards(end))
    }

    /// About how far off forces in bodies are by a single step, relative to the largest in each of them; zero of a method of steps of a length.
    pub fn error_of_forces(&self) -> f64 {
        match &self.stepper {
            Stepper::Radau(radau) => radau.control.error_of_forces(),
            Stepper::GeneralizedAlpha(_) => 0.0,
        }
    }

    /// Advances by a time, in as many steps as the accuracy needs. A step that fails leaves the motion at the last one that was made.
    pub(super) fn follow_over(&mut self, time: f64) -> Result<Effort, Error> {
        let (end, rest) = self.state.time_after(time);
        let mut effort = Effort::default();
        while self.state.time < end {
            let (_, made) = self.follow_towards(end)?;
            effort.iterations += made.iterations;
            effort.factorizations += made.factorizations;
        }
        self.state.time_rest = rest;
        Ok(effort)
    }

    /// One step towards an end, as long as the accuracy allows; it ends no later than at the next sample or jump of what drives and loads follow.
    pub(super) fn follow_towards(&mut self, end: f64) -> Result<(f64, Effort), Error> {
        let Self {
            system,
            stepper,
            state,
            corrector,
            ..
        } = self;
        let Stepper::Radau(radau) = stepper else {
            return Err(Error::described(
                "integrator",
                "takes steps of a length, not of an accuracy; that needs radau",
            ));
        };
        let jump = radau.next_jump(system, state.time);
        let stop = end.min(system.next_sample(state).time).min(jump);
        radau.begin(system, state);
        let mut more = Effort::default();
        let (step, ends_at_stop) = loop {
            let left = stop - state.time - state.time_rest;
            if let Some((step, made)) = radau.cross(corrector, system, state, stop) {
                more.iterations += made.iterations;
                more.factorizations += made.factorizations;
                break (step, step == left);
            }
            let step = radau.step_up_to(system, state, left);
            let ends_at_stop = step == left;
            // What jumps at the end is looked at before it does.
            let until = match ends_at_stop {
                true => stop.next_down(),
                false => f64::INFINITY,
            };
            let time = state.time + step;
            match radau.step(corrector, system, state, (step, until)) {
                Ok(made) => {
                    more.iterations += made.effort.iterations;
                    more.factorizations += made.effort.factorizations;
                    if radau.control.judge(time, step, made.error)? {
                        break (step, ends_at_stop);
                    }
                }
                Err(
                    error @ (Error::NotConverged { .. }
                    | Error::LongTurn { .. }
                    | Error::NotFinite { .. }
                    | Error::SingularBody { .. }
                    | Error::SingularJoints { .. }),
                ) => {
                    more.iterations += 1;
                    radau.forget_past();
                    // The shortest step says more by why it failed.
                    if radau.control.failed(time, step).is_err() {
                        return Err(error);
                    }
                    if radau.control.is_stuck(step) && state.earlier_step > 0.0 {
                        radau.begin_crossing(system, state, step);
                    }
                }
                Err(other) => return Err(other),
            }
        };
        let trial = &mut corrector.trial;
        if ends_at_stop {
            (trial.time, trial.time_rest) = (stop, 0.0);
        }
        radau.accept(&mut corrector.condensed, system, state, step, trial);
        self.accept(step, more)?;
        if ends_at_stop && jump <= stop {
            self.jump()?;
        }
        Ok((step, more))
    }
}
