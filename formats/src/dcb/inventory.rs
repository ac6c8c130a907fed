//! What a file holds: every dataset's type, shape, storage and claimed hash, and every attribute that the digest
//! covers, without reading any data.

use std::collections::BTreeMap;

use hdf5::types::{FloatSize, IntSize, TypeDescriptor};
use hdf5::{Group, LinkType, LocationType};

use super::attributes::{self, Value};
use super::contract::Element;
use super::digest::{self, Attributes, Line};
use super::storage::{self, Storage};

/// Groups inside groups, at most: `/mesh/cells/0` has three.
const DEEPEST: usize = 6;
/// Objects and attributes of a file, at most.
const MOST_OBJECTS: usize = 100_000;
/// Axes of a dataset, at most.
const MOST_AXES: usize = 8;

/// The lists of attributes that carry units; they are as long as an axis of their dataset.
const LONGEST_PLAIN_LIST: usize = 65_536;

/// One dataset of a file.
#[derive(Debug)]
pub(super) struct Entry {
    pub(super) dataset: hdf5::Dataset,
    pub(super) line: Line,
    pub(super) storage: Storage,
}

/// All of a file but the data.
#[derive(Debug, Default)]
pub(super) struct Inventory {
    pub(super) entries: BTreeMap<String, Entry>,
    pub(super) attributes: Attributes,
    objects: usize,
}

/// A place in the file and what is wrong there.
pub(super) struct Finding {
    pub(super) path: String,
    pub(super) message: String,
}

fn finding(path: &str) -> impl Fn(String) -> Finding + '_ {
    move |message| Finding { path: path.to_owned(), message }
}

impl Inventory {
    /// Takes the inventory of a file.
    pub(super) fn take(file: &hdf5::File, file_bytes: u64) -> Result<Self, Finding> {
        let mut inventory = Self::default();
        let root = file.group("/").map_err(|error| finding("/")(format!("is unreadable: {error}")))?;
        inventory.visit(&root, "", 0, file_bytes)?;
        Ok(inventory)
    }

    /// The digest that the inventory makes.
    pub(super) fn digest(&self) -> String {
        let lines = self.entries.iter().map(|(path, entry)| (path.clone(), entry.line.clone())).collect();
        digest::of_file(&lines, &self.attributes)
    }

    fn count(&mut self, path: &str) -> Result<(), Finding> {
        self.objects += 1;
        if self.objects > MOST_OBJECTS {
            return Err(finding(path)(format!("the file holds more than {MOST_OBJECTS} objects and attributes")));
        }
        Ok(())
    }

    fn visit(&mut self, group: &Group, path: &str, depth: usize, file_bytes: u64) -> Result<(), Finding> {
        let here = if path.is_empty() { "/" } else { path };
        let told = |error: hdf5::Error| finding(here)(format!("is unreadable: {error}"));
        self.count(here)?;
        if depth > DEEPEST {
            return Err(finding(here)(format!("groups are nested more than {DEEPEST} deep")));
        }
        if group.len() > MOST_OBJECTS as u64 {
            return Err(finding(here)(format!("claims {} members", group.len())));
        }
        self.read_attributes(group, here, LONGEST_PLAIN_LIST)?;
        let mut links = Vec::new();
        group
            .iter_visit_default(|name, info| {
                links.push((name.to_owned(), info.link_type));
                Ok(())
            })
            .map_err(told)?;
        for (name, link) in links {
            let path = format!("{path}/{name}");
            if link != LinkType::Hard {
                return Err(finding(&path)(format!("is a {link:?} link; only datasets and groups may stand here")));
            }
            let told = |error: hdf5::Error| finding(&path)(format!("is unreadable: {error}"));
            match group.loc_type_by_name(&name).map_err(told)? {
                LocationType::Group => {
                    let group = group.group(&name).map_err(told)?;
                    self.visit(&group, &path, depth + 1, file_bytes)?;
                }
                LocationType::Dataset => {
                    let dataset = group.dataset(&name).map_err(told)?;
                    self.add(dataset, &path, file_bytes)?;
                }
                _ => return Err(finding(&path)("is neither a dataset nor a group".to_owned())),
            }
        }
        Ok(())
    }

    fn add(&mut self, dataset: hdf5::Dataset, path: &str, file_bytes: u64) -> Result<(), Finding> {
        self.count(path)?;
        let told = |error: hdf5::Error| finding(path)(format!("is unreadable: {error}"));
        let dtype = dataset.dtype().map_err(told)?;
        let element = match dtype.to_descriptor().map_err(told)? {
            TypeDescriptor::Float(FloatSize::U8) if dtype.is::<f64>() => Element::Real,
            TypeDescriptor::Integer(IntSize::U8) if dtype.is::<i64>() => Element::Integer,
            TypeDescriptor::VarLenUnicode | TypeDescriptor::VarLenAscii => Element::Text,
            other => {
                let message = format!("holds {other:?}; only little-endian f64, little-endian i64 and variable-length strings are allowed");
                return Err(finding(path)(message));
            }
        };
        let space = dataset.space().map_err(told)?;
        let shape = space.shape();
        if space.is_null() || shape.len() > MOST_AXES {
            return Err(finding(path)(format!("has {} axes or an empty dataspace", shape.len())));
        }
        let may_compress = matches!(path, "/modes/shapes" | "/residual/shapes");
        let storage = storage::locate(&dataset, element, &shape, may_compress, file_bytes).map_err(finding(path))?;
        let longest = shape.iter().copied().max().unwrap_or(0).max(LONGEST_PLAIN_LIST);
        self.read_attributes(&dataset, path, longest)?;
        let sha256 = match self.attribute(path, "sha256") {
            Some(Value::Text(text)) if text.len() == 64 => text.clone(),
            _ => return Err(finding(path)("has no attribute sha256 with 64 hexadecimal digits".to_owned())),
        };
        let line = Line { element, shape, sha256 };
        self.entries.insert(path.to_owned(), Entry { dataset, line, storage });
        Ok(())
    }

    fn read_attributes(&mut self, object: &hdf5::Location, path: &str, longest: usize) -> Result<(), Finding> {
        let names = object.attr_names().map_err(|error| finding(path)(format!("has unreadable attributes: {error}")))?;
        for name in names {
            self.count(path)?;
            let value = attributes::read(object, &name, longest).map_err(finding(path))?;
            self.attributes.entry(path.to_owned()).or_default().insert(name, value);
        }
        Ok(())
    }

    /// An attribute of an object.
    pub(super) fn attribute(&self, path: &str, name: &str) -> Option<&Value> {
        self.attributes.get(path)?.get(name)
    }
}
