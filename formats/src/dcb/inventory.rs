//! What a file holds: every dataset's type, shape, storage and claimed hash, and every attribute, without reading
//! any data.

use std::collections::{BTreeMap, HashSet};

use super::attributes::Value;
use super::bytes::FileBytes;
use super::contract::Element;
use super::digest::{self, Attributes, Line};
use super::messages::{self, Storage};
use super::object_header::{self, Message, kind};
use super::text::{DESCRIPTOR_BYTES, Texts};

/// Groups inside groups, at most: `/mesh/cells/0` has three.
const DEEPEST: usize = 6;
/// Objects of a file, at most.
const MOST_OBJECTS: usize = 100_000;
/// The only datasets that may be compressed.
const FIELD_ARRAYS: [&str; 2] = ["/modes/shapes", "/residual/shapes"];

/// One dataset of a file.
#[derive(Debug)]
pub(super) struct Entry {
    pub(super) line: Line,
    pub(super) storage: Storage,
}

/// All of a file but the data.
#[derive(Debug, Default)]
pub(super) struct Inventory {
    pub(super) entries: BTreeMap<String, Entry>,
    pub(super) attributes: Attributes,
}

/// A place in the file and what is wrong there.
pub(super) struct Finding {
    pub(super) path: String,
    pub(super) message: String,
}

impl Finding {
    /// What is wrong at a path.
    pub(super) fn at(path: &str, message: impl Into<String>) -> Self {
        Self {
            path: path.to_owned(),
            message: message.into(),
        }
    }
}

/// Adds the path to a message.
fn finding(path: &str) -> impl Fn(String) -> Finding + '_ {
    move |message| Finding::at(path, message)
}

/// The attributes of the root group alone.
pub(super) fn root_attributes(
    file: &FileBytes,
    root: u64,
) -> Result<BTreeMap<String, Value>, Finding> {
    let messages = object_header::messages(file, root).map_err(finding("/"))?;
    attributes(&messages, &mut Texts::new(file)).map_err(finding("/"))
}

impl Inventory {
    /// Takes the inventory of a file whose root group is at `root`.
    pub(super) fn take(file: &FileBytes, root: u64) -> Result<Self, Finding> {
        let mut walk = Walk {
            file,
            texts: Texts::new(file),
            seen: HashSet::new(),
            found: Self::default(),
        };
        walk.visit(root, "", 0)?;
        Ok(walk.found)
    }

    /// The digest that the inventory makes.
    pub(super) fn digest(&self) -> String {
        let lines = self
            .entries
            .iter()
            .map(|(path, entry)| (path.clone(), entry.line.clone()))
            .collect();
        digest::of_file(&lines, &self.attributes)
    }

    /// An attribute of an object.
    pub(super) fn attribute(&self, path: &str, name: &str) -> Option<&Value> {
        self.attributes.get(path)?.get(name)
    }
}

struct Walk<'f> {
    file: &'f FileBytes,
    texts: Texts<'f>,
    seen: HashSet<u64>,
    found: Inventory,
}

impl Walk<'_> {
    /// Visits the object at `address`; `path` is empty for the root.
    fn visit(&mut self, address: u64, path: &str, depth: usize) -> Result<(), Finding> {
        let here = if path.is_empty() { "/" } else { path };
        let told = finding(here);
        if !self.seen.insert(address) {
            return Err(told(
                "is linked twice; every object has one place".to_owned(),
            ));
        }
        if self.seen.len() > MOST_OBJECTS || depth > DEEPEST {
            return Err(told(format!(
                "is one of more than {MOST_OBJECTS} objects, or more than {DEEPEST} groups deep"
            )));
        }
        let messages = object_header::messages(self.file, address).map_err(&told)?;
        let attributes = attributes(&messages, &mut self.texts).map_err(&told)?;
        let has = |wanted: u64| messages.iter().any(|message| message.kind == wanted);
        if has(kind::LAYOUT) {
            let entry = self.dataset(&messages, here, &attributes).map_err(&told)?;
            self.found.entries.insert(here.to_owned(), entry);
        } else if has(kind::LINK_INFO) {
            let links = links(&messages).map_err(&told)?;
            for (name, address) in links {
                self.visit(address, &format!("{path}/{name}"), depth + 1)?;
            }
        } else {
            return Err(told("is neither a dataset nor a group".to_owned()));
        }
        self.found.attributes.insert(here.to_owned(), attributes);
        Ok(())
    }

    fn dataset(
        &self,
        messages: &[Message],
        path: &str,
        attributes: &BTreeMap<String, Value>,
    ) -> Result<Entry, String> {
        let body = |wanted: u64, name: &str| {
            let found = messages.iter().find(|message| message.kind == wanted);
            found
                .map(|message| message.body.as_slice())
                .ok_or_else(|| format!("has no {name}"))
        };
        let element = messages::element(body(kind::DATATYPE, "element type")?)?;
        let shape = messages::shape(body(kind::DATASPACE, "shape")?)?;
        let element_bytes = if element == Element::Text {
            DESCRIPTOR_BYTES
        } else {
            8
        };
        let bytes = (messages::count(&shape)? as u64)
            .checked_mul(element_bytes)
            .ok_or_else(|| format!("has the impossible shape {shape:?}"))?;
        if messages
            .iter()
            .any(|message| message.kind == kind::EXTERNAL)
        {
            return Err("has its data in another file, which isn't allowed".to_owned());
        }
        let storage = messages::storage(
            body(kind::LAYOUT, "layout")?,
            bytes,
            shape.len(),
            self.file.length(),
        )
        .map_err(|message| format!("of shape {shape:?} {message}"))?;
        if let Ok(filters) = body(kind::FILTERS, "filters") {
            messages::check_filters(filters)?;
        }
        if storage == Storage::Chunked && !FIELD_ARRAYS.contains(&path) {
            return Err("is stored in chunks; only field arrays may be".to_owned());
        }
        let Some(Value::Text(sha256)) = attributes
            .get("sha256")
            .filter(|value| matches!(value, Value::Text(text) if text.len() == 64))
        else {
            return Err("has no attribute sha256 with 64 hexadecimal digits".to_owned());
        };
        Ok(Entry {
            line: Line {
                element,
                shape,
                sha256: sha256.clone(),
            },
            storage,
        })
    }
}

fn attributes(messages: &[Message], texts: &mut Texts) -> Result<BTreeMap<String, Value>, String> {
    let mut attributes = BTreeMap::new();
    for message in messages {
        match message.kind {
            kind::ATTRIBUTE_INFO => messages::check_compact(&message.body, 2)?,
            kind::ATTRIBUTE => {
                let (name, value) = messages::attribute(&message.body, texts)?;
                if attributes.insert(name.clone(), value).is_some() {
                    return Err(format!("has two attributes {name}"));
                }
            }
            _ => {}
        }
    }
    Ok(attributes)
}

fn links(messages: &[Message]) -> Result<Vec<(String, u64)>, String> {
    let mut links: Vec<(String, u64)> = Vec::new();
    let mut names = HashSet::new();
    for message in messages {
        match message.kind {
            kind::LINK_INFO => messages::check_compact(&message.body, 8)?,
            kind::LINK => {
                let (name, address) = messages::link(&message.body)?;
                if !names.insert(name.clone()) {
                    return Err(format!("has two members {name:.40?}"));
                }
                links.push((name, address));
            }
            _ => {}
        }
    }
    Ok(links)
}
