//! Continuous controllers in an iteration: efforts that follow coordinates of any joints.
//!
//! With s the sensed coordinates, u the controlled efforts and `u = K s` to first order, the factored matrix takes the efforts as given:
//!
//! ```text
//! δs = δs₀ + G δu,    δu = K δs       ⇒       δu = (1 - K G)⁻¹ K δs₀
//! ```
//! G are the responses of the system to unit efforts, found with the factor and kept with it.

use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, linalg::solvers::FullPivLu};

use super::Condensed;
use crate::actuator::{Sense, Source, Timing};
use crate::kinematics::frame_motion::SixOf;
use crate::system::System;
use crate::system::evaluation::Evaluation;
use crate::system::marker::turned;
use crate::system::number::{Number, dot};

/// Responses to the efforts of continuous controllers.
pub(super) struct Controls<T: Number> {
    /// Rows of the actuators, and their controllers.
    pub(super) rows: Vec<(usize, usize)>,
    /// δq, δλ and the change of interface displacements for a unit effort of each row.
    columns: Vec<[Vec<T>; 3]>,
    /// (1 - K G)⁻¹ K, row by row.
    gains: Vec<T>,
    /// Changes of the sensed coordinates.
    sensed: Vec<T>,
    /// Efforts of the last solve.
    efforts: Vec<T>,
    zeros: Vec<T>,
    changes: Vec<T>,
}

impl<T: Number> Default for Controls<T> {
    fn default() -> Self {
        Self {
            rows: Vec::new(),
            columns: Vec::new(),
            gains: Vec::new(),
            sensed: Vec::new(),
            efforts: Vec::new(),
            zeros: Vec::new(),
            changes: Vec::new(),
        }
    }
}

impl<T: Number> Controls<T> {
    pub(super) fn of(system: &System) -> Self {
        let continuous = |source: &Source| match source {
            Source::Controlled(index) => {
                let is_continuous =
                    matches!(system.controllers[*index].timing, Timing::Continuous { .. });
                is_continuous.then_some(*index)
            }
            _ => None,
        };
        let rows: Vec<(usize, usize)> = system
            .actuators
            .iter()
            .filter_map(|actuator| Some((actuator.row, continuous(&actuator.source)?)))
            .collect();
        let is_used = !rows.is_empty();
        let (count, sensors) = (rows.len(), system.sensors.len());
        let room = |length: usize| vec![T::of(0.0); if is_used { length } else { 0 }];
        let column = || {
            [
                room(system.velocity_count()),
                room(system.rows.len()),
                room(system.residual_row_count()),
            ]
        };
        Self {
            columns: (0..count).map(|_| column()).collect(),
            gains: room(count * sensors),
            sensed: room(sensors),
            efforts: room(count),
            zeros: room(system.velocity_count()),
            changes: room(system.rows.len()),
            rows,
        }
    }
}

impl<T: Number> Condensed<T> {
    /// Finds the responses with a new factor. Returns whether efforts and motion determine each other.
    pub(super) fn factor_controls(
        &mut self,
        system: &System,
        evaluation: &Evaluation,
        stiffness: f64,
    ) -> bool {
        let mut controls = std::mem::take(&mut self.controls);
        let (count, sensors) = (controls.rows.len(), system.sensors.len());
        controls.gains.fill(T::of(0.0));
        if stiffness == 0.0 {
            self.controls = controls;
            return true;
        }
        let mut slopes = Mat::<T>::zeros(count, sensors);
        for (i, (_, controller)) in controls.rows.iter().enumerate() {
            let Timing::Continuous { senses, first } = &system.controllers[*controller].timing
            else {
                continue;
            };
            let own = &evaluation.control_slopes[*first..first + senses.len()];
            for (sense, slope) in senses.iter().zip(own) {
                match sense {
                    Sense::Value(sensor) => slopes[(i, *sensor)] += T::of(stiffness * slope),
                    Sense::Rate(sensor) => {
                        slopes[(i, *sensor)] += self.rates_follow.times(*slope);
                    }
                }
            }
        }
        let mut responses = Mat::<T>::zeros(sensors, count);
        for j in 0..count {
            let row = controls.rows[j].0;
            controls.changes.fill(T::of(0.0));
            controls.changes[row] = self.compliances[row];
            self.respond(system, evaluation, &controls.changes, &controls.zeros);
            self.sense_step(system, evaluation, &mut controls.sensed);
            for (i, sensed) in controls.sensed.iter().enumerate() {
                responses[(i, j)] = *sensed;
            }
            let found = [&self.step, &self.force_step, &self.residual_step];
            for (column, found) in controls.columns[j].iter_mut().zip(found) {
                column.copy_from_slice(found);
            }
        }
        let closed = Mat::<T>::identity(count, count) - &slopes * &responses;
        let gains = FullPivLu::new(closed.as_ref()).inverse() * &slopes;
        for i in 0..count {
            for s in 0..sensors {
                controls.gains[i * sensors + s] = gains[(i, s)];
            }
        }
        let is_regular = controls.gains.iter().all(nalgebra::ComplexField::is_finite);
        self.controls = controls;
        is_regular
    }

    /// Lets controlled efforts follow the motion of the last solve.
    pub(super) fn follow_controls(&mut self, system: &System, evaluation: &Evaluation) {
        let mut controls = std::mem::take(&mut self.controls);
        let mut sensed = std::mem::take(&mut controls.sensed);
        self.sense_step(system, evaluation, &mut sensed);
        let sensors = sensed.len();
        for (effort, gains) in controls
            .efforts
            .iter_mut()
            .zip(controls.gains.chunks_exact(sensors.max(1)))
        {
            *effort = T::of(0.0);
            for (gain, sensed) in gains.iter().zip(&sensed) {
                *effort += *gain * *sensed;
            }
        }
        for (effort, column) in controls.efforts.iter().zip(&controls.columns) {
            let steps = [
                &mut self.step,
                &mut self.force_step,
                &mut self.residual_step,
            ];
            for (step, response) in steps.into_iter().zip(column) {
                for (step, response) in step.iter_mut().zip(response) {
                    *step += *effort * *response;
                }
            }
        }
        controls.sensed = sensed;
        self.controls = controls;
    }

    /// How the sensed coordinates change in the last solve.
    fn sense_step(&self, system: &System, evaluation: &Evaluation, sensed: &mut [T]) {
        let twist = |marker: usize| {
            let described = &system.markers[marker];
            let Some(index) = described.body else {
                return SixOf::zeros();
            };
            let body = &system.bodies[index];
            let (rigid, elastic) = self.step[body.velocities.clone()].split_at(6);
            let place = &evaluation.places[marker];
            let mut twist = described.twist(place, &SixOf::from_column_slice(rigid), elastic);
            if !body.residual_rows.is_empty() {
                let beside = &self.residual_step[body.residual_rows.clone()];
                twist += described.interface_twist(place, beside);
            }
            turned(&evaluation.poses[index].axes, &twist)
        };
        let sensors = system.sensors.iter().zip(&evaluation.sensed);
        for (change, (sensor, found)) in sensed.iter_mut().zip(sensors) {
            *change =
                dot(&found.gradient.a, &twist(sensor.a)) + dot(&found.gradient.b, &twist(sensor.b));
        }
    }
}
