//! The start anew after a jump of forces or of what drives follow.

use super::Radau;
use crate::error::Error;
use crate::integrator::newton::Corrector;
use crate::system::body_factor::Elastic;
use crate::system::condensed::Blend;
use crate::system::{State, System};

impl Radau {
    /// Velocities that meet the constraints of now, and the accelerations and λ that belong to them; what was before is forgotten.
    ///
    /// # Errors
    /// [`Error::SingularBody`], [`Error::SingularJoints`], [`Error::OutOfMemory`].
    pub fn restart(
        &mut self,
        corrector: &mut Corrector,
        system: &System,
        state: &mut State,
    ) -> Result<(), Error> {
        let evaluation = &mut corrector.evaluation;
        let condensed = match &mut self.mass {
            Some(condensed) => condensed,
            unused => unused.insert(Box::new(corrector.condensed.another(system)?)),
        };
        evaluation.refresh(system, state);
        let blend = Blend::mass_alone(Elastic::Moving);
        condensed.factor(system, state, evaluation, &blend, None)?;
        let [zeros, changes] = &mut self.real;
        zeros.fill(0.0);
        for (index, change) in changes.iter_mut().enumerate() {
            let defect = evaluation.velocity_defect(system, state, index);
            *change = -defect.unwrap_or(0.0);
        }
        condensed.solve_held(system, evaluation, changes, zeros);
        condensed.add_step(system, evaluation, &mut state.velocities);
        // With redundant constraints one solve is as exact as their regularization; two are exact.
        for _ in 0..2 {
            evaluation.add_velocities(system, state);
            evaluation.add_accelerations(system, state);
            evaluation.measure(system, state);
            for (index, row) in system.rows.iter().enumerate() {
                if !row.is_constraint() {
                    state.forces[index] = evaluation.answers[index];
                }
            }
            evaluation.load(system, state);
            evaluation.resist(system, state);
            for (index, change) in changes.iter_mut().enumerate() {
                let defect = evaluation.acceleration_defect(system, state, index);
                *change = -defect.unwrap_or(0.0);
            }
            let residual = &evaluation.residual;
            condensed.solve_held(system, evaluation, changes, residual);
            condensed.add_step(system, evaluation, &mut state.accelerations);
            for (index, row) in system.rows.iter().enumerate() {
                if row.is_constraint() {
                    state.forces[index] += condensed.force_step[index];
                }
            }
        }
        self.forget_past();
        self.control.forget_trend();
        Ok(())
    }
}
