//! SciPy's sparse matrices, and dense arrays, as the crates' compressed columns.
//!
//! Compressed rows of a symmetric matrix are its compressed columns, so nothing is turned over. Sorted indices without duplicates are copied once, as the
//! crates need 32-bit ones; anything else is put in order in that copy. Nothing that an object says of its own order is believed.

use std::ops::Range;

use dcb_formats::SparseMatrix;
use faer::sparse::SymbolicSparseColMat;
use numpy::PyReadonlyArray1;
use numpy::ndarray::{ArrayView2, Ix2};
use pyo3::prelude::*;

use crate::arrays::real;
use crate::error::Failure;

/// The symmetric matrix that an object holds: SciPy's sparse matrices and arrays in any format, or what NumPy makes a dense array of.
pub fn symmetric(py: Python<'_>, name: &str, value: &Bound<'_, PyAny>) -> PyResult<SparseMatrix> {
    let lines = match value.hasattr("tocsc")? {
        true => {
            let value = in_format(name, value, &["csr", "csc"], "tocsr")?;
            Lines::of(py, name, &value)?
        }
        false => Lines::of_dense(py, name, value, |dense| dense)?,
    };
    if lines.count != lines.width {
        return Err(Failure::input(format!(
            "{name}: has the shape ({}, {}), expected a square matrix",
            lines.count, lines.width
        ))
        .into());
    }
    Ok(py.detach(|| lines.assembled(name))?)
}

/// Any matrix that an object holds.
pub fn rectangular(py: Python<'_>, name: &str, value: &Bound<'_, PyAny>) -> PyResult<SparseMatrix> {
    let lines = match value.hasattr("tocsc")? {
        // Rows are checked before SciPy turns them over.
        true if in_format(name, value, &["csr"], "tocsr")?.is(value) => {
            Lines::of(py, name, value)?.sound(name)?;
            Lines::of(py, name, &value.call_method0("tocsc")?)?
        }
        true => Lines::of(py, name, &in_format(name, value, &["csc"], "tocsc")?)?,
        false => Lines::of_dense(py, name, value, |dense| dense.reversed_axes())?,
    };
    Ok(py.detach(|| lines.assembled(name))?)
}

/// A sparse matrix as it is where it has one of these formats, else converted.
fn in_format<'py>(
    name: &str,
    value: &Bound<'py, PyAny>,
    formats: &[&str],
    conversion: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let format = value.getattr("format").and_then(|format| format.extract());
    let format: String = format.map_err(|_| {
        PyErr::from(Failure::input(format!(
            "{name}: expected a sparse matrix of SciPy, or a dense array"
        )))
    })?;
    let axes: usize = value.getattr("ndim")?.extract()?;
    if axes != 2 {
        return Err(Failure::input(format!(
            "{name}: has {axes} axes, expected a matrix with two"
        ))
        .into());
    }
    match formats.contains(&format.as_str()) {
        true => Ok(value.clone()),
        false => value.call_method0(conversion),
    }
}

/// Compressed rows or columns.
struct Lines {
    count: usize,
    width: usize,
    starts: Vec<u32>,
    places: Vec<u32>,
    values: Vec<f64>,
}

impl Lines {
    /// As they stand in an object of SciPy.
    fn of(py: Python<'_>, name: &str, compressed: &Bound<'_, PyAny>) -> PyResult<Self> {
        let (rows, columns): (usize, usize) = compressed.getattr("shape")?.extract()?;
        let format: String = compressed.getattr("format")?.extract()?;
        let (count, width) = match format.as_str() {
            "csr" => (rows, columns),
            _ => (columns, rows),
        };
        let values = compressed.getattr("data")?;
        let kind: String = values.getattr("dtype")?.getattr("kind")?.extract()?;
        if !matches!(kind.as_str(), "f" | "i" | "u") {
            let dtype = values.getattr("dtype")?.str()?;
            return Err(Failure::input(format!(
                "{name}: is a matrix of {dtype}, expected real numbers"
            ))
            .into());
        }
        Ok(Self {
            count,
            width,
            starts: indices(py, name, &compressed.getattr("indptr")?)?,
            places: indices(py, name, &compressed.getattr("indices")?)?,
            values: real(py, name, &values)?
                .as_array()
                .iter()
                .copied()
                .collect(),
        })
    }

    /// Of a dense array, whose first axis as `turned` counts the lines.
    fn of_dense(
        py: Python<'_>,
        name: &str,
        value: &Bound<'_, PyAny>,
        turned: impl Fn(ArrayView2<'_, f64>) -> ArrayView2<'_, f64>,
    ) -> PyResult<Self> {
        let dense = real(py, name, value)?;
        let dense = dense.as_array();
        let axes = dense.ndim();
        let dense = dense.into_dimensionality::<Ix2>().map_err(|_| {
            PyErr::from(Failure::input(format!(
                "{name}: has {axes} axes, expected a matrix with two"
            )))
        })?;
        let dense = turned(dense);
        let (mut starts, mut places, mut values) = (vec![0], Vec::new(), Vec::new());
        for line in dense.outer_iter() {
            for (place, value) in line.iter().enumerate() {
                if *value != 0.0 {
                    places.push(place as u32);
                    values.push(*value);
                }
            }
            starts.push(places.len() as u32);
        }
        let (count, width) = dense.dim();
        Ok(Self {
            count,
            width,
            starts,
            places,
            values,
        })
    }

    fn range(&self, line: usize) -> Range<usize> {
        self.starts[line] as usize..self.starts[line + 1] as usize
    }

    /// Refuses indices that lead out of the matrix, and entries that are no numbers.
    fn sound(&self, name: &str) -> Result<(), Failure> {
        let refused = |message: String| Err(Failure::input(format!("{name}: {message}")));
        let ends = (self.starts.first().copied(), self.starts.last().copied());
        let is_sound = self.starts.len() == self.count + 1
            && ends == (Some(0), u32::try_from(self.places.len()).ok())
            && self.places.len() == self.values.len()
            && self.starts.is_sorted();
        if !is_sound {
            return refused(
                "its index arrays contradict each other; was it changed by hand?".into(),
            );
        }
        for line in 0..self.count {
            let range = self.range(line);
            let outside = |place: &&u32| **place as usize >= self.width;
            if let Some(place) = self.places[range.clone()].iter().find(outside) {
                return refused(format!(
                    "line {line} has the index {place}, expected 0 to {}",
                    self.width.saturating_sub(1)
                ));
            }
            if let Some(at) = range.into_iter().find(|at| !self.values[*at].is_finite()) {
                return refused(format!(
                    "the entry ({line}, {}) isn't finite",
                    self.places[at]
                ));
            }
        }
        Ok(())
    }

    /// The matrix of which these are the columns.
    fn assembled(self, name: &str) -> Result<SparseMatrix, Failure> {
        self.sound(name)?;
        let is_ordered = |line| self.places[self.range(line)].is_sorted_by(|a, b| a < b);
        let lines = match (0..self.count).all(is_ordered) {
            true => self,
            false => self.in_order(),
        };
        let symbolic = SymbolicSparseColMat::new_checked(
            lines.width,
            lines.count,
            lines.starts,
            None,
            lines.places,
        );
        Ok(SparseMatrix::new(symbolic, lines.values))
    }

    /// Sorted, entries of one place added.
    fn in_order(&self) -> Self {
        let mut ordered = Self {
            count: self.count,
            width: self.width,
            starts: vec![0],
            places: Vec::with_capacity(self.places.len()),
            values: Vec::with_capacity(self.values.len()),
        };
        let mut entries: Vec<(u32, f64)> = Vec::new();
        for line in 0..self.count {
            let range = self.range(line);
            entries.clear();
            entries.extend(
                (self.places[range.clone()].iter().copied())
                    .zip(self.values[range].iter().copied()),
            );
            // Stable: equal places are added in the order in which they stand.
            entries.sort_by_key(|(place, _)| *place);
            for same in entries.chunk_by(|a, b| a.0 == b.0) {
                ordered.places.push(same[0].0);
                ordered
                    .values
                    .push(same.iter().map(|(_, value)| value).sum());
            }
            ordered.starts.push(ordered.places.len() as u32);
        }
        ordered
    }
}

/// Indices of any width.
fn indices(py: Python<'_>, name: &str, array: &Bound<'_, PyAny>) -> PyResult<Vec<u32>> {
    let unusable = || {
        PyErr::from(Failure::input(format!(
            "{name}: has indices that are negative or beyond 32 bits; at most {} entries are supported",
            u32::MAX
        )))
    };
    if let Ok(small) = array.extract::<PyReadonlyArray1<'_, i32>>() {
        let narrow = |index: &i32| u32::try_from(*index).map_err(|_| unusable());
        return small.as_array().iter().map(narrow).collect();
    }
    let numpy = py.import("numpy")?;
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    let large = match kind.as_str() {
        "i" | "u" => numpy.call_method1("asarray", (array, "int64"))?,
        _ => {
            return Err(Failure::input(format!("{name}: its indices are no whole numbers")).into());
        }
    };
    let large = large.extract::<PyReadonlyArray1<'_, i64>>()?;
    let narrow = |index: &i64| u32::try_from(*index).map_err(|_| unusable());
    large.as_array().iter().map(narrow).collect()
}
