//! Inventory of a file: every dataset's type, shape and claimed hash, and every attribute, without reading any data.

use std::collections::BTreeMap;

use hdf5_pure::{Dataset, Group};

use super::attributes::{self, Value};
use super::container::{Container, SPARE_BYTES};
use super::digest::{self, Attributes, Line};
use super::storage::{Storage, element_of};
use crate::terminal::shortened;

/// Groups inside groups, at most: `/mesh/cells/0` has three.
const DEEPEST: usize = 6;
/// Objects of a file, at most.
const MOST_OBJECTS: usize = 100_000;

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
    pub(crate) storage: Storage,
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
    /// Fault at a path.
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
            claimed: 0,
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
    /// Stored bytes that the datasets so far need at least.
    claimed: u64,
    found: Inventory,
}

impl Walk {
    /// Adds what one more dataset needs: each may fit the file where all of them together can't.
    fn claim(&mut self, bytes: u64) -> Result<(), String> {
        self.claimed = self.claimed.saturating_add(bytes);
        if self.claimed > self.file_bytes.saturating_add(SPARE_BYTES) {
            return Err(format!(
                "and the datasets before it need {} bytes together, which a file of {} can't hold",
                self.claimed, self.file_bytes
            ));
        }
        Ok(())
    }

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
            if self.is_time_again(&path, &name, &dataset) {
                continue;
            }
            let told = |message| Finding::at(&path, message);
            let attributes = self.attributes_of(&dataset).map_err(told)?;
            let element = element_of(&dataset).map_err(told)?;
            let storage = Storage::of(dataset, self.file_bytes).map_err(told)?;
            self.claim(storage.needed()).map_err(told)?;
            let shape = storage.shape().to_vec();
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
                .insert(path.clone(), Entry { line, storage });
            self.found.attributes.insert(path, attributes);
        }
        for (name, child) in group.iter_groups().map_err(unreadable)? {
            let path = self.member(path, &name)?;
            self.visit(&child, &path, depth + 1)?;
        }
        Ok(())
    }

    /// Attributes of a dataset; those of files that grow without what ties them to their dimension scales.
    fn attributes_of(&self, dataset: &Dataset) -> Result<BTreeMap<String, Value>, String> {
        let (values, types) = (dataset.attrs(), dataset.attr_datatypes());
        match self.hashes {
            Hashes::Required => attributes::read(values, types),
            Hashes::Absent => attributes::read_but_references(values, types),
        }
    }

    /// Whether a dataset of a file that grows is the times in one of its groups: the same as those of the root, which are counted there.
    fn is_time_again(&self, path: &str, name: &str, dataset: &Dataset) -> bool {
        let is_list = || dataset.shape().is_ok_and(|shape| shape.len() == 1);
        self.hashes == Hashes::Absent && name == "time" && path != "/time" && is_list()
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
            let message = format!("has a member {:?}, which can't be a name", shortened(name));
            return Err(Finding::at(group, message));
        }
        Ok(path)
    }
}

/// The hash that a dataset says its data have.
fn claimed_hash(attributes: &BTreeMap<String, Value>) -> Result<String, String> {
    match attributes.get("sha256") {
        Some(Value::Text(text)) if text.len() == 64 => Ok(text.clone()),
        _ => Err("has no attribute sha256 with 64 hexadecimal digits".to_owned()),
    }
}
