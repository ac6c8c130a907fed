//! A state as a mechanism is linear about it: its accelerations, and the forces of its joints.

use crate::analysis::independent::{IndependentMotion, size};
use crate::error::Error;
use crate::initial::Starter;
use crate::system::evaluation::Evaluation;
use crate::system::{State, System};

/// Bodies that move by less than this part of their size in the time of the fastest pole are at rest.
const STILL: f64 = 1e-12;
/// Gravity that is left, as a part of it, where it is balanced.
const BALANCED: f64 = 1e-10;

/// A state of a motion with the accelerations that its positions, velocities and inputs have now, not those of an integrator's step.
pub(crate) fn settled(system: &System, state: &State) -> Result<State, Error> {
    let mut state = state.clone();
    Starter::of(system)?.accelerate(&mut state)?;
    Ok(state)
}

/// Whether nothing moves, and nothing begins to, but for rounding; `fastest` is the size of the fastest pole.
pub(super) fn is_at_rest(system: &System, state: &State, fastest: f64) -> bool {
    let lengths = system.bodies.iter().map(|body| body.length);
    let falling = system.gravity.norm() / lengths.fold(f64::INFINITY, f64::min);
    let (speed, acceleration) = (
        size(system, &state.velocities),
        size(system, &state.accelerations),
    );
    speed <= STILL * fastest && acceleration <= BALANCED * falling + f64::EPSILON * fastest.powi(2)
}

/// A consistent state with the forces of its springs, and those of constraints that are least, however often they repeat each other.
pub(super) fn with_reactions(system: &System, state: &State, motion: &IndependentMotion) -> State {
    let mut state = state.clone();
    let mut evaluation = Evaluation::of(system);
    evaluation.place(system, &state);
    // Differences must not meet the place where an angle that isn't counted yet jumps.
    evaluation.count_turns(system, &mut state);
    evaluation.add_velocities(system, &state);
    evaluation.measure(system, &state);
    for (index, row) in system.rows.iter().enumerate() {
        state.forces[index] = match row.is_constraint() {
            true => 0.0,
            false => evaluation.answers[index],
        };
    }
    evaluation.load(system, &state);
    evaluation.resist(system, &state);
    let reactions = motion.directions.reactions(&evaluation.residual);
    for (row, force) in motion.linearization.constraints.iter().zip(reactions) {
        state.forces[*row] = force;
    }
    state
}
