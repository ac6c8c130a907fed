//! Efforts that jump from one step to the next.

use super::Corrector;
use super::correct::three;
use crate::error::Error;
use crate::system::condensed::Blend;
use crate::system::{State, System};
use dcb_formats::scene::Scheme;

impl Corrector {
    /// Gives a state the accelerations and constraint forces that belong to efforts which have jumped. Its past jumps with it, so that
    /// what is smooth goes on: a step from here knows of no earlier effort.
    ///
    /// The change is (M + β h² K)⁻¹ Δf with the size h of the last step. Motions that such steps follow jump by M⁻¹ Δf, but for (ω h)²; faster ones hardly
    /// at all: their jump would be integrated as if it lasted.
    ///
    /// # Errors
    /// [`Error::SingularBody`], [`Error::SingularJoints`], [`Error::OutOfMemory`].
    pub fn jump(
        &mut self,
        system: &System,
        scheme: &Scheme,
        state: &mut State,
    ) -> Result<(), Error> {
        self.evaluation.measure(system, state);
        for actuator in &system.actuators {
            let row = actuator.row;
            let change = self.evaluation.answers[row] - state.forces[row];
            state.forces[row] += change;
            state.earlier_forces[row] += change;
        }
        self.evaluation.load(system, state);
        self.evaluation.resist(system, state);
        let h = state.earlier_step;
        let blend = Blend::smoothed_mass(scheme.beta * h * h);
        let condensed = match &mut self.jumping {
            Some(condensed) => condensed,
            unused => unused.insert(Box::new(self.condensed.another(system)?)),
        };
        condensed.factor(system, state, &self.evaluation, &blend, None)?;
        self.changes.fill(0.0);
        let residual = &self.evaluation.residual;
        condensed.solve(system, state, &self.evaluation, &self.changes, residual);
        for (index, body) in system.bodies.iter().enumerate() {
            let step = &condensed.step[body.velocities.clone()];
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
                state.forces[index] += condensed.force_step[index];
                state.earlier_forces[index] += condensed.force_step[index];
            }
        }
        Ok(())
    }
}
