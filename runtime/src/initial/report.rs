//! Changes at the start, and constraints that repeat others.

use nalgebra::Vector3;

use super::rank::dependent_rows;
use super::{InitialReport, MovedBody, Starter};
use crate::error::Error;
use crate::system::body_factor::Elastic;
use crate::system::condensed::Blend;
use crate::system::residual::row_flexibility;
use crate::system::{Body, State};

/// A deflection below this part of the body's length is rounding.
const ROUNDING: f64 = 1e-12;

impl Starter<'_> {
    /// Rank of the constraints in the metric of the mass: pivots of Λ scaled to a unit diagonal.
    pub(super) fn find_redundant(
        &mut self,
        state: &State,
        report: &mut InitialReport,
    ) -> Result<(), Error> {
        let still = state.without_motion();
        self.refresh_inertia(&still);
        let blend = Blend::mass_alone(Elastic::Moving);
        self.condensed
            .factor(self.system, &still, &self.evaluation, &blend, None)?;
        let constraints = self.system.constraints();
        let columns = self
            .condensed
            .compliance_columns(self.system, &self.evaluation);
        let mut position = vec![None; self.system.rows.len()];
        for (index, row) in constraints.iter().enumerate() {
            position[*row] = Some(index);
        }
        let mut diagonal: Vec<f64> = constraints
            .iter()
            .map(|row| columns.diagonal(*row))
            .collect();
        // What interfaces give way to is no redundancy. Both matrices are semi-definite: their weights don't matter.
        let flexibility = row_flexibility(self.system, &self.evaluation).and_then(|flexibility| {
            let own: f64 = constraints.iter().map(|i| flexibility[(*i, *i)]).sum();
            let weight = diagonal.iter().sum::<f64>() / own;
            (own > 0.0).then_some((flexibility, weight))
        });
        if let Some((flexibility, weight)) = &flexibility {
            for (entry, row) in diagonal.iter_mut().zip(&constraints) {
                *entry += weight * flexibility[(*row, *row)];
            }
        }
        let dependent = dependent_rows(&diagonal, |chosen, sum| {
            columns.for_each(constraints[chosen], |row, entry| {
                if let Some(index) = position[row] {
                    sum.add(index, entry);
                }
            });
            let Some((flexibility, weight)) = &flexibility else {
                return;
            };
            for (index, row) in constraints.iter().enumerate() {
                let entry = flexibility[(*row, constraints[chosen])];
                if entry != 0.0 {
                    sum.add(index, weight * entry);
                }
            }
        })
        .rows;
        report.independent_constraints = constraints.len() - dependent.len();
        for position in dependent {
            let connection = self.system.rows[constraints[position]].connection;
            let name = &self.system.connections[connection].name;
            match report.redundant.iter_mut().find(|(known, _)| known == name) {
                Some((_, count)) => *count += 1,
                None => report.redundant.push((name.clone(), 1)),
            }
        }
        Ok(())
    }

    pub(super) fn moved(&self, before: &State, after: &State) -> Vec<MovedBody> {
        let mut moved = Vec::new();
        for (index, body) in self.system.bodies.iter().enumerate() {
            let translation = (after.origins[index] - before.origins[index]).norm();
            let rotation = before.orientations[index].angle_to(&after.orientations[index]);
            if translation > 1e-9 * self.size || rotation > 1e-7 {
                moved.push(MovedBody {
                    body: body.name.clone(),
                    translation,
                    rotation,
                });
            }
        }
        moved
    }

    pub(super) fn strained(&self, state: &State) -> Vec<(String, f64)> {
        self.system
            .bodies
            .iter()
            .map(|body| {
                let y = &state.coordinates[body.coordinates.clone()];
                let displacements = &y[..body.flexible.displacement_count()];
                // Coordinates are displacements by the root of the mass.
                let square =
                    displacements.iter().map(|y| y * y).sum::<f64>() / body.flexible.inertia.mass();
                let deflects = square.sqrt() > ROUNDING * body.length;
                (deflects, &body.name, body.flexible.strain_energy(y))
            })
            .filter(|(deflects, _, energy)| *deflects && *energy > 0.0)
            .map(|(_, name, energy)| (name.clone(), energy))
            .collect()
    }

    pub(super) fn sped(&self, before: &[f64], after: &State) -> Vec<MovedBody> {
        let mut sped = Vec::new();
        let part = |i: usize| Vector3::from_column_slice(&after.velocities[i..i + 3]).norm();
        let speed = |body: &Body| {
            let at = body.velocities.start;
            part(at) + body.length * part(at + 3)
        };
        let fastest = self.system.bodies.iter().map(speed).fold(0.0, f64::max);
        for body in &self.system.bodies {
            let at = body.velocities.start;
            let change = |i: usize| {
                Vector3::from_fn(|k, _| after.velocities[at + i + k] - before[at + i + k]).norm()
            };
            let (translation, rotation) = (change(0), change(3));
            if translation + body.length * rotation > 1e-6 * fastest {
                sped.push(MovedBody {
                    body: body.name.clone(),
                    translation,
                    rotation,
                });
            }
        }
        sped
    }
}
