//! Datasets and attributes into an open file, keeping what the digest needs.

use std::collections::BTreeMap;

use faer::Mat;
use hdf5::types::VarLenUnicode;
use hdf5::{Dataset, H5Type};
use ndarray::s;

use super::Compression;
use super::contract::Counts;
use super::datasets;
use super::units::{Rule, UnitSystem};
use crate::hdf5_files::attributes::{self, Value};
use crate::hdf5_files::digest::{self, Attributes, Hash, Line};
use crate::hdf5_files::element::Element;

/// Values of one chunk of a compressed field array, at most: 1 MiB.
const CHUNK_VALUES: usize = 1 << 17;
/// zlib's own default.
const DEFLATE_LEVEL: u8 = 6;

/// Attributes of a dataset.
pub(super) struct About<'p> {
    pub(super) path: &'p str,
    pub(super) shape: Vec<usize>,
    pub(super) symbol: &'p str,
    pub(super) units: Rule,
    pub(super) description: &'p str,
}

/// A file being filled.
pub(super) struct Sink<'a> {
    file: &'a hdf5::File,
    counts: Counts,
    units: UnitSystem<'a>,
    compression: Compression,
    lines: BTreeMap<String, Line>,
    attributes: Attributes,
}

impl<'a> Sink<'a> {
    /// An empty file; `counts` and `units` give shapes and units of all that follows.
    pub(super) fn new(
        file: &'a hdf5::File,
        counts: Counts,
        units: UnitSystem<'a>,
        compression: Compression,
    ) -> Self {
        Self {
            file,
            counts,
            units,
            compression,
            lines: BTreeMap::new(),
            attributes: BTreeMap::new(),
        }
    }

    /// Writes the digest of all that went before.
    pub(super) fn finish(self) -> hdf5::Result<()> {
        let digest = digest::of_file(&self.lines, &self.attributes);
        attributes::write(self.file, "digest", &Value::Text(digest))
    }

    /// Makes a group.
    pub(super) fn group(&self, path: &str) -> hdf5::Result<()> {
        let builder = self.file.create_group_builder();
        builder.obj_track_times(false).create(path).map(drop)
    }

    /// Writes an attribute of a group or dataset that is there already.
    pub(super) fn attribute(&mut self, path: &str, name: &str, value: Value) -> hdf5::Result<()> {
        if self.lines.contains_key(path) {
            attributes::write(&*self.file.dataset(path)?, name, &value)?;
        } else {
            attributes::write(&*self.file.group(path)?, name, &value)?;
        }
        self.attributes
            .entry(path.to_owned())
            .or_default()
            .insert(name.to_owned(), value);
        Ok(())
    }

    /// Writes reals, row-major, to a path of the contract.
    pub(super) fn reals(&mut self, path: &str, values: &[f64]) -> hdf5::Result<()> {
        let about = self.about(path)?;
        self.put_reals(&about, values)
    }

    /// Writes integers, row-major, to a path of the contract.
    pub(super) fn integers(&mut self, path: &str, values: &[i64]) -> hdf5::Result<()> {
        let about = self.about(path)?;
        self.put_integers(&about, values)
    }

    /// Writes strings to a path of the contract.
    pub(super) fn texts(&mut self, path: &str, values: &[String]) -> hdf5::Result<()> {
        let about = self.about(path)?;
        self.put_texts(&about, values)
    }

    /// Writes the transpose of a field array (n_f, n) to a path of the contract: its columns are the dataset's rows.
    pub(super) fn field(&mut self, path: &str, fields: &Mat<f64>) -> hdf5::Result<()> {
        let about = self.about(path)?;
        let n_f = fields.nrows();
        let empty = n_f == 0 || fields.ncols() == 0;
        let builder = self.file.new_dataset::<f64>();
        let builder = match self.compression {
            Compression::Deflate if !empty => builder
                .chunk([1, n_f.min(CHUNK_VALUES)])
                .shuffle()
                .deflate(DEFLATE_LEVEL),
            _ => builder.no_chunk(),
        };
        let dataset = builder.shape(about.shape.clone()).create(path)?;
        let columns = || (0..fields.ncols()).map(|column| fields.col_as_slice(column));
        let write = || {
            if empty {
                return Ok(());
            }
            columns()
                .enumerate()
                .try_for_each(|(column, values)| dataset.write_slice(values, s![column, ..]))
        };
        let hash = || {
            let mut hash = Hash::default();
            columns().for_each(|values| hash.update_reals(values));
            hash.finish()
        };
        let (written, sha256) = rayon::join(write, hash);
        written?;
        self.annotate(&dataset, &about, Element::Real, sha256)
    }

    /// Writes reals, row-major.
    pub(super) fn put_reals(&mut self, about: &About, values: &[f64]) -> hdf5::Result<()> {
        let dataset = self.put(about, values)?;
        self.annotate(&dataset, about, Element::Real, digest::of_reals(values))
    }

    /// Writes integers, row-major.
    pub(super) fn put_integers(&mut self, about: &About, values: &[i64]) -> hdf5::Result<()> {
        let dataset = self.put(about, values)?;
        self.annotate(
            &dataset,
            about,
            Element::Integer,
            digest::of_integers(values),
        )
    }

    /// Writes strings.
    pub(super) fn put_texts(&mut self, about: &About, values: &[String]) -> hdf5::Result<()> {
        let texts = values
            .iter()
            .map(|text| attributes::hdf5_text(text))
            .collect::<hdf5::Result<Vec<VarLenUnicode>>>()?;
        let dataset = self.put(about, &texts)?;
        self.annotate(&dataset, about, Element::Text, digest::of_texts(values))
    }

    fn put<T: H5Type>(&self, about: &About, values: &[T]) -> hdf5::Result<Dataset> {
        let builder = self.file.new_dataset::<T>().no_chunk();
        let dataset = builder.shape(about.shape.clone()).create(about.path)?;
        match about.shape.is_empty() {
            true => values
                .first()
                .map_or(Ok(()), |value| dataset.write_scalar(value))?,
            false if values.is_empty() => {}
            false => dataset.write_raw(values)?,
        }
        Ok(dataset)
    }

    fn annotate(
        &mut self,
        dataset: &Dataset,
        about: &About,
        element: Element,
        sha256: String,
    ) -> hdf5::Result<()> {
        let units = self.units.attributes(about.units, &about.shape);
        let mut values = vec![
            ("symbol", Value::Text(about.symbol.to_owned())),
            ("units", Value::Text(units.units)),
            ("description", Value::Text(about.description.to_owned())),
            ("sha256", Value::Text(sha256.clone())),
        ];
        values.extend(
            units
                .axes
                .into_iter()
                .map(|(name, texts)| (name, Value::Texts(texts))),
        );
        for (name, value) in &values {
            attributes::write(dataset, name, value)?;
        }
        let values = values
            .into_iter()
            .map(|(name, value)| (name.to_owned(), value));
        self.attributes
            .entry(about.path.to_owned())
            .or_default()
            .extend(values);
        self.lines.insert(
            about.path.to_owned(),
            Line {
                element,
                shape: about.shape.clone(),
                sha256,
            },
        );
        Ok(())
    }

    fn about<'p>(&self, path: &'p str) -> hdf5::Result<About<'p>> {
        let dataset = datasets::dataset(path)
            .ok_or_else(|| hdf5::Error::from(format!("{path} isn't in the contract")))?;
        let units = dataset.units(self.counts.dimension);
        Ok(About {
            path,
            shape: self.counts.shape(dataset),
            symbol: dataset.symbol,
            units,
            description: dataset.description,
        })
    }
}
