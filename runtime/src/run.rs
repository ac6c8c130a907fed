//! A whole run: a scene to a results file.

use std::path::{Path, PathBuf};
use std::time::Instant;

use dcb_formats::component::Source;
use dcb_formats::dcb::Replace;
use dcb_formats::results::{Header, Outcome, ResultsWriter};
use serde_json::{Value, json};

use crate::error::Error;
use crate::initial::{InitialReport, Redundancy};
use crate::integrator::newton::{self, Effort, Method, Profile, Tolerance};
use crate::integrator::scheme::Scheme;
use crate::model::{FieldWriter, Model, RecordedStep, Recorder};
use crate::scene::{self, Integrator, Record, RedundantConstraints, Scene};
use crate::simulation::Simulation;
use crate::validity::Validity;

/// Who watches a run.
pub trait Observer {
    /// Something worth telling, at a time of the motion.
    fn note(&mut self, time: f64, message: &str);
    /// The motion has come this far of its end.
    fn progress(&mut self, time: f64, end: f64);
    /// Whether the run is to stop.
    fn is_stopped(&self) -> bool;
}

/// Nobody is watching.
impl Observer for () {
    fn note(&mut self, _: f64, _: &str) {}
    fn progress(&mut self, _: f64, _: f64) {}
    fn is_stopped(&self) -> bool {
        false
    }
}

/// Where the results go.
#[derive(Clone, Debug)]
pub struct Target {
    /// The file.
    pub path: PathBuf,
    /// What happens to one that is there.
    pub replace: Replace,
    /// Options that override the scene, for the record.
    pub options: Value,
    /// Whether to measure where the time goes.
    pub profiling: Profiling,
}

/// Whether to measure where the time goes; the measuring itself takes some.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Profiling {
    /// No.
    #[default]
    Off,
    /// Stage by stage.
    Stages,
}

/// How a run went.
#[derive(Clone, Debug, PartialEq)]
pub struct RunReport {
    /// What was done to make the start consistent.
    pub initial: InitialReport,
    /// Steps.
    pub steps: usize,
    /// What they took.
    pub effort: Effort,
    /// Wall time of the integration, s.
    pub seconds: f64,
    /// Time reached.
    pub time: f64,
    /// Largest defect of the energy balance among the recorded steps, and the largest energy that was stored.
    pub energy_defect: (f64, f64),
    /// Whether the end was reached.
    pub is_complete: bool,
    /// Where the time of the steps went, if it was asked for.
    pub profile: Option<Profile>,
}

/// The method of a scene's integrator.
pub fn method(integrator: &Integrator) -> Method {
    Method {
        scheme: match integrator.method {
            scene::Method::GeneralizedAlpha { rho_infinity } => {
                Scheme::generalized_alpha(rho_infinity)
            }
            scene::Method::Hht { alpha } => Scheme::hht(alpha),
        },
        formulation: match integrator.formulation {
            scene::Formulation::Index3 => newton::Formulation::Index3,
            scene::Formulation::StabilizedIndex2 => newton::Formulation::StabilizedIndex2,
        },
        tolerance: Tolerance {
            relative: integrator.tolerance,
            max_iterations: integrator.max_iterations as usize,
        },
    }
}

/// What a scene says about redundant constraints.
pub fn redundancy(scene: &Scene) -> Redundancy {
    match scene.redundant_constraints {
        RedundantConstraints::MinimumNorm => Redundancy::MinimumNorm,
        RedundantConstraints::Refuse => Redundancy::Refuse,
    }
}

/// Integrates a scene over time and records it.
///
/// # Errors
/// [`Error::File`] where results can't be written; [`Error::Description`] without an integrator; whatever stops the start or a
/// step: the results file then holds every step before it and says so.
pub fn transient(
    scene: &Scene,
    model: Model,
    target: &Target,
    observer: &mut dyn Observer,
) -> Result<RunReport, Error> {
    let integrator = scene
        .integrator
        .ok_or_else(|| Error::described("integrator", "is missing"))?;
    let superelements = model.files.iter().map(|file| file.path.as_path());
    refuse_inputs(&target.path, superelements, "a superelement of the scene")?;
    let header = header(scene, &model, target);
    let Model {
        system,
        drawn,
        mut recorder,
        fields,
        held,
        ..
    } = model;
    let fields: Result<Vec<_>, _> = fields.into_iter().map(FieldWriter::start).collect();
    let fields = fields?;
    let mut writer =
        ResultsWriter::create(&target.path, recorder.channels(), &header, target.replace)?;
    let method = method(&integrator);
    let started = Simulation::start_holding(system, drawn, method, redundancy(scene), &held);
    let (mut simulation, initial) = match started {
        Ok(started) => started,
        Err(error) => {
            let outcome = stopped(&error.to_string(), None);
            writer.finish(&outcome, &json!({}))?;
            return Err(error);
        }
    };
    tell_start(&initial, observer, &mut writer);
    let mut run = Run {
        integrator,
        record: scene.record.unwrap_or(Record::Every(1)),
        recorder: &mut recorder,
        fields,
        writer: &mut writer,
        validity: Validity::of(simulation.system()),
        energy_defect: (0.0, 0.0),
        met_singular: false,
        recorded: 0,
    };
    if target.profiling == Profiling::Stages {
        simulation.start_profile();
    }
    let clock = Instant::now();
    let result = run.integrate(&mut simulation, observer);
    let seconds = clock.elapsed().as_secs_f64();
    let energy_defect = run.energy_defect;
    let (steps, effort) = simulation.effort();
    let time = simulation.state().time;
    let summary = json!({
        "steps": steps,
        "newton_iterations": effort.iterations,
        "jacobian_updates": effort.factorizations,
        "integration_seconds": seconds,
        "energy_defect": energy_defect.0,
        "largest_energy": energy_defect.1,
        "redundant_constraints": initial.redundant.iter().map(|(name, count)| json!({"joint": name, "count": count})).collect::<Vec<_>>(),
    });
    let outcome = match &result {
        Ok(true) => Outcome::Complete,
        Ok(false) => stopped("interrupted", Some(time)),
        Err(error) => stopped(&error.to_string(), Some(time)),
    };
    writer.finish(&outcome, &summary)?;
    let is_complete = result?;
    Ok(RunReport {
        initial,
        steps,
        effort,
        seconds,
        time,
        energy_defect,
        is_complete,
        profile: simulation.profile().copied(),
    })
}

/// A file that is read can't be written.
///
/// # Errors
/// [`Error::WouldDestroyInput`] if `target` is one of the inputs, under whatever path.
pub fn refuse_inputs<'a>(
    target: &Path,
    inputs: impl IntoIterator<Item = &'a Path>,
    role: &'static str,
) -> Result<(), Error> {
    let Ok(target) = target.canonicalize() else {
        // What isn't there can't be lost.
        return Ok(());
    };
    for input in inputs {
        if input.canonicalize().is_ok_and(|input| input == target) {
            return Err(Error::WouldDestroyInput { path: target, role });
        }
    }
    Ok(())
}

fn stopped(reason: &str, time: Option<f64>) -> Outcome {
    Outcome::Stopped {
        reason: reason.to_owned(),
        time,
    }
}

/// What the file says before its first row.
fn header(scene: &Scene, model: &Model, target: &Target) -> Header {
    let input = |file: &crate::model::LoadedFile| Source {
        role: "superelement".into(),
        file_name: file_name(&file.path),
        sha256: file.digest.clone(),
    };
    Header {
        units: scene.units.clone(),
        generator: concat!("dcb simulate ", env!("CARGO_PKG_VERSION")).into(),
        scene: serde_json::to_value(scene).unwrap_or_default(),
        inputs: model.files.iter().map(input).collect(),
        options: target.options.clone(),
        warnings: model.notes.clone(),
    }
}

fn file_name(path: &Path) -> String {
    path.file_name()
        .map(|name| name.to_string_lossy().into_owned())
        .unwrap_or_default()
}

/// What it took to make the start consistent.
fn tell_start(initial: &InitialReport, observer: &mut dyn Observer, writer: &mut ResultsWriter) {
    let mut tell = |message: String| {
        observer.note(0.0, &message);
        writer.note(0.0, &message);
    };
    for moved in &initial.moved {
        tell(format!(
            "assembly moved body {:?} by {:.3e} and turned it by {:.3e} rad",
            moved.body, moved.translation, moved.rotation
        ));
    }
    for (body, energy) in &initial.strained {
        tell(format!(
            "assembly strained body {body:?}: it starts with an elastic energy of {energy:.3e}"
        ));
    }
    for sped in &initial.sped {
        tell(format!(
            "the joints ask for another velocity of body {:?}: changed by {:.3e}, spin by {:.3e}",
            sped.body, sped.translation, sped.rotation
        ));
    }
    for (joint, count) in &initial.redundant {
        let s = if *count == 1 { "" } else { "s" };
        tell(format!(
            "{count} redundant constraint{s} in {joint:?}: its forces are not unique and shared out in the minimum-norm sense"
        ));
    }
}

/// The loop over steps.
struct Run<'a> {
    integrator: Integrator,
    record: Record,
    recorder: &'a mut Recorder,
    fields: Vec<FieldWriter>,
    writer: &'a mut ResultsWriter,
    validity: Validity,
    energy_defect: (f64, f64),
    /// Whether a singular configuration has been told.
    met_singular: bool,
    /// Records so far.
    recorded: u64,
}

impl Run<'_> {
    /// Whether the end was reached.
    fn integrate(
        &mut self,
        simulation: &mut Simulation,
        observer: &mut dyn Observer,
    ) -> Result<bool, Error> {
        let Integrator { step, end, .. } = self.integrator;
        // A remainder below rounding is no step.
        let count = (end / step - 1e-9).ceil().max(0.0) as u64;
        self.write(simulation, Effort::default(), 0.0)?;
        for field in &mut self.fields {
            field.write(simulation.system(), simulation.state(), step)?;
        }
        for index in 1..=count {
            if observer.is_stopped() {
                return Ok(false);
            }
            let step = if index == count {
                end - simulation.state().time
            } else {
                step
            };
            let effort = simulation.step(step)?;
            if simulation.was_singular() && !self.met_singular {
                self.met_singular = true;
                let time = simulation.state().time;
                let message = "passed a singular configuration (dead centre): constraint forces are not unique there";
                observer.note(time, message);
                self.writer.note(time, message);
            }
            for field in &mut self.fields {
                field.write(simulation.system(), simulation.state(), step)?;
            }
            let is_due = match self.record {
                Record::Every(steps) => index.is_multiple_of(u64::from(steps)),
                Record::Interval(interval) => {
                    let due = (self.recorded as f64) * interval;
                    simulation.state().time >= due - 1e-9 * interval
                }
            };
            if is_due || index == count {
                self.write(simulation, effort, step)?;
                observer.progress(simulation.state().time, end);
                let time = simulation.state().time;
                let writer = &mut *self.writer;
                let (system, state) = (simulation.system(), simulation.state());
                self.validity.check(system, state, |message| {
                    observer.note(time, &message);
                    writer.note(time, &message);
                });
            }
        }
        Ok(true)
    }

    fn write(
        &mut self,
        simulation: &mut Simulation,
        effort: Effort,
        step: f64,
    ) -> Result<(), Error> {
        let now = RecordedStep::of(simulation, step, effort);
        let scale = now.energy.kinetic + now.energy.strain + now.energy.springs;
        self.energy_defect.0 = self.energy_defect.0.max(now.defect.abs());
        self.energy_defect.1 = self.energy_defect.1.max(scale);
        let row = self.recorder.row(&now);
        self.writer.append(simulation.state().time, row)?;
        self.recorded += 1;
        Ok(())
    }
}
