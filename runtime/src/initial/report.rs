//! What the start changed, and which constraints repeat others.

use faer::Mat;
use nalgebra::Vector3;

use super::{InitialReport, MovedBody, Starter};
use crate::error::Error;
use crate::system::body_factor::Elastic;
use crate::system::condensed::Blend;
use crate::system::residual::row_flexibility;
use crate::system::{Body, State};

/// Scaled pivots of the joints' system below this are redundant constraints.
const DEPENDENT: f64 = 1e-9;

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
        let mut lambda =
            self.condensed
                .joint_compliance(self.system, &self.evaluation, &constraints);
        if let Some(flexibility) = row_flexibility(self.system, &self.evaluation) {
            // What interfaces give way to is no redundancy. Both matrices are semi-definite: their weights don't matter.
            let trace =
                |entry: &dyn Fn(usize) -> f64| (0..constraints.len()).map(entry).sum::<f64>();
            let own = trace(&|i| flexibility[(constraints[i], constraints[i])]);
            let weight = trace(&|i| lambda[(i, i)]) / own;
            for (i, row) in constraints.iter().enumerate().filter(|_| own > 0.0) {
                for (j, column) in constraints.iter().enumerate() {
                    lambda[(i, j)] += weight * flexibility[(*row, *column)];
                }
            }
        }
        let dependent = dependent_rows(lambda);
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
                (body.name.clone(), body.flexible.strain_energy(y))
            })
            .filter(|(_, energy)| *energy > 0.0)
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

/// Rows of a positive semi-definite matrix that depend on the others: what a Cholesky factorization with diagonal pivoting of the
/// scaled matrix leaves below [`DEPENDENT`].
pub(crate) fn dependent_rows(mut lambda: Mat<f64>) -> Vec<usize> {
    let n = lambda.nrows();
    let scale: Vec<f64> = (0..n)
        .map(|i| {
            let entry = lambda[(i, i)].abs();
            if entry > 0.0 { 1.0 / entry.sqrt() } else { 1.0 }
        })
        .collect();
    for j in 0..n {
        for i in 0..n {
            lambda[(i, j)] *= scale[i] * scale[j];
        }
    }
    let mut left: Vec<usize> = (0..n).collect();
    while !left.is_empty() {
        let Some((position, pivot)) = left
            .iter()
            .map(|i| lambda[(*i, *i)])
            .enumerate()
            .max_by(|a, b| a.1.total_cmp(&b.1))
        else {
            break;
        };
        if pivot <= DEPENDENT {
            break;
        }
        let chosen = left.remove(position);
        for &j in &left {
            let factor = lambda[(chosen, j)] / pivot;
            for &i in &left {
                let change = lambda[(i, chosen)] * factor;
                lambda[(i, j)] -= change;
            }
        }
    }
    left.sort_unstable();
    left
}
