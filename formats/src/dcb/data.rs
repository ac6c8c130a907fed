//! A file's data, read when they are asked for and checked against their hashes.

use faer::Mat;
use hdf5_pure::{Dataset, Layout, VlenStringReadOptions};

use super::read::SuperelementFile;
use crate::hdf5_files::digest::{self, Hash};
use crate::hdf5_files::element::Element;
use crate::hdf5_files::inventory::{Entry, Finding};
use crate::hdf5_files::version::missing;

impl SuperelementFile {
    /// Checks the hash of every dataset and returns how many there are.
    pub(super) fn check_hashes(&self) -> Result<usize, Finding> {
        for (path, entry) in &self.inventory().entries {
            match entry.line.element {
                Element::Real if entry.line.shape.len() == 2 => self.each_row(path, |_, _| ())?,
                Element::Real => drop(self.reals(path)?),
                Element::Integer => drop(self.integers(path)?),
                Element::Text => drop(self.texts(path)?),
            }
        }
        Ok(self.inventory().entries.len())
    }

    /// The inventory's line of a dataset that must be there.
    pub(super) fn entry(&self, path: &str) -> Result<&Entry, Finding> {
        let entry = self.inventory().entries.get(path);
        entry.ok_or_else(|| missing(path))
    }

    /// Reals, row-major.
    pub(super) fn reals(&self, path: &str) -> Result<Vec<f64>, Finding> {
        let entry = self.entry(path)?;
        let values = self.all(path, Dataset::read_f64)?;
        check_hash(path, entry, &digest::of_reals(&values))?;
        Ok(values)
    }

    /// Integers, row-major.
    pub(super) fn integers(&self, path: &str) -> Result<Vec<i64>, Finding> {
        let entry = self.entry(path)?;
        let values = self.all(path, Dataset::read_i64)?;
        check_hash(path, entry, &digest::of_integers(&values))?;
        Ok(values)
    }

    /// Strings.
    pub(super) fn texts(&self, path: &str) -> Result<Vec<String>, Finding> {
        let entry = self.entry(path)?;
        let is_variable = entry.storage.has_variable_strings();
        let file_bytes = usize::try_from(self.container().length()).unwrap_or(usize::MAX);
        let limits = VlenStringReadOptions::new().with_max_payload_bytes(file_bytes);
        let texts = self.all(path, |dataset| match is_variable {
            true => dataset.read_vlen_strings(limits),
            false => dataset.read_string(),
        })?;
        if texts.iter().any(|text| text.contains('\0')) {
            return Err(Finding::at(path, "has a string with a zero byte"));
        }
        check_hash(path, entry, &digest::of_texts(&texts))?;
        Ok(texts)
    }

    /// The transpose of a field array: its rows become columns.
    pub(super) fn field(&self, path: &str) -> Result<Mat<f64>, Finding> {
        let [columns, n_f] = self.entry(path)?.line.shape[..] else {
            return Err(Finding::at(path, "isn't a matrix"));
        };
        let mut fields = Mat::zeros(n_f, columns);
        self.each_row(path, |row, values| {
            fields.col_as_slice_mut(row).copy_from_slice(values)
        })?;
        Ok(fields)
    }

    /// Some columns of a field array, each as a row. Of contiguous data only their bytes are read, which can't be compared with a
    /// hash over all of them; of any other layout everything is read and compared.
    pub(super) fn field_columns(&self, path: &str, columns: &[usize]) -> Result<Mat<f64>, Finding> {
        let entry = self.entry(path)?;
        let [rows, n_f] = entry.line.shape[..] else {
            return Err(Finding::at(path, "isn't a matrix"));
        };
        let mut fields = Mat::zeros(columns.len(), rows);
        let unreadable = |message: String| Finding::at(path, format!("can't be read: {message}"));
        let told = |message: String| Finding::at(path, message);
        let Layout::Contiguous {
            address: Some(address),
            size,
        } = entry.storage.layout().map_err(told)?
        else {
            self.each_row(path, |row, values| {
                for (to, column) in columns.iter().enumerate() {
                    fields[(to, row)] = values[*column];
                }
            })?;
            return Ok(fields);
        };
        let right = (rows * n_f * size_of::<f64>()) as u64;
        let end = address.checked_add(size);
        if size != right || end.is_none_or(|end| end > self.container().length()) {
            let message = format!("has {size} bytes from {address}, which isn't possible");
            return Err(Finding::at(path, message));
        }
        self.container().allow_reading();
        // Adjacent columns, such as the dofs of a node, are read together.
        for run in columns.chunk_by(|a, b| a + 1 == *b) {
            let to = columns.partition_point(|column| *column < run[0]);
            for row in 0..rows {
                let offset = address + ((row * n_f + run[0]) * size_of::<f64>()) as u64;
                let values = self.container().reals_at(offset, run.len());
                for (i, value) in values.map_err(unreadable)?.into_iter().enumerate() {
                    fields[(to + i, row)] = value;
                }
            }
        }
        Ok(fields)
    }

    /// A few rows of a matrix, which can't be compared with the hash over all of them.
    pub(super) fn some_rows(
        &self,
        path: &str,
        start: usize,
        count: usize,
    ) -> Result<Vec<f64>, Finding> {
        let entry = self.entry(path)?;
        let width: usize = entry.line.shape.iter().skip(1).product();
        self.read(path, count * width, |dataset| {
            dataset.read_f64_rows(start as u64, count as u64)
        })
    }

    /// Reads a matrix by and by, whole chunks at a time; the hash is checked at the end.
    fn each_row(&self, path: &str, mut take: impl FnMut(usize, &[f64])) -> Result<(), Finding> {
        let entry = self.entry(path)?;
        let [rows, columns] = entry.line.shape[..] else {
            return Err(Finding::at(path, "isn't a matrix"));
        };
        let window = entry.storage.window_rows(rows, columns);
        let mut hash = Hash::default();
        for start in (0..if columns == 0 { 0 } else { rows }).step_by(window) {
            let count = window.min(rows - start);
            let values = self.read(path, count * columns, |dataset| {
                dataset.read_f64_rows(start as u64, count as u64)
            })?;
            hash.update_reals(&values);
            for (row, values) in values.chunks_exact(columns).enumerate() {
                take(start + row, values);
            }
        }
        check_hash(path, entry, &hash.finish())
    }

    /// All values of a dataset.
    fn all<T>(
        &self,
        path: &str,
        values: impl FnOnce(&Dataset) -> Result<Vec<T>, hdf5_pure::Error>,
    ) -> Result<Vec<T>, Finding> {
        let count = self.entry(path)?.line.shape.iter().product();
        self.read(path, count, values)
    }

    /// Values from the file, as many as there must be.
    fn read<T>(
        &self,
        path: &str,
        count: usize,
        values: impl FnOnce(&Dataset) -> Result<Vec<T>, hdf5_pure::Error>,
    ) -> Result<Vec<T>, Finding> {
        let data = self.entry(path)?.storage.data(self.container());
        let data = data.map_err(|message| Finding::at(path, message))?;
        self.container().allow_reading();
        let values =
            values(data).map_err(|error| Finding::at(path, format!("can't be read: {error}")))?;
        if values.len() != count {
            let message = format!("has {} values instead of {count}", values.len());
            return Err(Finding::at(path, message));
        }
        Ok(values)
    }
}

fn check_hash(path: &str, entry: &Entry, found: &str) -> Result<(), Finding> {
    let claimed = &entry.line.sha256;
    if digest::is_right(claimed, found) {
        return Ok(());
    }
    let message =
        format!("its sha256 is {claimed}, but its data give {found}: they were changed or damaged");
    Err(Finding::at(path, message))
}
