//! Runs with fewer coordinates and simpler inertia, compared with the run with everything.

use std::cell::Cell;

use super::activity::Activity;
use super::ranking::{Coordinate, Flexible, Ranking};
use crate::error::Error;
use crate::fewest::{Trial, fewest};
use crate::model::Model;
use crate::pruning::{Carried, Pruning};
use crate::scene::{BodyKind, InertiaChange, Scene};
use crate::simulation::Simulation;
use crate::study::Subject;
use crate::study::comparison::{Distance, places, scale};
use crate::study::grid::{Grid, Trace};
use crate::study::monitor::Monitor;
use crate::study::motion;

/// So small a part of the coordinates isn't worth another run.
const PRECISION: f64 = 0.03;

/// What runs are compared with.
pub(super) struct Trials<'a> {
    pub subject: &'a Subject,
    pub grid: Grid,
    pub expected: &'a Trace,
    pub monitor: &'a Monitor,
    /// Runs made.
    pub made: Cell<usize>,
}

/// The run from which coordinates are left out.
#[derive(Clone)]
pub(super) struct Start {
    pub scene: Scene,
    bodies: Vec<Flexible>,
    ranking: Ranking,
    /// What a step takes beside what elastic coordinates take, in coordinates.
    overhead: f64,
    /// Its error.
    pub error: f64,
}

/// What a rigid freedom or a row takes in a step, in elastic coordinates. Seen on mechanisms of three and six bodies in space: as much as 90 coordinates for
/// 36 freedoms and rows, and as 104 for 72.
const RIGID: f64 = 2.0;

/// Coordinates that are enough.
pub(super) struct Found {
    pub chosen: Ranking,
    /// Elastic coordinates with them.
    pub coordinates: usize,
    /// The error with them.
    pub error: f64,
    /// What was tried.
    pub trials: Vec<Trial>,
}

impl Trials<'_> {
    /// Runs a scene and ranks its coordinates. `None` if the user stopped it.
    pub fn start(&self, scene: &Scene, pruning: &Pruning) -> Result<Option<Start>, Error> {
        let scene = &pruning.applied_to(scene);
        let model = Model::load(scene)?;
        let bodies = flexible(scene, pruning, &model);
        let system = &model.system;
        let rigid = system.freedom_count() - system.coordinate_count() + system.rows.len();
        let mut activity = Activity::default();
        let mut watch = |simulation: &Simulation| activity.watch(simulation);
        let error = self.error(scene, coordinates(&bodies), &mut watch)?;
        Ok(error.map(|error| Start {
            ranking: Ranking::of(&bodies, &activity),
            scene: scene.clone(),
            bodies,
            overhead: RIGID * rigid as f64,
            error,
        }))
    }

    /// The same with an inertia that follows the deflection no further than the outputs need: that of all bodies, or else of one after the
    /// other. `None` if the user stopped it.
    pub fn simplest_inertia(
        &self,
        mut start: Start,
        tolerance: f64,
    ) -> Result<Option<Start>, Error> {
        let each: Vec<usize> = (0..start.bodies.len()).collect();
        let groups = std::iter::once(&each[..]).chain(each.chunks(1));
        for places in groups {
            for change in [InertiaChange::Constant, InertiaChange::FirstOrder] {
                let Some(scene) = start.with_inertia(places, change) else {
                    continue;
                };
                match self.error_with_all(&start, &scene)? {
                    None => return Ok(None),
                    Some(error) if error <= tolerance => {
                        (start.scene, start.error) = (scene, error);
                        break;
                    }
                    Some(_) => {}
                }
            }
        }
        Ok(Some(start))
    }

    /// The fewest coordinates in the order of the ranking, then the fewest attachments and the fewest modes among them.
    /// `None` if the user stopped it.
    pub fn fewest(&self, start: &Start, tolerance: f64) -> Result<Option<Found>, Error> {
        let (mut chosen, mut error) = (start.ranking.clone(), start.error);
        let mut trials = Vec::new();
        let any = |_: Coordinate| true;
        let attachment = |coordinate: Coordinate| coordinate == Coordinate::Attachment;
        let mode = |coordinate: Coordinate| coordinate != Coordinate::Attachment;
        let kinds: [&dyn Fn(Coordinate) -> bool; 3] = [&any, &attachment, &mode];
        for is_of_kind in kinds {
            let candidate = |count: usize| chosen.with_first(count, is_of_kind);
            let others = start.bound() + chosen.order.len() - chosen.count(is_of_kind);
            let searched = fewest(
                chosen.count(is_of_kind),
                error,
                tolerance,
                PRECISION,
                |count| {
                    let scene = start.with(&candidate(count))?;
                    self.error(&scene, others + count, &mut |_| {})
                },
            )?;
            let Some(searched) = searched else {
                return Ok(None);
            };
            let best = candidate(searched.best.kept);
            error = searched.best.error;
            trials.extend(searched.trials.iter().map(|trial| Trial {
                kept: trial.kept + others,
                ..*trial
            }));
            chosen = best;
        }
        Ok(Some(Found {
            coordinates: start.bound() + chosen.order.len(),
            chosen,
            error,
            trials,
        }))
    }

    /// The error of a scene with all coordinates of a start. `None` if the user stopped it.
    pub fn error_with_all(&self, start: &Start, scene: &Scene) -> Result<Option<f64>, Error> {
        self.error(scene, coordinates(&start.bodies), &mut |_| {})
    }

    /// Largest distance of an output from the run with everything, relative to its range there; infinite where the run doesn't come to
    /// its end. `None` if the user stopped it.
    fn error(
        &self,
        scene: &Scene,
        coordinates: usize,
        watch: &mut dyn FnMut(&Simulation),
    ) -> Result<Option<f64>, Error> {
        self.made.set(self.made.get() + 1);
        self.monitor.tell(&format!("{coordinates} coordinates"));
        self.monitor.expect(motion::steps_of(scene)?);
        let made = motion::follow(self.subject, scene, self.grid, self.monitor, watch)?;
        let Some((course, trace)) = made else {
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

impl Start {
    /// The same coordinates in another scene, with its error.
    pub fn of(&self, scene: Scene, error: f64) -> Self {
        Self {
            scene,
            error,
            ..self.clone()
        }
    }

    /// How much a run of given length takes with so many elastic coordinates, in an arbitrary unit.
    pub fn work(&self, coordinates: usize) -> f64 {
        let step = self
            .scene
            .integrator
            .map_or(1.0, |integrator| integrator.step);
        (self.overhead + coordinates as f64) / step
    }

    /// Coordinates that have to stay whatever is chosen.
    fn bound(&self) -> usize {
        let bound = self.bodies.iter().filter(|body| body.has_bound_modes);
        bound.map(|body| body.modes).sum()
    }

    /// The scene with the inertia of some bodies, by their places, following the deflection to this order; `None` if it goes no further in any
    /// of them.
    fn with_inertia(&self, places: &[usize], change: InertiaChange) -> Option<Scene> {
        let mut scene = self.scene.clone();
        let mut is_simpler = false;
        for body in places.iter().map(|place| &self.bodies[*place]) {
            let described = scene.bodies.get_index_mut(body.index);
            if let Some(BodyKind::Superelement(of)) =
                described.map(|(_, described)| &mut described.kind)
                && !body.is_stiffened
                && of.inertia_change as u8 > change as u8
            {
                of.inertia_change = change;
                is_simpler = true;
            }
        }
        is_simpler.then_some(scene)
    }

    /// The scene with these coordinates only.
    pub fn with(&self, chosen: &Ranking) -> Result<Scene, Error> {
        let mut scene = self.scene.clone();
        for (place, body) in self.bodies.iter().enumerate() {
            let (modes, attachments) = chosen.of_body(place);
            let Some((_, described)) = scene.bodies.get_index_mut(body.index) else {
                continue;
            };
            if let BodyKind::Superelement(of) = &mut described.kind
                && let Some(Carried::Selection(selection)) = &of.carried
            {
                let all = selection.modes();
                let fewer = match body.has_bound_modes {
                    true => (**selection).clone(),
                    false => {
                        let kept = modes.into_iter().map(|mode| all[mode]);
                        (**selection).clone().with_modes(kept)?
                    }
                };
                of.carried = Some(Carried::Selection(Box::new(
                    fewer.with_attachments(attachments),
                )));
            }
        }
        Ok(scene)
    }
}

fn coordinates(bodies: &[Flexible]) -> usize {
    let of = |body: &Flexible| body.modes + body.attachments;
    bodies.iter().map(of).sum()
}

/// Bodies of a scene that deflect.
fn flexible(scene: &Scene, pruning: &Pruning, model: &Model) -> Vec<Flexible> {
    let bodies = scene.bodies.iter().zip(&model.system.bodies).enumerate();
    let selected = bodies.filter(|(_, ((_, described), _))| match &described.kind {
        BodyKind::Superelement(of) => matches!(of.carried, Some(Carried::Selection(_))),
        BodyKind::Rigid(_) => false,
    });
    selected
        .map(|(index, ((name, _), body))| Flexible {
            name: name.clone(),
            index,
            modes: body.flexible.mode_count,
            has_bound_modes: (pruning.bodies.get(name))
                .is_some_and(|pruned| pruned.has_bound_modes),
            attachments: body.flexible.displacement_count() - body.flexible.mode_count,
            is_stiffened: body.flexible.is_stiffened(),
        })
        .collect()
}
