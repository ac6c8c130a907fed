//! What errors of the motion are relative to.

use super::stage::spin;
use crate::integrator::larger;
use crate::system::{Body, State, System};

/// Deflections below this part of a body's length are nothing; nor are the forces that make them.
const NO_DEFLECTION: f64 = 1e-9;

/// Lengths by bodies: errors of places are compared with a body's length, those of the deflection with its largest deflection so far, and those of the
/// forces in it with the largest so far.
pub(super) struct Scale {
    lengths: Vec<f64>,
    deflections: Vec<f64>,
    /// Forces as accelerations by √mass: those of interfaces and loads, by the coordinates' unit modal mass.
    forces: Vec<f64>,
    /// 1/√mass by bodies.
    to_length: Vec<f64>,
}

impl Scale {
    pub fn of(system: &System) -> Self {
        let all: f64 = system.bodies.iter().map(|body| body.length).sum();
        let smallest = 0.01 * if all > 0.0 { all } else { 1.0 };
        let bodies = &system.bodies;
        let lengths: Vec<f64> = bodies.iter().map(|b| b.length.max(smallest)).collect();
        let no_force = |(body, length): (&Body, &f64)| {
            let softest = body.flexible.stiffness.first().copied().unwrap_or(0.0);
            NO_DEFLECTION * length * body.flexible.inertia.mass().sqrt() * softest
        };
        Self {
            forces: bodies.iter().zip(&lengths).map(no_force).collect(),
            deflections: lengths
                .iter()
                .map(|length| NO_DEFLECTION * length)
                .collect(),
            to_length: bodies
                .iter()
                .map(|body| 1.0 / body.flexible.inertia.mass().sqrt())
                .collect(),
            lengths,
        }
    }

    /// Takes over what a state knows of its past.
    pub fn go_on_from(&mut self, state: &State) {
        let known = self.deflections.iter_mut().zip(&state.deflections);
        for ((deflection, known), length) in known.zip(&self.lengths) {
            *deflection = known.max(NO_DEFLECTION * length);
        }
        for (force, known) in self.forces.iter_mut().zip(&state.body_forces) {
            *force = known.max(*force);
        }
    }

    /// What a state is to know of its past.
    pub fn write_to(&self, state: &mut State) {
        state.deflections.copy_from_slice(&self.deflections);
        state.body_forces.copy_from_slice(&self.forces);
    }

    /// Takes the deflections and forces of a state into account, and the deflections at which its forces would be at rest.
    pub fn look_at(&mut self, system: &System, state: &State) {
        for (index, body) in system.bodies.iter().enumerate() {
            let y = &state.coordinates[body.coordinates.clone()];
            let (rigid, second) = state.accelerations[body.velocities.clone()].split_at(6);
            let linear: f64 = rigid[..3].iter().map(|a| a * a).sum();
            let mut force = body.flexible.inertia.mass() * linear;
            let (mut now, mut at_rest) = (0.0, 0.0);
            for ((y, second), stiffness) in y.iter().zip(second).zip(&body.flexible.stiffness) {
                now += y * y;
                at_rest += (y + second / stiffness).powi(2);
                force += (stiffness * y + second).powi(2);
            }
            let force = force.sqrt();
            if force.is_finite() {
                self.forces[index] = self.forces[index].max(force);
            }
            let size = f64::max(now, at_rest).sqrt() * self.to_length[index];
            if size.is_finite() {
                self.deflections[index] = self.deflections[index].max(size);
            }
        }
    }

    /// The size of a change of places, laid out as velocities with rigid parts in any axes, by bodies and the worst of them.
    pub fn size(&self, system: &System, change: &[f64]) -> f64 {
        let mut largest: f64 = 0.0;
        for (index, body) in system.bodies.iter().enumerate() {
            let own = &change[body.velocities.clone()];
            let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
            let place = norm(&own[..3]) / self.lengths[index] + norm(&own[3..6]);
            let deflection = self.deflection(index, norm(&own[6..]));
            largest = larger(larger(place, deflection), largest);
        }
        largest
    }

    /// The size of a deflection of a body, given as a norm of its coordinates.
    pub fn deflection(&self, body: usize, norm: f64) -> f64 {
        norm * self.to_length[body] / self.deflections[body]
    }

    /// The size of what a change of deflections does to the forces in bodies, the worst of them.
    pub fn force(&self, system: &System, change: &[f64]) -> f64 {
        let mut largest: f64 = 0.0;
        for (index, body) in system.bodies.iter().enumerate() {
            let own = &change[body.velocities.clone()][6..];
            let terms = own.iter().zip(&body.flexible.stiffness);
            let squares: f64 = terms.map(|(y, stiffness)| (stiffness * y).powi(2)).sum();
            largest = larger(self.force_in(index, squares.sqrt()), largest);
        }
        largest
    }

    /// The size of a force in a body, given as a norm of those of its coordinates.
    pub fn force_in(&self, body: usize, norm: f64) -> f64 {
        match norm > 0.0 {
            true => norm / self.forces[body],
            false => 0.0,
        }
    }

    /// One over the shortest of the lengths.
    pub fn by_length(&self) -> f64 {
        1.0 / self.lengths.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// The longest step in which no body turns by more than this, rad.
    pub fn step_by_turn(&self, system: &System, state: &State, turn: f64) -> f64 {
        let spins = system.bodies.iter().map(|body| spin(state, body).norm());
        turn / spins.fold(0.0, f64::max)
    }
}
