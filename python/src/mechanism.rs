//! A scene in motion under the control of a Python program.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use dcb_runtime::Mechanism as Motion;
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::error::{Failure, apart, at_once};
use crate::linear::{LinearSystem, request};
use crate::scene::Scene;

/// A panic within a call leaves the motion in no known state.
const POISONED: &str = "an earlier call of this mechanism ended with a defect; start a new one";

/// Steps that take longer together look for Ctrl-C in between.
const PATIENCE: Duration = Duration::from_millis(50);

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

/// Up to so many steps, as long as nobody who presses Ctrl-C would wait; how many are left.
fn some_steps(motion: &mut Motion, step: f64, count: usize) -> Result<usize, Failure> {
    let begun = (count > 1).then(Instant::now);
    for left in (0..count).rev() {
        motion.step(step)?;
        if begun.is_some_and(|begun| begun.elapsed() >= PATIENCE) {
            return Ok(left);
        }
    }
    Ok(0)
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

    /// One step, or several of the same length; the lock of the interpreter is given up meanwhile, and Ctrl-C ends them between two steps.
    #[pyo3(signature = (step, count = 1))]
    fn step(&self, py: Python<'_>, step: f64, count: usize) -> PyResult<()> {
        let mut left = count;
        while left > 0 {
            left = apart(py, || self.with(|motion| some_steps(motion, step, left)))?;
            // With the motion free: who waits for it may hold the interpreter's lock.
            if left > 0 {
                py.check_signals()?;
            }
        }
        Ok(())
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
