//! Reductions of matrices in memory.

use std::path::Path;
use std::sync::Arc;

use dcb_formats::component::{Component, ComponentDraft, ComponentFault, NamedLoad};
use dcb_formats::description::{MeshArrays, component_in_memory};
use dcb_formats::mesh::{CellBlock, Mesh};
use dcb_reducer::mode_selection::ModeOptions;
use dcb_reducer::observer::{Observer, Stage};
use dcb_reducer::{Reduced, Reduction};
use pyo3::prelude::*;

use crate::arrays::{real, rows_of};
use crate::error::{Failure, apart};
use crate::sparse::matrix;
use crate::superelement::Superelement;

/// A component in memory is called so in messages.
const IN_MEMORY: &str = "component";

/// Reduces a component. `description` is JSON, as under the key `component` of a component file; `options` are those of `reduce`, JSON;
/// `cells` has name, array of nodes for each block; `loads` name and forces. `progress`, if given, is called with stage and share.
#[pyfunction]
#[pyo3(signature = (stiffness, mass, points, description, cells, loads, options, modes, progress, threads))]
#[expect(clippy::too_many_arguments, reason = "called by the Python half alone, by position")]
pub fn reduce(
    py: Python<'_>,
    stiffness: &Bound<'_, PyAny>,
    mass: &Bound<'_, PyAny>,
    points: &Bound<'_, PyAny>,
    description: &str,
    cells: Vec<(String, Bound<'_, PyAny>)>,
    loads: Vec<(String, Bound<'_, PyAny>)>,
    options: &str,
    modes: &str,
    progress: Option<Py<PyAny>>,
    threads: Option<usize>,
) -> PyResult<Superelement> {
    let (coordinates, [_, coordinate_count]) = rows_of(py, "points", points)?;
    let cells = cells.iter().map(|(kind, nodes)| block(py, kind, nodes));
    let mesh = MeshArrays {
        coordinates,
        coordinate_count,
        cells: cells.collect::<PyResult<_>>()?,
        point_sets: std::collections::BTreeMap::new(),
    };
    let stiffness = matrix(py, "K", stiffness)?;
    let mass = matrix(py, "M", mass)?;
    let loads = loads.iter().map(|(name, forces)| {
        let forces = real(py, &format!("loads[{name:?}]"), forces)?;
        Ok(NamedLoad {
            name: name.clone(),
            forces: forces.as_array().iter().copied().collect(),
        })
    });
    let loads = loads.collect::<PyResult<Vec<_>>>()?;
    let (reduced, mesh) = apart(py, || {
        let component = component(stiffness, mass, mesh, description, loads)?;
        let options = options_of(options, modes, &component)?;
        let mut watch = Watch {
            progress,
            stage: Stage::Model,
            told: None,
        };
        let reduced = match threads {
            None => dcb_reducer::reduce(&component, &options, &mut watch),
            Some(threads) => {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
                let pool = pool
                    .build()
                    .map_err(|error| Failure::input(format!("threads: {error}")))?;
                pool.install(|| dcb_reducer::reduce(&component, &options, &mut watch))
            }
        };
        if let Some(raised) = watch.told {
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

fn component(
    stiffness: dcb_formats::SparseMatrix,
    mass: dcb_formats::SparseMatrix,
    mesh: MeshArrays,
    description: &str,
    loads: Vec<NamedLoad>,
) -> Result<Component, Failure> {
    let path = Path::new(IN_MEMORY);
    let described = component_in_memory(description, mesh, path)?;
    let dofs = described.dof_map(stiffness.nrows(), path)?;
    let draft = ComponentDraft {
        interfaces: described.interfaces,
        damping: described.damping,
        notes: described.notes,
        loads,
        ..ComponentDraft::new(
            &described.name,
            described.units,
            (described.mesh, dofs),
            stiffness,
            mass,
        )
    };
    Component::checked(draft)
        .map_err(|ComponentFault { place, message }| Failure::input(format!("{place}: {message}")))
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
    told: Option<PyErr>,
}

impl Watch {
    fn tell(&mut self, share: f64) {
        if self.told.is_some() {
            return;
        }
        let Some(progress) = &self.progress else {
            return;
        };
        let stage = self.stage.name();
        self.told = Python::attach(|py| progress.call1(py, (stage, share)).err());
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
