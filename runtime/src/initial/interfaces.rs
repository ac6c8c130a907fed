//! Interfaces that follow their forces, at the start.

use super::Starter;
use super::assembly::{CLOSED, OPEN};
use crate::body::Compatibility;
use crate::error::Error;
use crate::system::State;
use crate::system::residual::add_product;

/// Rounds of finding the interface forces of a start and making room for the deflection by them.
const SETTLING_ROUNDS: usize = 30;

impl Starter<'_> {
    /// Interfaces as their forces deflect them.
    pub(super) fn settle_interfaces(&mut self, state: &mut State) -> Result<(), Error> {
        let mut last = f64::INFINITY;
        for _ in 0..SETTLING_ROUNDS {
            let change = self.follow_forces(state);
            self.close(state)?;
            self.match_velocities(state)?;
            self.accelerate(state)?;
            if change <= CLOSED || (change >= 0.5 * last && change <= OPEN) {
                return Ok(());
            }
            last = change;
        }
        Err(Error::NotConverged {
            time: state.time,
            iterations: SETTLING_ROUNDS,
            residual: last * self.size,
            tolerance: OPEN * self.size,
            worst: self
                .system
                .bodies
                .iter()
                .find(|body| !body.residual_rows.is_empty())
                .map_or_else(String::new, |body| body.name.clone()),
        })
    }

    /// Deflects interfaces beside the coordinates by the forces of the state; the largest change relative to the mechanism
    /// (translations) or in rad.
    pub(super) fn follow_forces(&mut self, state: &mut State) -> f64 {
        let system = self.system;
        self.evaluation.place(system, state);
        self.evaluation.measure(system, state);
        self.evaluation.load(system, state);
        let mut largest: f64 = 0.0;
        for body in &system.bodies {
            let Some(flexibility) = &body.flexible.residual_flexibility else {
                continue;
            };
            let forces = &self.evaluation.residual_forces[body.residual_rows.clone()];
            let mut change = vec![0.0; forces.len()];
            add_product(flexibility.as_ref(), forces, &mut change);
            let mut before = vec![0.0; forces.len()];
            match body.flexible.compatibility {
                Compatibility::Strong | Compatibility::Static => {
                    let x = &mut state.residual_displacements[body.residual_rows.clone()];
                    before.copy_from_slice(x);
                    x.copy_from_slice(&change);
                }
                Compatibility::Weak => {
                    let own = &mut state.coordinates[body.coordinates.clone()];
                    let g = &mut own[body.flexible.displacement_count()..];
                    add_product(flexibility.as_ref(), g, &mut before);
                    g.copy_from_slice(forces);
                }
            }
            for ((after, before), row) in change.iter().zip(&before).zip(&body.flexible.rows) {
                let unit = if row.direction < 3 { self.size } else { 1.0 };
                largest = largest.max((after - before).abs() / unit);
            }
        }
        largest
    }
}
