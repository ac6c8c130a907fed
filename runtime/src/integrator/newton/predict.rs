//! The start of a step: what the motion so far tells of its end.

use nalgebra::{UnitQuaternion, Vector3};

use super::Corrector;
use super::correct::three;
use crate::error::Error;
use crate::integrator::method::Method;
use crate::system::{State, System};
use dcb_formats::scene::Scheme;

impl Corrector {
    /// The change of the velocities that a larger step asks for.
    ///
    /// An increment lacks `h³ c` of the motion. Constraints on positions put that right in their own directions, by velocities that are
    /// off by `h² c` there. Where the step is the same from step to step this is smooth and of second order; where it grows, and at the
    /// start, the velocities have to be given it, or the accelerations jump by `h c` and the joints' forces with them
    /// (Arnold, Brüls and Cardona 2015). Not where it shrinks: c comes from the change of the accelerations, and steps that are cut
    /// again and again would feed on its rounding and ringing.
    pub(super) fn find_offset(
        &mut self,
        system: &System,
        method: &Method,
        start: &State,
        step: f64,
    ) -> Result<(), Error> {
        self.trial.copy_from(start);
        self.turns.fill(Vector3::zeros());
        self.evaluate(system, method.formulation);
        self.factor(system, method, step)?;
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
    pub(super) fn predict(&mut self, system: &System, scheme: &Scheme, start: &State, step: f64) {
        let trial = &mut self.trial;
        (trial.time, trial.time_rest) = start.time_after(step);
        trial.angles.copy_from_slice(&start.angles);
        trial.inputs.copy_from_slice(&start.inputs);
        trial.felt_inputs.copy_from_slice(&start.felt_inputs);
        trial.memory.copy_from_slice(&start.memory);
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
        self.force_changes.fill(0.0);
        if self.condensed.regularization == 0.0 || self.condensed.carries_redundant() {
            for (i, change) in self.force_changes.iter_mut().enumerate() {
                *change = carried(0.0, start.earlier_forces[i] - start.forces[i]);
            }
            self.condensed.remove_redundant(&mut self.force_changes);
        }
        let changes = start.forces.iter().zip(&self.force_changes);
        for (force, (before, change)) in trial.forces.iter_mut().zip(changes) {
            *force = before + change;
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
}
