//! Actuators in an iteration.
//!
//! Efforts that bend or saturate are looked for where the coordinate's own motion meets them, the rest of the system following as the present
//! factor says. For one coordinate alone this is the solution itself, however sharply the effort bends; Newton's straight lines
//! alone would jump to and fro between both sides of a saturation.

use super::Condensed;
use crate::actuator::{Effort, meeting};
use crate::system::evaluation::Evaluation;
use crate::system::{State, System};

/// An effort, and the change of the coordinate that it belongs to.
pub(super) struct Met {
    pub(super) effort: Effort,
    pub(super) change: f64,
}

impl Condensed {
    /// The effort of an actuator where it is met.
    pub(super) fn met_effort(
        &self,
        system: &System,
        state: &State,
        evaluation: &Evaluation,
        index: usize,
    ) -> Met {
        let actuator = &system.actuators[index];
        let here = Met {
            effort: evaluation.efforts[index],
            change: 0.0,
        };
        let mobility = self.mobilities[index];
        if !actuator.source.bends() || mobility == 0.0 {
            return here;
        }
        let row = actuator.row;
        let (value, rate) = (evaluation.values[row], evaluation.value_rates[row]);
        let follow = self.rates_follow;
        let at =
            |change: f64| system.effort(actuator, state, value + change, rate + follow * change);
        let (change, _) = meeting(state.forces[row], mobility, |change| {
            let effort = at(change);
            (effort.force, effort.by_value + follow * effort.by_rate)
        });
        match change == 0.0 {
            true => here,
            false => Met {
                effort: at(change),
                change,
            },
        }
    }
}
