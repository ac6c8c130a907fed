//! A stage: the motion at one of the nodes within a step.

use nalgebra::{UnitQuaternion, Vector3};

use super::coefficients::Coefficients;
use crate::kinematics::rotation_vector::right_jacobian_inverse;
use crate::system::evaluation::Evaluation;
use crate::system::{Body, State, System};

/// Times that turns are found again from their own rates.
const SWEEPS: usize = 2;

/// A stage.
pub(super) struct Stage {
    pub state: State,
    pub evaluation: Evaluation,
    /// θ of each body since the start of the step.
    pub turns: Vec<Vector3<f64>>,
    /// θ' of each body.
    pub turn_rates: Vec<Vector3<f64>>,
    /// What each row still lacks: e'' − f'' of a constraint, force less λ of a spring.
    pub defects: Vec<f64>,
}

impl Stage {
    pub fn of(system: &System) -> Self {
        let bodies = system.bodies.len();
        Self {
            state: State::at_rest(system),
            evaluation: Evaluation::of(system),
            turns: vec![Vector3::zeros(); bodies],
            turn_rates: vec![Vector3::zeros(); bodies],
            defects: vec![0.0; system.rows.len()],
        }
    }

    /// Equations and rows at the state.
    pub fn evaluate(&mut self, system: &System) {
        let (state, evaluation) = (&self.state, &mut self.evaluation);
        evaluation.refresh(system, state);
        for (index, defect) in self.defects.iter_mut().enumerate() {
            *defect = match evaluation.acceleration_defect(system, state, index) {
                Some(defect) => defect,
                None => evaluation.answers[index] - state.forces[index],
            };
        }
    }
}

/// ω of a body.
pub(super) fn spin(state: &State, body: &Body) -> Vector3<f64> {
    Vector3::from_column_slice(&state.velocities[body.velocities.clone()][3..6])
}

/// Velocities and places of all stages from their accelerations.
pub(super) fn integrate(
    stages: &mut [Stage],
    coefficients: &Coefficients,
    system: &System,
    start: &State,
    step: f64,
) {
    for i in 0..stages.len() {
        let mut velocities = std::mem::take(&mut stages[i].state.velocities);
        velocities.copy_from_slice(&start.velocities);
        for (weight, stage) in coefficients.weights[i].iter().zip(stages.iter()) {
            add_scaled(&mut velocities, step * weight, &stage.state.accelerations);
        }
        stages[i].state.velocities = velocities;
    }
    for (index, body) in system.bodies.iter().enumerate() {
        let first = body.velocities.start;
        for i in 0..stages.len() {
            let ahead = step * coefficients.nodes[i];
            let weights = &coefficients.double_weights[i];
            let moved = |stages: &[Stage], k: usize| {
                let terms = weights.iter().zip(stages);
                let sum: f64 = terms
                    .map(|(w, s)| w * s.state.accelerations[first + k])
                    .sum();
                ahead * start.velocities[first + k] + step * step * sum
            };
            let shift = Vector3::from_fn(|k, _| moved(stages, k));
            stages[i].state.origins[index] = start.origins[index] + shift;
            for (k, at) in body.coordinates.clone().enumerate() {
                let y = start.coordinates[at] + moved(stages, 6 + k);
                stages[i].state.coordinates[at] = y;
            }
        }
        for _ in 0..SWEEPS {
            for stage in stages.iter_mut() {
                let rate = right_jacobian_inverse(&stage.turns[index]) * spin(&stage.state, body);
                stage.turn_rates[index] = rate;
            }
            for i in 0..stages.len() {
                let terms = coefficients.weights[i].iter().zip(stages.iter());
                let sum: Vector3<f64> = terms.map(|(w, s)| s.turn_rates[index] * *w).sum();
                stages[i].turns[index] = sum * step;
            }
        }
        for stage in stages.iter_mut() {
            stage.state.orientations[index] =
                start.orientations[index] * UnitQuaternion::new(stage.turns[index]);
        }
    }
}

/// `y += factor x`
pub(super) fn add_scaled(y: &mut [f64], factor: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += factor * x;
    }
}
