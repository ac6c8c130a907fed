//! The error of a step, by an embedded formula.
//!
//! ```text
//! e_q = h Σ d_i q'_i,   e_v = h Σ d_i q''_i          start and stages
//! (σ² M + σ C + K) e = M (σ² e_q + σ e_v)            σ = 1/(h μ), the real shift
//! ```
//! The solve with the iteration matrix keeps motions that the step doesn't follow from being taken for errors
//! (Hairer and Wanner IV.8, Eq. 8.19).

use nalgebra::Vector3;

use super::Radau;
use super::stage::{add_scaled, spin};
use crate::integrator::newton::Corrector;
use crate::system::{State, System};

impl Radau {
    /// The error of the places, of the velocities times the step, or of the forces in bodies, whichever is largest, in tolerances.
    pub(super) fn estimate(
        &mut self,
        corrector: &mut Corrector,
        system: &System,
        start: &State,
        step: f64,
    ) -> f64 {
        let Self {
            stages,
            coefficients,
            scratch,
            scale,
            ..
        } = self;
        let [places, rates, mixed] = scratch;
        places.fill(0.0);
        rates.fill(0.0);
        let weights = &coefficients.estimate;
        add_scaled(places, step * weights[0], &start.velocities);
        add_scaled(rates, step * weights[0], &start.accelerations);
        for (stage, weight) in stages.iter().zip(&weights[1..]) {
            add_scaled(places, step * weight, &stage.state.velocities);
            add_scaled(rates, step * weight, &stage.state.accelerations);
        }
        let middle = stages.len() / 2;
        let shift = 1.0 / (step * coefficients.real.value);
        for (index, body) in system.bodies.iter().enumerate() {
            let axes = &stages[middle].evaluation.poses[index].axes;
            let mut turn = spin(start, body) * weights[0];
            for (stage, weight) in stages.iter().zip(&weights[1..]) {
                turn += stage.turn_rates[index] * *weight;
            }
            let own = body.velocities.clone();
            for part in [&mut *places, &mut *rates] {
                let three = &mut part[own.clone()][..3];
                let linear = axes.tr_mul(&Vector3::from_column_slice(three));
                three.copy_from_slice(linear.as_slice());
            }
            places[own][3..6].copy_from_slice((turn * step).as_slice());
        }
        for (mixed, (place, rate)) in mixed.iter_mut().zip(places.iter().zip(rates.iter())) {
            *mixed = -shift * (shift * place + rate);
        }
        let [residual, changes] = &mut self.real;
        let condensed = &mut corrector.condensed;
        condensed.mass_product(system, mixed, residual);
        changes.fill(0.0);
        condensed.solve_held(system, &stages[middle].evaluation, changes, residual);
        for (rate, (after, place)) in rates
            .iter_mut()
            .zip(condensed.step.iter().zip(places.iter()))
        {
            *rate = step * shift * (after - place);
        }
        let places = &mut condensed.step;
        (self.control).in_tolerances(system, step, scale, places, rates)
    }
}
