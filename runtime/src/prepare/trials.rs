//! Runs with fewer coordinates, compared with the run with everything.

use super::ranking::{Coordinate, Part, Ranking};
use super::search::{Trial, fewest};
use crate::error::Error;
use crate::scene::{BodyKind, Coordinates, Scene};
use crate::study::Subject;
use crate::study::comparison::{Distance, places, scale};
use crate::study::grid::{Grid, Trace};
use crate::study::monitor::Monitor;
use crate::study::motion;

/// What runs are made of and compared with.
pub(super) struct Trials<'a> {
    pub subject: &'a Subject,
    /// With everything.
    pub scene: &'a Scene,
    pub parts: &'a [Part],
    pub grid: Grid,
    pub expected: &'a Trace,
    pub monitor: &'a Monitor,
}

/// Coordinates that are enough, the error with them, and what was tried.
pub(super) type Found = (Ranking, f64, Vec<Trial>);

impl Trials<'_> {
    /// The fewest coordinates in the order of a ranking, then the fewest attachments and the fewest modes among them.
    /// `None` if the user stopped it.
    pub fn fewest(&self, ranking: &Ranking, tolerance: f64) -> Result<Option<Found>, Error> {
        let (mut chosen, mut error, mut trials) = (ranking.clone(), 0.0, Vec::new());
        let any = |_: Coordinate| true;
        let attachment = |coordinate: Coordinate| coordinate == Coordinate::Attachment;
        let mode = |coordinate: Coordinate| coordinate != Coordinate::Attachment;
        let kinds: [&dyn Fn(Coordinate) -> bool; 3] = [&any, &attachment, &mode];
        for is_of_kind in kinds {
            let candidate = |count: usize| chosen.with_first(count, is_of_kind);
            let searched = fewest(chosen.count(is_of_kind), error, tolerance, |count| {
                self.error(&candidate(count))
            })?;
            let Some(searched) = searched else {
                return Ok(None);
            };
            let best = candidate(searched.best.kept);
            error = searched.best.error;
            let others = chosen.order.len() - chosen.count(is_of_kind);
            trials.extend(searched.trials.iter().map(|trial| Trial {
                kept: trial.kept + others,
                ..*trial
            }));
            chosen = best;
        }
        Ok(Some((chosen, error, trials)))
    }

    /// The scene with these coordinates.
    pub fn with(&self, chosen: &Ranking) -> Scene {
        let mut scene = self.scene.clone();
        for (index, part) in self.parts.iter().enumerate() {
            let (modes, attachments) = chosen.of_part(index);
            for body in &part.bodies {
                let body = scene.bodies.get_index_mut(*body).map(|(_, body)| body);
                if let Some(BodyKind::Superelement(of)) = body.map(|body| &mut body.kind) {
                    of.coordinates = Some(Coordinates {
                        modes: modes.clone(),
                        attachments,
                    });
                }
            }
        }
        scene
    }

    /// Largest distance of an output from the run with everything, relative to its range there; infinite where the run doesn't come to
    /// its end. `None` if the user stopped it.
    fn error(&self, chosen: &Ranking) -> Result<Option<f64>, Error> {
        let scene = self.with(chosen);
        self.monitor
            .tell(&format!("{} coordinates", chosen.order.len()));
        self.monitor.expect(motion::steps_of(&scene)?);
        let Some((course, trace)) = motion::follow(self.subject, &scene, self.grid, self.monitor)?
        else {
            return Ok(None);
        };
        if course.stopped.is_some() {
            return Ok(Some(f64::INFINITY));
        }
        let columns = places(&self.subject.quantities).into_iter();
        let errors = columns.filter_map(|columns| {
            let scale = scale(self.expected, columns.clone())?;
            Some(Distance::between(&trace, self.expected, columns).maximum / scale)
        });
        Ok(Some(errors.fold(0.0, f64::max)))
    }
}
