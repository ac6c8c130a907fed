//! A scene in motion under the control of a Python program.

use std::sync::Mutex;

use dcb_runtime::Mechanism as Motion;
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::error::{Failure, apart, at_once};
use crate::linear::{LinearSystem, request};
use crate::scene::Scene;

/// A panic within a call leaves the motion in no known state.
const POISONED: &str = "an earlier call of this mechanism ended with a defect; start a new one";

#[pyclass(frozen, subclass, module = "tisserand._native")]
pub struct Mechanism {
    motion: Mutex<Motion>,
}

/// A state that a mechanism can go back to.
#[pyclass(frozen, module = "tisserand")]
pub struct Snapshot {
    saved: dcb_runtime::simulation::Snapshot,
}

impl Mechanism {
    fn with<T>(&self, work: impl FnOnce(&mut Motion) -> Result<T, Failure>) -> Result<T, Failure> {
        let mut motion = self
            .motion
            .lock()
            .map_err(|_| Failure::Panicked(POISONED.into()))?;
        work(&mut motion)
    }
}

#[pymethods]
impl Mechanism {
    #[new]
    fn new(py: Python<'_>, scene: &Bound<'_, Scene>) -> PyResult<Self> {
        let scene = &scene.get().scene;
        apart(py, || {
            Ok(Self {
                motion: Mutex::new(Motion::start(scene)?),
            })
        })
    }

    #[getter]
    fn time(&self) -> PyResult<f64> {
        at_once(|| self.with(|motion| Ok(motion.time())))
    }

    /// One step, or several of the same length; the lock of the interpreter is given up meanwhile.
    #[pyo3(signature = (step, count = 1))]
    fn step(&self, py: Python<'_>, step: f64, count: usize) -> PyResult<()> {
        apart(py, || {
            self.with(|motion| {
                for _ in 0..count {
                    motion.step(step)?;
                }
                Ok(())
            })
        })
    }

    fn set_input(&self, name: &str, value: f64) -> PyResult<()> {
        at_once(|| self.with(|motion| Ok(motion.set_input(name, value)?)))
    }

    fn output<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArray1<f64>>> {
        at_once(|| self.with(|motion| Ok(PyArray1::from_slice(py, motion.output(name)?))))
    }

    fn linear_system(
        &self,
        py: Python<'_>,
        inputs: Vec<String>,
        outputs: Vec<String>,
        order: Option<usize>,
    ) -> PyResult<LinearSystem> {
        apart(py, || {
            let request = request(inputs, outputs, order);
            self.with(|motion| Ok(LinearSystem::of(motion.linearize(&request)?)))
        })
    }

    fn save(&self) -> PyResult<Snapshot> {
        at_once(|| {
            self.with(|motion| {
                Ok(Snapshot {
                    saved: motion.save(),
                })
            })
        })
    }

    fn restore(&self, snapshot: &Bound<'_, Snapshot>) -> PyResult<()> {
        let saved = &snapshot.get().saved;
        at_once(|| self.with(|motion| Ok(motion.restore(saved)?)))
    }
}
