//! The start of a step: what the last one tells of its stages.

use super::Radau;
use super::stage::{add_scaled, integrate};
use crate::integrator::newton::Corrector;
use crate::system::{State, System};

/// The last step tells nothing beyond so many of its lengths: its polynomials enlarge rounding and what they lack.
const FURTHEST: f64 = 1.7;

impl Radau {
    /// Accelerations and λ of the stages by the polynomials of the last step, or those of the start; velocities and places by them.
    pub(super) fn predict(
        &mut self,
        corrector: &mut Corrector,
        system: &System,
        start: &State,
        (step, until): (f64, f64),
    ) {
        let past = &self.past;
        let ahead = step / past.step;
        let is_known = past.is_continued && ahead < FURTHEST;
        for (i, stage) in self.stages.iter_mut().enumerate() {
            let state = &mut stage.state;
            (state.time, state.time_rest) = start.time_after(step * self.coefficients.nodes[i]);
            if state.time >= until {
                (state.time, state.time_rest) = (until, 0.0);
            }
            state.angles.copy_from_slice(&start.angles);
            state.inputs.copy_from_slice(&start.inputs);
            state.felt_inputs.copy_from_slice(&start.felt_inputs);
            state.memory.copy_from_slice(&start.memory);
            if !is_known {
                state.accelerations.copy_from_slice(&start.accelerations);
                state.forces.copy_from_slice(&start.forces);
                continue;
            }
            let x = 1.0 + ahead * self.coefficients.nodes[i];
            self.coefficients.write_values(x, &mut self.weights);
            state.accelerations.fill(0.0);
            state.forces.fill(0.0);
            for (node, weight) in self.weights.iter().enumerate() {
                add_scaled(&mut state.accelerations, *weight, &past.accelerations[node]);
                add_scaled(&mut state.forces, *weight, &past.forces[node]);
            }
            if corrector.condensed.carries_redundant() {
                for (force, before) in state.forces.iter_mut().zip(&start.forces) {
                    *force -= before;
                }
                corrector.condensed.remove_redundant(&mut state.forces);
                for (force, before) in state.forces.iter_mut().zip(&start.forces) {
                    *force += before;
                }
            }
        }
        for (stage, node) in self.stages.iter_mut().zip(&self.coefficients.nodes) {
            for (turn, body) in stage.turns.iter_mut().zip(&system.bodies) {
                *turn = super::stage::spin(start, body) * (step * node);
            }
        }
        integrate(&mut self.stages, &self.coefficients, system, start, step);
    }
}
