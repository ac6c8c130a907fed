//! Changes of the measures of rows: those that are needed, and those by a motion.

use super::Condensed;
use super::touch::side;
use crate::kinematics::frame_motion::Six;
use crate::system::evaluation::Evaluation;
use crate::system::marker::turned;
use crate::system::{Demand, State, System};

impl Condensed {
    /// Change that each row's measure needs: to the demand for constraints, and for springs by what the force still differs.
    ///
    /// Where constraints are redundant their regularization is a compliance of the joints, part of the equations and not
    /// of the iteration alone: the share of λ that does nothing is then determined and can't drift from step to step.
    pub fn demand(
        &self,
        system: &System,
        state: &State,
        evaluation: &Evaluation,
        changes: &mut [f64],
    ) {
        for (index, row) in system.rows.iter().enumerate() {
            changes[index] = match &row.demand {
                Demand::Hold(_) | Demand::Follow(_) => {
                    -evaluation.answers[index] - self.yielding(state, index)
                }
                Demand::Answer(_) => {
                    (evaluation.answers[index] - state.forces[index]) * self.compliances[index]
                }
                Demand::Actuate(actuator) => {
                    let met = self.met_effort(system, state, evaluation, *actuator);
                    (met.effort.force - state.forces[index]) * self.compliances[index] + met.change
                }
            };
        }
    }

    /// How the rows' measures change with a motion δq, rigid parts in body axes.
    pub fn row_changes(
        &mut self,
        system: &System,
        evaluation: &Evaluation,
        motion: &[f64],
        changes: &mut [f64],
    ) {
        self.twist_markers(system, evaluation, motion);
        changes.fill(0.0);
        for touch in self.touches.iter().flatten() {
            changes[touch.row] += side(evaluation, touch).dot(&self.twists[touch.marker(system)]);
        }
    }

    /// World twists of the markers by a motion δq.
    fn twist_markers(&mut self, system: &System, evaluation: &Evaluation, motion: &[f64]) {
        for (body, pose) in system.bodies.iter().zip(&evaluation.poses) {
            let (rigid, elastic) = motion[body.velocities.clone()].split_at(6);
            let six = Six::from_column_slice(rigid);
            for &marker in body.markers.iter().filter(|m| self.coupled[**m]) {
                let twist = system.markers[marker].twist(&evaluation.places[marker], &six, elastic);
                self.twists[marker] = turned(&pose.axes, &twist);
            }
        }
    }

    /// How far a constraint gives way to its force by the regularization.
    pub fn yielding(&self, state: &State, row: usize) -> f64 {
        self.joints.regularizing_compliance(row) * state.forces[row]
    }
}
