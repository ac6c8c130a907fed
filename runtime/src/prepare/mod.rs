//! The smallest superelements with which a scene's outputs stay within a tolerance, found by running the scene.
//!
//! One run with everything is the reference, at the scene's own step. It says how much each coordinate moves by itself ([`Activity`]);
//! the coordinates are left out in this order, the least active first, as many as the outputs allow. What is left out keeps its
//! flexibility: modes in the attachments, attachments as massless flexibility. Every answer was run; nothing is inferred.

mod activity;
mod ranking;
mod search;
mod trials;


pub use activity::Activity;
pub use ranking::{Coordinate, Part, Ranking};
pub use search::{Searched, Trial, fewest};

use crate::error::Error;
use crate::model::Model;
use crate::scene::{Compatibility, Scene};
use trials::Trials;
use crate::study::Subject;

use crate::study::grid::Grid;
use crate::study::monitor::Monitor;
use crate::study::motion::{self, Course};

/// Part of the tolerance that a search may use: the rest is for what the large superelements themselves are off.
const SHARE: f64 = 0.8;

/// A scene whose superelements were made small.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// The scene with the coordinates chosen.
    pub scene: Scene,
    /// Superelement files by the order of their first bodies.
    pub parts: Vec<Part>,
    /// What is kept of each: modes, and a number of attachments.
    pub kept: Vec<(Vec<usize>, usize)>,
    /// Largest relative distance of an output from the run with everything.
    pub error: f64,
    /// Every number of coordinates that was run, in this order.
    pub trials: Vec<Trial>,
    /// The run with everything.
    pub reference: Course,
}

/// Chooses the coordinates; `None` if the user stopped it.
///
/// # Errors
/// [`Error::Description`] with weak compatibility; what stops the run with everything; files that can't be read.
pub fn prepare(
    subject: &Subject,
    tolerance: f64,
    monitor: &Monitor,
) -> Result<Option<Prepared>, Error> {
    if subject.scene.compatibility == Compatibility::Weak {
        return Err(Error::described(
            "compatibility",
            "is \"weak\", whose interface forces are coordinates that can't be left out; prepare the scene with \"strong\" or \"static\"",
        ));
    }
    let scene = subject.own.applied_to(subject)?;
    let parts = ranking::parts(&scene, &Model::load(&scene)?);
    let grid = Grid::of([subject.own.step], subject.end);
    monitor.tell("everything");
    monitor.expect(motion::steps_of(&scene)?);
    let mut activity = Activity::default();
    let mut watch = |simulation: &_| activity.watch(simulation);
    let Some((reference, expected)) =
        motion::follow_to_the_end(subject, &scene, grid, monitor, &mut watch)?
    else {
        return Ok(None);
    };
    let run = Trials {
        subject,
        scene: &scene,
        parts: &parts,
        grid,
        expected: &expected,
        monitor,
    };
    let Some(found) = run.fewest(&Ranking::of(&parts, &activity), SHARE * tolerance)? else {
        return Ok(None);
    };
    let (chosen, error, trials) = found;
    Ok(Some(Prepared {
        scene: run.with(&chosen),
        kept: (0..parts.len()).map(|part| chosen.of_part(part)).collect(),
        parts,
        error,
        trials,
        reference,
    }))
}
