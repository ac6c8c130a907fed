//! A scene in motion under the control of a Python program.

use std::sync::{Mutex, MutexGuard, TryLockError};
use std::time::{Duration, Instant};

use dcb_runtime::Mechanism as Motion;
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::error::Failure;
use crate::fence::{apart, apart_alone, at_once};
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
    /// Works on the motion without the interpreter's lock held.
    fn with<T>(&self, work: impl FnOnce(&mut Motion) -> Result<T, Failure>) -> Result<T, Failure> {
        let mut motion = self.motion.lock().map_err(|_| poisoned())?;
        work(&mut motion)
    }

    /// Works at once where the motion is free. Where another thread has it, Python's other threads go on during the wait.
    fn soon<T>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Motion) -> Result<T, Failure>,
    ) -> PyResult<T> {
        loop {
            match self.motion.try_lock() {
                Ok(motion) => {
                    // A panic within poisons what it holds.
                    return at_once(move || {
                        let mut motion = motion;
                        work(&mut motion)
                    });
                }
                Err(TryLockError::Poisoned(_)) => return Err(poisoned().into()),
                Err(TryLockError::WouldBlock) => {
                    apart_alone(py, || {
                        let free: Result<MutexGuard<'_, Motion>, _> = self.motion.lock();
                        free.map(drop).map_err(|_| poisoned())
                    })?;
                }
            }
        }
    }
}

fn poisoned() -> Failure {
    Failure::Panicked(POISONED.into())
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

    /// Time reached, in the scene's unit of time.
    #[getter]
    fn time(&self, py: Python<'_>) -> PyResult<f64> {
        self.soon(py, |motion| Ok(motion.time()))
    }

    /// Names of the inputs, in the order of the scene.
    #[getter]
    fn input_names(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.soon(py, |motion| {
            let inputs = motion.inputs().iter();
            Ok(inputs.map(|input| input.name.clone()).collect())
        })
    }

    /// Names of all that `output` knows: the scene's outputs first, then what a run records besides.
    #[getter]
    fn output_names(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.soon(py, |motion| {
            let names = motion.channels().iter().map(|channel| {
                let name = channel.path.strip_prefix("outputs/");
                name.unwrap_or(&channel.path).to_owned()
            });
            Ok(names.collect())
        })
    }

    /// One step, or several of the same length; the lock of the interpreter is given up meanwhile, and Ctrl-C ends them between two steps.
    #[pyo3(signature = (step, count = 1))]
    fn step(&self, py: Python<'_>, step: f64, count: i64) -> PyResult<()> {
        let mut left = usize::try_from(count)
            .map_err(|_| Failure::input(format!("count: is {count}, expected 0 or more")))?;
        while left > 0 {
            left = apart_alone(py, || self.with(|motion| some_steps(motion, step, left)))?;
            // With the motion free: who waits for it may hold the interpreter's lock.
            if left > 0 {
                py.check_signals()?;
            }
        }
        Ok(())
    }

    /// Sets an input, which keeps this value until it is set again; its unit is that of what it feeds. A force or moment acts in full from now on.
    fn set_input(&self, py: Python<'_>, name: &str, value: f64) -> PyResult<()> {
        self.soon(py, |motion| Ok(motion.set_input(name, value)?))
    }

    /// An output as it is now, one number for each of its columns, in the units of the scene; also what else a run records, such as `reactions/JOINT`.
    fn output<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.soon(py, |motion| {
            Ok(PyArray1::from_slice(py, motion.output(name)?))
        })
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

    /// The present state, inputs included.
    fn save(&self, py: Python<'_>) -> PyResult<Snapshot> {
        self.soon(py, |motion| {
            Ok(Snapshot {
                saved: motion.save(),
            })
        })
    }

    /// Goes back to a state of this mechanism; all that follows from there is the same to the last bit.
    fn restore(&self, py: Python<'_>, snapshot: &Bound<'_, Snapshot>) -> PyResult<()> {
        let saved = &snapshot.get().saved;
        self.soon(py, |motion| Ok(motion.restore(saved)?))
    }
}
