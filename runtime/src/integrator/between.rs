//! The motion within a step, from both of its ends: what is recorded at times that no step ends at.
//!
//! ```text
//! place        cubic from q, q' at both ends          error h⁴ q''''/384
//! velocities   cubic from q', q'' at both ends        the same of q'
//! accelerations, forces of joints, drives and springs: straight lines     error h² λ''/8
//! ```
//! Turns are interpolated by the rotation vector from the start of the step. None of these errors is of a lower order than that of the method,
//! which is two.

use nalgebra::{UnitQuaternion, Vector3};

use crate::kinematics::rotation_vector::right_jacobian_inverse;
use crate::system::{State, System};

/// Hermite's cubic through values and slopes at both ends of a step.
struct Cubic {
    /// Weights of the value and of the slope at the start, and of those at the end.
    weights: [f64; 4],
}

impl Cubic {
    /// At the part `x` of a step of this length.
    fn at(x: f64, step: f64) -> Self {
        let y = 1.0 - x;
        Self {
            weights: [
                y * y * (1.0 + 2.0 * x),
                step * x * y * y,
                x * x * (1.0 + 2.0 * y),
                -step * x * x * y,
            ],
        }
    }

    fn of(&self, before: (f64, f64), after: (f64, f64)) -> f64 {
        let [a, b, c, d] = self.weights;
        a * before.0 + b * before.1 + c * after.0 + d * after.1
    }

    fn of_vectors(&self, before: [Vector3<f64>; 2], after: [Vector3<f64>; 2]) -> Vector3<f64> {
        let [a, b, c, d] = self.weights;
        before[0] * a + before[1] * b + after[0] * c + after[1] * d
    }
}

/// The motion at a time within the step that led from one state to the other.
pub fn between(system: &System, before: &State, after: &State, time: f64) -> State {
    let step = after.earlier_step;
    let x = (time - before.time - before.time_rest) / step;
    let cubic = Cubic::at(x, step);
    let straight = |before: &[f64], after: &[f64], now: &mut [f64]| {
        for ((now, before), after) in now.iter_mut().zip(before).zip(after) {
            *now = before + x * (after - before);
        }
    };
    let mut now = after.clone();
    (now.time, now.time_rest) = (time, 0.0);
    // Angles are counted from where they were: the next one found is the nearest.
    now.angles.copy_from_slice(&before.angles);
    // Actuators go on from what they remembered at the start.
    now.memory.copy_from_slice(&before.memory);
    for (index, body) in system.bodies.iter().enumerate() {
        let first = body.velocities.start;
        let three = |values: &[f64], at: usize| Vector3::from_column_slice(&values[at..at + 3]);
        now.origins[index] = cubic.of_vectors(
            [before.origins[index], three(&before.velocities, first)],
            [after.origins[index], three(&after.velocities, first)],
        );
        let start = before.orientations[index];
        let turn = (start.inverse() * after.orientations[index]).scaled_axis();
        let spins = [before, after].map(|state| three(&state.velocities, first + 3));
        let rate = right_jacobian_inverse(&turn) * spins[1];
        let turned = cubic.of_vectors([Vector3::zeros(), spins[0]], [turn, rate]);
        now.orientations[index] = start * UnitQuaternion::new(turned);
        for (k, i) in body.coordinates.clone().enumerate() {
            // Those beyond the displacements are forces.
            if k >= body.flexible.displacement_count() {
                now.coordinates[i] =
                    before.coordinates[i] + x * (after.coordinates[i] - before.coordinates[i]);
                continue;
            }
            let rate = |state: &State| state.velocities[first + 6 + k];
            now.coordinates[i] = cubic.of(
                (before.coordinates[i], rate(before)),
                (after.coordinates[i], rate(after)),
            );
        }
    }
    for (i, velocity) in now.velocities.iter_mut().enumerate() {
        *velocity = cubic.of(
            (before.velocities[i], before.accelerations[i]),
            (after.velocities[i], after.accelerations[i]),
        );
    }
    for (i, x) in now.residual_displacements.iter_mut().enumerate() {
        *x = cubic.of(
            (before.residual_displacements[i], before.residual_rates[i]),
            (after.residual_displacements[i], after.residual_rates[i]),
        );
    }
    straight(
        &before.accelerations,
        &after.accelerations,
        &mut now.accelerations,
    );
    straight(
        &before.algorithmic,
        &after.algorithmic,
        &mut now.algorithmic,
    );
    straight(&before.forces, &after.forces, &mut now.forces);
    straight(
        &before.residual_rates,
        &after.residual_rates,
        &mut now.residual_rates,
    );
    straight(
        &before.residual_accelerations,
        &after.residual_accelerations,
        &mut now.residual_accelerations,
    );
    now
}
