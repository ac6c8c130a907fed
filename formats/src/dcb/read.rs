//! A superelement from a file that anybody may have made.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use faer::Mat;
use ndarray::s;

use super::attributes::Value;
use super::bytes::{Cursor, FileBytes};
use super::contract::{Axis, Counts, DATASETS, Dataset, Element, Presence};
use super::digest::{self, Hash};
use super::inventory::{self, Entry, Finding, Inventory};
use super::messages::Storage;
use super::object_header;
use super::text::{DESCRIPTOR_BYTES, Texts};
use super::{FORMAT, FORMAT_VERSION, FormatVersion, assemble, check, names};
use crate::Error;
use crate::mesh::{CellBlock, Dimension, Mesh};
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
            check::recovery(&basis, self.counts.dimension, columns, None)?;
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
            check::mesh(&mesh, self.counts.dimension)?;
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
                    .map_err(|message| wrong(path, message))?;
            }
            Storage::Chunked => {
                let read = |error: hdf5::Error| wrong(path, format!("cannot be read: {error}"));
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
            return Err(wrong(path, "is compressed".to_owned()));
        };
        let count: usize = entry.line.shape.iter().product();
        let read = || {
            let bytes = self.bytes.read(offset, count as u64 * DESCRIPTOR_BYTES)?;
            let (mut at, mut texts) = (Cursor::new(&bytes), Texts::new(&self.bytes));
            (0..count)
                .map(|_| texts.next(&mut at))
                .collect::<Result<Vec<_>, String>>()
        };
        let texts = read().map_err(|message| wrong(path, message))?;
        self.check_hash(path, entry, digest::of_texts(&texts))?;
        Ok(texts)
    }

    /// The transpose of a field array: its rows become columns.
    fn field(&self, path: &str) -> Result<Mat<f64>, Finding> {
        let [columns, n_f] = self.entry(path)?.line.shape[..] else {
            return Err(wrong(path, "isn't a matrix".to_owned()));
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
            return Err(wrong(path, "isn't a matrix".to_owned()));
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
                        .map_err(|message| wrong(path, message))?;
                }
                Storage::Chunked => {
                    let chunked = chunked.as_ref().ok_or_else(|| missing(path))?;
                    let read = chunked.read_slice_1d::<f64, _>(s![row, ..]);
                    let read =
                        read.map_err(|error| wrong(path, format!("cannot be read: {error}")))?;
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
            open().map_err(|error| wrong(path, format!("cannot be read: {error}")))?;
        if !is_real || dataset.shape() != entry.line.shape {
            return Err(wrong(
                path,
                "isn't what its header said when the file was opened".to_owned(),
            ));
        }
        Ok(dataset)
    }

    fn raw(&self, path: &str, entry: &Entry, element_bytes: u64) -> Result<Vec<u8>, Finding> {
        let Storage::Contiguous(offset) = entry.storage else {
            return Err(wrong(path, "is compressed".to_owned()));
        };
        let count = entry.line.shape.iter().product::<usize>() as u64 * element_bytes;
        self.bytes
            .read(offset, count)
            .map_err(|message| wrong(path, message))
    }

    fn check_hash(&self, path: &str, entry: &Entry, found: String) -> Result<(), Finding> {
        if found == entry.line.sha256 {
            return Ok(());
        }
        let claimed = &entry.line.sha256;
        Err(wrong(
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
                    wrong(path, "isn't a name as the format writes it".to_owned())
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
            wrong(
                path,
                format!("names a node that isn't from 0 to {}", u32::MAX),
            )
        })
    }
}

pub(super) fn wrong(path: &str, message: String) -> Finding {
    Finding {
        path: path.to_owned(),
        message,
    }
}

fn missing(path: &str) -> Finding {
    wrong(path, "is missing".to_owned())
}

/// Format and version, before anything else is believed.
fn read_version(attributes: &BTreeMap<String, Value>) -> Result<FormatVersion, Finding> {
    let root = |message: String| wrong("/", message);
    let read = |name: &str| match attributes.get(name) {
        Some(Value::Text(text)) => Ok(text),
        Some(other) => Err(root(format!(
            "attribute {name} is {other:?}; it must be a string"
        ))),
        None => Err(root(format!(
            "attribute {name} is missing: this isn't a superelement"
        ))),
    };
    let format = read("format")?;
    if format != FORMAT {
        return Err(root(format!(
            "format is {format:.40?}; a superelement's is {FORMAT:?}"
        )));
    }
    let text = read("format_version")?;
    let parts = text
        .split_once('.')
        .and_then(|(major, minor)| Some((major.parse().ok()?, minor.parse().ok()?)));
    let (major, minor) = parts.ok_or_else(|| {
        root(format!(
            "format_version is {text:.40?}; it must be like \"{FORMAT_VERSION}\""
        ))
    })?;
    if major != FORMAT_VERSION.major {
        return Err(root(format!(
            "format_version is {major}.{minor}, and this program reads versions {}.x; use a program that reads {major}.x",
            FORMAT_VERSION.major
        )));
    }
    Ok(FormatVersion { major, minor })
}

/// A text attribute that must be there.
pub(super) fn text_attribute<'i>(
    inventory: &'i Inventory,
    path: &str,
    name: &str,
) -> Result<&'i str, Finding> {
    match inventory.attribute(path, name) {
        Some(Value::Text(text)) => Ok(text),
        Some(other) => Err(wrong(
            path,
            format!("attribute {name} is {other:?}; it must be a string"),
        )),
        None => Err(wrong(path, format!("attribute {name} is missing"))),
    }
}

/// The numbers that all shapes must agree with.
fn count(inventory: &Inventory) -> Result<Counts, Finding> {
    let dimension = match inventory.attribute("/", "dimension") {
        Some(Value::Integer(2)) => Dimension::Planar,
        Some(Value::Integer(3)) => Dimension::Spatial,
        other => {
            return Err(wrong(
                "/",
                format!("attribute dimension is {other:?}; it must be the integer 2 or 3"),
            ));
        }
    };
    let size = |path: &str, axis: usize| {
        let entry = inventory.entries.get(path).ok_or_else(|| missing(path))?;
        entry
            .line
            .shape
            .get(axis)
            .copied()
            .ok_or_else(|| wrong(path, format!("has no axis {axis}")))
    };
    let optional = |path: &str, axis: usize| {
        if inventory.entries.contains_key(path) {
            size(path, axis)
        } else {
            Ok(0)
        }
    };
    Ok(Counts {
        dimension,
        interfaces: size("/interfaces/names", 0)?,
        rows: size("/interfaces/dofs", 0)?,
        modes: size("/modes/eigenvalues", 0)?,
        enrichment: optional("/enrichment/interface_shapes", 1)?,
        rank: size("/residual/sigma2", 0)?,
        field_dofs: optional("/fields/dofs", 0)?,
    })
}

/// Everything that must be there is there, in type and shape.
fn check_shapes(inventory: &Inventory, counts: &Counts) -> Result<(), Finding> {
    for dataset in DATASETS {
        match inventory.entries.get(dataset.path) {
            Some(entry) => check_shape(dataset, entry, counts)?,
            None if is_required(dataset, inventory, counts) => return Err(missing(dataset.path)),
            None => {}
        }
    }
    for path in inventory.entries.keys() {
        text_attribute(inventory, path, "symbol")?;
        text_attribute(inventory, path, "units")?;
        if path.starts_with("/mesh/") {
            check_mesh_shape(inventory, path, counts)?;
        }
    }
    if !inventory.entries.contains_key("/mesh/points")
        && inventory
            .entries
            .keys()
            .any(|path| path.starts_with("/mesh/"))
    {
        return Err(missing("/mesh/points"));
    }
    match inventory.attribute("/residual/transform", "rank") {
        Some(Value::Integer(rank)) if usize::try_from(*rank) == Ok(counts.rank) => Ok(()),
        other => Err(wrong(
            "/residual/transform",
            format!(
                "attribute rank is {other:?}; its columns are {}",
                counts.rank
            ),
        )),
    }
}

fn is_required(dataset: &Dataset, inventory: &Inventory, counts: &Counts) -> bool {
    let any = |presence: Presence| {
        DATASETS
            .iter()
            .any(|other| other.presence == presence && inventory.entries.contains_key(other.path))
    };
    match dataset.presence {
        Presence::Required => true,
        Presence::Spatial => counts.dimension == Dimension::Spatial,
        Presence::Optional => false,
        group => any(group),
    }
}

fn check_shape(dataset: &Dataset, entry: &Entry, counts: &Counts) -> Result<(), Finding> {
    let shape = counts.shape(dataset);
    if dataset.presence == Presence::Spatial && counts.dimension == Dimension::Planar {
        return Err(wrong(
            dataset.path,
            "doesn't belong in a planar superelement".to_owned(),
        ));
    }
    if entry.line.element != dataset.element || entry.line.shape != shape {
        return Err(wrong(
            dataset.path,
            format!(
                "is {} of shape {:?}; the other parts need {} of shape {shape:?}",
                entry.line.element.name(),
                entry.line.shape,
                dataset.element.name()
            ),
        ));
    }
    Ok(())
}

fn check_mesh_shape(inventory: &Inventory, path: &str, counts: &Counts) -> Result<(), Finding> {
    let Some(entry) = inventory.entries.get(path) else {
        return Err(missing(path));
    };
    let line = &entry.line;
    let d = counts.length(Axis::Coordinates);
    let right = match path
        .strip_prefix("/mesh/")
        .unwrap_or(path)
        .split('/')
        .collect::<Vec<_>>()[..]
    {
        ["points"] => line.element == Element::Real && line.shape.len() == 2 && line.shape[1] == d,
        ["cells", block, "data"] => {
            let index = block.parse::<usize>();
            let preceded = |index: usize| {
                index == 0
                    || inventory
                        .entries
                        .contains_key(&format!("/mesh/cells/{}/data", index - 1))
            };
            let named = inventory
                .entries
                .contains_key(&format!("/mesh/cells/{block}/type"));
            line.element == Element::Integer
                && line.shape.len() == 2
                && named
                && index.is_ok_and(preceded)
        }
        ["cells", block, "type"] => {
            let has_data = inventory
                .entries
                .contains_key(&format!("/mesh/cells/{block}/data"));
            line.element == Element::Text && line.shape.is_empty() && has_data
        }
        ["point_sets", _] => line.element == Element::Integer && line.shape.len() == 1,
        _ => true,
    };
    if right {
        Ok(())
    } else {
        Err(wrong(
            path,
            format!(
                "{} of shape {:?} doesn't fit there",
                line.element.name(),
                line.shape
            ),
        ))
    }
}
