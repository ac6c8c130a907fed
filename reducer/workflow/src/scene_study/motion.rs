//! One run of a study: once for its values, and by itself for its time.

use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::grid::{Grid, Sampler, Trace};
use super::monitor::Monitor;
use super::setting::interval;
use super::subject::{Quantity, Subject};
use dcb_demand::SuperelementFiles;
use dcb_demand::pruning::NarrowedScene;
use dcb_formats::scene::{Compatibility, Integrator, Scene, Scheme};
use dcb_runtime::error::Error;
use dcb_runtime::integrator::Effort;
use dcb_runtime::integrator::equal_steps::EqualSteps;
use dcb_runtime::model::{Model, RecordedStep, Recorder};
use dcb_runtime::run::rule;
use dcb_runtime::run::transient::{imbalance_warning, resolution_warning, rounding_warning};
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
            let counted = course.steps / STEPS_BETWEEN_LOOKS * STEPS_BETWEEN_LOOKS;
            monitor.advance(steps_of(&narrowed.scene)? - counted);
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
    let mut sampler = Sampler::new(grid, step_of(scene)?.step, width);
    let outcome = begin(narrowed, &mut course).and_then(|(simulation, recorder)| {
        let mut run = TimedRun {
            validity: Validity::of(simulation.system(), simulation.state()),
            balance: EnergyBalance::default(),
            simulation,
            recorder,
            places: Vec::with_capacity(width),
            values: Vec::with_capacity(width),
            sampler: &mut sampler,
            course: &mut course,
            watch,
        };
        for quantity in &subject.quantities {
            run.places.extend(quantity.places(&run.recorder)?);
        }
        run.integrate(scene, grid, monitor)
    });
    Ok((course, sampler.finish(), outcome))
}

/// Measures how long integrating takes, recording nothing; `None` if the user stopped it. Nothing else should run meanwhile.
pub fn time(scene: &Scene, monitor: &Monitor) -> Result<Option<Timing>, Error> {
    let integrator = step_of(scene)?;
    let steps = equal_steps(&integrator);
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
        for index in 1..=steps.count() {
            simulation.step_equally(&steps, index)?;
            if index % STEPS_BETWEEN_LOOKS == 0 && monitor.is_stopped() {
                return Ok(None);
            }
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

/// Steps that a run of this scene takes.
pub fn steps_of(scene: &Scene) -> Result<u64, Error> {
    Ok(equal_steps(&step_of(scene)?).count())
}

/// A run that is sampled.
struct TimedRun<'a> {
    simulation: Simulation,
    recorder: Recorder,
    validity: Validity,
    balance: EnergyBalance,
    /// Where the quantities are in a recorded row.
    places: Vec<usize>,
    values: Vec<f64>,
    sampler: &'a mut Sampler,
    course: &'a mut Course,
    watch: &'a mut dyn FnMut(&Simulation),
}

impl TimedRun<'_> {
    /// Whether the end was reached; else the user stopped it.
    fn integrate(&mut self, scene: &Scene, grid: Grid, monitor: &Monitor) -> Result<bool, Error> {
        let integrator = step_of(scene)?;
        let stride = grid.steps_between(integrator.step).unwrap_or(1);
        let steps = equal_steps(&integrator);
        let count = steps.count();
        self.sample()?;
        for index in 1..=count {
            if index % STEPS_BETWEEN_LOOKS == 0 {
                monitor.advance(STEPS_BETWEEN_LOOKS);
                if monitor.is_stopped() {
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
        monitor.advance(count % STEPS_BETWEEN_LOOKS);
        let warnings = &mut self.course.warnings;
        warnings.extend(resolution_warning(&self.simulation, &scene.units.time));
        warnings.extend(rounding_warning(
            &self.simulation,
            integrator.step,
            &scene.units.time,
        ));
        warnings.extend(imbalance_warning(&self.balance));
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
        let row = self.recorder.row(&now);
        self.values.clear();
        self.values
            .extend(self.places.iter().map(|place| row[*place]));
        self.sampler.take(now.state.time, &self.values);
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
        let integrator = step_of(scene)?;
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
    let rule = rule(&step_of(scene)?);
    let (simulation, _) =
        Simulation::start_holding(system, drawn, rule, scene.redundant_constraints, &held)?;
    Ok((simulation, recorder))
}

fn step_of(scene: &Scene) -> Result<Integrator, Error> {
    let missing = || Error::described("integrator", "is missing");
    let mut integrator = scene.integrator.ok_or_else(missing)?;
    if integrator.is_radau() {
        integrator.step = interval(integrator.end);
    }
    Ok(integrator)
}

fn equal_steps(integrator: &Integrator) -> EqualSteps {
    EqualSteps::new(integrator.step, integrator.end)
}
