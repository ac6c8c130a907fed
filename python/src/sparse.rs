//! SciPy's sparse matrices, and dense arrays, as the crates' compressed columns.
//!
//! Compressed rows of a symmetric matrix are its compressed columns, so nothing is turned over. Sorted indices without duplicates are copied once, as the
//! crates need 32-bit ones; anything else SciPy puts in order first.

use dcb_formats::SparseMatrix;
use faer::sparse::SymbolicSparseColMat;
use numpy::{PyReadonlyArray1, PyReadonlyArrayDyn};
use pyo3::prelude::*;

use crate::error::Failure;

/// The matrix that an object holds: SciPy's sparse matrices and arrays in any format, or what NumPy makes a dense array of.
pub fn matrix(py: Python<'_>, name: &str, value: &Bound<'_, PyAny>) -> PyResult<SparseMatrix> {
    let compressed = match value.hasattr("tocsc")? {
        true => in_order(name, value)?,
        false => {
            let dense = crate::arrays::real(py, name, value)?;
            return of_dense(name, &dense);
        }
    };
    let shape: (usize, usize) = compressed.getattr("shape")?.extract()?;
    if shape.0 != shape.1 {
        return Err(Failure::input(format!(
            "{name}: has the shape {shape:?}, expected a square matrix"
        ))
        .into());
    }
    let starts = indices(&compressed.getattr("indptr")?, name)?;
    let rows = indices(&compressed.getattr("indices")?, name)?;
    let values = compressed.getattr("data")?;
    let kind: String = values.getattr("dtype")?.getattr("kind")?.extract()?;
    if !matches!(kind.as_str(), "f" | "i" | "u" | "b") {
        let dtype = values.getattr("dtype")?.str()?;
        return Err(Failure::input(format!(
            "{name}: is a matrix of {dtype}, expected real numbers"
        ))
        .into());
    }
    let values = crate::arrays::real(py, name, &values)?;
    let values: Vec<f64> = values.as_array().iter().copied().collect();
    py.detach(|| assembled(name, shape.0, starts, rows, values))
        .map_err(PyErr::from)
}

/// Compressed rows or columns, sorted and without duplicates. What isn't so is copied first: the caller's matrix stays as it is.
fn in_order<'py>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let format: String = value
        .getattr("format")
        .and_then(|format| format.extract())
        .map_err(|_| {
            PyErr::from(Failure::input(format!(
                "{name}: expected a sparse matrix of SciPy, or a dense array"
            )))
        })?;
    let compressed = match format.as_str() {
        "csr" | "csc" => value.clone(),
        _ => value.call_method0("tocsr")?,
    };
    if compressed.getattr("has_canonical_format")?.extract()? {
        return Ok(compressed);
    }
    let own = compressed.call_method0("copy")?;
    own.call_method0("sum_duplicates")?;
    Ok(own)
}

/// Indices of 32 or 64 bits.
fn indices(array: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<u32>> {
    let beyond = || {
        PyErr::from(Failure::input(format!(
            "{name}: has indices beyond 32 bits; at most {} entries are supported",
            u32::MAX
        )))
    };
    if let Ok(small) = array.extract::<PyReadonlyArray1<'_, i32>>() {
        let small = small.as_array();
        return small
            .iter()
            .map(|index| u32::try_from(*index).map_err(|_| beyond()))
            .collect();
    }
    let large = array.extract::<PyReadonlyArray1<'_, i64>>()?;
    let large = large.as_array();
    large
        .iter()
        .map(|index| u32::try_from(*index).map_err(|_| beyond()))
        .collect()
}

fn assembled(
    name: &str,
    size: usize,
    starts: Vec<u32>,
    rows: Vec<u32>,
    values: Vec<f64>,
) -> Result<SparseMatrix, Failure> {
    let refused = |message: String| Failure::input(format!("{name}: {message}"));
    let ends = (starts.first().copied(), starts.last().copied());
    let is_sound = starts.len() == size + 1
        && ends == (Some(0), u32::try_from(rows.len()).ok())
        && rows.len() == values.len()
        && starts.is_sorted();
    if !is_sound {
        return Err(refused(
            "its index arrays contradict each other; was it changed by hand?".into(),
        ));
    }
    for line in 0..size {
        let range = starts[line] as usize..starts[line + 1] as usize;
        let places = &rows[range.clone()];
        if !places.is_sorted_by(|a, b| a < b)
            || places.last().is_some_and(|&at| at as usize >= size)
        {
            return Err(refused(format!(
                "the indices of line {line} aren't rising below {size}"
            )));
        }
        if let Some(at) = values[range].iter().position(|value| !value.is_finite()) {
            return Err(refused(format!(
                "the entry ({line}, {}) isn't finite",
                places[at]
            )));
        }
    }
    let symbolic = SymbolicSparseColMat::new_checked(size, size, starts, None, rows);
    Ok(SparseMatrix::new(symbolic, values))
}

fn of_dense(name: &str, dense: &PyReadonlyArrayDyn<'_, f64>) -> PyResult<SparseMatrix> {
    let dense = dense.as_array();
    let &[size, columns] = dense.shape() else {
        return Err(Failure::input(format!(
            "{name}: has {} axes, expected a square matrix",
            dense.ndim()
        ))
        .into());
    };
    if size != columns {
        return Err(Failure::input(format!(
            "{name}: has the shape ({size}, {columns}), expected a square matrix"
        ))
        .into());
    }
    let (mut starts, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
    for line in 0..size {
        for at in 0..size {
            let value = dense[[line, at]];
            if value != 0.0 {
                rows.push(at as u32);
                values.push(value);
            }
        }
        starts.push(rows.len() as u32);
    }
    Ok(assembled(name, size, starts, rows, values)?)
}
