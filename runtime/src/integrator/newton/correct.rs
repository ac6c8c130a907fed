//! The correction of a trial state.

use nalgebra::{UnitQuaternion, Vector3};

use super::Corrector;
use crate::integrator::larger;
use crate::kinematics::rotation_vector::right_jacobian_inverse;
use crate::system::{State, System};
use dcb_formats::scene::Scheme;

impl Corrector {
    /// Adds the correction to the trial state; its size, as a length.
    pub(super) fn apply(
        &mut self,
        system: &System,
        scheme: &Scheme,
        start: &State,
        step: f64,
    ) -> f64 {
        let (beta, gamma) = (scheme.acceleration_slope(step), scheme.velocity_slope(step));
        let to_algorithmic = 1.0 / (scheme.beta * step * step);
        let trial = &mut self.trial;
        let mut largest: f64 = 0.0;
        for (index, body) in system.bodies.iter().enumerate() {
            let first = body.velocities.start;
            let correction = &self.condensed.step[body.velocities.clone()];
            let moving = &self.moving[body.velocities.clone()];
            let axes = &self.evaluation.poses[index].axes;
            let follow = right_jacobian_inverse(&self.turns[index]);
            let (shift, turn) = (three(correction, 0), three(correction, 3));
            trial.origins[index] += axes * shift;
            self.turns[index] += follow * turn;
            trial.orientations[index] =
                start.orientations[index] * UnitQuaternion::new(self.turns[index]);
            let mut deflection = 0.0;
            let coordinates = &mut trial.coordinates[body.coordinates.clone()];
            for (y, change) in coordinates.iter_mut().zip(&correction[6..]) {
                *y += change;
            }
            for change in &correction[6..6 + body.flexible.displacement_count()] {
                deflection += change * change;
            }
            let (linear, angular) = (axes * three(moving, 0), follow * three(moving, 3));
            for (k, change) in moving.iter().enumerate() {
                let change = match k {
                    0..3 => linear[k],
                    3..6 => angular[k - 3],
                    _ => *change,
                };
                trial.accelerations[first + k] += beta * change;
                trial.velocities[first + k] += gamma * change;
                trial.algorithmic[first + k] += to_algorithmic * change;
            }
            let deflection = (deflection / body.flexible.inertia.mass()).sqrt();
            let size = shift.norm() + body.length * turn.norm() + deflection;
            largest = larger(size, largest);
        }
        for (i, change) in self.condensed.residual_step.iter().enumerate() {
            trial.residual_displacements[i] += change;
            trial.residual_rates[i] += gamma * change;
            trial.residual_accelerations[i] += to_algorithmic * change;
        }
        for (force, change) in trial.forces.iter_mut().zip(&self.condensed.force_step) {
            *force += change;
        }
        largest
    }
}

pub(super) fn three(values: &[f64], first: usize) -> Vector3<f64> {
    Vector3::from_column_slice(&values[first..first + 3])
}
