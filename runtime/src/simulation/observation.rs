//! The motion as it is now, and within the last step.

use super::{Simulation, Stepper};
use crate::energy::{Energy, Works};
use crate::integrator::Effort;
use crate::integrator::between::between;
use crate::system::evaluation::Evaluation;
use crate::system::{State, System};

impl Simulation {
    /// The motion now.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The mechanism.
    pub fn system(&self) -> &System {
        &self.system
    }

    /// Steps so far, and what they took.
    pub fn effort(&self) -> (usize, Effort) {
        (self.steps, self.effort)
    }

    /// Evaluates frames, velocities, accelerations and forces at the state. Forces of redundant constraints are shared out for it in the
    /// minimum-norm sense.
    pub fn refresh(&mut self) -> &mut Evaluation {
        let (system, state) = (&self.system, &mut self.state);
        self.corrector.evaluation.refresh(system, state);
        let is_shared = self.corrector.share_redundant(system, state);
        let evaluation = &mut self.corrector.evaluation;
        if is_shared {
            self.effort.factorizations += 1;
            evaluation.load(system, state);
            evaluation.resist(system, state);
        }
        evaluation
    }

    /// The motion at a time within the last step, which must have been the last thing that happened to it, evaluated as
    /// [`Simulation::refresh`] does ([`crate::integrator::between`]).
    pub fn look_within(&mut self, time: f64) -> State {
        let Self {
            system,
            corrector,
            stepper,
            ..
        } = self;
        // After a step the trial state is what it began with.
        let mut now = match stepper {
            Stepper::Radau(radau) if !radau.has_crossed() => {
                radau.within(system, &corrector.trial, &self.state, time)
            }
            Stepper::GeneralizedAlpha(_) | Stepper::Radau(_) => {
                between(system, &corrector.trial, &self.state, time)
            }
        };
        corrector.evaluation.refresh(system, &now);
        corrector.evaluation.count_turns(system, &mut now);
        if corrector.share_redundant_within(system, &mut now) {
            self.effort.factorizations += 1;
            corrector.evaluation.load(system, &now);
            corrector.evaluation.resist(system, &now);
        }
        now
    }

    /// Energy, works and the balance's defect at a state that [`Simulation::look_within`] gave last.
    pub(crate) fn energy_within(&mut self, now: &State) -> (Energy, Works, f64) {
        let step = self.state.earlier_step;
        let x = (now.time - self.corrector.trial.time) / step;
        let works = self.earlier_works.within(&self.works, x, step);
        let energy = Energy::at(&self.system, now, &mut self.corrector.evaluation);
        (energy, works, self.lacking(&energy, &works))
    }

    /// Last evaluation.
    pub fn evaluation(&self) -> &Evaluation {
        &self.corrector.evaluation
    }

    /// Energy, works, and the balance's defect, after `refresh`.
    pub fn energy(&mut self) -> (Energy, Works, f64) {
        let evaluation = &mut self.corrector.evaluation;
        let energy = Energy::at(&self.system, &self.state, evaluation);
        (energy, self.works, self.lacking(&energy, &self.works))
    }

    /// Defect of the balance.
    fn lacking(&self, energy: &Energy, works: &Works) -> f64 {
        energy.total() - self.reference_energy - works.drives - works.loads + works.dissipated
    }

    /// g of a body, after `refresh`: forces and moments of joints, springs and loads on its interface rows, body axes, acting
    /// on the body. One entry for each row of [`crate::FlexibleBody::rows`]; `body` counts in the order of the system.
    pub fn interface_forces(&self, body: usize) -> Vec<f64> {
        let mut forces = vec![0.0; self.system.bodies[body].flexible.rows.len()];
        self.corrector
            .evaluation
            .write_interface_forces(&self.system, body, &mut forces);
        forces
    }
}
