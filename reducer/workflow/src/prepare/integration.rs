//! How a prepared scene is integrated: by an iteration no finer and steps no shorter than its outputs need.

use super::trials::{Start, Trials};
use dcb_demand::pruning::NarrowedScene;
use dcb_formats::scene::{Integrator, Record, Scene};
use dcb_runtime::error::Error;

/// Whether a preparation may change how the scene is integrated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Integration {
    /// It stays as the scene has it.
    #[default]
    OfScene,
    /// With a coarser iteration and steps up to 16 times as long, as far as the outputs stay within the tolerance.
    Adapted,
}

/// Tolerances of the iteration that are tried, in this order.
const ITERATION: [f64; 4] = [1e-4, 1e-5, 1e-6, 1e-7];

/// Longest steps that are tried, in those of the scene.
pub(super) const LONGEST: u32 = 16;
/// How many steps the longest is divided into, in the order in which they are tried: all of them end where it ends.
const DIVISIONS: [u32; 11] = [13, 11, 9, 8, 7, 6, 5, 4, 3, 2, 1];

impl Trials<'_> {
    /// The same with the coarsest iteration that brings no output further from the reference than `more`. `None` if the user stopped it.
    pub fn coarsest_iteration(&self, start: Start, more: f64) -> Result<Option<Start>, Error> {
        for tolerance in ITERATION {
            let coarser = start.with_integrator(|integrator| {
                let is_coarser = integrator.tolerance < tolerance;
                integrator.tolerance = tolerance;
                is_coarser
            });
            let Some(narrowed) = coarser else {
                continue;
            };
            let error = unless_stopped!(self.error_with_all(&start, &narrowed)?);
            if error <= start.error + more {
                return Ok(Some(start.of(narrowed, error)));
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
            let error = unless_stopped!(self.error_with_all(first, &narrowed)?);
            if error > tolerance || error.is_nan() {
                break;
            }
            let longer = first.of(narrowed, error);
            all.push(longer);
        }
        Ok(Some(all))
    }
}

impl Start {
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
