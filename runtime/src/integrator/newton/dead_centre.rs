//! Steps that end at a dead centre, where constraints that are independent elsewhere depend on each other.
//!
//! A motion δ becomes free there, and a part λ of the constraints' forces does nothing. Along that motion, with m what moves and e where its
//! inertia alone would leave it at the end of the step,
//!
//! ```text
//! β' m (δ - e) = δ λ,     ½ δ² = 0
//! ```
//! has no solution but e = 0. Constraints with a small compliance c beside the forces λ₀ of the prediction, ½ δ² + c (λ - λ₀) = 0, have
//! one: for c well above e² it is δ = e, λ = λ₀. The mechanism is carried through by its inertia, off by e, at least of second order in the
//! step, and open by ½ e². Where e is no small part of what the step moves, the mechanism comes to rest there and could go on in two ways:
//! that is an error.

use super::judge::Correction;
use super::{Corrector, STAGNANT, three};
use crate::error::Error;
use crate::integrator::method::{Formulation, Method};
use crate::system::{State, System};

/// The joints' system enlarges its right-hand side by more than this only near a dead centre,
const NEARLY_SINGULAR: f64 = 1e5;
/// and by more than this only at one.
const SINGULAR: f64 = 1e9;
/// The compliance of constraints at a dead centre, as a part of what a step's inertia gives way by.
pub(super) const COMPLIANCE: f64 = 1e-6;
/// A step that ends further than this part of its own length from its prediction comes to rest.
const RESTING: f64 = 0.1;
/// Places along the free motion have half the digits of others.
const HALF_OF_THE_DIGITS: f64 = 1e-7;

impl Corrector {
    /// Whether the constraints nearly depend on each other, though they aren't redundant.
    pub(super) fn is_at_dead_centre(&mut self) -> bool {
        self.condensed.amplification() > SINGULAR
    }

    /// Whether a correction is what rounding leaves near a dead centre: places are known by half of the digits that the joints' system
    /// costs.
    pub(super) fn is_as_good_as_possible(&mut self, correction: &Correction) -> bool {
        let amplification = self.condensed.amplification();
        amplification > NEARLY_SINGULAR
            && correction.in_roundings < STAGNANT * amplification.min(SINGULAR).sqrt()
    }

    /// Gives the constraints of this step their compliance.
    pub(super) fn enter_dead_centre(&mut self, method: &mut Method, step: f64) {
        self.was_singular = true;
        // What such constraints ask of the velocities changes with the place, more than what they ask of the place.
        method.formulation = Formulation::Index3;
        self.regularize(method, step, COMPLIANCE);
    }

    /// Takes it back.
    pub(super) fn leave_dead_centre(&mut self) {
        self.condensed.regularization = 0.0;
        self.condensed.resting_forces.fill(0.0);
        self.factored_step = None;
    }

    /// What comes to rest at a dead centre could go on either way.
    pub(super) fn refuse_rest(&self, system: &System, start: &State) -> Result<(), Error> {
        for (index, body) in system.bodies.iter().enumerate() {
            let predicted = &self.increments[body.velocities.clone()];
            let moved = self.trial.origins[index] - start.origins[index];
            let turned = self.turns[index];
            let length = |shift: f64, turn: f64| shift + body.length * turn;
            let missed = length(
                (moved - three(predicted, 0)).norm(),
                (turned - three(predicted, 3)).norm(),
            );
            if missed > HALF_OF_THE_DIGITS * body.length
                && missed > RESTING * length(moved.norm(), turned.norm())
            {
                return Err(Error::RestAtDeadCentre {
                    time: self.trial.time,
                    body: body.name.clone(),
                });
            }
        }
        Ok(())
    }
}
