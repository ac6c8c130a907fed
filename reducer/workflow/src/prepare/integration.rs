//! How a prepared scene is integrated: by an iteration no finer and steps no shorter than its outputs need.

use super::trials::{Start, Trials};
use dcb_demand::pruning::NarrowedScene;
use dcb_formats::scene::{Compatibility, Integrator, Method, Record, Scene};
use dcb_runtime::error::Error;

/// Whether a preparation may change how the scene is integrated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Integration {
    /// It stays as the scene has it.
    #[default]
    OfScene,
    /// With a coarser iteration and steps up to 16 times as long, or with radau, as far as the outputs stay within the tolerance.
    Adapted,
}

/// Tolerances of the iteration that are tried, in this order.
const ITERATION: [f64; 4] = [1e-4, 1e-5, 1e-6, 1e-7];

/// Longest steps that are tried, in those of the scene.
pub(super) const LONGEST: u32 = 16;
/// How many steps the longest is divided into, in the order in which they are tried: all of them end where it ends.
const DIVISIONS: [u32; 11] = [13, 11, 9, 8, 7, 6, 5, 4, 3, 2, 1];

/// Accuracies of radau that are tried, in tolerances of the outputs: from the coarsest on, until one is good enough.
const ACCURACIES: [f64; 6] = [3.0, 1.0, 0.3, 0.1, 0.01, 0.001];
/// The coarsest accuracy that a scene may have.
const COARSEST: f64 = 0.1;

/// What an iteration of a method takes, in those of generalized alpha, with its share of a step's other work: an evaluation for each stage, and solutions with a
/// real and one or two complex matrices, of four times the operations. Seen on the mechanisms of `docs/data/work_precision.jsonl`: 6 to 16.
pub(super) fn iteration_cost(method: Method) -> f64 {
    match method {
        Method::GeneralizedAlpha { .. } | Method::Hht { .. } => 1.0,
        Method::Radau { order, .. } if order < 9 => 8.0,
        Method::Radau { .. } => 13.0,
    }
}

impl Trials<'_> {
    /// The same with the coarsest iteration that brings no output further from the reference than `more`. `None` if the user stopped it.
    /// That of radau follows its accuracy.
    pub fn coarsest_iteration(&self, start: Start, more: f64) -> Result<Option<Start>, Error> {
        for tolerance in ITERATION {
            let coarser = start.with_integrator(|integrator| {
                let is_coarser = !integrator.is_radau() && integrator.tolerance < tolerance;
                integrator.tolerance = tolerance;
                is_coarser
            });
            let Some(narrowed) = coarser else {
                continue;
            };
            let run = unless_stopped!(self.run_with_all(&start, &narrowed)?);
            if run.error <= start.run.error + more {
                return Ok(Some(start.of(narrowed, run)));
            }
        }
        Ok(Some(start))
    }

    /// The same with longer and longer steps, as far as no output is further from the reference than the tolerance; the scene's own
    /// steps are the first. `None` if the user stopped it.
    pub fn longer_steps(&self, start: Start, tolerance: f64) -> Result<Option<Vec<Start>>, Error> {
        let mut all = vec![start];
        for division in DIVISIONS {
            let first = &all[0];
            let Some(mut narrowed) = first.with_integrator(|integrator| {
                let is_fixed = integrator.has_equal_steps();
                integrator.step *= f64::from(LONGEST) / f64::from(division);
                is_fixed
            }) else {
                break;
            };
            keep_records(&mut narrowed.scene, division);
            let run = unless_stopped!(self.run_with_all(first, &narrowed)?);
            if run.error > tolerance || run.error.is_nan() {
                break;
            }
            let longer = first.of(narrowed, run);
            all.push(longer);
        }
        Ok(Some(all))
    }

    /// The same by radau, with the coarsest accuracy that brings no output further from the reference than `limit`, and with the next finer one, which
    /// leaves more room for fewer coordinates. None where radau can't integrate the scene or no accuracy is good enough; of a scene that has radau
    /// already, with a coarser accuracy than its own. `None` if the user stopped it.
    pub fn by_accuracy(
        &self,
        start: &Start,
        tolerance: f64,
        limit: f64,
    ) -> Result<Option<Vec<Start>>, Error> {
        let mut good: Vec<Start> = Vec::new();
        if start.narrowed.scene.compatibility != Compatibility::Strong {
            return Ok(Some(good));
        }
        let looks_at_forces = start.narrowed.scene.looks_at_reactions();
        for part in ACCURACIES {
            let accuracy = (part * tolerance).min(COARSEST);
            let Some(mut narrowed) = start.with_integrator(|integrator| {
                let is_coarser = !integrator.is_radau() || integrator.tolerance < accuracy;
                *integrator = match integrator.is_radau() {
                    true => Integrator {
                        tolerance: accuracy,
                        ..*integrator
                    },
                    false => Integrator::radau(accuracy, integrator.end),
                };
                if looks_at_forces {
                    integrator.hold_forces(accuracy);
                }
                is_coarser
            }) else {
                break;
            };
            if let Some(step) = start.step() {
                record_as_often(&mut narrowed.scene, step);
            }
            if narrowed.scene.check().is_err() {
                break;
            }
            let run = unless_stopped!(self.run_with_all(start, &narrowed)?);
            if run.error <= limit {
                good.push(start.of(narrowed, run));
            }
            if good.len() == 2 {
                break;
            }
        }
        Ok(Some(good))
    }
}

impl Start {
    /// The length of its steps, where they are equal.
    fn step(&self) -> Option<f64> {
        let integrator = self.narrowed.scene.integrator?;
        integrator.has_equal_steps().then_some(integrator.step)
    }

    /// The scene with another integrator, if it has one and `change` says that it is another.
    fn with_integrator(
        &self,
        change: impl FnOnce(&mut Integrator) -> bool,
    ) -> Option<NarrowedScene> {
        let mut narrowed = self.narrowed.clone();
        let is_changed = narrowed.scene.integrator.as_mut().is_some_and(change);
        is_changed.then_some(narrowed)
    }
}

/// Recorded times stay the same, as far as the longest step is divided so that it can.
fn keep_records(scene: &mut Scene, division: u32) {
    if let Some(Record::Every(every)) = &mut scene.record {
        let kept = f64::from(*every) * f64::from(division) / f64::from(LONGEST);
        *every = (kept.round() as u32).max(1);
    }
}

/// Recorded times stay the same where steps follow an accuracy; where every step of this length was recorded, every [`LONGEST`] of them is.
fn record_as_often(scene: &mut Scene, step: f64) {
    scene.record = match scene.record {
        None => Some(Record::Interval(f64::from(LONGEST) * step)),
        Some(Record::Every(steps)) => Some(Record::Interval(f64::from(steps) * step)),
        at_times @ Some(Record::Interval(_)) => at_times,
    };
}
