//! Scenes, and whole runs of them.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use dcb_demand::SuperelementFiles;
use dcb_formats::output::Replace;
use dcb_runtime::run::{self, Observer, Profiling, Target};
use dcb_runtime::{Model, Scene as Description};
use pyo3::prelude::*;
use serde_json::json;

use crate::error::Failure;
use crate::fence::apart;

/// Ctrl-C is looked for so often.
const LOOK: Duration = Duration::from_millis(50);

#[pyclass(frozen, module = "tisserand._native")]
pub struct Scene {
    pub scene: Description,
}

#[pymethods]
impl Scene {
    /// Reads and checks JSON; `path` names it in messages, and relative paths start at its folder.
    #[staticmethod]
    fn parse(py: Python<'_>, text: &str, path: PathBuf) -> PyResult<Self> {
        apart(py, || {
            Ok(Self {
                scene: Description::parse(text, &path)?,
            })
        })
    }

    /// Reads and checks a file.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        apart(py, || {
            Ok(Self {
                scene: Description::read(&path)?,
            })
        })
    }

    /// As it is simulated, JSON.
    fn to_json(&self) -> PyResult<String> {
        let text = serde_json::to_string(&self.scene);
        text.map_err(|error| Failure::input(error.to_string()).into())
    }
}

/// Runs a scene to a results file; whether it reached its end. `tolerance` is the relative error that leaving out what the scene doesn't need may
/// make; everything is carried where it is `None`. `scene_file` is the way from the results to the scene's file, if it has one. `told` gets time and
/// message of notes, and time and end of the motion with `None`.
#[pyfunction]
#[expect(clippy::too_many_arguments)]
pub fn simulate(
    py: Python<'_>,
    scene: &Bound<'_, Scene>,
    path: PathBuf,
    overwrite: bool,
    tolerance: Option<f64>,
    scene_file: Option<String>,
    fields_in: Option<PathBuf>,
    told: Option<Py<PyAny>>,
) -> PyResult<bool> {
    let scene = &scene.get().scene;
    apart(py, || {
        let mut watch = Watch::new(told);
        let open = SuperelementFiles::default();
        let (model, left_out) = match tolerance {
            None => (Model::load_from(scene, &open)?, None),
            Some(tolerance) => {
                let (model, pruning) = Model::load_needed(scene, &open, tolerance)?;
                if let Some(summary) = pruning.summary() {
                    watch.note(0.0, &summary);
                }
                (model, Some(pruning.left_out()))
            }
        };
        drop(open);
        for note in &model.notes {
            watch.note(0.0, note);
        }
        let target = Target {
            path: path.clone(),
            replace: match overwrite {
                true => Replace::Overwrite,
                false => Replace::Refuse,
            },
            fields_in: fields_in.or_else(|| path.parent().map(Path::to_path_buf)),
            kept: Vec::new(),
            options: json!({
                "model": if tolerance.is_some() { "needed" } else { "everything" },
                "tolerance": tolerance,
                "left_out": left_out,
                "scene_file": scene_file,
            }),
            profiling: Profiling::Off,
        };
        let report = run::run(scene, model, &target, &mut watch);
        match watch.raised {
            // What was reached is in the file.
            Some(raised) => Err(Failure::Raised(raised)),
            None => Ok(report?.is_complete()),
        }
    })
}

/// Tells a Python function how far a run is, and listens to Ctrl-C.
pub struct Watch {
    told: Option<Py<PyAny>>,
    raised: Option<PyErr>,
    last: Instant,
}

impl Watch {
    /// That calls this function, if any, with time, end and text.
    pub fn new(told: Option<Py<PyAny>>) -> Self {
        Self {
            told,
            raised: None,
            last: Instant::now(),
        }
    }

    /// What the function has raised, or Ctrl-C.
    pub fn raised(self) -> Option<PyErr> {
        self.raised
    }

    fn tell(&mut self, time: f64, end: Option<f64>, message: Option<&str>) {
        if self.raised.is_some() {
            return;
        }
        self.raised = Python::attach(|py| {
            let asked = py.check_signals().err();
            asked.or_else(|| {
                let told = self.told.as_ref()?;
                told.call1(py, (time, end, message)).err()
            })
        });
    }
}

impl Observer for Watch {
    fn note(&mut self, time: f64, message: &str) {
        self.tell(time, None, Some(message));
    }

    fn progress(&mut self, time: f64, end: f64) {
        if self.last.elapsed() >= LOOK {
            self.last = Instant::now();
            self.tell(time, Some(end), None);
        }
    }

    fn is_stopped(&self) -> bool {
        self.raised.is_some()
    }
}
