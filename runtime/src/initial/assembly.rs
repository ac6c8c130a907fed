//! Positions that close the joints.

use nalgebra::{UnitQuaternion, Vector3};

use super::Starter;
use crate::error::Error;
use crate::system::body_factor::Elastic;
use crate::system::condensed::{Blend, Interfaces};
use crate::system::{Demand, State};

/// How far constraints may stay open, relative to the size of the mechanism: rounding. What stays open is pulled shut in the first
/// step, with an acceleration of this much over its square.
pub(super) const CLOSED: f64 = 1e-15;
/// How far a misfit may stay open before a scene is refused.
pub(super) const OPEN: f64 = 1e-8;
/// Largest turn that one iteration of an assembly makes.
const LARGEST_TURN: f64 = 0.5;
/// Iterations of an assembly.
const ITERATIONS: usize = 60;

impl Starter<'_> {
    /// Angles start at their principal value, or at the turn where their drive starts.
    pub(super) fn start_angles(&mut self, state: &mut State) {
        self.evaluation.place(self.system, state);
        for row in &self.system.rows {
            for term in &self.system.terms[row.terms.clone()] {
                if let Some(angle) = term.angle {
                    state.angles[angle] = match &row.demand {
                        Demand::Follow(signal) if term.weight != 0.0 => {
                            self.system.signal(*signal, state).value / term.weight
                        }
                        _ => term.measure.value(
                            &self.evaluation.motions[term.a],
                            &self.evaluation.motions[term.b],
                        ),
                    };
                }
            }
        }
    }

    /// Closes the joints.
    pub(super) fn close(&mut self, state: &mut State) -> Result<(), Error> {
        self.condensed.hold(&self.held);
        let done = self.close_unheld(state);
        self.condensed.hold(&[]);
        done
    }

    fn close_unheld(&mut self, state: &mut State) -> Result<(), Error> {
        let mut closed = self.close_with(state, Elastic::Frozen)?;
        let deflects = self.system.coordinate_count() + self.system.residual_row_count() > 0;
        if !closed && deflects {
            closed = self.close_strained(state)?;
        }
        if closed || self.worst_row().1 <= OPEN {
            return Ok(());
        }
        Err(self.open())
    }

    /// Which joint stays open.
    pub(super) fn open(&self) -> Error {
        let (worst, _) = self.worst_row();
        let connection = &self.system.connections[self.system.rows[worst].connection];
        Error::CannotAssemble {
            joint: connection.name.clone(),
            misfit: self.evaluation.answers[worst],
            allowed: OPEN * self.size,
        }
    }

    /// Closes the joints by deflection, interfaces beside the coordinates included.
    fn close_strained(&mut self, state: &mut State) -> Result<bool, Error> {
        for (force, assembly) in state.forces.iter_mut().zip(&self.assembly) {
            *force -= assembly;
        }
        let closed = self.close_with(state, Elastic::Moving)?;
        for (row, assembly) in self.assembly.iter_mut().enumerate() {
            if self.condensed.is_compliant(row) {
                *assembly = self.condensed.force_step[row];
            }
        }
        for (force, assembly) in state.forces.iter_mut().zip(&self.assembly) {
            *force += assembly;
        }
        Ok(closed)
    }

    pub(super) fn close_with(
        &mut self,
        state: &mut State,
        elastic: Elastic,
    ) -> Result<bool, Error> {
        let softest = self
            .system
            .bodies
            .iter()
            .flat_map(|b| b.flexible.stiffness.iter())
            .filter(|s| **s > 0.0)
            .fold(f64::INFINITY, |least, s| least.min(*s));
        let mut last = f64::INFINITY;
        for _ in 0..ITERATIONS {
            self.evaluation.place(self.system, state);
            self.evaluation.measure(self.system, state);
            let (_, misfit) = self.worst_row();
            if misfit <= CLOSED || (misfit >= 0.5 * last && misfit <= OPEN) {
                return Ok(true);
            }
            last = misfit;
            let blend = match elastic {
                Elastic::Frozen => Blend::mass_alone(elastic),
                // Deflection costs its strain energy, rigid motion next to nothing.
                Elastic::Moving => Blend {
                    mass: 1e-3 * softest,
                    damping: 0.0,
                    stiffness: 1.0,
                    elastic,
                    interfaces: Interfaces::Following,
                },
            };
            let still = state.without_motion();
            self.refresh_inertia(&still);
            self.condensed
                .factor(self.system, &still, &self.evaluation, &blend, None)?;
            self.demand_changes(|evaluation, row| Some(-evaluation.answers[row]));
            let mut forces = std::mem::take(&mut self.zeros);
            forces.fill(0.0);
            if elastic == Elastic::Moving {
                for body in &self.system.bodies {
                    let y = &state.coordinates[body.coordinates.clone()];
                    for (k, force) in forces[body.velocities.clone()][6..].iter_mut().enumerate() {
                        *force = body.flexible.stiffness[k] * y[k];
                    }
                }
            }
            if self.system.residual_row_count() > 0 {
                self.evaluation.load(self.system, state);
            }
            let (system, evaluation) = (self.system, &self.evaluation);
            self.condensed
                .solve(system, state, evaluation, &self.changes, &forces);
            forces.fill(0.0);
            self.zeros = forces;
            self.shift(state);
        }
        Ok(false)
    }

    /// Moves the state by the last solve, with turns limited.
    pub(super) fn shift(&self, state: &mut State) {
        let largest = self
            .system
            .bodies
            .iter()
            .map(|b| {
                Vector3::from_column_slice(&self.condensed.step[b.velocities.clone()][3..6]).norm()
            })
            .fold(0.0, f64::max);
        let factor = if largest > LARGEST_TURN {
            LARGEST_TURN / largest
        } else {
            1.0
        };
        for (index, body) in self.system.bodies.iter().enumerate() {
            let step = &self.condensed.step[body.velocities.clone()];
            let shift = Vector3::from_column_slice(&step[..3]) * factor;
            let turn = Vector3::from_column_slice(&step[3..6]) * factor;
            state.origins[index] += self.evaluation.poses[index].axes * shift;
            state.orientations[index] *= UnitQuaternion::new(turn);
            let rows = body.residual_rows.clone();
            let steps = &self.condensed.residual_step[rows.clone()];
            for (x, change) in state.residual_displacements[rows].iter_mut().zip(steps) {
                *x += factor * change;
            }
            for (y, change) in state.coordinates[body.coordinates.clone()]
                .iter_mut()
                .zip(&step[6..])
            {
                *y += factor * change;
            }
        }
    }

    /// The constraint that is furthest from its demand, and how far relative to the mechanism.
    pub(super) fn worst_row(&self) -> (usize, f64) {
        let mut worst = (0, 0.0);
        for (index, row) in self.system.rows.iter().enumerate() {
            if !row.is_constraint() {
                continue;
            }
            let term = &self.system.terms[row.terms.start];
            let unit = if term.measure.is_length() {
                self.size
            } else {
                1.0
            };
            let misfit = self.evaluation.answers[index].abs() / unit;
            if misfit > worst.1 || misfit.is_nan() {
                worst = (index, misfit);
            }
        }
        worst
    }
}
