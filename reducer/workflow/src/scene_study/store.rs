//! The folder of a study: what is known already, and where the rest goes.
//!
//! `rows.jsonl` has what each run told, a line as soon as it is known; `histories/NAME.h5` has its values at the times of
//! comparison, in the format of results. Both are there before the next run begins, so a study that was stopped goes on.

use std::path::{Path, PathBuf};

use dcb_formats::component::Source;
use dcb_formats::output::{Replace, remove_leftovers};
use dcb_formats::results::{Channel, Column, Header, Outcome, Results, ResultsWriter};
use dcb_report::{Ledger, Start};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::grid::{Grid, Trace};
use super::motion::{Course, Timing};
use super::reference::SceneReference;
use super::setting::Setting;
use super::subject::{Quantity, Subject};
use dcb_runtime::error::Error;
use dcb_runtime::model::LoadedFile;

/// Content of a line of `rows.jsonl`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum SceneEntry {
    Reference(SceneReference),
    Course(Course),
    Timing(Timing),
}

/// The folder of a study.
pub struct Store {
    folder: PathBuf,
    ledger: Ledger<SceneEntry>,
    grid: Grid,
}

impl Store {
    /// Opens the folder, or makes it. What it has is kept if it is of the same scene, superelements, program and reference.
    ///
    /// # Errors
    /// [`Error::File`] if it is a folder of something else, or of a study of something else and `start` wants to go on with it.
    pub fn open(
        folder: &Path,
        subject: &Subject,
        first: &Setting,
        grid: Grid,
        start: Start,
    ) -> Result<Self, Error> {
        let path = folder.join("rows.jsonl");
        let refused = |message: &str| {
            Err(Error::File(dcb_formats::Error::File {
                path: folder.to_owned(),
                message: message.to_owned(),
            }))
        };
        if folder.exists() && !folder.is_dir() {
            return refused("is there already and is no folder; name another one with --output");
        }
        remove_leftovers(&path);
        let is_empty = std::fs::read_dir(folder).is_ok_and(|mut files| files.next().is_none());
        if folder.is_dir() && !is_empty && !path.is_file() {
            return refused("is there already and holds no study; name another one with --output");
        }
        let histories = folder.join("histories");
        std::fs::create_dir_all(&histories).map_err(|source| Error::CannotWrite {
            path: histories,
            source,
        })?;
        let settings = settings(subject, first, grid);
        Ok(Self {
            folder: folder.to_owned(),
            ledger: Ledger::open(&path, "motion", &settings, start)?,
            grid,
        })
    }

    /// A file in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// The reference, if it has been made.
    pub fn reference(&self, subject: &Subject) -> Option<(SceneReference, Trace)> {
        match self.ledger.row("reference") {
            Some(SceneEntry::Reference(reference)) => {
                Some((reference.clone(), self.history(subject, "reference")?))
            }
            _ => None,
        }
    }

    /// How a run of these options went, if it was made.
    pub fn course(&self, subject: &Subject, setting: &Setting) -> Option<(Course, Trace)> {
        let key = setting.key();
        match self.ledger.row(&format!("course {key}")) {
            Some(SceneEntry::Course(course)) => {
                Some((course.clone(), self.history(subject, &file_name(&key))?))
            }
            _ => None,
        }
    }

    /// Time of a run with these options, if it was measured.
    pub fn timing(&self, setting: &Setting) -> Option<Timing> {
        match self.ledger.row(&timing_key(setting)) {
            Some(SceneEntry::Timing(timing)) => Some(*timing),
            _ => None,
        }
    }

    /// Reads what other processes have added.
    pub(super) fn refresh(&mut self) -> Result<(), Error> {
        Ok(self.ledger.refresh()?)
    }

    /// Keeps the reference.
    pub(super) fn keep_reference(
        &mut self,
        subject: &Subject,
        reference: &SceneReference,
        trace: &Trace,
    ) -> Result<(), Error> {
        self.write(
            subject,
            "reference",
            &reference.setting,
            &reference.course,
            trace,
        )?;
        let entry = SceneEntry::Reference(reference.clone());
        Ok(self.ledger.add("reference", entry)?)
    }

    /// Keeps how a run went.
    pub(super) fn keep_course(
        &mut self,
        subject: &Subject,
        setting: &Setting,
        course: &Course,
        trace: &Trace,
    ) -> Result<(), Error> {
        let key = setting.key();
        self.write(subject, &file_name(&key), setting, course, trace)?;
        let entry = SceneEntry::Course(course.clone());
        Ok(self.ledger.add(&format!("course {key}"), entry)?)
    }

    /// Keeps what a run takes.
    pub(super) fn keep_timing(&mut self, setting: &Setting, timing: Timing) -> Result<(), Error> {
        let key = timing_key(setting);
        Ok(self.ledger.add(&key, SceneEntry::Timing(timing))?)
    }

    /// Writes the values of a run as a results file.
    fn write(
        &self,
        subject: &Subject,
        name: &str,
        setting: &Setting,
        course: &Course,
        trace: &Trace,
    ) -> Result<(), Error> {
        let input = |file: &LoadedFile| Source {
            role: "superelement".into(),
            file_name: file_of(&file.path),
            sha256: file.digest.clone(),
        };
        let header = Header {
            units: subject.scene.units.clone(),
            generator: generator(),
            scene: serde_json::to_value(&subject.scene).unwrap_or_default(),
            inputs: subject.files.iter().map(input).collect(),
            options: setting.in_scene(subject),
            warnings: course.warnings.clone(),
        };
        let channels: Vec<Channel> = subject.quantities.iter().map(channel).collect();
        let path = self.history_path(name);
        let mut writer = ResultsWriter::create(&path, &channels, &header, Replace::Overwrite)?;
        for index in 0..trace.len() {
            if let Some(row) = trace.row(index) {
                writer.append(self.grid.time(index), row)?;
            }
        }
        let outcome = match &course.stopped {
            None => Outcome::Complete,
            Some(reason) => Outcome::Stopped {
                reason: reason.clone(),
                time: (trace.len().checked_sub(1)).map(|last| self.grid.time(last)),
            },
        };
        let summary = serde_json::to_value(course).unwrap_or_default();
        Ok(writer.finish(&outcome, &summary)?)
    }

    /// The values of a run; `None` if the file isn't there or can't be read: the run is made again.
    fn history(&self, subject: &Subject, name: &str) -> Option<Trace> {
        let results = Results::open(self.history_path(name)).ok()?;
        let histories = subject.quantities.iter();
        let histories: Option<Vec<_>> = histories
            .map(|quantity| results.history(&channel(quantity).path).ok())
            .collect();
        let histories = histories?;
        let mut trace = Trace {
            width: histories.iter().map(|history| history.ncols()).sum(),
            values: Vec::new(),
        };
        for index in 0..results.step_count() {
            for history in &histories {
                trace.values.extend(history.row(index).iter());
            }
        }
        Some(trace)
    }

    fn history_path(&self, name: &str) -> PathBuf {
        self.folder.join("histories").join(format!("{name}.h5"))
    }
}

/// Program and version.
pub fn generator() -> String {
    concat!("dcb simulate ", env!("CARGO_PKG_VERSION")).into()
}

/// Properties that all rows share.
fn settings(subject: &Subject, first: &Setting, grid: Grid) -> Value {
    let files: Vec<Value> = (subject.files.iter())
        .map(|file| json!({"file": file_of(&file.path), "digest": file.digest}))
        .collect();
    let quantities = subject.quantities.iter().map(|quantity| &quantity.name);
    // The first difference is told, in alphabetical order: the step that was asked for before what follows from it.
    json!({
        (format!("finest {}", first.fineness.name())): first.fineness.coarser().value(),
        "program": generator(),
        "scene": subject.scene,
        "superelements": files,
        "outputs": quantities.collect::<Vec<_>>(),
        "times": {"spacing": grid.spacing, "count": grid.count},
        "reference": first,
    })
}

/// Where the folder of the scene is doesn't matter.
fn file_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

fn timing_key(setting: &Setting) -> String {
    format!("timing {}", setting.key())
}

/// A key as the name of a file.
fn file_name(key: &str) -> String {
    key.replace('/', "_")
}

/// A quantity as a channel among the outputs.
fn channel(quantity: &Quantity) -> Channel {
    let column = |label: &String| Column {
        name: label.clone(),
        unit: quantity.unit.clone(),
    };
    Channel {
        path: format!("outputs/{}", quantity.name.replace('/', ".")),
        columns: quantity.labels.iter().map(column).collect(),
        description: format!("{} at the times of comparison", quantity.path),
    }
}
