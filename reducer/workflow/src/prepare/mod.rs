//! The smallest superelements with which a scene's outputs stay within a tolerance, found by running the scene.
//!
//! A run with everything is the reference, at the scene's own step. What the scene doesn't need by itself is left out first
//! ([`dcb_demand::pruning`]). A run without it says how much each coordinate moves on its own, and the least active ones are left out, as many
//! as the outputs allow; the inertia follows the deflection no further than they need. What is left out keeps its flexibility: modes in the attachments, attachments as flexibility without mass. Every answer was
//! run; nothing is inferred.

mod activity;
mod field_samples;
mod files;
mod integration;
mod ranking;
mod trials;

pub use field_samples::FieldSamples;
pub use files::{PreparedFile, write};
pub use integration::Integration;

use std::cell::Cell;

use crate::scene_study::grid::Grid;
use crate::scene_study::monitor::Monitor;
use crate::scene_study::motion::{self, Course};
use crate::scene_study::setting::interval;
use crate::scene_study::{Fineness, Subject};
use dcb_demand::SuperelementFiles;
use dcb_demand::coordinate_search::Trial;
use dcb_demand::pruning::{NarrowedScene, Pruning};
use dcb_formats::scene::{Compatibility, Scene};
use dcb_runtime::error::Error;
use trials::{Found, Start, Trials};

/// Part of the tolerance that a search may use: the rest is for what the large superelements themselves are off.
const SHARE: f64 = 0.8;
/// Part of the tolerance for what the scene doesn't need by itself.
const PRUNED: f64 = 0.1;
/// Part of the tolerance up to which the inertia may be simplified: it costs time in each step, but less than coordinates do.
const INERTIA: f64 = 0.3;
/// Part of the tolerance that a coarser iteration may use.
const ITERATION: f64 = 0.02;
/// Of all steps that are short enough the longest so many are tried with fewer coordinates: a little longer can ask for many more.
const LONGEST_TRIED: usize = 3;
/// A scene whose superelements were made small.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// The scene, with what is carried of each superelement.
    pub narrowed: NarrowedScene,
    /// Contents that weren't needed before anything was run.
    pub pruning: Pruning,
    /// Elastic coordinates that are left.
    pub coordinates: usize,
    /// Largest relative distance of an output from the run with everything.
    pub error: f64,
    /// Numbers of coordinates that were run with the steps that were chosen, in this order.
    pub trials: Vec<Trial>,
    /// Runs made.
    pub runs: usize,
    /// The run with everything.
    pub reference: Course,
}

/// Chooses what is carried; `None` if the user stopped it.
///
/// # Errors
/// [`Error::Description`] with weak compatibility; what stops the run with everything; files that can't be read.
pub fn prepare(
    subject: &Subject,
    tolerance: f64,
    integration: Integration,
    monitor: &Monitor,
) -> Result<Option<Prepared>, Error> {
    if subject.scene.compatibility == Compatibility::Weak {
        return Err(Error::described(
            "compatibility",
            "is \"weak\", whose interface forces are coordinates that can't be left out; prepare the scene with \"strong\" or \"static\"",
        ));
    }
    let whole = NarrowedScene::from(subject.own.applied_to(subject)?);
    let scene = &whole.scene;
    // Every time of comparison is the end of a step.
    let apart = match subject.own.fineness {
        Fineness::Step(step) => f64::from(integration::LONGEST) * step,
        Fineness::Accuracy(_) => interval(subject.end),
    };
    let grid = Grid::of([apart], subject.end);
    monitor.tell("everything");
    monitor.expect(motion::steps_of(scene)?);
    let mut unseen = |_: &_| {};
    let followed = motion::follow_to_the_end(subject, &whole, grid, monitor, &mut unseen)?;
    let (reference, expected) = unless_stopped!(followed);
    let trials = Trials {
        subject,
        grid,
        expected: &expected,
        monitor,
        made: Cell::new(1),
    };
    let limit = SHARE * tolerance;
    let open = SuperelementFiles::default();
    let (pruning, mut start) =
        unless_stopped!(first_good_enough(&trials, scene, &open, tolerance)?);
    if integration == Integration::Adapted {
        let coarser = trials.coarsest_iteration(start, ITERATION * tolerance)?;
        start = unless_stopped!(coarser);
    }
    let start = unless_stopped!(trials.simplest_inertia(start, INERTIA * tolerance)?);
    let starts = match integration {
        Integration::OfScene => vec![start],
        Integration::Adapted => unless_stopped!(adapted(&trials, start, tolerance)?),
    };
    let (start, found) = unless_stopped!(cheapest(&trials, &starts, limit)?);
    Ok(Some(Prepared {
        narrowed: start.with(&found.chosen)?,
        coordinates: found.coordinates,
        pruning,
        error: found.error,
        trials: found.trials,
        runs: trials.made.get(),
        reference,
    }))
}

/// The first of these with which the outputs are within the tolerance: what the scene needs of the superelements without their Krylov columns,
/// what it needs of all of them, everything. `None` if the user stopped it.
fn first_good_enough(
    trials: &Trials,
    scene: &Scene,
    open: &SuperelementFiles,
    tolerance: f64,
) -> Result<Option<(Pruning, Start)>, Error> {
    let (pruned, limit) = (PRUNED * tolerance, SHARE * tolerance);
    if let Some(pruning) = Pruning::without_krylov_columns(scene, open, pruned)? {
        let start = unless_stopped!(trials.start(scene, &pruning)?);
        if start.run.error <= limit {
            return Ok(Some((pruning, start)));
        }
    }
    let pruning = Pruning::of(scene, open, pruned)?;
    let start = unless_stopped!(trials.start(scene, &pruning)?);
    if start.run.error <= limit {
        return Ok(Some((pruning, start)));
    }
    let pruning = Pruning::nothing(scene, open)?;
    let start = unless_stopped!(trials.start(scene, &pruning)?);
    Ok(Some((pruning, start)))
}

/// The scene as it is integrated, with the longest steps that are good enough, and by radau. `None` if the user stopped it.
fn adapted(trials: &Trials, start: Start, tolerance: f64) -> Result<Option<Vec<Start>>, Error> {
    let limit = SHARE * tolerance;
    let by_accuracy = unless_stopped!(trials.by_accuracy(&start, tolerance, limit)?);
    let mut starts = unless_stopped!(trials.longer_steps(start, limit)?);
    starts = starts.split_off(starts.len().saturating_sub(LONGEST_TRIED));
    starts.extend(by_accuracy);
    Ok(Some(starts))
}

/// The start and the coordinates with which a run takes the least time.
/// `None` if the user stopped it.
fn cheapest<'a>(
    trials: &Trials,
    starts: &'a [Start],
    limit: f64,
) -> Result<Option<(&'a Start, Found)>, Error> {
    let mut best: Option<(&Start, Found)> = None;
    for start in starts.iter().rev() {
        let found = unless_stopped!(trials.fewest(start, limit)?);
        let work = start.work(found.coordinates);
        if !(best.as_ref()).is_some_and(|(start, best)| start.work(best.coordinates) <= work) {
            best = Some((start, found));
        }
    }
    Ok(best)
}
