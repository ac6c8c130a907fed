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
use dcb_formats::component::{
    Component, ComponentDraft, ComponentFault, ComponentMasses, NamedLoad,
};
use dcb_formats::description::{MeshArrays, component_in_memory};
use dcb_formats::mesh::CellBlock;
use dcb_reducer::mode_selection::{DEFAULT_MODES, ModeOptions};
use dcb_reducer::observer::{Observer, Stage};
use dcb_reducer::resources::memory_limit::{FactorChoice, MemoryLimit, available, size};
use dcb_reducer::{Reduced, Reduction};
use dcb_workflow::scene::{ComponentDemand, Extent, Fitted, Limits, PartInScene, Search};
use pyo3::prelude::*;
use serde::Deserialize;
use serde_json::json;

use crate::arrays::{real, rows_of};
use crate::error::Failure;
use crate::fence::apart;
use crate::scene::Scene;
use crate::sparse::{rectangular, symmetric};
use crate::superelement::Superelement;
use crate::threads::with_threads;

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
    boundary: Option<SparseMatrix>,
    component_masses: Vec<(String, SparseMatrix)>,
    stiffening: Vec<(String, SparseMatrix)>,
    description: String,
}

impl Parts {
    /// As [`Given`] says.
    pub fn of(py: Python<'_>, part: Given<'_>) -> PyResult<Self> {
        let Given {
            stiffness,
            mass,
            points,
            description,
            cells,
            loads,
            boundary,
            component_masses,
            stiffening,
        } = part;
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
        let of_name = |group: &str, name: &str| format!("{group}[{name:?}]");
        let component_masses = component_masses.iter().map(|(name, matrix)| {
            let matrix = rectangular(py, &of_name("component_masses", name), matrix)?;
            Ok((name.clone(), matrix))
        });
        let stiffening = stiffening.iter().map(|(name, matrix)| {
            let matrix = symmetric(py, &of_name("stiffening", name), matrix)?;
            Ok((name.clone(), matrix))
        });
        Ok(Self {
            loads: loads.collect::<PyResult<_>>()?,
            stiffness: symmetric(py, "K", &stiffness)?,
            mass: symmetric(py, "M", &mass)?,
            boundary: (boundary.as_ref())
                .map(|boundary| rectangular(py, "boundary", boundary))
                .transpose()?,
            component_masses: component_masses.collect::<PyResult<_>>()?,
            stiffening: stiffening.collect::<PyResult<_>>()?,
            mesh,
            description,
        })
    }

    /// Checked.
    pub fn component(self) -> Result<Component, Failure> {
        let path = Path::new(IN_MEMORY);
        let described = component_in_memory(&self.description, self.mesh, path)?;
        let dofs = described.dof_map(self.stiffness.nrows(), path)?;
        let mut draft = ComponentDraft {
            interfaces: described.interfaces,
            damping: described.damping,
            notes: described.notes,
            loads: self.loads,
            explicit_boundary: self.boundary,
            ..ComponentDraft::new(
                &described.name,
                described.units,
                (described.mesh, dofs),
                self.stiffness,
                self.mass,
            )
        };
        if !self.component_masses.is_empty() {
            draft.component_masses = Some(ordered(self.component_masses, &draft)?);
        }
        if !self.stiffening.is_empty() {
            let taken = draft.stiffen(self.stiffening);
            taken.map_err(|unknown| Failure::input(format!("stiffening: {unknown}")))?;
        }
        Component::checked(draft).map_err(|ComponentFault { place, message }| {
            Failure::input(format!("{place}: {message}"))
        })
    }
}

/// Component masses in the order of their names.
fn ordered(
    mut named: Vec<(String, SparseMatrix)>,
    draft: &ComponentDraft,
) -> Result<ComponentMasses, Failure> {
    let names = ComponentMasses::names(draft.dimension());
    let place = |name: &str| names.iter().position(|known| *known == name);
    let mut found: Vec<&str> = named.iter().map(|(name, _)| name.as_str()).collect();
    found.sort_by_key(|name| place(name));
    if found != names {
        return Err(Failure::input(format!(
            "component_masses: are {}, expected {}",
            found.join(", "),
            names.join(", ")
        )));
    }
    named.sort_by_key(|(name, _)| place(name));
    Ok(ComponentMasses {
        matrices: named.into_iter().map(|(_, matrix)| matrix).collect(),
    })
}

/// A named object each.
type Named<'py> = Vec<(String, Bound<'py, PyAny>)>;

/// A component as Python gives it: a dictionary.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Given<'py> {
    stiffness: Bound<'py, PyAny>,
    mass: Bound<'py, PyAny>,
    points: Bound<'py, PyAny>,
    /// JSON, as under the key `component` of a component file.
    description: String,
    /// Arrays of nodes.
    cells: Named<'py>,
    /// Forces.
    loads: Named<'py>,
    /// Further rows of L_b.
    boundary: Option<Bound<'py, PyAny>>,
    component_masses: Named<'py>,
    /// Geometric stiffness.
    stiffening: Named<'py>,
}

/// The scene that a part is reduced for.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct ForScene<'py> {
    scene: Bound<'py, Scene>,
    /// Folder and name of the scene, for its paths and for messages.
    path: PathBuf,
    /// Those made of the part; where none is named, those of the file that has its name.
    bodies: Vec<String>,
    /// `NAME.dcb.h5`.
    file: PathBuf,
    tolerance: f64,
    keep_all: bool,
    /// The most, if that is said.
    modes: Option<usize>,
}

impl ForScene<'_> {
    fn wanted(&self) -> Result<(PartInScene, Limits), Failure> {
        let scene = self.scene.get().scene.clone();
        let files = [self.file.as_path(), self.file.as_path()];
        let part = PartInScene::of(scene, &self.path, &self.bodies, files)?;
        let limits = Limits {
            tolerance: self.tolerance,
            most_modes: self.modes,
            default_modes: DEFAULT_MODES,
            extent: match self.keep_all {
                true => Extent::Everything,
                false => Extent::Needed,
            },
        };
        Ok((part, limits))
    }
}

/// Reduces a component for a scene.
fn for_scene(
    (part, limits): &(PartInScene, Limits),
    component: Component,
    options: &Reduction,
    watch: &mut Watch<'_>,
) -> Result<Superelement, Failure> {
    let asked = ComponentDemand::of(part, component)?;
    let search = Search {
        asked: &asked,
        options,
        limits,
        cached: None,
    };
    let whole = search.whole(watch)?;
    let fitted = Fitted::of(whole, part, &asked, limits)?;
    let (fields, mesh) = fitted.fields.unzip();
    Ok(Superelement {
        element: Arc::new(fitted.superelement),
        recovery: fields.map(Arc::new),
        mesh: mesh.map(Arc::new),
    })
}

/// Reduces a component; `options` are those of `reduce`, JSON. `progress`, if given, is called with stage and share.
#[pyfunction]
pub fn reduce(
    py: Python<'_>,
    part: Given<'_>,
    options: &str,
    means: &str,
    scene: Option<ForScene<'_>>,
    progress: Option<Py<PyAny>>,
    threads: Option<usize>,
) -> PyResult<Superelement> {
    let parts = Parts::of(py, part)?;
    let wanted = scene.map(|scene| scene.wanted()).transpose()?;
    apart(py, || {
        watched(progress, |watch| {
            with_threads(threads, || {
                let component = parts.component()?;
                let options = options_of(options, means, &component)?;
                if let Some(wanted) = &wanted {
                    return for_scene(wanted, component, &options, watch);
                }
                let reduced = dcb_reducer::reduce(&component, &options, watch);
                let reduced = reduced.and_then(Reduced::accepted)?;
                Ok(Superelement {
                    element: Arc::new(reduced.superelement),
                    recovery: Some(Arc::new(reduced.recovery)),
                    mesh: Some(Arc::new(component.into_draft().mesh)),
                })
            })?
        })
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
        Ok(MemoryLimit::here(bytes, self.factor, self.scratch.clone()))
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
