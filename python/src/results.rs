//! Results of runs, read when they are asked for.

use std::path::PathBuf;

use dcb_formats::results::{Outcome, Results as File};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

use crate::arrays::copied;
use crate::fence::apart;

/// Path, description, names and units of the columns of a channel.
type Channel = (String, String, Vec<String>, Vec<String>);

#[pyclass(frozen, module = "tisserand._native")]
pub struct Results {
    file: File,
}

#[pymethods]
impl Results {
    #[new]
    fn new(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        apart(py, || {
            Ok(Self {
                file: File::open(&path)?,
            })
        })
    }

    #[getter]
    fn units(&self) -> (&str, &str, &str) {
        let units = self.file.units();
        (&units.length, &units.mass, &units.time)
    }

    #[getter]
    fn is_complete(&self) -> bool {
        *self.file.outcome() == Outcome::Complete
    }

    /// Why a run ended before its end.
    #[getter]
    fn stopped(&self) -> Option<&str> {
        match self.file.outcome() {
            Outcome::Complete => None,
            Outcome::Stopped { reason, .. } => Some(reason),
        }
    }

    fn channels(&self) -> Vec<Channel> {
        let channel = |channel: &dcb_formats::results::Channel| {
            let columns = || channel.columns.iter();
            (
                channel.path.clone(),
                channel.description.clone(),
                columns().map(|column| column.name.clone()).collect(),
                columns().map(|column| column.unit.clone()).collect(),
            )
        };
        self.file.channels().iter().map(channel).collect()
    }

    fn time<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let time = apart(py, || Ok(self.file.time()?))?;
        let time = PyArray1::from_vec(py, time);
        time.readwrite().make_nonwriteable();
        Ok(time)
    }

    /// (steps, columns).
    fn history<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let history = apart(py, || Ok(self.file.history(name)?))?;
        Ok(copied(py, history.as_ref()))
    }

    fn events(&self, py: Python<'_>) -> PyResult<Vec<(f64, String)>> {
        let events = apart(py, || Ok(self.file.events()?))?;
        let event = |event: dcb_formats::results::Event| (event.time, event.message);
        Ok(events.into_iter().map(event).collect())
    }

    /// Angular frequencies, frequencies and damping ratios of an analysis of modes: name, unit, values.
    fn modes(&self, py: Python<'_>) -> PyResult<Vec<(String, String, Vec<f64>)>> {
        let modes = apart(py, || Ok(self.file.modes()?))?;
        let Some(modes) = modes else {
            return Ok(Vec::new());
        };
        let lists = modes.lists(self.file.units());
        let list =
            |(name, unit, values): (&str, String, &[f64])| (name.to_owned(), unit, values.to_vec());
        Ok(lists.into_iter().map(list).collect())
    }
}
