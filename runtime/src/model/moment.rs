//! A state with all that recorded quantities are computed from.

use crate::energy::{Energy, Works};
use crate::system::evaluation::Evaluation;
use crate::system::{State, System};

/// A state and everything that depends on it.
#[derive(Clone, Copy)]
pub(super) struct Moment<'a> {
    pub system: &'a System,
    pub state: &'a State,
    /// Up to date, with velocities and accelerations of the markers.
    pub evaluation: &'a Evaluation,
    pub energy: &'a Energy,
    pub works: &'a Works,
    /// Defect of the energy balance.
    pub defect: f64,
    /// Size of the last step, and the iterations that it took.
    pub step: (f64, usize),
}
