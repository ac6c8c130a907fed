//! States beside a state, and derivatives along the way there.
//!
//! With x the variation of a body's frame in its own axes and W the cross product of its spin, positions, velocities and accelerations vary by
//!
//! ```text
//! translations   Aᵀ δR = x,   Aᵀ δV = x' + W x,   Aᵀ δV' = x'' + 2 W x' + (W² + W') x
//! rotations         δφ = x,      δω = x' + W x,      δω' = x'' + W x' + W' x
//! ```

use nalgebra::{UnitQuaternion, Vector3};

use crate::system::state::rates;
use crate::system::{State, System};

/// x, x', x'' laid out as velocities, translations in body axes, and δλ of all rows; empty where nothing varies.
#[derive(Clone, Copy, Debug)]
pub struct Variation<'a> {
    /// x.
    pub place: &'a [f64],
    /// x'.
    pub rate: &'a [f64],
    /// x''.
    pub second_rate: &'a [f64],
    /// δλ.
    pub forces: &'a [f64],
}

impl Variation<'_> {
    /// The state that lies `amount` of the variation away; angles are not counted on.
    pub fn applied(&self, system: &System, state: &State, amount: f64) -> State {
        let mut varied = state.clone();
        let at = |values: &[f64], index: usize| values.get(index).map_or(0.0, |x| amount * x);
        for (index, body) in system.bodies.iter().enumerate() {
            let first = body.velocities.start;
            let axes = state.pose(index).axes;
            let spin = rates(&state.velocities[body.velocities.clone()])
                .angular
                .cross_matrix();
            let turning = rates(&state.accelerations[body.velocities.clone()])
                .angular
                .cross_matrix();
            let three =
                |values: &[f64], first: usize| Vector3::from_fn(|k, _| at(values, first + k));
            let (x, turn) = (three(self.place, first), three(self.place, first + 3));
            let (x1, turn1) = (three(self.rate, first), three(self.rate, first + 3));
            let (x2, turn2) = (
                three(self.second_rate, first),
                three(self.second_rate, first + 3),
            );
            let velocity = axes * (x1 + spin * x);
            let acceleration = axes * (x2 + spin * x1 * 2.0 + (spin * spin + turning) * x);
            let spin_change = turn1 + spin * turn;
            let turning_change = turn2 + spin * turn1 + turning * turn;
            varied.origins[index] += axes * x;
            varied.orientations[index] *= UnitQuaternion::new(turn);
            for k in 0..3 {
                varied.velocities[first + k] += velocity[k];
                varied.velocities[first + 3 + k] += spin_change[k];
                varied.accelerations[first + k] += acceleration[k];
                varied.accelerations[first + 3 + k] += turning_change[k];
            }
            for (k, y) in varied.coordinates[body.coordinates.clone()]
                .iter_mut()
                .enumerate()
            {
                *y += at(self.place, first + 6 + k);
                varied.velocities[first + 6 + k] += at(self.rate, first + 6 + k);
                varied.accelerations[first + 6 + k] += at(self.second_rate, first + 6 + k);
            }
        }
        for (row, force) in varied.forces.iter_mut().enumerate() {
            *force += at(self.forces, row);
        }
        varied
    }
}

/// The derivative at zero of numbers that depend on one, by differences of fourth order over `step` and twice that, exact for
/// polynomials of degree four.
pub fn derivative(step: f64, mut values: impl FnMut(f64) -> Vec<f64>) -> Vec<f64> {
    let mut slope = values(step);
    let (behind, ahead_twice, behind_twice) =
        (values(-step), values(2.0 * step), values(-2.0 * step));
    for (i, ahead) in slope.iter_mut().enumerate() {
        let (near, far) = (*ahead - behind[i], ahead_twice[i] - behind_twice[i]);
        *ahead = (8.0 * near - far) / (12.0 * step);
    }
    slope
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_of_degree_four_have_their_derivative() {
        let polynomial = |x: f64| vec![3.0 - 2.0 * x + 5.0 * x.powi(2) - x.powi(3) + x.powi(4)];
        let slope = derivative(0.5, polynomial)[0];
        assert!((slope + 2.0).abs() < 1e-14, "{slope}");
    }
}
