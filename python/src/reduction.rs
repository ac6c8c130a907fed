//! Reductions of matrices in memory.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use dcb_formats::SparseMatrix;
use dcb_formats::component::{Component, ComponentDraft, ComponentFault, NamedLoad};
use dcb_formats::description::{MeshArrays, component_in_memory};
use dcb_formats::mesh::{CellBlock, Mesh};
use dcb_reducer::mode_selection::ModeOptions;
use dcb_reducer::observer::{Observer, Stage};
use dcb_reducer::{Reduced, Reduction};
use pyo3::prelude::*;
use serde_json::json;

use crate::arrays::{real, rows_of};
use crate::error::{Failure, apart};
use crate::sparse::matrix;
use crate::superelement::Superelement;

/// A component in memory is called so in messages.
const IN_MEMORY: &str = "component";

/// What a component is made of, from Python.
struct Parts {
    stiffness: SparseMatrix,
    mass: SparseMatrix,
    mesh: MeshArrays,
    loads: Vec<NamedLoad>,
    description: String,
}

impl Parts {
    /// `part` is (K, M, points, description, cells, loads): `description` is JSON, as under the key `component` of a component file; `cells` has name
    /// and array of nodes for each block; `loads` name and forces.
    fn of(py: Python<'_>, part: Given<'_>) -> PyResult<Self> {
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

    fn component(self) -> Result<Component, Failure> {
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
type Given<'py> = (
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
    modes: &str,
    progress: Option<Py<PyAny>>,
    threads: Option<usize>,
) -> PyResult<Superelement> {
    let parts = Parts::of(py, part)?;
    let (reduced, mesh) = apart(py, || {
        let component = parts.component()?;
        let options = options_of(options, modes, &component)?;
        let mut watch = Watch {
            progress,
            stage: Stage::Model,
            raised: None,
        };
        let reduced = with_threads(threads, || {
            dcb_reducer::reduce(&component, &options, &mut watch)
        })?;
        if let Some(raised) = watch.raised {
            return Err(Failure::Raised(raised));
        }
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
pub fn plan(py: Python<'_>, part: Given<'_>, modes: &str) -> PyResult<String> {
    let parts = Parts::of(py, part)?;
    apart(py, || {
        let component = parts.component()?;
        let options = options_of("{}", modes, &component)?;
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
fn with_threads<T: Send>(
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

fn options_of(options: &str, modes: &str, component: &Component) -> Result<Reduction, Failure> {
    let unreadable = |error: serde_json::Error| Failure::input(format!("options: {error}"));
    let mut reduction: Reduction = serde_json::from_str(options).map_err(unreadable)?;
    let modes: ModeOptions = serde_json::from_str(modes).map_err(unreadable)?;
    reduction.modes = modes.request().selection(&component.units.time)?;
    Ok(reduction)
}

/// Tells a Python function how far a reduction is.
struct Watch {
    progress: Option<Py<PyAny>>,
    stage: Stage,
    /// What the function raised; it isn't called again.
    raised: Option<PyErr>,
}

impl Watch {
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

impl Observer for Watch {
    fn begin(&mut self, stage: Stage) {
        self.stage = stage;
        self.tell(0.0);
    }

    fn progress(&mut self, share: f64) {
        self.tell(share);
    }
}
