//! Linear systems of mechanisms as NumPy arrays.

use std::path::PathBuf;

use dcb_export::linear_system::LinearFile;
use dcb_formats::linear_system::{LinearSystem as System, Variable};
use dcb_formats::output::Replace;
use dcb_runtime::{LinearRequest, OperatingPoint, linearize as linearized};
use numpy::PyArray2;
use pyo3::prelude::*;

use crate::arrays::matrix_of;
use crate::error::Failure;
use crate::fence::{apart, at_once};
use crate::scene::{Scene, Watch};

/// States before, poles kept apart, Hankel singular values, bound, and bounds of outputs by inputs.
type Truncated = (usize, usize, Vec<f64>, f64, Vec<Vec<f64>>);

#[pyclass(frozen, module = "tisserand._native")]
pub struct LinearSystem {
    system: System,
}

/// Name, unit and value at the operating point.
type Told = (String, String, f64);

impl LinearSystem {
    pub fn of(system: System) -> Self {
        Self { system }
    }
}

/// What is asked for.
pub fn request(inputs: Vec<String>, outputs: Vec<String>, order: Option<usize>) -> LinearRequest {
    LinearRequest {
        inputs,
        outputs,
        order,
    }
}

fn told(of: &[Variable]) -> Vec<Told> {
    let of = of.iter();
    of.map(|one| (one.name.clone(), one.unit.clone(), one.at))
        .collect()
}

#[pymethods]
impl LinearSystem {
    /// A, B, C and D by their letter.
    fn matrix<'py>(slf: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let system = &slf.get().system;
        let matrix = match name {
            "A" => &system.a,
            "B" => &system.b,
            "C" => &system.c,
            "D" => &system.d,
            _ => return Err(Failure::input(format!("no matrix is called {name:?}")).into()),
        };
        Ok(matrix_of(slf.as_any(), matrix.as_ref()))
    }

    #[getter]
    fn states(&self) -> Vec<Told> {
        told(&self.system.states)
    }

    #[getter]
    fn inputs(&self) -> Vec<Told> {
        told(&self.system.inputs)
    }

    #[getter]
    fn outputs(&self) -> Vec<Told> {
        told(&self.system.outputs)
    }

    /// Real and imaginary parts.
    #[getter]
    fn poles(&self) -> Vec<(f64, f64)> {
        let poles = self.system.poles.iter();
        poles
            .map(|pole| (pole.growth, pole.angular_frequency))
            .collect()
    }

    #[getter]
    fn units(&self) -> (String, String, String) {
        let units = self.system.units.clone();
        (units.length, units.mass, units.time)
    }

    #[getter]
    fn time(&self) -> f64 {
        self.system.time
    }

    #[getter]
    fn is_equilibrium(&self) -> bool {
        self.system.is_equilibrium
    }

    /// States before, poles kept apart, Hankel singular values, bound, and bounds of outputs by inputs; of a truncated system.
    #[getter]
    fn truncation(&self) -> Option<Truncated> {
        let truncation = self.system.truncation.as_ref()?;
        let bounds = truncation.bounds.row_iter();
        Some((
            truncation.full_order,
            truncation.kept_apart,
            truncation.hankel.clone(),
            truncation.bound,
            bounds.map(|row| row.iter().copied().collect()).collect(),
        ))
    }

    #[pyo3(signature = (path, overwrite = false))]
    fn write(&self, py: Python<'_>, path: PathBuf, overwrite: bool) -> PyResult<()> {
        apart(py, || {
            let replace = match overwrite {
                true => Replace::Overwrite,
                false => Replace::Refuse,
            };
            Ok(LinearFile::of(&path)?.write(&self.system, &path, replace)?)
        })
    }
}

/// About the start of a scene (`initial`), a rest near it (`static`) or a time.
#[pyfunction]
pub fn linearize(
    py: Python<'_>,
    scene: &Bound<'_, Scene>,
    at: &Bound<'_, PyAny>,
    inputs: Vec<String>,
    outputs: Vec<String>,
    order: Option<usize>,
    told: Option<Py<PyAny>>,
) -> PyResult<LinearSystem> {
    let at = operating_point(at)?;
    let scene = &scene.get().scene;
    apart(py, || {
        let mut watch = Watch::new(told);
        let found = linearized(scene, at, &request(inputs, outputs, order), &mut watch);
        if let Some(raised) = watch.raised() {
            return Err(Failure::Raised(raised));
        }
        match found? {
            Some(system) => Ok(LinearSystem::of(system)),
            None => Err(Failure::input("stopped before the operating point")),
        }
    })
}

fn operating_point(at: &Bound<'_, PyAny>) -> PyResult<OperatingPoint> {
    if let Ok(time) = at.extract::<f64>() {
        return Ok(OperatingPoint::Time(time));
    }
    at_once(|| match at.extract::<String>().as_deref() {
        Ok("initial") => Ok(OperatingPoint::Initial),
        Ok("static") => Ok(OperatingPoint::Static),
        _ => Err(Failure::input(format!(
            "at: is {at}, expected \"initial\", \"static\" or a time"
        ))),
    })
}
