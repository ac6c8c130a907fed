//! What controllers see of a run.

use crate::energy::{Energy, Works};
use crate::system::evaluation::Evaluation;
use crate::system::{State, System};

/// A run at a sample.
pub struct Sight<'a> {
    /// The mechanism.
    pub system: &'a System,
    /// The motion.
    pub state: &'a State,
    /// Evaluated at the state, with velocities and accelerations.
    pub evaluation: &'a Evaluation,
    /// Energy at the state.
    pub energy: Energy,
    /// Works since the start.
    pub works: Works,
    /// Defect of the energy balance.
    pub defect: f64,
}

/// Writes the outputs that sampled controllers use, in the order of their arguments.
pub type Senses = Box<dyn FnMut(&Sight, &mut [f64]) + Send + Sync>;
