//! What a file holds: every dataset's type, shape and claimed hash, and every attribute, without reading any data.

use std::collections::BTreeMap;

use hdf5_pure::{
    Datatype, DatatypeByteOrder, FixedPointLayout, FloatingPointLayout, Group, Layout,
};

use super::attributes::{self, Value};
use super::container::Container;
use super::contract::Element;
use super::digest::{self, Attributes, Line};

/// Groups inside groups, at most: `/mesh/cells/0` has three.
const DEEPEST: usize = 6;
/// Objects of a file, at most.
const MOST_OBJECTS: usize = 100_000;
/// Axes of a dataset, at most.
const MOST_AXES: usize = 8;
/// Deflate can't do better than 1:1032.
const LARGEST_DEFLATE_RATIO: u64 = 1032;
/// HDF5's numbers of the filters that may be used.
const FILTERS: [(u16, &str); 3] = [(DEFLATE, "deflate"), (2, "shuffle"), (3, "fletcher32")];
/// The only one of them that makes data smaller.
const DEFLATE: u16 = 1;

/// Whether every dataset must claim a hash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Hashes {
    /// It must.
    Required,
    /// Hashes aren't kept: the file grew by and by.
    Absent,
}

/// One dataset of a file.
#[derive(Debug)]
pub(crate) struct Entry {
    pub(crate) line: Line,
    pub(crate) dataset: hdf5_pure::Dataset,
}

/// All of a file but the data.
#[derive(Debug, Default)]
pub(crate) struct Inventory {
    pub(crate) entries: BTreeMap<String, Entry>,
    pub(crate) attributes: Attributes,
}

/// A place in the file and what is wrong there.
pub(crate) struct Finding {
    pub(crate) path: String,
    pub(crate) message: String,
}

impl Finding {
    /// What is wrong at a path.
    pub(crate) fn at(path: &str, message: impl Into<String>) -> Self {
        Self {
            path: path.to_owned(),
            message: message.into(),
        }
    }
}

/// The attributes of the root group alone.
pub(crate) fn root_attributes(file: &Container) -> Result<BTreeMap<String, Value>, Finding> {
    let root = file.root();
    attributes::read(root.attrs(), root.attr_datatypes())
        .map_err(|message| Finding::at("/", message))
}

impl Inventory {
    /// Takes the inventory of a file. Soft and external links lead nowhere, as in h5py's `visititems`.
    pub(crate) fn take(file: &Container, hashes: Hashes) -> Result<Self, Finding> {
        let mut walk = Walk {
            file_bytes: file.length(),
            hashes,
            objects: 0,
            found: Self::default(),
        };
        walk.visit(&file.root(), "", 0)?;
        Ok(walk.found)
    }

    /// The digest that the inventory makes.
    pub(crate) fn digest(&self) -> String {
        let lines = self
            .entries
            .iter()
            .map(|(path, entry)| (path.clone(), entry.line.clone()))
            .collect();
        digest::of_file(&lines, &self.attributes)
    }

    /// An attribute of an object.
    pub(crate) fn attribute(&self, path: &str, name: &str) -> Option<&Value> {
        self.attributes.get(path)?.get(name)
    }
}

struct Walk {
    file_bytes: u64,
    hashes: Hashes,
    objects: usize,
    found: Inventory,
}

impl Walk {
    /// Visits a group; `path` is empty for the root.
    fn visit(&mut self, group: &Group, path: &str, depth: usize) -> Result<(), Finding> {
        let here = if path.is_empty() { "/" } else { path };
        let told = |message: String| Finding::at(here, message);
        let unreadable = |error: hdf5_pure::Error| told(format!("can't be read: {error}"));
        if depth > DEEPEST {
            return Err(told(format!("is more than {DEEPEST} groups deep")));
        }
        let attributes = attributes::read(group.attrs(), group.attr_datatypes()).map_err(told)?;
        self.found.attributes.insert(here.to_owned(), attributes);
        for (name, dataset) in group.iter_datasets().map_err(unreadable)? {
            let path = self.member(path, &name)?;
            let told = |message| Finding::at(&path, message);
            let attributes =
                attributes::read(dataset.attrs(), dataset.attr_datatypes()).map_err(told)?;
            let (element, shape) = storage(&dataset, self.file_bytes).map_err(told)?;
            let sha256 = match self.hashes {
                Hashes::Required => claimed_hash(&attributes).map_err(told)?,
                Hashes::Absent => String::new(),
            };
            let line = Line {
                element,
                shape,
                sha256,
            };
            self.found
                .entries
                .insert(path.clone(), Entry { line, dataset });
            self.found.attributes.insert(path, attributes);
        }
        for (name, child) in group.iter_groups().map_err(unreadable)? {
            let path = self.member(path, &name)?;
            self.visit(&child, &path, depth + 1)?;
        }
        Ok(())
    }

    /// The path of one more object.
    fn member(&mut self, group: &str, name: &str) -> Result<String, Finding> {
        let path = format!("{group}/{name}");
        self.objects += 1;
        if self.objects > MOST_OBJECTS {
            let message = format!("is one of more than {MOST_OBJECTS} objects");
            return Err(Finding::at(&path, message));
        }
        if name.is_empty() || name == "." || name.contains(['/', '\0', '\n']) {
            let message = format!("has a member {name:.40?}, which can't be a name");
            return Err(Finding::at(group, message));
        }
        Ok(path)
    }
}

/// Element type and shape of a dataset, if the file can hold what its shape claims.
fn storage(dataset: &hdf5_pure::Dataset, file_bytes: u64) -> Result<(Element, Vec<usize>), String> {
    let unreadable = |error: hdf5_pure::Error| format!("can't be read: {error}");
    let element = element(&dataset.datatype().map_err(unreadable)?)?;
    let shape = dataset.shape().map_err(unreadable)?;
    let impossible = || format!("has the impossible shape {shape:?}");
    let bytes_of = |shape: &[u64]| -> Result<u64, String> {
        let element_bytes = dataset.element_size().map_err(unreadable)?;
        let product = shape
            .iter()
            .try_fold(element_bytes, |product, &size| product.checked_mul(size));
        product.ok_or_else(impossible)
    };
    if shape.len() > MOST_AXES {
        return Err(format!("has {} axes", shape.len()));
    }
    let filters = dataset.filters();
    let known = |filter: &u16| FILTERS.iter().any(|(known, _)| known == filter);
    if let Some(unknown) = filters.iter().find(|filter| !known(filter)) {
        return Err(format!(
            "is stored with filter {unknown}; only {:?} may be used",
            FILTERS.map(|(_, name)| name)
        ));
    }
    let needed = bytes_of(&shape)?;
    let ratio = if filters.contains(&DEFLATE) {
        LARGEST_DEFLATE_RATIO
    } else {
        1
    };
    if needed / ratio > file_bytes {
        return Err(format!(
            "of shape {shape:?} needs {needed} bytes, which a file of {file_bytes} can't hold"
        ));
    }
    match dataset.layout().map_err(unreadable)? {
        // Where there is nothing in it no chunk is stored either.
        Layout::Chunked { chunk_shape, .. }
            if needed > 0 && bytes_of(&chunk_shape)? / ratio > file_bytes =>
        {
            return Err(format!(
                "has chunks of shape {chunk_shape:?}, which a file of {file_bytes} bytes can't hold"
            ));
        }
        Layout::Virtual => {
            return Err("has its data in other files, which isn't allowed".to_owned());
        }
        _ => {}
    }
    let shape = shape
        .iter()
        .map(|&size| usize::try_from(size).map_err(|_| impossible()))
        .collect::<Result<_, _>>()?;
    Ok((element, shape))
}

/// The hash that a dataset says its data have.
fn claimed_hash(attributes: &BTreeMap<String, Value>) -> Result<String, String> {
    match attributes.get("sha256") {
        Some(Value::Text(text)) if text.len() == 64 => Ok(text.clone()),
        _ => Err("has no attribute sha256 with 64 hexadecimal digits".to_owned()),
    }
}

/// Element type: one of three.
fn element(datatype: &Datatype) -> Result<Element, String> {
    let whole = FixedPointLayout {
        signed: true,
        bit_offset: 0,
        bit_precision: 64,
    };
    match datatype {
        Datatype::FloatingPoint {
            size: 8,
            byte_order: DatatypeByteOrder::LittleEndian,
            layout,
        } if *layout == FloatingPointLayout::IEEE754_BINARY64 => Ok(Element::Real),
        Datatype::FixedPoint {
            size: 8,
            byte_order: DatatypeByteOrder::LittleEndian,
            layout,
        } if *layout == whole => Ok(Element::Integer),
        Datatype::String { .. }
        | Datatype::VariableLength {
            is_string: true, ..
        } => Ok(Element::Text),
        _ => Err(
            "holds something else than little-endian f64, little-endian i64 or strings".to_owned(),
        ),
    }
}
