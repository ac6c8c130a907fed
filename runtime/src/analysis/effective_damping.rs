//! Damping of the lowest modes of a mechanism as it is put together.
//!
//! Modal ratios ζ hold for the coordinates of each part by itself, `2 ζₖ ωₖ y'ₖ` (free-free modes and attachments). A mode of the mechanism
//! with the lower frequency ω moves many of them slowly. With the undamped mode z, ω² = zᵀKz / zᵀMz,
//!
//! ```text
//! ratio  =  zᵀ C z / (2 ω zᵀ M z)          exact to second order in the damping
//! ```
//! so that stiff coordinates damp slow motions by about ω/ωₖ of what was given for them.

use crate::analysis::eigenmodes::undamped;
use crate::error::Error;
use crate::system::evaluation::Evaluation;
use crate::system::free_directions::FreeDirections;
use crate::system::linearization::Linearization;
use crate::system::{State, System};

/// Modes that are told.
const MODES: usize = 4;
/// A larger system isn't looked at: its eigenvalues would take longer than a second.
const LARGEST: usize = 300;
/// Modes with less of their energy than this in damped superelements aren't what is damped.
const ELASTIC: f64 = 0.1;

/// One mode of the mechanism.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectiveDamping {
    /// Cycles per time.
    pub frequency: f64,
    /// Part of the critical damping.
    pub ratio: f64,
}

/// Of the lowest modes in which damped superelements deflect, at a state taken as being at rest. Empty where no superelement with damping is
/// in a joint or on a spring, for systems with more than 300 degrees of freedom, and for compatibilities that have no linearization.
pub fn effective_damping(system: &System, state: &State) -> Vec<EffectiveDamping> {
    if !has_damped_parts(system) || system.velocity_count() > LARGEST {
        return Vec::new();
    }
    // It is told beside a run, which it must not stop.
    estimated(system, state).unwrap_or_default()
}

/// Whether something holds a superelement that has damping.
fn has_damped_parts(system: &System) -> bool {
    let is_damped = |marker: usize| {
        let body = system.markers[marker].body;
        body.is_some_and(|body| {
            let flexible = &system.bodies[body].flexible;
            (0..flexible.displacement_count()).any(|k| flexible.damping_coefficient(k) > 0.0)
        })
    };
    let mut terms = system.terms.iter();
    terms.any(|term| is_damped(term.a) || is_damped(term.b))
}

fn estimated(system: &System, state: &State) -> Result<Vec<EffectiveDamping>, Error> {
    let state = &state.without_motion();
    let evaluation = Evaluation::at(system, state);
    let linear = Linearization::with_rigid_joints(system, state, &evaluation)?;
    let directions = FreeDirections::of(system, &linear.jacobian)?;
    if directions.count() == 0 {
        return Ok(Vec::new());
    }
    let [mass, damping, stiffness] = directions.reduced(&linear);
    let mut modes = undamped(&mass, &stiffness)?;
    modes.retain(|mode| mode.angular_frequency > 0.0);
    modes.sort_by(|a, b| a.angular_frequency.total_cmp(&b.angular_frequency));
    let form = |matrix: &faer::Mat<f64>, z: &[f64]| {
        let columns = matrix.col_iter().zip(z);
        let of_column = |column: faer::ColRef<'_, f64>| -> f64 {
            column.iter().zip(z).map(|(entry, z)| entry * z).sum()
        };
        columns
            .map(|(column, z)| of_column(column) * z)
            .sum::<f64>()
    };
    let elastic = |z: &[f64]| {
        let mut motion = vec![0.0; system.velocity_count()];
        directions.add_motion(z, &mut motion);
        let of = |body: &crate::system::Body| -> f64 {
            let y = &motion[body.velocities.clone()][6..];
            let damped = (0..body.flexible.displacement_count())
                .filter(|k| body.flexible.damping_coefficient(*k) > 0.0);
            damped
                .map(|k| body.flexible.stiffness[k] * y[k] * y[k])
                .sum()
        };
        system.bodies.iter().map(of).sum::<f64>()
    };
    let found = modes.iter().filter_map(|mode| {
        let z = &mode.shape;
        let omega = mode.angular_frequency;
        let energy = form(&mass, z) * omega * omega;
        (elastic(z) > ELASTIC * energy).then(|| EffectiveDamping {
            frequency: mode.frequency(),
            ratio: 0.5 * omega * form(&damping, z) / energy,
        })
    });
    Ok(found.take(MODES).collect())
}
