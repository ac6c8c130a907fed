//! Runs with fewer coordinates and simpler inertia, compared with the run with everything.

use std::cell::Cell;

use super::activity::Activity;
use super::integration::iteration_cost;
use super::ranking::{Coordinate, Flexible, Ranking};
use crate::scene_study::Subject;
use crate::scene_study::comparison::{Distance, places, scale};
use crate::scene_study::grid::{Grid, Trace};
use crate::scene_study::monitor::Monitor;
use crate::scene_study::motion;
use dcb_demand::SuperelementFiles;
use dcb_demand::coordinate_search::{Trial, fewest};
use dcb_demand::pruning::{Carried, NarrowedScene, Pruning};
use dcb_formats::scene::{BodyKind, InertiaChange, Scene};
use dcb_runtime::error::Error;
use dcb_runtime::model::Model;
use dcb_runtime::simulation::Simulation;

/// So small a part of the coordinates isn't worth another run.
const PRECISION: f64 = 0.03;

/// Reference of the runs.
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
    pub narrowed: NarrowedScene,
    bodies: Vec<Flexible>,
    ranking: Ranking,
    /// Cost of an iteration beside that of elastic coordinates, in coordinates.
    overhead: f64,
    /// How it went.
    pub run: Made,
}

/// How a run went.
#[derive(Clone, Copy, Debug)]
pub(super) struct Made {
    /// Largest distance of an output from the run with everything, relative to its range there; infinite where the run doesn't come to its end.
    pub error: f64,
    /// Newton iterations.
    iterations: usize,
}

/// Cost of a rigid degree of freedom or a row in an iteration, in elastic coordinates. Seen on mechanisms of three and six bodies in space: as much as 90 coordinates for
/// 36 degrees of freedom and rows, and as 104 for 72.
const RIGID: f64 = 2.0;

/// Coordinates that are enough.
pub(super) struct Found {
    pub chosen: Ranking,
    /// Elastic coordinates with them.
    pub coordinates: usize,
    /// The error with them.
    pub error: f64,
    /// Selection that was tried.
    pub trials: Vec<Trial>,
}

impl Trials<'_> {
    /// Runs a scene and ranks its coordinates. `None` if the user stopped it.
    pub fn start(&self, scene: &Scene, pruning: &Pruning) -> Result<Option<Start>, Error> {
        let narrowed = pruning.applied_to(scene);
        let model = Model::load_narrowed(&narrowed, &SuperelementFiles::default())?;
        let bodies = flexible(&narrowed, pruning, &model);
        let system = &model.system;
        let rigid = system.dof_count() - system.coordinate_count() + system.rows.len();
        let mut activity = Activity::default();
        let mut watch = |simulation: &Simulation| activity.watch(simulation);
        let made = self.run(&narrowed, coordinates(&bodies), &mut watch)?;
        Ok(made.map(|run| Start {
            ranking: Ranking::of(&bodies, &activity),
            narrowed,
            bodies,
            overhead: RIGID * rigid as f64,
            run,
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
                let Some(narrowed) = start.with_inertia(places, change) else {
                    continue;
                };
                let run = unless_stopped!(self.run_with_all(&start, &narrowed)?);
                if run.error <= tolerance {
                    (start.narrowed, start.run) = (narrowed, run);
                    break;
                }
            }
        }
        Ok(Some(start))
    }

    /// The fewest coordinates in the order of the ranking, then the fewest attachments and the fewest modes among them.
    /// `None` if the user stopped it.
    pub fn fewest(&self, start: &Start, tolerance: f64) -> Result<Option<Found>, Error> {
        let (mut chosen, mut error) = (start.ranking.clone(), start.run.error);
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
                |count| -> Result<_, Error> {
                    let narrowed = start.with(&candidate(count))?;
                    let made = self.run(&narrowed, others + count, &mut |_| {})?;
                    Ok(made.map(|made| made.error))
                },
            )?;
            let searched = unless_stopped!(searched);
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

    /// A run of a scene with all coordinates of a start. `None` if the user stopped it.
    pub fn run_with_all(
        &self,
        start: &Start,
        narrowed: &NarrowedScene,
    ) -> Result<Option<Made>, Error> {
        self.run(narrowed, coordinates(&start.bodies), &mut |_| {})
    }

    /// A run, compared with that with everything. `None` if the user stopped it.
    fn run(
        &self,
        narrowed: &NarrowedScene,
        coordinates: usize,
        watch: &mut dyn FnMut(&Simulation),
    ) -> Result<Option<Made>, Error> {
        self.made.set(self.made.get() + 1);
        self.monitor.tell(&format!("{coordinates} coordinates"));
        self.monitor.expect(motion::steps_of(&narrowed.scene)?);
        let made = motion::follow(self.subject, narrowed, self.grid, self.monitor, watch)?;
        let (course, trace) = unless_stopped!(made);
        let made = |error: f64| Made {
            error,
            iterations: course.iterations,
        };
        if course.stopped.is_some() {
            return Ok(Some(made(f64::INFINITY)));
        }
        let columns = places(&self.subject.quantities).into_iter();
        let errors = columns.filter_map(|columns| {
            let scale = scale(self.expected, columns.clone())?;
            Some(Distance::between(&trace, self.expected, columns).maximum / scale)
        });
        Ok(Some(made(errors.fold(0.0, f64::max))))
    }
}

impl Start {
    /// The same coordinates in another scene, and how that went.
    pub fn of(&self, narrowed: NarrowedScene, run: Made) -> Self {
        Self {
            narrowed,
            run,
            ..self.clone()
        }
    }

    /// How much a run takes with so many elastic coordinates, in an arbitrary unit.
    pub fn work(&self, coordinates: usize) -> f64 {
        let integrator = self.narrowed.scene.integrator;
        let of_method = integrator.map_or(1.0, |integrator| iteration_cost(integrator.method));
        (self.overhead + coordinates as f64) * of_method * self.run.iterations as f64
    }

    /// Coordinates that have to stay whatever is chosen.
    fn bound(&self) -> usize {
        let bound = self.bodies.iter().filter(|body| body.has_bound_modes);
        bound.map(|body| body.modes).sum()
    }

    /// The scene with the inertia of some bodies, by their places, following the deflection to this order; `None` if it goes no further in any
    /// of them.
    fn with_inertia(&self, places: &[usize], change: InertiaChange) -> Option<NarrowedScene> {
        let mut narrowed = self.narrowed.clone();
        let mut is_simpler = false;
        for body in places.iter().map(|place| &self.bodies[*place]) {
            let described = narrowed.scene.bodies.get_index_mut(body.index);
            if let Some(BodyKind::Superelement(of)) =
                described.map(|(_, described)| &mut described.kind)
                && !body.is_stiffened
                && of.inertia_change as u8 > change as u8
            {
                of.inertia_change = change;
                is_simpler = true;
            }
        }
        is_simpler.then_some(narrowed)
    }

    /// The scene with these coordinates only.
    pub fn with(&self, chosen: &Ranking) -> Result<NarrowedScene, Error> {
        let mut narrowed = self.narrowed.clone();
        for (place, body) in self.bodies.iter().enumerate() {
            let (modes, attachments) = chosen.of_body(place);
            let carried = narrowed.carrying.bodies.get_mut(&body.name);
            if let Some(Carried::Selection(selection)) = carried {
                let fewer = match body.has_bound_modes {
                    true => (**selection).clone(),
                    false => {
                        let kept = modes.into_iter().map(|mode| selection.modes()[mode]);
                        (**selection).clone().with_modes(kept)?
                    }
                };
                **selection = fewer.with_attachments(attachments);
            }
        }
        Ok(narrowed)
    }
}

fn coordinates(bodies: &[Flexible]) -> usize {
    let of = |body: &Flexible| body.modes + body.attachments;
    bodies.iter().map(of).sum()
}

/// Bodies of a scene that deflect.
fn flexible(narrowed: &NarrowedScene, pruning: &Pruning, model: &Model) -> Vec<Flexible> {
    let NarrowedScene { scene, carrying } = narrowed;
    let bodies = scene.bodies.iter().zip(&model.system.bodies).enumerate();
    let selected = bodies.filter(|(_, ((name, _), _))| {
        matches!(carrying.bodies.get(*name), Some(Carried::Selection(_)))
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
