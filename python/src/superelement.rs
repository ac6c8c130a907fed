//! A superelement in Python: files, arrays, errors, checks.

use std::path::PathBuf;
use std::sync::Arc;

use dcb_formats::dcb::{Compression, Contents, SuperelementFile, WriteOptions, write_superelement};
use dcb_formats::mesh::Mesh;
use dcb_formats::output::Replace;
use dcb_formats::scene::Compatibility;
use dcb_formats::{RecoveryBasis, Superelement as Element};
use dcb_programs::reduce::{self, Form};
use dcb_reducer::verify::{Findings, check_alone};
use dcb_superelement::error_bounds::ErrorBounds;
use dcb_superelement::{LOSS_FACTOR, Selection};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{copied, list_of, matrix_of};
use crate::error::Failure;
use crate::fence::apart;

#[pyclass(frozen, module = "tisserand._native")]
pub struct Superelement {
    pub element: Arc<Element>,
    pub recovery: Option<Arc<RecoveryBasis>>,
    pub mesh: Option<Arc<Mesh>>,
}

/// What `reduce inspect` says of a file, as JSON or for people.
#[pyfunction]
pub fn inspected(py: Python<'_>, path: PathBuf, as_json: bool) -> PyResult<String> {
    let form = match as_json {
        true => Form::Json,
        false => Form::Text,
    };
    apart(py, || Ok(reduce::inspected(&path, form)?))
}

/// What `reduce compare` says of two files.
#[pyfunction]
pub fn compared(py: Python<'_>, a: PathBuf, b: PathBuf) -> PyResult<String> {
    apart(py, || Ok(reduce::compared(&a, &b)?))
}

#[pymethods]
impl Superelement {
    /// Reads a file with its nodal fields and its mesh, where it has them.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        apart(py, || {
            let file = SuperelementFile::open(&path)?;
            Ok(Self {
                element: Arc::new(file.superelement()?),
                recovery: file.recovery()?.map(Arc::new),
                mesh: file.mesh()?.map(Arc::new),
            })
        })
    }

    #[pyo3(signature = (path, *, overwrite = false, fields = true, mesh = true, compress = false))]
    fn write(
        &self,
        py: Python<'_>,
        path: PathBuf,
        overwrite: bool,
        fields: bool,
        mesh: bool,
        compress: bool,
    ) -> PyResult<()> {
        apart(py, || {
            let contents = Contents {
                superelement: &self.element,
                recovery: self.recovery.as_deref().filter(|_| fields),
                mesh: self.mesh.as_deref().filter(|_| mesh),
            };
            let options = WriteOptions {
                replace_existing: match overwrite {
                    true => Replace::Overwrite,
                    false => Replace::Refuse,
                },
                compression: match compress {
                    true => Compression::Deflate,
                    false => Compression::None,
                },
            };
            Ok(write_superelement(&path, &contents, &options)?)
        })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.element.name
    }

    #[getter]
    fn dimension(&self) -> usize {
        self.element.dimension.coordinate_count()
    }

    #[getter]
    fn units(&self) -> (&str, &str, &str) {
        let units = &self.element.units;
        (&units.length, &units.mass, &units.time)
    }

    /// The unit of time in seconds; 1 where it isn't known by its name.
    #[getter]
    fn second(&self) -> f64 {
        dcb_formats::units::si_factor(&self.element.units.time).unwrap_or(1.0)
    }

    #[getter]
    fn mass(&self) -> f64 {
        self.element.inertia.mass
    }

    #[getter]
    fn origin(&self) -> [f64; 3] {
        self.element.origin
    }

    #[getter]
    fn inertia(&self) -> [[f64; 3]; 3] {
        self.element.inertia.tensor
    }

    #[getter]
    fn interfaces(&self) -> Vec<&str> {
        let interfaces = self.element.interfaces.iter();
        interfaces
            .map(|interface| interface.name.as_str())
            .collect()
    }

    #[getter]
    fn rows(&self) -> Vec<String> {
        let rows = 0..self.element.boundary_row_count();
        rows.map(|row| self.element.row_name(row)).collect()
    }

    #[getter]
    fn warnings(&self) -> Vec<&str> {
        let warnings = self.element.provenance.warnings.iter();
        warnings.map(String::as_str).collect()
    }

    #[getter]
    fn eigenvalues<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<f64>> {
        list_of(slf.as_any(), &slf.get().element.modes.eigenvalues)
    }

    #[getter]
    fn interface_shapes<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray2<f64>> {
        matrix_of(
            slf.as_any(),
            slf.get().element.modes.interface_shapes.as_ref(),
        )
    }

    #[getter]
    fn residual_flexibility<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray2<f64>> {
        matrix_of(
            slf.as_any(),
            slf.get().element.residual.flexibility.as_ref(),
        )
    }

    #[getter]
    fn residual_mass<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray2<f64>> {
        matrix_of(slf.as_any(), slf.get().element.residual.mass.as_ref())
    }

    /// Φ at the nodes' dofs, (n_f, n_k); `None` where the file has no fields.
    #[getter]
    fn modes<'py>(slf: &Bound<'py, Self>) -> Option<Bound<'py, PyArray2<f64>>> {
        let recovery = slf.get().recovery.as_ref()?;
        Some(matrix_of(slf.as_any(), recovery.modes.as_ref()))
    }

    /// G_res L_bᵀ at the nodes' dofs, (n_f, n_b).
    #[getter]
    fn attachments<'py>(slf: &Bound<'py, Self>) -> Option<Bound<'py, PyArray2<f64>>> {
        let recovery = slf.get().recovery.as_ref()?;
        Some(matrix_of(slf.as_any(), recovery.residual.as_ref()))
    }

    /// Node and direction (0 to 5) of each row of the fields.
    #[getter]
    fn field_dofs(&self) -> Option<Vec<(u32, usize)>> {
        let recovery = self.recovery.as_ref()?;
        let dofs = recovery.dofs.iter();
        Some(dofs.map(|dof| (dof.node, dof.direction.index())).collect())
    }

    /// Places of the nodes, (n, 2) or (n, 3).
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray2<f64>>> {
        let mesh = self.mesh.as_ref()?;
        let width = mesh.dimension.coordinate_count();
        let points =
            faer::MatRef::from_row_major_slice(&mesh.coordinates, mesh.node_count(), width);
        Some(copied(py, points))
    }

    /// Name and nodes of each block of cells.
    #[getter]
    fn cells(&self) -> Vec<(&str, Vec<Vec<u32>>)> {
        let blocks = self.mesh.iter().flat_map(|mesh| &mesh.cells);
        let of_block = |block: &'_ dcb_formats::mesh::CellBlock| {
            let width = block.nodes_per_cell.max(1);
            block.nodes.chunks(width).map(<[u32]>::to_vec).collect()
        };
        blocks
            .map(|block| (block.cell_type.as_str(), of_block(block)))
            .collect()
    }

    /// What `reduce verify` finds from the superelement alone: the lines, and those that failed.
    fn check(&self, py: Python<'_>) -> PyResult<(String, Vec<String>)> {
        apart(py, || {
            let mut findings = Findings {
                text: String::new(),
                broken: Vec::new(),
            };
            check_alone(
                &self.element,
                self.recovery.as_deref(),
                self.mesh.as_deref(),
                &mut findings,
            )?;
            Ok((findings.text, findings.broken))
        })
    }

    /// Bounds of the errors up to ω² (those of the usual band where `None`), with strong or static compatibility.
    fn error_bounds<'py>(
        &self,
        py: Python<'py>,
        upper: Option<f64>,
        compatibility: &str,
        points: usize,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        let compatibility = compatibility_of(compatibility)?;
        let found = apart(py, || {
            let Some(bounds) = ErrorBounds::of(&self.element, compatibility)? else {
                return Ok(None);
            };
            let rows: Vec<usize> = (0..self.element.boundary_row_count()).collect();
            let band = match upper {
                Some(upper) => Some(bounds.band(None, upper, points)),
                None => bounds.usual_band(points),
            };
            let Some(band) = band else { return Ok(None) };
            let estimate = bounds.over(&rows, &band, LOSS_FACTOR)?;
            Ok(Some((estimate, band.top())))
        })?;
        let Some((estimate, top)) = found else {
            return Ok(None);
        };
        let table = PyDict::new(py);
        let bracket =
            |bracket: dcb_superelement::error_bounds::Bracket| (bracket.lower, bracket.upper);
        table.set_item("upper_eigenvalue", top)?;
        table.set_item("static_response", bracket(estimate.static_response))?;
        table.set_item("collocated", bracket(estimate.collocated.largest))?;
        table.set_item(
            "transfer",
            estimate.transfer.map(|error| bracket(error.largest)),
        )?;
        table.set_item("held_frequency", estimate.held_frequency.map(bracket))?;
        table.set_item("free_frequency", estimate.free_frequency)?;
        Ok(Some(table))
    }

    /// With the lowest modes only, as a reduction with so many would give it.
    fn lowest_modes(&self, py: Python<'_>, count: usize) -> PyResult<Self> {
        apart(py, || {
            let lowest = Selection::lowest_modes(&self.element, count)?;
            let selection = match self.element.enrichment {
                // The same superelement, with the moments of its errors.
                None => Selection::everything(&self.element)
                    .with_modes(lowest.modes().iter().copied())?,
                Some(_) => lowest,
            };
            let element = selection.superelement(&self.element)?;
            let recovery = match &self.recovery {
                Some(recovery) => Some(Arc::new(selection.recovery(&self.element, recovery)?)),
                None => None,
            };
            Ok(Self {
                element: Arc::new(element),
                recovery,
                mesh: self.mesh.clone(),
            })
        })
    }
}

fn compatibility_of(name: &str) -> PyResult<Compatibility> {
    serde_json::from_value(name.into()).map_err(|_| {
        Failure::input(format!(
            "compatibility: {name:?}, expected strong, static or weak"
        ))
        .into()
    })
}
