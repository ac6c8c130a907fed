//! Up to which frequency a run's deflections must be modelled.
//!
//! Two things limit it. Steps of length h follow an oscillation with a period wrong by
//!
//! ```text
//! C (ω h)²,    C = -½ [1/12 + ½ (α_m - α_m² - α_f + α_f²) - g/2 + g²/4],    g = γ + ½
//! ```
//! to leading order, which is (ω h)²/12 without numerical damping; beyond [`PERIOD_ERROR`] an oscillation isn't followed, and the run
//! says so if there is one. And where bodies stay where they are but for small motions, nothing is faster than what acts on them.

use std::f64::consts::TAU;

use serde::Serialize;

use super::excitation::{Excitation, NEGLIGIBLE};
use crate::Error;
use dcb_formats::scene::{Analysis, Integrator, Scene, Scheme};
use dcb_formats::units::written_frequency;

/// Largest relative error of a period that counts as followed: that of 20 steps in a period, of which a run begins to warn.
const PERIOD_ERROR: f64 = 0.01;

/// How fast deflections are that a run has to model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Band {
    /// Cycles per time unit: faster oscillations of a part are not followed or not excited, and deflect as if their forces didn't change.
    /// `None` where no limit is known.
    pub frequency: Option<f64>,
    /// Why.
    pub reasons: Vec<String>,
}

impl Band {
    /// Of a run of a scene.
    ///
    /// # Errors
    /// [`Error::Formats`] for functions of time that can't be evaluated.
    pub fn of(scene: &Scene) -> Result<Self, Error> {
        let at = |frequency: f64, reason: &str| {
            Ok(Self {
                frequency: Some(frequency),
                reasons: vec![reason.to_owned()],
            })
        };
        let integrator = match (&scene.analysis, &scene.integrator) {
            (Analysis::Static | Analysis::InertiaRelief, _) => {
                return at(0.0, "an equilibrium has no frequency");
            }
            (Analysis::Kinematic, _) => return at(0.0, "flexible bodies are taken as rigid"),
            (Analysis::Transient, Some(integrator)) => integrator,
            (Analysis::Modes(modes), _) => {
                return Ok(Self {
                    frequency: None,
                    reasons: vec![format!(
                        "the {} lowest oscillations are wanted, and how fast they are isn't known before",
                        modes.count
                    )],
                });
            }
            (Analysis::FrequencyResponse(_), _) => {
                return Ok(Self {
                    frequency: None,
                    reasons: vec![
                        "a frequency response takes all modes of the files, which cost little beside its frequencies".into(),
                    ],
                });
            }
            (Analysis::Transient, None) => {
                return Ok(Self {
                    frequency: None,
                    reasons: vec!["the scene has no integrator, whose steps would limit it".into()],
                });
            }
        };
        let time = &scene.units.time;
        let (limit, told) = match Scheme::of(integrator.method) {
            Some(scheme) => by_step(integrator, &scheme, time),
            None => by_accuracy(integrator.highest_frequency(), time),
        };
        Ok(match Excitation::of(scene, integrator.end)? {
            Excitation::Unlimited(reasons) => Self {
                frequency: limit,
                reasons: [told].into_iter().chain(reasons).collect(),
            },
            Excitation::UpTo(excited, by) => Self {
                frequency: Some(limit.map_or(excited, |limit| limit.min(excited))),
                reasons: vec![told, small_motions(&by, &written_frequency(excited, time))],
            },
        })
    }
}

/// The frequency up to which steps of a length follow the motion, and how that is told.
fn by_step(integrator: &Integrator, scheme: &Scheme, time: &str) -> (Option<f64>, String) {
    let step = integrator
        .adaptive
        .map_or(integrator.step, |adaptive| adaptive.minimum_step);
    let followed = 1.0 / (steps_per_period(scheme) * step);
    let which = match integrator.adaptive {
        Some(_) => "the shortest steps allowed",
        None => "the steps",
    };
    let told = format!(
        "{which} of {step:.3e} {time} resolve motion up to {} (period error {:.0} %)",
        written_frequency(followed, time),
        100.0 * PERIOD_ERROR
    );
    (Some(followed), told)
}

/// The same of steps that follow an accuracy: they limit nothing, but the scene may.
fn by_accuracy(highest: Option<f64>, time: &str) -> (Option<f64>, String) {
    let told = match highest {
        None => BY_TOLERANCE.to_owned(),
        Some(frequency) => format!(
            "the scene wants motion up to {} (integrator.radau.highest_frequency)",
            written_frequency(frequency, time)
        ),
    };
    (highest, told)
}

/// Why no step limits the motion that is followed.
const BY_TOLERANCE: &str = "the steps follow the accuracy and limit nothing";

fn small_motions(by: &str, frequency: &str) -> String {
    format!(
        "all motions are small, and {by}: above {frequency} less than {:.0} % of the deflection oscillates",
        100.0 * NEGLIGIBLE
    )
}

/// Steps in a period that is wrong by [`PERIOD_ERROR`].
fn steps_per_period(scheme: &Scheme) -> f64 {
    let Scheme {
        alpha_m,
        alpha_f,
        gamma,
        ..
    } = *scheme;
    let g = gamma + 0.5;
    let lead = 1.0 / 12.0 + 0.5 * (alpha_m - alpha_m * alpha_m - alpha_f + alpha_f * alpha_f)
        - 0.5 * g
        + 0.25 * g * g;
    TAU * (-0.5 * lead / PERIOD_ERROR).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Period in steps and what is left of the amplitude after it, of x'' = -z x with steps of 1, by stepping.
    fn measured(scheme: &Scheme, z: f64) -> (f64, f64) {
        let (mut x, mut v, mut after, mut own) = (1.0, 0.0, -z, -z);
        let mut crossings: Vec<f64> = Vec::new();
        let mut peaks: Vec<f64> = Vec::new();
        for step in 0..2000_u32 {
            // x₁ = known + β' q''₁ / slope with q''₁ = -z x₁: linear, so two trials give the root.
            let trial = |acceleration: f64| {
                let next = scheme.algorithmic(own, after, acceleration);
                x + scheme.increment(1.0, v, own, next)
            };
            let (at_zero, at_one) = (trial(0.0), trial(1.0));
            let acceleration = -z * at_zero / (1.0 + z * (at_one - at_zero));
            let next = scheme.algorithmic(own, after, acceleration);
            let moved = x + scheme.increment(1.0, v, own, next);
            v = scheme.velocity(1.0, v, own, next);
            if x < 0.0 && moved >= 0.0 {
                crossings.push(f64::from(step) + x / (x - moved));
                peaks.push(0.0);
            }
            if let Some(peak) = peaks.last_mut() {
                *peak = peak.max(moved * moved + v * v / z);
            }
            (x, after, own) = (moved, acceleration, next);
        }
        let last = crossings.len() - 1;
        let periods = last as f64;
        let left = (peaks[last - 1] / peaks[1]).powf(0.5 / (periods - 2.0));
        ((crossings[last] - crossings[0]) / periods, left)
    }

    #[test]
    fn periods_at_the_limit_are_wrong_by_one_percent_and_keep_their_amplitude() {
        let members = [0.0, 0.5, 0.8, 0.9, 1.0].map(Scheme::generalized_alpha);
        let hht = [-0.05, -0.1, -1.0 / 3.0].map(Scheme::hht);
        for scheme in members.into_iter().chain(hht) {
            let steps = steps_per_period(&scheme);
            let (period, left) = measured(&scheme, (TAU / steps).powi(2));
            let wrong = period / steps - 1.0;
            assert!(
                (wrong / PERIOD_ERROR - 1.0).abs() < 0.06,
                "{scheme:?}: {steps} steps, {wrong}"
            );
            assert!(1.0 - left < 0.0105, "{scheme:?}: keeps {left} in a period");
        }
        assert!((steps_per_period(&Scheme::generalized_alpha(0.8)) - 18.635).abs() < 1e-3);
    }
}
