//! A whole run: a scene to a results file.
//!
//! [`run`] does what the scene's `analysis` says: motion over time ([`transient`]), or a rest, a motion that the drives fix, or small
//! oscillations (`analyses`). Whatever stops a run, its file holds what was reached.

pub(crate) mod analyses;
mod start;
pub mod transient;

use std::path::{Path, PathBuf};

use dcb_formats::component::Source;
use dcb_formats::output::{Replace, is_same_file};
use dcb_formats::results::{Header, Outcome, ResultsWriter};
use serde_json::{Value, json};

use crate::analysis::inertia_relief::InertiaReliefReport;
use crate::error::Error;
use crate::frequency::FrequencyReport;
use crate::integrator::radau::{Accuracy, Stages};
use crate::integrator::{self, Method, Rule, Tolerance};
use crate::model::{FieldFolders, FieldWriter, LoadedFile, Model, RecordedStep, Recorder};
use crate::simulation::Senses;
use crate::system::{State, System};
use crate::watch::applicability::Scope;
pub use analyses::{DrivenReport, ModesReport, RestReport};
use dcb_formats::scene::Scheme;
use dcb_formats::scene::{self, Analysis, Integrator, Scene};
use start::tell_start;
pub use start::{check_gaps, start_notes};
pub use transient::RunReport;

/// Who watches a run.
pub trait Observer {
    /// Something worth telling, at a time of the motion.
    fn note(&mut self, time: f64, message: &str);
    /// The motion has come this far of its end.
    fn progress(&mut self, time: f64, end: f64);
    /// Whether the run is to stop.
    fn is_stopped(&self) -> bool;
    /// Why the run is to stop, for the record in its results.
    fn stop_reason(&self) -> &'static str {
        "interrupted"
    }
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
    /// Treatment of a file that exists.
    pub replace: Replace,
    /// Folder in which the scene may write fields, beside its own and that of the results.
    pub fields_in: Option<PathBuf>,
    /// Files that fields must not replace, beside superelements and results: the scene, a table.
    pub kept: Vec<PathBuf>,
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

/// Results of a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Report {
    /// Motion over time.
    Transient(RunReport),
    /// A rest.
    Static(RestReport),
    /// A rest in an accelerated frame.
    InertiaRelief(InertiaReliefReport),
    /// The motion that the drives fix.
    Kinematic(DrivenReport),
    /// Small oscillations.
    Modes(ModesReport),
    /// Oscillations under oscillating inputs.
    Frequency(FrequencyReport),
}

impl Report {
    /// Whether the whole job was done; else it was interrupted.
    pub fn is_complete(&self) -> bool {
        match self {
            Self::Transient(report) => report.is_complete,
            Self::Kinematic(report) => report.is_complete,
            Self::Static(_) | Self::InertiaRelief(_) | Self::Modes(_) | Self::Frequency(_) => true,
        }
    }
}

/// Does what the scene asks for, and records it.
///
/// # Errors
/// [`Error::File`] where results can't be written; whatever stops the analysis: the results file then holds everything
/// before it and says so.
pub fn run(
    scene: &Scene,
    model: Model,
    target: &Target,
    observer: &mut dyn Observer,
) -> Result<Report, Error> {
    match &scene.analysis {
        Analysis::Transient => {
            transient::transient(scene, model, target, observer).map(Report::Transient)
        }
        Analysis::Static => analyses::rest(scene, model, target, observer).map(Report::Static),
        Analysis::InertiaRelief => {
            analyses::accelerated_rest(scene, model, target, observer).map(Report::InertiaRelief)
        }
        Analysis::Kinematic => {
            analyses::driven(scene, model, target, observer).map(Report::Kinematic)
        }
        Analysis::Modes(asked) => {
            analyses::modes(scene, model, target, observer, asked).map(Report::Modes)
        }
        Analysis::FrequencyResponse(asked) => {
            analyses::frequency(scene, model, target, observer, asked).map(Report::Frequency)
        }
    }
}

/// How a scene's integrator advances.
pub fn rule(integrator: &Integrator) -> Rule {
    let stages = |order| match order {
        9 => Stages::Five,
        _ => Stages::Three,
    };
    let scheme = match integrator.method {
        scene::Method::Radau { order, .. } => {
            return Rule::Radau(Accuracy {
                tolerance: integrator.tolerance,
                of_forces: integrator.force_tolerance().unwrap_or(f64::INFINITY),
                stages: stages(order),
                longest: integrator.step,
                horizon: integrator.end,
            });
        }
        scene::Method::GeneralizedAlpha { rho_infinity } => Scheme::generalized_alpha(rho_infinity),
        scene::Method::Hht { alpha } => Scheme::hht(alpha),
    };
    Rule::GeneralizedAlpha(Method {
        scheme,
        formulation: match integrator.formulation {
            scene::Formulation::Index3 => integrator::Formulation::Index3,
            scene::Formulation::StabilizedIndex2 => integrator::Formulation::StabilizedIndex2,
        },
        tolerance: Tolerance {
            relative: integrator.tolerance,
            max_iterations: integrator.max_iterations as usize,
        },
    })
}

/// A file that is read can't be written.
///
/// # Errors
/// [`Error::WouldDestroyInput`] if `target` is one of the inputs, under whatever path, through symbolic and hard links.
pub fn refuse_inputs<'a>(
    target: &Path,
    inputs: impl IntoIterator<Item = &'a Path>,
    role: &'static str,
) -> Result<(), Error> {
    let mut inputs = inputs.into_iter();
    match inputs.any(|input| is_same_file(input, target)) {
        false => Ok(()),
        true => Err(Error::WouldDestroyInput {
            path: target.canonicalize().unwrap_or(target.to_owned()),
            role,
        }),
    }
}

fn stopped(reason: &str, time: Option<f64>) -> Outcome {
    Outcome::Stopped {
        reason: reason.to_owned(),
        time,
    }
}

/// Header of the file.
fn header(scene: &Scene, model: &Model, target: &Target) -> Header {
    let input = |file: &LoadedFile| Source {
        role: "superelement".into(),
        file_name: file_name(&file.path),
        sha256: file.digest.clone(),
    };
    let mut options = target.options.clone();
    if let Some(options) = options.as_object_mut() {
        let stiffened: Vec<&str> = stiffened(model).collect();
        options.insert("geometric_stiffening".into(), json!(stiffened));
    }
    Header {
        units: scene.units.clone(),
        generator: concat!("dcb simulate ", env!("CARGO_PKG_VERSION")).into(),
        scene: serde_json::to_value(scene).unwrap_or_default(),
        inputs: model.files.iter().map(input).collect(),
        options,
        warnings: model.notes.clone(),
    }
}

/// The bodies whose geometric stiffening acts.
pub fn stiffened(model: &Model) -> impl Iterator<Item = &str> {
    let bodies = model.system.bodies.iter();
    bodies
        .filter(|body| body.flexible.is_stiffened())
        .map(|body| body.name.as_str())
}

fn file_name(path: &Path) -> String {
    path.file_name()
        .map(|name| name.to_string_lossy().into_owned())
        .unwrap_or_default()
}

/// A results file being written, and what writes into it.
struct Session {
    recorder: Recorder,
    fields: Vec<FieldWriter>,
    writer: ResultsWriter,
    scope: Scope,
}

/// Rest of a model when its session is open.
struct Opened {
    session: Session,
    system: System,
    drawn: State,
    held: Vec<usize>,
    senses: Option<Senses>,
}

impl Session {
    /// Makes the results file and the folders of the fields.
    fn open(scene: &Scene, model: Model, target: &Target) -> Result<Opened, Error> {
        let superelements = model.files.iter().map(|file| file.path.as_path());
        refuse_inputs(
            &target.path,
            superelements.clone(),
            "a superelement of the scene",
        )?;
        let rules = FieldFolders {
            within: [
                Some(scene.directory.as_path()),
                target.path.parent(),
                target.fields_in.as_deref(),
            ]
            .into_iter()
            .flatten()
            .collect(),
            replace: target.replace,
            others: superelements
                .chain(target.kept.iter().map(PathBuf::as_path))
                .chain([target.path.as_path()])
                .collect(),
        };
        let folders = rules.make(&model.fields)?;
        let header = header(scene, &model, target);
        let Model {
            system,
            drawn,
            recorder,
            fields,
            held,
            senses,
            ..
        } = model;
        let fields: Result<Vec<_>, _> = (fields.into_iter().zip(&folders))
            .map(|(plan, folder)| FieldWriter::start(plan, folder, target.replace))
            .collect();
        let fields = fields?;
        let channels = recorder.channels();
        let writer = ResultsWriter::create(&target.path, channels, &header, target.replace)?;
        Ok(Opened {
            session: Self {
                recorder,
                fields,
                writer,
                scope: Scope::of(&system),
            },
            system,
            drawn,
            held,
            senses,
        })
    }

    /// Records a step.
    fn record(&mut self, step: &RecordedStep) -> Result<(), Error> {
        self.scope
            .observe_forces(step.system, step.state, step.evaluation);
        let row = self.recorder.row(step);
        self.writer.append(step.state.time, row)?;
        Ok(())
    }

    /// Tells somebody, and the file.
    fn tell(&mut self, observer: &mut dyn Observer, time: f64, message: &str) {
        observer.note(time, message);
        self.writer.note(time, message);
    }

    /// Tells what went beyond that for which the superelements were made.
    fn tell_scope(&mut self, system: &System, observer: &mut dyn Observer) {
        for found in self.scope.found(system) {
            self.tell(observer, found.time, &found.message);
        }
    }

    /// Closes the file with how it ended.
    fn close<T>(
        self,
        observer: &dyn Observer,
        result: Result<T, Error>,
        ending: &Ending,
        summary: &Value,
    ) -> Result<T, Error> {
        let outcome = match (&result, ending.is_complete) {
            (Ok(_), true) => Outcome::Complete,
            (Ok(_), false) => stopped(observer.stop_reason(), ending.time),
            (Err(error), _) => stopped(&error.to_string(), ending.time),
        };
        let finished = self.writer.finish(&outcome, summary);
        // What went wrong first is what must be told.
        let result = result?;
        finished?;
        Ok(result)
    }
}

/// How a session ended.
struct Ending {
    is_complete: bool,
    /// Last time that was reached, if any.
    time: Option<f64>,
}
