//! Whether an iteration has done, and why it can't.

use std::f64::consts::TAU;

use nalgebra::Vector3;

use super::correct::three;
use super::{Corrector, ROUNDING};
use crate::error::Error;
use crate::initial::REGULARIZATION;
use crate::integrator::method::{Formulation, Method};
use crate::system::{Demand, State, System};
use dcb_formats::scene::Scheme;

/// A constraint that stays this many times further open than the iteration's accuracy contradicts others.
const VIOLATED: f64 = 1e6;

/// The joints' system enlarges its right-hand side by more than this only near a dead centre.
const NEARLY_SINGULAR: f64 = 1e3;
/// Rounding is taken to be enlarged by no more: a dead centre leaves half the digits of a position.
const LARGEST_AMPLIFICATION: f64 = 1e8;
/// Largest turn of a joint in one step whose angle is counted, rad.
const LONGEST_TURN: f64 = 0.9 * std::f64::consts::PI;
/// How much more than one rounding of a position forces scatter by, seen on pendulums.
const SCATTER: f64 = 10.0;
/// Part of the forces by which rounding may change redundant ones.
const DETERMINED: f64 = 1e-2;
/// Largest part of what a step's inertia gives way by which redundant constraints may.
const LARGEST_REGULARIZATION: f64 = 1e-2;

impl Corrector {
    /// With redundant constraints an iteration converges also where they contradict each other; then they stay violated.
    pub(in crate::integrator) fn refuse_contradiction(
        &self,
        system: &System,
        accuracy: f64,
    ) -> Result<(), Error> {
        if self.condensed.regularization == 0.0 && !self.was_singular {
            return Ok(());
        }
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
                    unit: match term.measure.is_length() {
                        true => "units of length".to_owned(),
                        false => "rad".to_owned(),
                    },
                });
            }
        }
        Ok(())
    }

    /// The size of accelerations that corrections are compared with.
    pub(super) fn rescale(&mut self, system: &System, start: &State) -> f64 {
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
        self.acceleration_scale
    }

    /// How far from the world's origin positions are, for their rounding; angles beyond a turn, which are counted on, are as coarse as
    /// an arc of that length.
    pub(super) fn reach(&self, system: &System) -> f64 {
        let angles = self.trial.angles.iter();
        let turned = angles.fold(0.0, |most: f64, angle| most.max(angle.abs() - TAU));
        system
            .bodies
            .iter()
            .zip(&self.trial.origins)
            .fold(0.0, |most: f64, (body, origin)| {
                most.max(origin.amax() + body.length)
                    .max(turned * body.length)
            })
    }

    /// Corrections of a place below this length are rounding.
    pub(in crate::integrator) fn rounding(&self, system: &System) -> f64 {
        ROUNDING * self.reach(system)
    }

    /// Whether a correction is what rounding leaves at a dead centre: there the constraints nearly depend on each other, and
    /// positions are known by so much less. Redundant constraints always look like that, so nothing is forgiven where there are some.
    pub(super) fn is_as_good_as_possible(&mut self, correction: f64, floor: f64) -> bool {
        if self.condensed.regularization > 0.0 {
            return false;
        }
        let amplification = self.condensed.amplification();
        amplification > NEARLY_SINGULAR
            && correction < 100.0 * floor * amplification.min(LARGEST_AMPLIFICATION)
    }

    /// Why a correction is not finite: a function of time that has no value there, or the motion itself.
    pub(in crate::integrator) fn not_finite(&self, system: &System) -> Error {
        let time = self.trial.time;
        let bad = |signal: usize| {
            Some(system.signal(signal, &self.trial).value).filter(|v| !v.is_finite())
        };
        let drives = system.rows.iter().filter_map(|row| match &row.demand {
            Demand::Follow(signal) => {
                Some((bad(*signal)?, &system.connections[row.connection].name))
            }
            Demand::Actuate(actuator) => {
                let found = self.evaluation.answers[system.actuators[*actuator].row];
                (!found.is_finite()).then_some((found, &system.connections[row.connection].name))
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
                body: self.worst_body(system),
            },
        }
    }

    /// The body with the largest correction.
    pub(in crate::integrator) fn worst_body(&self, system: &System) -> String {
        let size = |body: &crate::system::Body| {
            self.condensed.step[body.velocities.clone()]
                .iter()
                .map(|x| x.abs())
                .fold(0.0, |most: f64, x| {
                    if x.is_nan() {
                        f64::INFINITY
                    } else {
                        most.max(x)
                    }
                })
        };
        system
            .bodies
            .iter()
            .max_by(|a, b| size(a).total_cmp(&size(b)))
            .map_or_else(String::new, |body| body.name.clone())
    }

    /// An angle can be counted on from its last value only if it turns by less than half a turn in a step.
    pub(in crate::integrator) fn refuse_long_turns(
        &self,
        system: &System,
        step: f64,
    ) -> Result<(), Error> {
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

    /// Where what redundant constraints do nothing by isn't carried on, it is determined by how little they give way. That must be more than what
    /// rounding makes of the positions in a step's forces, and it shows in the accelerations of short steps.
    pub(super) fn sharing_regularization(
        &self,
        system: &System,
        method: &Method,
        step: f64,
    ) -> f64 {
        let of_rounding = ROUNDING * self.reach(system);
        let of_forces = method.scheme.beta * step * step * self.acceleration_scale;
        let needed = of_rounding / (DETERMINED * of_forces);
        // Constraints on velocities have forces that rounding reaches by 1/h less.
        match method.formulation {
            Formulation::Index3 if needed.is_finite() => {
                needed.clamp(REGULARIZATION, LARGEST_REGULARIZATION)
            }
            Formulation::Index3 | Formulation::StabilizedIndex2 => REGULARIZATION,
        }
    }

    /// Rounding of the positions in the accelerations that constraints ask for: small steps and far places make it large where
    /// constraints are on positions.
    pub fn rounding_of_accelerations(&self, system: &System, scheme: &Scheme, step: f64) -> f64 {
        let of_positions = SCATTER * ROUNDING * self.reach(system);
        of_positions / (scheme.beta * step * step)
    }

    /// The accelerations that the joints' forces belong to at the state of the last step: those of the bodies, and those that the forces by
    /// themselves would give the heaviest body.
    pub fn accelerations_of_forces(&self, system: &System) -> f64 {
        let masses = system.bodies.iter().map(|b| b.flexible.inertia.mass());
        let heaviest = masses.fold(0.0, f64::max);
        let longest = system.bodies.iter().map(|b| b.length).fold(0.0, f64::max);
        let mut largest = self.acceleration_scale;
        for (row, force) in system.rows.iter().zip(&self.trial.forces) {
            if row.is_constraint() {
                let is_length = system.terms[row.terms.start].measure.is_length();
                let arm = if is_length { 1.0 } else { longest };
                largest = largest.max(force.abs() / (arm * heaviest));
            }
        }
        largest
    }

    /// The accelerations that no rounding is in: of gravity, and those that would turn the motion back within a body's length.
    pub fn accelerations_of_motion(&self, system: &System) -> f64 {
        let of = |body: &crate::system::Body| {
            let own = &self.trial.velocities[body.velocities.clone()];
            let (speed, spin) = (three(own, 0).norm(), three(own, 3).norm());
            (speed + body.length * spin).powi(2) / body.length
        };
        let motions = system.bodies.iter().map(of);
        motions.fold(system.gravity.norm(), f64::max)
    }
}
