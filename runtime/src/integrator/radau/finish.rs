//! The end of a step: back to the constraints.

use super::Radau;
use crate::error::Error;
use crate::integrator::newton::Corrector;
use crate::system::{Demand, State, System};

/// Times that places are brought back at most.
const CORRECTIONS: usize = 4;
/// What a correction may be of the one before it.
const SHRUNK: f64 = 0.3;
/// Corrections below this part of the tolerance end it.
const CLOSED: f64 = 1e-5;
/// Velocities that have to change by more than this part of themselves belong to another motion, which meets this one at a dead centre.
const ANOTHER_MOTION: f64 = 0.01;

impl Radau {
    /// The trial state and its evaluation at the end of the step, with places and velocities that meet the constraints in the metric of the real
    /// factor.
    ///
    /// # Errors
    /// [`Error::NotConverged`] where velocities belong to another motion, [`Error::Contradiction`], [`Error::LongTurn`], those of a factorization.
    pub(super) fn finish(
        &mut self,
        corrector: &mut Corrector,
        system: &System,
        start: &State,
        step: f64,
    ) -> Result<(), Error> {
        // Its time is that of the end, or just before what jumps there.
        let last = self.stages.len() - 1;
        corrector.trial.copy_from(&self.stages[last].state);
        corrector.evaluation.place(system, &corrector.trial);
        if !self.close(corrector, system) {
            // The factor is of other gradients: where a body resists turns far less than shifts, the joints' system turns with them.
            corrector.trial.copy_from(&self.stages[last].state);
            corrector.factor_here(system)?;
            self.close(corrector, system);
        }
        let rounding = corrector.rounding(system) * self.scale.by_length();
        let Corrector {
            trial,
            evaluation,
            condensed,
            ..
        } = &mut *corrector;
        trial.algorithmic.copy_from_slice(&trial.accelerations);
        let [residual, changes] = &mut self.real;
        residual.fill(0.0);
        evaluation.add_velocities(system, trial);
        evaluation.measure(system, trial);
        for (index, change) in changes.iter_mut().enumerate() {
            let defect = evaluation.velocity_defect(system, trial, index);
            *change = -defect.unwrap_or(0.0);
        }
        condensed.solve_positions(system, evaluation, changes, residual);
        let change = self.scale.size(system, &condensed.step);
        condensed.add_step(system, evaluation, &mut trial.velocities);
        let [before, after] = [&start.velocities, &trial.velocities]
            .map(|velocities| self.scale.size(system, velocities));
        let tolerance = self.accuracy.tolerance;
        let allowed = ANOTHER_MOTION.max(tolerance) * before.max(after);
        if change > allowed && change * step > (CLOSED * tolerance).max(rounding) {
            return Err(Error::NotConverged {
                time: trial.time,
                iterations: 0,
                residual: change * step,
                tolerance: allowed * step,
                worst: corrector.worst_body(system),
            });
        }
        evaluation.add_velocities(system, trial);
        evaluation.add_accelerations(system, trial);
        for (index, row) in system.rows.iter().enumerate() {
            if let Demand::Answer(_) | Demand::Actuate(_) = row.demand {
                trial.forces[index] = evaluation.answers[index];
            }
        }
        let accuracy = self.accuracy.tolerance / self.scale.by_length();
        corrector.refuse_contradiction(system, 1e-6 * accuracy)?;
        let gaps = self
            .coefficients
            .nodes
            .windows(2)
            .map(|pair| pair[1] - pair[0]);
        let widest = gaps.fold(self.coefficients.nodes[0], f64::max);
        corrector.refuse_long_turns(system, step * widest)
    }

    /// Brings the places of the trial state back to the constraints. Returns whether the corrections shrink as they should.
    fn close(&mut self, corrector: &mut Corrector, system: &System) -> bool {
        let rounding = corrector.rounding(system) * self.scale.by_length();
        let Corrector {
            trial,
            evaluation,
            condensed,
            ..
        } = &mut *corrector;
        let [residual, changes] = &mut self.real;
        residual.fill(0.0);
        let mut before = f64::INFINITY;
        for _ in 0..CORRECTIONS {
            evaluation.measure(system, trial);
            for (index, change) in changes.iter_mut().enumerate() {
                *change = match system.rows[index].is_constraint() {
                    true => -evaluation.answers[index],
                    false => 0.0,
                };
            }
            condensed.solve_positions(system, evaluation, changes, residual);
            let size = self.scale.size(system, &condensed.step);
            if size.is_nan() || size > SHRUNK * before && size > 100.0 * rounding {
                return false;
            }
            trial.shift(system, &condensed.step);
            evaluation.place(system, trial);
            if size < (CLOSED * self.accuracy.tolerance).max(rounding) {
                return true;
            }
            before = size;
        }
        true
    }
}
