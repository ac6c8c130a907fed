//! The motion within the last step, by the polynomials of its stages.
//!
//! Accelerations and λ are the polynomials of degree s through start and stages, velocities and places their integrals: of order s + 2 and
//! s + 3 within a step. What places lack at the end of the step is added with the cube of the time.

use nalgebra::{UnitQuaternion, Vector3};

use super::Radau;
use super::stage::add_scaled;
use crate::system::{State, System};

impl Radau {
    /// The motion at a time within the step that led from one state to the other.
    pub fn within(&self, system: &System, before: &State, after: &State, time: f64) -> State {
        let step = self.past.step;
        let x = (time - before.time - before.time_rest) / step;
        let mut now = after.clone();
        (now.time, now.time_rest) = (time, 0.0);
        now.angles.copy_from_slice(&before.angles);
        now.memory.copy_from_slice(&before.memory);
        let (past, coefficients) = (&self.past, &self.coefficients);
        let mut weights = vec![0.0; self.weights.len()];
        coefficients.write_values(x, &mut weights);
        now.accelerations.fill(0.0);
        now.forces.fill(0.0);
        for (node, weight) in weights.iter().enumerate() {
            add_scaled(&mut now.accelerations, *weight, &past.accelerations[node]);
            add_scaled(&mut now.forces, *weight, &past.forces[node]);
        }
        now.algorithmic.copy_from_slice(&now.accelerations);
        coefficients.write_integrals(x, &mut weights);
        now.velocities.copy_from_slice(&before.velocities);
        for (node, weight) in weights.iter().enumerate() {
            add_scaled(
                &mut now.velocities,
                step * weight,
                &past.accelerations[node],
            );
        }
        let turned = |index: usize, weights: &[f64]| {
            let terms = weights.iter().zip(&past.turn_rates);
            let sum: Vector3<f64> = terms.map(|(w, rates)| rates[index] * *w).sum();
            sum * step
        };
        let turns: Vec<Vector3<f64>> = (0..system.bodies.len())
            .map(|index| turned(index, &weights))
            .collect();
        let mut whole = vec![0.0; weights.len()];
        coefficients.write_integrals(1.0, &mut whole);
        let mut whole_double = vec![0.0; weights.len()];
        coefficients.write_double_integrals(1.0, &mut whole_double);
        coefficients.write_double_integrals(x, &mut weights);
        let cube = x * x * x;
        for (index, body) in system.bodies.iter().enumerate() {
            let first = body.velocities.start;
            let moved = |k: usize, x: f64, weights: &[f64]| {
                let terms = weights.iter().zip(&past.accelerations);
                let sum: f64 = terms.map(|(w, a)| w * a[first + k]).sum();
                step * (x * before.velocities[first + k] + step * sum)
            };
            let place = |k: usize, from: f64, to: f64| {
                let lacking = to - from - moved(k, 1.0, &whole_double);
                from + moved(k, x, &weights) + cube * lacking
            };
            let (from, to) = (before.origins[index], after.origins[index]);
            now.origins[index] = Vector3::from_fn(|k, _| place(k, from[k], to[k]));
            for (k, at) in body.coordinates.clone().enumerate() {
                now.coordinates[at] = place(6 + k, before.coordinates[at], after.coordinates[at]);
            }
            let start = before.orientations[index];
            let lacking = (start * UnitQuaternion::new(turned(index, &whole))).inverse()
                * after.orientations[index];
            now.orientations[index] = start
                * UnitQuaternion::new(turns[index])
                * UnitQuaternion::new(lacking.scaled_axis() * cube);
        }
        now
    }
}
