//! Reductions of matrices in memory.

use std::collections::BTreeMap;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use dcb_formats::SparseMatrix;
use dcb_formats::component::{Component, ComponentDraft, ComponentFault, NamedLoad};
use dcb_formats::description::{MeshArrays, component_in_memory};
use dcb_formats::mesh::{CellBlock, Mesh};
use dcb_reducer::mode_selection::ModeOptions;
use dcb_reducer::observer::{Observer, Stage};
use dcb_reducer::resources::memory_limit::{FactorChoice, MemoryLimit, available, size};
use dcb_reducer::{Reduced, Reduction};
use pyo3::prelude::*;
use serde::Deserialize;
use serde_json::json;

use crate::arrays::{real, rows_of};
use crate::error::{Failure, apart};
use crate::sparse::matrix;
use crate::superelement::Superelement;

/// A component in memory is called so in messages.
const IN_MEMORY: &str = "component";
/// Time between looks whether the user has pressed Ctrl-C.
const LISTENING: Duration = Duration::from_millis(20);
/// Stack of the thread that reduces, bytes: that of a program's first thread.
const STACK: usize = 8 << 20;

/// What a component is made of, from Python.
pub struct Parts {
    stiffness: SparseMatrix,
    mass: SparseMatrix,
    mesh: MeshArrays,
    loads: Vec<NamedLoad>,
    description: String,
}

impl Parts {
    /// `part` is (K, M, points, description, cells, loads): `description` is JSON, as under the key `component` of a component file; `cells` has name
    /// and array of nodes for each block; `loads` name and forces.
    pub fn of(py: Python<'_>, part: Given<'_>) -> PyResult<Self> {
        let (stiffness, mass, points, description, cells, loads) = part;
        let (coordinates, [_, coordinate_count]) = rows_of(py, "points", &points)?;
        let cells = cells.iter().map(|(kind, nodes)| block(py, kind, nodes));
        let mesh = MeshArrays {
            coordinates,
            coordinate_count,
            cells: cells.collect::<PyResult<_>>()?,
            point_sets: BTreeMap::new(),
        };
        let loads = loads.iter().map(|(name, forces)| {
            let forces = real(py, &format!("loads[{name:?}]"), forces)?;
            Ok(NamedLoad {
                name: name.clone(),
                forces: forces.as_array().iter().copied().collect(),
            })
        });
        Ok(Self {
            loads: loads.collect::<PyResult<_>>()?,
            stiffness: matrix(py, "K", &stiffness)?,
            mass: matrix(py, "M", &mass)?,
            mesh,
            description,
        })
    }

    /// Checked.
    pub fn component(self) -> Result<Component, Failure> {
        let path = Path::new(IN_MEMORY);
        let described = component_in_memory(&self.description, self.mesh, path)?;
        let dofs = described.dof_map(self.stiffness.nrows(), path)?;
        let draft = ComponentDraft {
            interfaces: described.interfaces,
            damping: described.damping,
            notes: described.notes,
            loads: self.loads,
            ..ComponentDraft::new(
                &described.name,
                described.units,
                (described.mesh, dofs),
                self.stiffness,
                self.mass,
            )
        };
        Component::checked(draft).map_err(|ComponentFault { place, message }| {
            Failure::input(format!("{place}: {message}"))
        })
    }
}

/// K, M, points, description, cells, loads.
pub type Given<'py> = (
    Bound<'py, PyAny>,
    Bound<'py, PyAny>,
    Bound<'py, PyAny>,
    String,
    Vec<(String, Bound<'py, PyAny>)>,
    Vec<(String, Bound<'py, PyAny>)>,
);

/// Reduces a component; `options` are those of `reduce`, JSON. `progress`, if given, is called with stage and share.
#[pyfunction]
pub fn reduce(
    py: Python<'_>,
    part: Given<'_>,
    options: &str,
    means: &str,
    progress: Option<Py<PyAny>>,
    threads: Option<usize>,
) -> PyResult<Superelement> {
    let parts = Parts::of(py, part)?;
    let (reduced, mesh) = apart(py, || {
        let component = parts.component()?;
        let options = options_of(options, means, &component)?;
        let reduced = watched(progress, |watch| {
            with_threads(threads, || dcb_reducer::reduce(&component, &options, watch))
        })?;
        let reduced = reduced.and_then(Reduced::accepted)?;
        let mesh: Mesh = component.into_draft().mesh;
        Ok((reduced, mesh))
    })?;
    Ok(Superelement {
        element: Arc::new(reduced.superelement),
        recovery: Some(Arc::new(reduced.recovery)),
        mesh: Some(Arc::new(mesh)),
    })
}

/// What a reduction will cost, as JSON: sizes, and the most memory in bytes.
#[pyfunction]
pub fn plan(py: Python<'_>, part: Given<'_>, means: &str) -> PyResult<String> {
    let parts = Parts::of(py, part)?;
    apart(py, || {
        let component = parts.component()?;
        let options = options_of("{}", means, &component)?;
        let forecast = dcb_reducer::forecast(&component, options.modes)?;
        let storage = options.memory.candidates().swap_remove(0);
        let table = json!({
            "dofs": forecast.dofs,
            "modes": forecast.modes,
            "attachments": forecast.attachment_columns,
            "factor_entries": forecast.factor_entries,
            "operations": forecast.flops,
            "memory": forecast.peak_bytes(&storage),
        });
        Ok(table.to_string())
    })
}

/// Works with so many threads; with all where nothing is said.
pub fn with_threads<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> T + Send,
) -> Result<T, Failure> {
    let Some(threads) = threads else {
        return Ok(work());
    };
    if threads == 0 {
        return Err(Failure::input("threads: is 0, expected 1 or more"));
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| Failure::input(format!("threads: {error}")))?;
    Ok(pool.install(work))
}

fn block(py: Python<'_>, kind: &str, nodes: &Bound<'_, PyAny>) -> PyResult<CellBlock> {
    let name = format!("cells[{kind:?}]");
    let (numbers, [_, nodes_per_cell]) = rows_of(py, &name, nodes)?;
    let node = |number: f64| {
        let is_node = number >= 0.0 && number < f64::from(u32::MAX) && number.fract() == 0.0;
        match is_node {
            true => Ok(number as u32),
            false => Err(PyErr::from(Failure::input(format!(
                "{name}: {number} is no node, counted from 0"
            )))),
        }
    };
    Ok(CellBlock {
        cell_type: kind.to_owned(),
        nodes_per_cell,
        nodes: numbers.into_iter().map(node).collect::<PyResult<_>>()?,
    })
}

/// What decides on modes and memory beside the options.
#[derive(Deserialize)]
pub struct Means {
    #[serde(flatten)]
    modes: ModeOptions,
    memory: Option<String>,
    factor: FactorChoice,
    scratch: PathBuf,
}

impl Means {
    /// From JSON.
    pub fn of(text: &str) -> Result<Self, Failure> {
        serde_json::from_str(text).map_err(|error| Failure::input(format!("options: {error}")))
    }

    /// How much memory may be taken: what the machine has available where nothing is said.
    pub fn memory(&self) -> Result<MemoryLimit, Failure> {
        let bytes = match &self.memory {
            Some(text) => {
                let told = |error| Failure::input(format!("memory: {error}, found {text:?}"));
                Some(size(text).map_err(told)?)
            }
            None => available(),
        };
        Ok(MemoryLimit {
            bytes,
            factor: self.factor,
            scratch: self.scratch.clone(),
        })
    }
}

fn options_of(options: &str, means: &str, component: &Component) -> Result<Reduction, Failure> {
    let unreadable = |error: serde_json::Error| Failure::input(format!("options: {error}"));
    let mut reduction: Reduction = serde_json::from_str(options).map_err(unreadable)?;
    let means = Means::of(means)?;
    reduction.modes = means.modes.request().selection(&component.units.time)?;
    reduction.memory = means.memory()?;
    Ok(reduction)
}

/// Works in a thread of its own, which Python's signals don't reach, and listens for Ctrl-C here meanwhile.
pub fn watched<T: Send>(
    progress: Option<Py<PyAny>>,
    work: impl FnOnce(&mut Watch<'_>) -> Result<T, Failure> + Send,
) -> Result<T, Failure> {
    let is_asked_to_end = AtomicBool::new(false);
    let mut watch = Watch {
        progress,
        stage: Stage::Model,
        raised: None,
        is_asked_to_end: &is_asked_to_end,
    };
    let (sender, ended) = channel::<()>();
    thread::scope(|scope| {
        let watch = &mut watch;
        let worker = thread::Builder::new()
            .stack_size(STACK)
            .spawn_scoped(scope, move || {
                // Goes at the end, however that comes.
                let _sender = sender;
                let done = work(watch);
                watch
                    .raised
                    .take()
                    .map_or(done, |raised| Err(Failure::Raised(raised)))
            });
        let worker = worker.map_err(|error| Failure::input(format!("threads: {error}")))?;
        let mut interrupted = None;
        while ended.recv_timeout(LISTENING) == Err(RecvTimeoutError::Timeout) {
            if interrupted.is_none()
                && let Err(raised) = Python::attach(|py| py.check_signals())
            {
                interrupted = Some(raised);
                is_asked_to_end.store(true, Ordering::Relaxed);
            }
        }
        let done = worker.join().unwrap_or_else(|panic| resume_unwind(panic));
        match interrupted {
            Some(raised) => Err(Failure::Raised(raised)),
            None => done,
        }
    })
}

/// Tells a Python function how far a reduction is.
pub struct Watch<'a> {
    progress: Option<Py<PyAny>>,
    stage: Stage,
    /// What the function raised; it isn't called again.
    raised: Option<PyErr>,
    is_asked_to_end: &'a AtomicBool,
}

impl Watch<'_> {
    fn tell(&mut self, share: f64) {
        if self.raised.is_some() {
            return;
        }
        let Some(progress) = &self.progress else {
            return;
        };
        let stage = self.stage.name();
        self.raised = Python::attach(|py| progress.call1(py, (stage, share)).err());
    }
}

impl Observer for Watch<'_> {
    fn begin(&mut self, stage: Stage) {
        self.stage = stage;
        self.tell(0.0);
    }

    fn progress(&mut self, share: f64) {
        self.tell(share);
    }

    fn is_stopped(&self) -> bool {
        self.raised.is_some() || self.is_asked_to_end.load(Ordering::Relaxed)
    }
}
