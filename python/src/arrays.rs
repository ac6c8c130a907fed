//! Rust's arrays as NumPy's, without copies where their owner stays alive.

use faer::MatRef;
use numpy::ndarray::{ArrayView1, ArrayView2, ShapeBuilder};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::error::Failure;

/// A matrix that belongs to a Python object which never changes: a read-only array, column after column, that keeps the object alive.
pub fn matrix_of<'py>(
    owner: &Bound<'py, PyAny>,
    matrix: MatRef<'_, f64>,
) -> Bound<'py, PyArray2<f64>> {
    let (rows, columns) = matrix.shape();
    if rows == 0 || columns == 0 {
        return PyArray2::zeros(owner.py(), (rows, columns), true);
    }
    let strides = (matrix.row_stride() as usize, matrix.col_stride() as usize);
    let shape = (rows, columns).strides(strides);
    // SAFETY: the strides are those of the matrix, whose memory belongs to the owner; owners are frozen classes, so it stays where it is and as it is.
    let array = unsafe {
        let view = ArrayView2::from_shape_ptr(shape, matrix.as_ptr());
        PyArray2::borrow_from_array(&view, owner.clone())
    };
    array.readwrite().make_nonwriteable();
    array
}

/// The same of a list of numbers.
pub fn list_of<'py>(owner: &Bound<'py, PyAny>, list: &[f64]) -> Bound<'py, PyArray1<f64>> {
    // SAFETY: as above.
    let array = unsafe { PyArray1::borrow_from_array(&ArrayView1::from(list), owner.clone()) };
    array.readwrite().make_nonwriteable();
    array
}

/// A read-only array of its own.
pub fn copied<'py>(py: Python<'py>, matrix: MatRef<'_, f64>) -> Bound<'py, PyArray2<f64>> {
    let array = PyArray2::zeros(py, matrix.shape(), true);
    {
        let mut into = array.readwrite();
        let mut into = into.as_array_mut();
        for column in 0..matrix.ncols() {
            for row in 0..matrix.nrows() {
                into[[row, column]] = matrix[(row, column)];
            }
        }
    }
    array.readwrite().make_nonwriteable();
    array
}

/// Numbers of an array of any real type and layout with two axes, row after row; finite.
pub fn rows_of(
    py: Python<'_>,
    name: &str,
    value: &Bound<'_, PyAny>,
) -> PyResult<(Vec<f64>, [usize; 2])> {
    let array = real(py, name, value)?;
    let &[rows, columns] = array.shape() else {
        let found = array.shape().to_vec();
        return Err(Failure::input(format!(
            "{name}: has the shape {found:?}, expected two axes, one row for each node"
        ))
        .into());
    };
    let numbers: Vec<f64> = array.as_array().iter().copied().collect();
    Ok((numbers, [rows, columns]))
}

/// An array of doubles, converted where that loses nothing.
pub fn real<'py>(
    py: Python<'py>,
    name: &str,
    value: &Bound<'py, PyAny>,
) -> PyResult<PyReadonlyArrayDyn<'py, f64>> {
    if let Ok(array) = value.extract::<PyReadonlyArrayDyn<'py, f64>>() {
        return Ok(array);
    }
    let numpy = py.import("numpy")?;
    let array = numpy.call_method1("asarray", (value,))?;
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    if !matches!(kind.as_str(), "f" | "i" | "u") {
        let dtype = array.getattr("dtype")?.str()?;
        return Err(Failure::input(format!(
            "{name}: is an array of {dtype}, expected real numbers"
        ))
        .into());
    }
    let array = numpy.call_method1("asarray", (array, "float64"))?;
    array.extract::<PyReadonlyArrayDyn<'py, f64>>()
}
