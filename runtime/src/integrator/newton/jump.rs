//! Efforts that jump from one step to the next.

use super::Corrector;
use super::correct::three;
use crate::error::Error;
use crate::system::body_factor::Elastic;
use crate::system::condensed::Blend;
use crate::system::{State, System};

impl Corrector {
    /// Gives a state the accelerations and constraint forces that belong to efforts which have jumped. Its past jumps with it, so that
    /// what is smooth goes on: a step from here knows of no earlier effort.
    ///
    /// # Errors
    /// [`Error::SingularBody`], [`Error::SingularJoints`].
    pub fn jump(&mut self, system: &System, state: &mut State) -> Result<(), Error> {
        self.evaluation.measure(system, state);
        for actuator in &system.actuators {
            let row = actuator.row;
            let change = self.evaluation.answers[row] - state.forces[row];
            state.forces[row] += change;
            state.earlier_forces[row] += change;
        }
        self.evaluation.load(system, state);
        self.evaluation.resist(system, state);
        let blend = Blend::mass_alone(Elastic::Moving);
        self.factored_step = None;
        self.condensed
            .factor(system, state, &self.evaluation, &blend, None)?;
        self.changes.fill(0.0);
        let residual = &self.evaluation.residual;
        self.condensed
            .solve(system, state, &self.evaluation, &self.changes, residual);
        for (index, body) in system.bodies.iter().enumerate() {
            let step = &self.condensed.step[body.velocities.clone()];
            let linear = self.evaluation.poses[index].axes * three(step, 0);
            for (k, change) in step.iter().enumerate() {
                let change = if k < 3 { linear[k] } else { *change };
                let at = body.velocities.start + k;
                state.accelerations[at] += change;
                state.algorithmic[at] += change;
                state.earlier_accelerations[at] += change;
            }
        }
        for (index, row) in system.rows.iter().enumerate() {
            if row.is_constraint() {
                state.forces[index] += self.condensed.force_step[index];
                state.earlier_forces[index] += self.condensed.force_step[index];
            }
        }
        Ok(())
    }
}
