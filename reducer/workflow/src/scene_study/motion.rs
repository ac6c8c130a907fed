//! One run of a study: once for its values, and by itself for its time.

use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::grid::{Grid, Sampler, Trace};
use super::monitor::Monitor;
use super::subject::{Quantity, Subject};
use dcb_demand::SuperelementFiles;
use dcb_demand::pruning::NarrowedScene;
use dcb_formats::scene::{Compatibility, Integrator, Scene, Scheme};
use dcb_runtime::error::Error;
use dcb_runtime::integrator::Effort;
use dcb_runtime::integrator::equal_steps::EqualSteps;
use dcb_runtime::model::timetable::{Due, Timetable};
use dcb_runtime::model::{Model, RecordedStep, Recorder};
use dcb_runtime::run::rule;
use dcb_runtime::run::transient::{
    Stepping, imbalance_warning, resolution_warning, rounding_warning,
};
use dcb_runtime::simulation::Simulation;
use dcb_runtime::watch::compatibility_window::WeakWindow;
use dcb_runtime::watch::energy_balance::EnergyBalance;
use dcb_runtime::watch::validity::Validity;

/// A timing goes on until this many seconds have been measured,
const LONG_ENOUGH: f64 = 0.3;
/// or this many runs.
const MOST_RUNS: u32 = 5;
/// Steps between two looks at whether to stop.
const STEPS_BETWEEN_LOOKS: u64 = 256;
/// What a run whose steps follow an accuracy counts as in a progress, in steps: they aren't known before.
const STEPS_OF_ACCURACY: u64 = 256;

/// How a run went.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Course {
    /// Dynamic coordinates: rigid motions and deflections of all bodies.
    pub freedoms: usize,
    /// Those among them that are deflections.
    pub elastic: usize,
    /// Constraint and spring rows, one unknown force each.
    pub rows: usize,
    /// Steps made.
    pub steps: u64,
    /// Newton iterations.
    pub iterations: usize,
    /// Largest defect of the energy balance.
    pub energy_defect: f64,
    /// The largest energy that was stored or exchanged; zero where all of it is rounding.
    pub largest_energy: f64,
    /// Notes for the user.
    pub warnings: Vec<String>,
    /// Why the run did not come to its end; `None` if it did.
    pub stopped: Option<String>,
}

/// Effort of an integration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// Wall time of the fastest run, s: steps only.
    pub seconds: f64,
    /// Its steps.
    pub steps: u64,
    /// Runs made.
    pub runs: u32,
}

/// Runs a scene and samples the subject's quantities; `watch` sees every state that is sampled. `None` if the user stopped it.
/// Only failures that don't depend on the options are errors: files that can't be read, memory. Others are told in [`Course::stopped`].
pub fn follow(
    subject: &Subject,
    narrowed: &NarrowedScene,
    grid: Grid,
    monitor: &Monitor,
    watch: &mut dyn FnMut(&Simulation),
) -> Result<Option<(Course, Trace)>, Error> {
    let (mut course, trace, outcome) = attempt(subject, narrowed, grid, monitor, watch)?;
    match outcome {
        Ok(true) => Ok(Some((course, trace))),
        Ok(false) => Ok(None),
        Err(error @ (Error::File(_) | Error::OutOfMemory)) => Err(error),
        Err(error) => {
            course.stopped = Some(error.to_string());
            Ok(Some((course, trace)))
        }
    }
}

/// The same for a run that has to come to its end.
pub fn follow_to_the_end(
    subject: &Subject,
    narrowed: &NarrowedScene,
    grid: Grid,
    monitor: &Monitor,
    watch: &mut dyn FnMut(&Simulation),
) -> Result<Option<(Course, Trace)>, Error> {
    let (course, trace, outcome) = attempt(subject, narrowed, grid, monitor, watch)?;
    Ok(outcome?.then_some((course, trace)))
}

/// Course and trace as far as the run came, and whether that is the end: not if the user or an error stopped it.
fn attempt(
    subject: &Subject,
    narrowed: &NarrowedScene,
    grid: Grid,
    monitor: &Monitor,
    watch: &mut dyn FnMut(&Simulation),
) -> Result<(Course, Trace, Result<bool, Error>), Error> {
    let mut course = Course::default();
    let scene = &narrowed.scene;
    let widths = subject.quantities.iter().map(Quantity::width);
    let width: usize = widths.sum();
    let integrator = integrator_of(scene)?;
    // A motion that follows an accuracy is looked at where the times of the grid are.
    let step = match integrator.is_radau() {
        true => grid.spacing,
        false => integrator.step,
    };
    let mut sampler = Sampler::new(grid, step, width);
    let mut progress = Progress {
        monitor,
        expected: steps_of(scene)?,
        told: 0,
    };
    let outcome = begin(narrowed, &mut course).and_then(|(simulation, recorder)| {
        let mut run = TimedRun {
            validity: Validity::of(simulation.system(), simulation.state()),
            balance: EnergyBalance::default(),
            simulation,
            recorder,
            sampled: Sampled {
                places: Vec::with_capacity(width),
                values: Vec::with_capacity(width),
                sampler: &mut sampler,
            },
            course: &mut course,
            progress: &mut progress,
            watch,
        };
        for quantity in &subject.quantities {
            run.sampled.places.extend(quantity.places(&run.recorder)?);
        }
        run.integrate(&scene.units.time, &integrator, grid)
    });
    if !matches!(outcome, Ok(false)) {
        progress.finish();
    }
    Ok((course, sampler.finish(), outcome))
}

/// Measures how long integrating takes, recording nothing; `None` if the user stopped it. Nothing else should run meanwhile.
pub fn time(scene: &Scene, monitor: &Monitor) -> Result<Option<Timing>, Error> {
    let integrator = integrator_of(scene)?;
    let (mut simulation, _) = start(Model::load(scene)?, scene)?;
    let drawn = simulation.save();
    let mut timing = Timing {
        seconds: f64::INFINITY,
        steps: 0,
        runs: 0,
    };
    let mut total = 0.0;
    while timing.runs < MOST_RUNS && (timing.runs == 0 || total < LONG_ENOUGH) {
        simulation.restore(&drawn)?;
        let (before, _) = simulation.effort();
        let clock = Instant::now();
        let mut stepping = Stepping::of(&integrator, simulation.system());
        let mut made: u64 = 0;
        let is_stopped =
            |made: u64| made.is_multiple_of(STEPS_BETWEEN_LOOKS) && monitor.is_stopped();
        while stepping
            .advance(&mut simulation, || is_stopped(made))?
            .is_some()
        {
            made += 1;
        }
        if simulation.state().time < integrator.end {
            return Ok(None);
        }
        let seconds = clock.elapsed().as_secs_f64();
        timing.seconds = timing.seconds.min(seconds);
        // Those of radau are as many as the accuracy needs.
        timing.steps = (simulation.effort().0 - before) as u64;
        timing.runs += 1;
        total += seconds;
    }
    Ok(Some(timing))
}

/// Steps that a run of this scene counts as in a progress.
pub fn steps_of(scene: &Scene) -> Result<u64, Error> {
    let integrator = integrator_of(scene)?;
    Ok(match integrator.is_radau() {
        true => STEPS_OF_ACCURACY,
        false => EqualSteps::new(integrator.step, integrator.end).count(),
    })
}

/// How far a run is, told to a monitor.
struct Progress<'a> {
    monitor: &'a Monitor,
    expected: u64,
    told: u64,
}

impl Progress<'_> {
    fn reach(&mut self, steps: u64) {
        self.monitor.advance(steps.saturating_sub(self.told));
        self.told = self.told.max(steps);
    }

    /// Steps that won't be made count, too.
    fn finish(&mut self) {
        self.reach(self.expected);
    }
}

/// The quantities of rows, sampled.
struct Sampled<'a> {
    /// Where they are in a recorded row.
    places: Vec<usize>,
    values: Vec<f64>,
    sampler: &'a mut Sampler,
}

impl Sampled<'_> {
    fn take(&mut self, time: f64, row: &[f64]) {
        self.values.clear();
        self.values
            .extend(self.places.iter().map(|place| row[*place]));
        self.sampler.take(time, &self.values);
    }
}

/// A run that is sampled.
struct TimedRun<'a, 'm> {
    simulation: Simulation,
    recorder: Recorder,
    validity: Validity,
    balance: EnergyBalance,
    sampled: Sampled<'a>,
    course: &'a mut Course,
    progress: &'a mut Progress<'m>,
    watch: &'a mut dyn FnMut(&Simulation),
}

impl TimedRun<'_, '_> {
    /// Whether the end was reached; else the user stopped it.
    fn integrate(
        &mut self,
        unit_of_time: &str,
        integrator: &Integrator,
        grid: Grid,
    ) -> Result<bool, Error> {
        self.sample()?;
        let is_whole = match integrator.is_radau() {
            true => self.follow_accuracy(integrator.end, grid)?,
            false => self.follow_steps(integrator, grid)?,
        };
        if !is_whole {
            return Ok(false);
        }
        let mean_step = integrator.end / self.course.steps.max(1) as f64;
        let warnings = &mut self.course.warnings;
        warnings.extend(resolution_warning(&self.simulation, unit_of_time));
        warnings.extend(rounding_warning(&self.simulation, mean_step, unit_of_time));
        warnings.extend(imbalance_warning(&self.balance));
        Ok(true)
    }

    /// Equal steps, looked at where times of the grid are, or after each of them.
    fn follow_steps(&mut self, integrator: &Integrator, grid: Grid) -> Result<bool, Error> {
        let stride = grid.steps_between(integrator.step).unwrap_or(1);
        let steps = EqualSteps::new(integrator.step, integrator.end);
        let count = steps.count();
        for index in 1..=count {
            if index % STEPS_BETWEEN_LOOKS == 0 {
                self.progress.reach(index);
                if self.progress.monitor.is_stopped() {
                    return Ok(false);
                }
            }
            let (_, effort) = self.simulation.step_equally(&steps, index)?;
            self.course.steps = index;
            self.course.iterations += effort.iterations;
            if index % stride == 0 || index == count {
                self.sample()?;
            }
        }
        Ok(true)
    }

    /// Steps as long as the accuracy allows, looked at within them.
    fn follow_accuracy(&mut self, end: f64, grid: Grid) -> Result<bool, Error> {
        let mut times = Timetable::every(grid.spacing);
        times.take(0.0);
        while self.simulation.state().time < end {
            if self.progress.monitor.is_stopped() {
                return Ok(false);
            }
            let (step, effort) = self.simulation.step_towards(end)?;
            self.course.steps += 1;
            self.course.iterations += effort.iterations;
            let now = self.simulation.state().time;
            self.progress
                .reach((now / end * STEPS_OF_ACCURACY as f64) as u64);
            while let Some(due) = times.take(now) {
                if let Due::Within(time) = due {
                    let state = self.simulation.look_within(time);
                    let seen = RecordedStep::within(&mut self.simulation, &state, step, effort);
                    let row = self.recorder.row(&seen);
                    self.sampled.take(time, row);
                }
            }
            self.sample()?;
        }
        Ok(true)
    }

    fn sample(&mut self) -> Result<(), Error> {
        let now = RecordedStep::of(&mut self.simulation, 0.0, Effort::default());
        self.balance.look_at(&now);
        // JSON has no infinity.
        self.course.energy_defect = self.balance.defect.min(f64::MAX);
        // Nothing to compare with where all energies are rounding.
        let compared = self.balance.share().map_or(0.0, |_| self.balance.largest);
        self.course.largest_energy = compared.min(f64::MAX);
        self.sampled.take(now.state.time, self.recorder.row(&now));
        let warnings = &mut self.course.warnings;
        self.validity
            .check(now.system, now.state, |message| warnings.push(message))?;
        (self.watch)(&self.simulation);
        Ok(())
    }
}

/// Loads and starts, and notes the size of the system.
fn begin(narrowed: &NarrowedScene, course: &mut Course) -> Result<(Simulation, Recorder), Error> {
    let scene = &narrowed.scene;
    let model = Model::load_narrowed(narrowed, &SuperelementFiles::default())?;
    course.freedoms = model.system.dof_count();
    course.elastic = model.system.coordinate_count();
    course.rows = model.system.rows.len();
    let (simulation, recorder) = start(model, scene)?;
    if scene.compatibility == Compatibility::Weak {
        let integrator = integrator_of(scene)?;
        if let Some(scheme) = Scheme::of(integrator.method) {
            let window = WeakWindow::of(simulation.system(), simulation.state(), &scheme);
            let count = window.negative_eigenvalue_count;
            if count > 0 {
                course.warnings.push(format!(
                    "weak compatibility: {count} negative eigenvalue{}",
                    if count == 1 { "" } else { "s" }
                ));
            }
            if !scene.allow_unstable_weak {
                window.check(integrator.step)?;
            }
        }
    }
    Ok((simulation, recorder))
}

fn start(model: Model, scene: &Scene) -> Result<(Simulation, Recorder), Error> {
    let Model {
        system,
        drawn,
        recorder,
        held,
        ..
    } = model;
    let rule = rule(&integrator_of(scene)?);
    let (simulation, _) =
        Simulation::start_holding(system, drawn, rule, scene.redundant_constraints, &held)?;
    Ok((simulation, recorder))
}

fn integrator_of(scene: &Scene) -> Result<Integrator, Error> {
    scene
        .integrator
        .ok_or_else(|| Error::described("integrator", "is missing"))
}
