//! A fence that no panic passes, around all that Python calls.

use std::panic::{AssertUnwindSafe, catch_unwind};

use pyo3::prelude::*;

use crate::error::Failure;
use crate::threads::of_this_process;

/// Works without the interpreter's lock, with the threads of this process; a panic becomes an exception.
pub fn apart<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, Failure> + Send,
) -> PyResult<T> {
    apart_alone(py, || of_this_process(work)?)
}

/// The same for what needs no other threads.
pub fn apart_alone<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, Failure> + Send,
) -> PyResult<T> {
    let done = py.detach(|| catch_unwind(AssertUnwindSafe(work)));
    fenced(done)
}

/// Works with the interpreter's lock held: for what takes microseconds.
pub fn at_once<T>(work: impl FnOnce() -> Result<T, Failure>) -> PyResult<T> {
    fenced(catch_unwind(AssertUnwindSafe(work)))
}

fn fenced<T>(done: std::thread::Result<Result<T, Failure>>) -> PyResult<T> {
    let result = done.unwrap_or_else(|panic| {
        let text = panic
            .downcast_ref::<String>()
            .cloned()
            .or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()));
        Err(Failure::Panicked(text.unwrap_or_else(|| "a panic".into())))
    });
    Ok(result?)
}
