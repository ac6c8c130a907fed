//! Whether an iteration has done, and why it can't.

use super::Corrector;
use crate::error::Error;
use crate::system::{Demand, State, System};

/// A constraint that stays this many times further open than the iteration's accuracy contradicts others.
const VIOLATED: f64 = 1e4;

/// The joints' system enlarges its right-hand side by more than this only near a dead centre.
const NEARLY_SINGULAR: f64 = 1e5;
/// Rounding is taken to be enlarged by no more: a dead centre leaves half the digits of a position.
const LARGEST_AMPLIFICATION: f64 = 1e8;

impl Corrector {
    /// With redundant constraints an iteration converges also where they contradict each other; then they stay violated.
    pub(super) fn refuse_contradiction(&self, system: &System, accuracy: f64) -> Result<(), Error> {
        if self.condensed.regularization == 0.0 && !self.was_singular {
            return Ok(());
        }
        for (index, row) in system.rows.iter().enumerate() {
            if matches!(row.demand, Demand::Answer(_)) {
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

    /// How far from the world's origin positions are, for their rounding.
    pub(super) fn reach(&self, system: &System) -> f64 {
        system
            .bodies
            .iter()
            .zip(&self.trial.origins)
            .fold(0.0, |most: f64, (body, origin)| {
                most.max(origin.amax() + body.length)
            })
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
    pub(super) fn not_finite(&self, system: &System) -> Error {
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
        match drives.chain(loads).next() {
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
    pub(super) fn worst_body(&self, system: &System) -> String {
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
}
