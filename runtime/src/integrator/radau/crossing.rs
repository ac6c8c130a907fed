//! A dead centre, where constraints that are independent elsewhere depend on each other, is passed by generalized alpha.
//!
//! On both sides of it their gradients point against each other, so that no matrix serves stages on both, and steps that avoid it become shorter
//! without end. Generalized alpha wants its equations at the ends of steps only. It takes over for a part of a usual step, in equal steps that are short
//! enough for the tolerance: near a dead centre accelerations are far off, which says nothing of places.

use super::Radau;
use crate::integrator::adaptive::up_to;
use crate::integrator::newton::Corrector;
use crate::integrator::{Effort, Formulation, Method, Tolerance};
use crate::system::{State, System};
use dcb_formats::scene::Scheme;

/// How far it goes, in steps of which the iteration failed.
const BEYOND: f64 = 3.0;
/// Its steps, at least and at most.
const STEPS: [f64; 2] = [16.0, 2000.0];
/// Its spectral radius.
const RADIUS: f64 = 0.8;

/// A dead centre that is being passed.
pub(super) struct Crossing {
    until: f64,
    step: f64,
}

impl Radau {
    /// Begins to pass what the iteration of a step failed at.
    pub fn begin_crossing(&mut self, system: &System, start: &State, failed: f64) {
        let way = BEYOND * failed;
        // An error of (ω h)² / 12 a time of 1/ω.
        let moved = way * self.scale.size(system, &start.velocities);
        let [least, most] = STEPS;
        let steps = (moved.powi(3) / (12.0 * self.accuracy.tolerance)).sqrt();
        self.crossing = Some(Crossing {
            until: start.time + way,
            step: way / steps.clamp(least, most),
        });
        self.factored_step = None;
        self.forget_past();
        self.control.begin_anew(failed);
    }

    /// One step of it from `start` into the corrector's trial state, no further than `stop`; its length, and what it took. `None` where none is being
    /// passed, or if the step fails, which ends it: Radau says why it can't go on.
    pub fn cross(
        &mut self,
        corrector: &mut Corrector,
        system: &System,
        start: &State,
        stop: f64,
    ) -> Option<(f64, Effort)> {
        let crossing = self.crossing.take()?;
        let method = Method {
            scheme: Scheme::generalized_alpha(RADIUS),
            formulation: Formulation::Index3,
            tolerance: Tolerance {
                relative: 1e-10,
                max_iterations: 20,
            },
        };
        let left = stop.min(crossing.until) - start.time - start.time_rest;
        let step = up_to(left, crossing.step);
        let effort = corrector.step(system, &method, start, step).ok()?;
        self.has_crossed = true;
        corrector.was_singular = true;
        if step < left || stop < crossing.until {
            self.crossing = Some(crossing);
        } else {
            let mut state = corrector.trial.clone();
            if self.restart(corrector, system, &mut state).is_ok() {
                corrector.trial.copy_from(&state);
            }
            corrector.forget_factor();
        }
        Some((step, effort))
    }
}
