//! Motion that the drives alone fix, and the forces that it takes: kinematics and inverse dynamics.
//!
//! ```text
//! positions      e(q) - f(t) = 0
//! velocities     B q' = f'
//! accelerations  B q'' + (B)' q' = f''
//! forces         Bᵀ λ = M q'' + velocity terms - applied
//! ```
//! Bodies are rigid, or stay as deflected as they start. λ of a drive is its effort; where constraints repeat each other the forces are
//! those of least norm.

use crate::error::Error;
use crate::initial::{InitialReport, Starter, carried};
use crate::system::evaluation::Evaluation;
use crate::system::free_directions::FreeDirections;
use crate::system::linearization::Linearization;
use crate::system::{State, System};
use dcb_formats::scene::RedundantConstraints;

/// A mechanism that follows its drives.
pub struct DrivenMotion<'a> {
    starter: Starter<'a>,
    state: State,
}

impl<'a> DrivenMotion<'a> {
    /// At the state's time, from positions as drawn.
    ///
    /// # Errors
    /// [`Error::NotDriven`] with the number of degrees of freedom that no drive fixes; those of [`Starter::start`].
    pub fn start(system: &'a System, mut state: State) -> Result<(Self, InitialReport), Error> {
        let mut starter = Starter::of(system)?;
        let report = starter.start(&mut state, RedundantConstraints::MinimumNorm)?;
        let count = dof_count(system, &state)?;
        if count > 0 {
            return Err(Error::NotDriven { count });
        }
        starter.follow(&mut state)?;
        Ok((Self { starter, state }, report))
    }

    /// Positions, velocities, accelerations and forces at a time; steps are to be short enough for the mechanism to be followed, turns
    /// of a body below half a turn.
    ///
    /// # Errors
    /// Those of [`Starter::follow`]; the motion stays where it was.
    pub fn advance_to(&mut self, time: f64) -> Result<&State, Error> {
        self.state = self.at(time)?;
        Ok(&self.state)
    }

    /// The same without going there.
    ///
    /// # Errors
    /// As [`DrivenMotion::advance_to`].
    pub fn at(&mut self, time: f64) -> Result<State, Error> {
        let mut next = carried(self.starter.system(), &self.state, time - self.state.time);
        (next.time, next.time_rest) = (time, 0.0);
        self.starter.follow(&mut next)?;
        Ok(next)
    }

    /// The motion now.
    pub fn state(&self) -> &State {
        &self.state
    }
}

/// Degrees of freedom of the bodies, as rigid ones, that joints and drives leave.
fn dof_count(system: &System, state: &State) -> Result<usize, Error> {
    let still = state.without_motion();
    let evaluation = Evaluation::at(system, &still);
    let mut jacobian = Linearization::at(system, &still, &evaluation)?.jacobian;
    for body in &system.bodies {
        for column in body.velocities.start + 6..body.velocities.end {
            jacobian.col_mut(column).fill(0.0);
        }
    }
    Ok(FreeDirections::of(system, &jacobian)?.count() - system.coordinate_count())
}
