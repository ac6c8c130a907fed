//! The programs as functions of their arguments.

use pyo3::prelude::*;

use crate::fence::apart;

/// The program `reduce` with these arguments; its exit status.
#[pyfunction]
pub fn run_reduce(py: Python<'_>, arguments: Vec<std::ffi::OsString>) -> PyResult<u8> {
    apart(py, || {
        Ok(dcb_programs::reduce::main(
            arguments,
            dcb_programs::simulate::command,
        ))
    })
}

/// The program `simulate` with these arguments; its exit status.
#[pyfunction]
pub fn run_simulate(py: Python<'_>, arguments: Vec<std::ffi::OsString>) -> PyResult<u8> {
    apart(py, || {
        Ok(dcb_programs::simulate::main(
            arguments,
            dcb_programs::reduce::command,
        ))
    })
}
