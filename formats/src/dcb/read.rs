//! A superelement from a file that anybody may have made.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use faer::Mat;
use ndarray::s;

use super::bytes::{Cursor, FileBytes};
use super::contract::{Counts, Element};
use super::digest::{self, Hash};
use super::inventory::{self, Entry, Finding, Inventory};
use super::messages::Storage;
use super::object_header;
use super::shapes::{check_shapes, count, missing, read_version, text_attribute};
use super::text::{DESCRIPTOR_BYTES, Texts};
use super::{FormatVersion, assemble, check, check_fields, names};
use crate::Error;
use crate::mesh::{CellBlock, Mesh};
use crate::superelement::{RecoveryBasis, Superelement};

/// An open `.dcb.h5` file. Opening checks its version, its digest and all shapes; data are read, and checked
/// against their hashes, when asked for. A large file opens at once.
#[derive(Debug)]
pub struct SuperelementFile {
    path: PathBuf,
    bytes: FileBytes,
    inventory: Inventory,
    counts: Counts,
    version: FormatVersion,
    digest: String,
}

/// Reads a superelement without its nodal fields.
///
/// # Errors
/// As [`SuperelementFile::open`] and [`SuperelementFile::superelement`].
pub fn read_superelement(path: &Path) -> Result<Superelement, Error> {
    SuperelementFile::open(path)?.superelement()
}

impl SuperelementFile {
    /// Opens a file and checks everything but the data.
    ///
    /// # Errors
    /// The file can't be read, isn't a superelement, is of a higher major version, is damaged, or its parts don't
    /// fit each other; the message names the place.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref().to_owned();
        let io = |action| {
            let path = path.clone();
            move |source| Error::Io {
                path,
                action,
                source,
            }
        };
        let unusable = |message: String| Error::File {
            path: path.clone(),
            message,
        };
        let at = |finding: Finding| Error::Location {
            path: path.clone(),
            location: finding.path,
            message: finding.message,
        };

        let status = std::fs::metadata(&path).map_err(io("cannot read"))?;
        if !status.is_file() {
            return Err(unusable(
                "isn't a file; a superelement is a file NAME.dcb.h5".to_owned(),
            ));
        }
        let bytes = FileBytes::new(File::open(&path).map_err(io("cannot read"))?, status.len());
        let root = object_header::root(&bytes).map_err(unusable)?;
        let version =
            read_version(&inventory::root_attributes(&bytes, root).map_err(at)?).map_err(at)?;
        let inventory = Inventory::take(&bytes, root).map_err(at)?;
        let digest = text_attribute(&inventory, "/", "digest")
            .map_err(at)?
            .to_owned();
        let found = inventory.digest();
        if digest != found {
            let message = format!(
                "digest is {digest}, but the file's contents give {found}: they were changed or damaged"
            );
            return Err(at(Finding {
                path: "/".to_owned(),
                message,
            }));
        }
        let counts = count(&inventory).map_err(at)?;
        check_shapes(&inventory, &counts).map_err(at)?;
        Ok(Self {
            path,
            bytes,
            inventory,
            counts,
            version,
            digest,
        })
    }

    /// The version that the file says it is.
    pub fn format_version(&self) -> FormatVersion {
        self.version
    }

    /// The digest, checked on opening: it identifies the superelement.
    pub fn digest(&self) -> &str {
        &self.digest
    }

    /// Reads the superelement.
    ///
    /// # Errors
    /// [`Error::Location`]: data that don't match their hash, or numbers that break the contract.
    pub fn superelement(&self) -> Result<Superelement, Error> {
        let superelement = assemble::superelement(self).map_err(|finding| self.told(finding))?;
        check::superelement(&superelement).map_err(|finding| self.told(finding))?;
        Ok(superelement)
    }

    /// Reads the nodal fields, if the file has them.
    ///
    /// # Errors
    /// As [`SuperelementFile::superelement`].
    pub fn recovery(&self) -> Result<Option<RecoveryBasis>, Error> {
        if !self.has("/fields/dofs") {
            return Ok(None);
        }
        let read = || {
            let basis = RecoveryBasis {
                dofs: assemble::field_dofs(self)?,
                modes: self.field("/modes/shapes")?,
                residual: self.field("/residual/shapes")?,
            };
            let columns = (self.counts.modes, self.counts.rows);
            let points = self.inventory.entries.get("/mesh/points");
            let node_count = points.and_then(|entry| entry.line.shape.first().copied());
            check_fields::recovery(&basis, self.counts.dimension, columns, node_count)?;
            Ok(basis)
        };
        read().map(Some).map_err(|finding| self.told(finding))
    }

    /// Reads the mesh, if the file has one.
    ///
    /// # Errors
    /// As [`SuperelementFile::superelement`].
    pub fn mesh(&self) -> Result<Option<Mesh>, Error> {
        if !self.has("/mesh/points") {
            return Ok(None);
        }
        let read = || {
            let mesh = self.read_mesh()?;
            check_fields::mesh(&mesh, self.counts.dimension)?;
            Ok(mesh)
        };
        read().map(Some).map_err(|finding| self.told(finding))
    }

    /// Checks the hash of every dataset and returns how many there are.
    ///
    /// # Errors
    /// The first dataset whose data don't match.
    pub fn verify_digests(&self) -> Result<usize, Error> {
        for (path, entry) in &self.inventory.entries {
            let checked = match entry.line.element {
                Element::Real if entry.line.shape.len() == 2 => self.each_row(path, |_, _| ()),
                Element::Real => self.reals(path).map(drop),
                Element::Integer => self.integers(path).map(drop),
                Element::Text => self.texts(path).map(drop),
            };
            checked.map_err(|finding| self.told(finding))?;
        }
        Ok(self.inventory.entries.len())
    }

    fn told(&self, finding: Finding) -> Error {
        Error::Location {
            path: self.path.clone(),
            location: finding.path,
            message: finding.message,
        }
    }

    pub(super) fn counts(&self) -> &Counts {
        &self.counts
    }

    pub(super) fn inventory(&self) -> &Inventory {
        &self.inventory
    }

    pub(super) fn has(&self, path: &str) -> bool {
        self.inventory.entries.contains_key(path)
    }

    fn entry(&self, path: &str) -> Result<&Entry, Finding> {
        self.inventory
            .entries
            .get(path)
            .ok_or_else(|| missing(path))
    }

    /// Reals, row-major.
    pub(super) fn reals(&self, path: &str) -> Result<Vec<f64>, Finding> {
        let entry = self.entry(path)?;
        let mut values = vec![0.0; entry.line.shape.iter().product()];
        match entry.storage {
            Storage::Contiguous(offset) => {
                self.bytes
                    .read_reals(offset, &mut values)
                    .map_err(|message| Finding::at(path, message))?;
            }
            Storage::Chunked => {
                let read =
                    |error: hdf5::Error| Finding::at(path, format!("cannot be read: {error}"));
                self.chunked(path, entry)?
                    .read_into_raw(&mut values)
                    .map_err(read)?;
            }
        }
        self.check_hash(path, entry, digest::of_reals(&values))?;
        Ok(values)
    }

    /// Integers, row-major.
    pub(super) fn integers(&self, path: &str) -> Result<Vec<i64>, Finding> {
        let entry = self.entry(path)?;
        let bytes = self.raw(path, entry, 8)?;
        let (words, _) = bytes.as_chunks::<8>();
        let values: Vec<i64> = words.iter().map(|word| i64::from_le_bytes(*word)).collect();
        self.check_hash(path, entry, digest::of_integers(&values))?;
        Ok(values)
    }

    /// Strings.
    pub(super) fn texts(&self, path: &str) -> Result<Vec<String>, Finding> {
        let entry = self.entry(path)?;
        let Storage::Contiguous(offset) = entry.storage else {
            return Err(Finding::at(path, "is compressed".to_owned()));
        };
        let count: usize = entry.line.shape.iter().product();
        let read = || {
            let bytes = self.bytes.read(offset, count as u64 * DESCRIPTOR_BYTES)?;
            let (mut at, mut texts) = (Cursor::new(&bytes), Texts::new(&self.bytes));
            (0..count)
                .map(|_| texts.next(&mut at))
                .collect::<Result<Vec<_>, String>>()
        };
        let texts = read().map_err(|message| Finding::at(path, message))?;
        self.check_hash(path, entry, digest::of_texts(&texts))?;
        Ok(texts)
    }

    /// The transpose of a field array: its rows become columns.
    fn field(&self, path: &str) -> Result<Mat<f64>, Finding> {
        let [columns, n_f] = self.entry(path)?.line.shape[..] else {
            return Err(Finding::at(path, "isn't a matrix".to_owned()));
        };
        let mut fields = Mat::zeros(n_f, columns);
        self.each_row(path, |row, values| {
            fields.col_as_slice_mut(row).copy_from_slice(values)
        })?;
        Ok(fields)
    }

    /// Reads a matrix row by row; the hash is checked at the end.
    fn each_row(&self, path: &str, mut take: impl FnMut(usize, &[f64])) -> Result<(), Finding> {
        let entry = self.entry(path)?;
        let [rows, columns] = entry.line.shape[..] else {
            return Err(Finding::at(path, "isn't a matrix".to_owned()));
        };
        let chunked = if entry.storage == Storage::Chunked {
            Some(self.chunked(path, entry)?)
        } else {
            None
        };
        let mut hash = Hash::default();
        let mut values = vec![0.0; columns];
        for row in 0..if columns == 0 { 0 } else { rows } {
            match entry.storage {
                Storage::Contiguous(offset) => {
                    let offset = offset + 8 * (row * columns) as u64;
                    self.bytes
                        .read_reals(offset, &mut values)
                        .map_err(|message| Finding::at(path, message))?;
                }
                Storage::Chunked => {
                    let chunked = chunked.as_ref().ok_or_else(|| missing(path))?;
                    let read = chunked.read_slice_1d::<f64, _>(s![row, ..]);
                    let read = read
                        .map_err(|error| Finding::at(path, format!("cannot be read: {error}")))?;
                    values
                        .iter_mut()
                        .zip(read)
                        .for_each(|(value, read)| *value = read);
                }
            }
            hash.update_reals(&values);
            take(row, &values);
        }
        self.check_hash(path, entry, hash.finish())
    }

    /// A compressed field array: the only thing that libhdf5 reads.
    fn chunked(&self, path: &str, entry: &Entry) -> Result<hdf5::Dataset, Finding> {
        let open = || -> hdf5::Result<_> {
            let dataset = hdf5::File::open(&self.path)?.dataset(path)?;
            let is_real = dataset.dtype()?.is::<f64>();
            Ok((dataset, is_real))
        };
        let (dataset, is_real) =
            open().map_err(|error| Finding::at(path, format!("cannot be read: {error}")))?;
        if !is_real || dataset.shape() != entry.line.shape {
            return Err(Finding::at(
                path,
                "isn't what its header said when the file was opened".to_owned(),
            ));
        }
        Ok(dataset)
    }

    fn raw(&self, path: &str, entry: &Entry, element_bytes: u64) -> Result<Vec<u8>, Finding> {
        let Storage::Contiguous(offset) = entry.storage else {
            return Err(Finding::at(path, "is compressed".to_owned()));
        };
        let count = entry.line.shape.iter().product::<usize>() as u64 * element_bytes;
        self.bytes
            .read(offset, count)
            .map_err(|message| Finding::at(path, message))
    }

    fn check_hash(&self, path: &str, entry: &Entry, found: String) -> Result<(), Finding> {
        if found == entry.line.sha256 {
            return Ok(());
        }
        let claimed = &entry.line.sha256;
        Err(Finding::at(
            path,
            format!(
                "its sha256 is {claimed}, but its data give {found}: they were changed or damaged"
            ),
        ))
    }

    fn read_mesh(&self) -> Result<Mesh, Finding> {
        let mut cells = Vec::new();
        loop {
            let path = format!("/mesh/cells/{}", cells.len());
            let data = format!("{path}/data");
            if !self.has(&data) {
                break;
            }
            let cell_type = self
                .texts(&format!("{path}/type"))?
                .pop()
                .unwrap_or_default();
            let nodes_per_cell = self.entry(&data)?.line.shape.get(1).copied().unwrap_or(0);
            cells.push(CellBlock {
                cell_type,
                nodes_per_cell,
                nodes: self.nodes(&data)?,
            });
        }
        let mut point_sets = BTreeMap::new();
        for path in self.inventory.entries.keys() {
            if let Some(link) = path.strip_prefix("/mesh/point_sets/") {
                let name = names::decode(link).ok_or_else(|| {
                    Finding::at(path, "isn't a name as the format writes it".to_owned())
                })?;
                point_sets.insert(name, self.nodes(path)?);
            }
        }
        Ok(Mesh {
            dimension: self.counts.dimension,
            coordinates: self.reals("/mesh/points")?,
            cells,
            point_sets,
        })
    }

    fn nodes(&self, path: &str) -> Result<Vec<u32>, Finding> {
        let ids = self
            .integers(path)?
            .into_iter()
            .map(u32::try_from)
            .collect::<Result<Vec<_>, _>>();
        ids.map_err(|_| {
            Finding::at(
                path,
                format!("names a node that isn't from 0 to {}", u32::MAX),
            )
        })
    }
}
