//! Whether an iteration has done, and why it can't.

use nalgebra::Vector3;

use super::{Corrector, three};
use crate::error::Error;
use crate::integrator::method::{Formulation, Method};
use crate::integrator::scheme::Scheme;
use crate::system::{Demand, State, System};

/// A constraint that stays this many times further open than the iteration's accuracy contradicts others.
const VIOLATED: f64 = 1e6;

/// Largest turn of a joint in one step whose angle is counted, rad.
const LONGEST_TURN: f64 = 0.9 * std::f64::consts::PI;
/// How much more than one rounding of a position forces scatter by, seen on pendulums.
const SCATTER: f64 = 10.0;
/// Part of the forces by which rounding may change redundant ones.
const DETERMINED: f64 = 1e-2;
/// Largest part of what a step's inertia gives way by which redundant constraints may.
const LARGEST_REGULARIZATION: f64 = 1e-2;

/// The size of a correction. A body's is its translation, turn by its length and deflection together, a length.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Correction {
    /// The largest.
    pub length: f64,
    /// The largest by what is allowed for the body.
    pub in_tolerances: f64,
    /// The largest by the rounding of the body's place.
    pub in_roundings: f64,
    /// The body that is furthest from what is allowed.
    pub worst: usize,
    /// Its own.
    pub of_worst: f64,
}

impl Corrector {
    /// The size of the last correction, where `allowed` is enough or what rounding leaves.
    pub(super) fn size_up(&self, system: &System, allowed: f64) -> Correction {
        let mut all = Correction::default();
        // `max` would drop a NaN.
        let larger = |a: f64, b: f64| if a > b || a.is_nan() { a } else { b };
        for (index, body) in system.bodies.iter().enumerate() {
            let step = &self.condensed.step[body.velocities.clone()];
            let squares = step[6..6 + body.flexible.displacement_count()].iter();
            let deflection = squares.map(|y| y * y).sum::<f64>() / body.flexible.inertia.mass();
            let size =
                three(step, 0).norm() + body.length * three(step, 3).norm() + deflection.sqrt();
            let floor = self.roundings.of_body(index);
            let in_tolerances = size / allowed.max(floor);
            if in_tolerances > all.in_tolerances || in_tolerances.is_nan() {
                (all.worst, all.of_worst) = (index, size);
            }
            all.length = larger(size, all.length);
            all.in_tolerances = larger(in_tolerances, all.in_tolerances);
            all.in_roundings = larger(size / floor, all.in_roundings);
        }
        all
    }

    /// With redundant constraints an iteration converges also where they contradict each other; then they stay violated.
    pub(super) fn refuse_contradiction(
        &self,
        system: &System,
        allowed: f64,
        correction: &Correction,
    ) -> Result<(), Error> {
        if self.condensed.regularization == 0.0 {
            return Ok(());
        }
        let accuracy = correction
            .length
            .max(allowed)
            .max(self.roundings.coarsest());
        for (index, row) in system.rows.iter().enumerate() {
            if !row.is_constraint() {
                continue;
            }
            let term = &system.terms[row.terms.start];
            let unit = if term.measure.is_length() {
                1.0
            } else {
                system.bodies.iter().map(|b| b.length).fold(0.0, f64::max)
            };
            let misfit = self.evaluation.answers[index];
            if misfit.abs() * unit > VIOLATED * accuracy {
                return Err(Error::Contradiction {
                    time: self.trial.time,
                    joint: system.connections[row.connection].name.clone(),
                    misfit,
                });
            }
        }
        Ok(())
    }

    /// The size of accelerations that corrections are compared with.
    pub(super) fn rescale(&mut self, system: &System, start: &State) {
        let mut scale = system.gravity.norm();
        for body in &system.bodies {
            let a = &start.accelerations[body.velocities.clone()];
            let v = &start.velocities[body.velocities.clone()];
            let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
            let size = norm(&a[..3])
                + body.length * (norm(&a[3..6]) + norm(&v[3..6]).powi(2))
                + norm(&a[6..6 + body.flexible.displacement_count()])
                    / body.flexible.inertia.mass().sqrt();
            scale = scale.max(size);
        }
        self.acceleration_scale = scale.max(0.999 * self.acceleration_scale);
    }

    /// Why a correction is not finite: a function of time that has no value there, or the motion itself.
    pub(super) fn not_finite(&self, system: &System, correction: &Correction) -> Error {
        let time = self.trial.time;
        let bad = |signal: usize| {
            Some(system.signal(signal, &self.trial).value).filter(|v| !v.is_finite())
        };
        let drives = system.rows.iter().filter_map(|row| match &row.demand {
            Demand::Follow(signal) => {
                Some((bad(*signal)?, &system.connections[row.connection].name))
            }
            Demand::Hold(_) | Demand::Answer(_) => None,
        });
        let loads = system.loads.iter().filter_map(|load| {
            let signals = load.force.iter().chain(&load.torque).flatten();
            let found = signals.copied().find_map(bad)?;
            Some((found, &load.name))
        });
        let inside = system.part_loads.iter();
        let inside = inside.filter_map(|load| Some((bad(load.factor)?, &load.name)));
        match drives.chain(loads).chain(inside).next() {
            Some((found, name)) => Error::FunctionNotFinite {
                time,
                name: name.clone(),
                found,
            },
            None => Error::NotFinite {
                time,
                body: system.bodies[correction.worst].name.clone(),
            },
        }
    }

    /// An angle can be counted on from its last value only if it turns by less than half a turn in a step.
    pub(super) fn refuse_long_turns(&self, system: &System, step: f64) -> Result<(), Error> {
        let spin = |marker: usize| match system.markers[marker].body {
            None => Vector3::zeros(),
            Some(body) => {
                let own = system.bodies[body].velocities.clone();
                self.evaluation.poses[body].axes * three(&self.trial.velocities[own], 3)
            }
        };
        for term in system.terms.iter().filter(|term| term.angle.is_some()) {
            let turn = (spin(term.b) - spin(term.a)).norm() * step;
            if turn > LONGEST_TURN {
                let of = |marker: usize| match system.markers[marker].body {
                    None => "ground".to_owned(),
                    Some(body) => system.bodies[body].name.clone(),
                };
                return Err(Error::LongTurn {
                    time: self.trial.time,
                    a: of(term.a),
                    b: of(term.b),
                    turn,
                });
            }
        }
        Ok(())
    }

    /// Forces of constraints that depend on each other are determined by how little these give way. That must be more than what rounding
    /// makes of the positions in a step's forces, and stays far below what anybody sees: at least `least`, as a part of what a step's
    /// inertia gives way by.
    pub(super) fn regularize(&mut self, method: &Method, step: f64, least: f64) {
        // Constraints on velocities have forces that rounding reaches by 1/h less.
        let needed = match method.formulation {
            Formulation::Index3 => {
                let of_forces = method.scheme.beta * step * step * self.acceleration_scale;
                self.roundings.coarsest() / (DETERMINED * of_forces)
            }
            Formulation::StabilizedIndex2 => least,
        };
        self.condensed.regularization = if needed.is_finite() {
            needed.clamp(least, LARGEST_REGULARIZATION)
        } else {
            least
        };
    }

    /// What rounding of the positions is in the joints' forces, as a part of the forces of the run: small steps and far places make it
    /// large where constraints are on positions.
    pub fn rounding_of_forces(&self, scheme: &Scheme, step: f64) -> f64 {
        let of_positions = SCATTER * self.roundings.coarsest();
        of_positions / (scheme.beta * step * step * self.acceleration_scale)
    }
}
