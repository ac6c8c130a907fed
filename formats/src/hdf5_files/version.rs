//! FileKind and version of a file, and other attributes that every file must have.

use std::collections::BTreeMap;

use super::attributes::Value;
use super::inventory::{Finding, Inventory};
use crate::terminal::shortened;

/// Version of the format: the major one changes what old readers rely on, the minor one only adds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct FormatVersion {
    /// Changes what old readers rely on.
    pub major: u32,
    /// Adds what old readers may ignore.
    pub minor: u32,
}

impl std::fmt::Display for FormatVersion {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}", self.major, self.minor)
    }
}

/// A dataset or group that has to be there.
pub(crate) fn missing(path: &str) -> Finding {
    Finding::at(path, "is missing".to_owned())
}

/// The kind of file that a program reads.
pub(crate) struct FileKind {
    /// Usual name, with its article.
    pub(crate) called: &'static str,
    /// Its attribute `format`.
    pub(crate) format: &'static str,
    /// The version that this program writes.
    pub(crate) version: FormatVersion,
}

/// Format and version, before anything else is believed.
pub(crate) fn read_version(
    attributes: &BTreeMap<String, Value>,
    kind: &FileKind,
) -> Result<FormatVersion, Finding> {
    let called = kind.called;
    let root = |message: String| Finding::at("/", message);
    let read = |name: &str| match attributes.get(name) {
        Some(Value::Text(text)) => Ok(text),
        Some(other) => Err(root(format!(
            "attribute {name} is {other:?}; it must be a string"
        ))),
        None => Err(root(format!(
            "attribute {name} is missing: this isn't {called}"
        ))),
    };
    let format = read("format")?;
    if format != kind.format {
        return Err(root(format!(
            "format is {:?}; that of {called} is {:?}",
            shortened(format),
            kind.format
        )));
    }
    let text = read("format_version")?;
    let parts = text
        .split_once('.')
        .and_then(|(major, minor)| Some((major.parse().ok()?, minor.parse().ok()?)));
    let (major, minor) = parts.ok_or_else(|| {
        root(format!(
            "format_version is {:?}; it must be like \"{}\"",
            shortened(text),
            kind.version
        ))
    })?;
    if major != kind.version.major {
        return Err(root(format!(
            "format_version is {major}.{minor}, and this program reads versions {}.x; use a program that reads {major}.x",
            kind.version.major
        )));
    }
    Ok(FormatVersion { major, minor })
}

/// A text attribute that must be there.
pub(crate) fn text_attribute<'i>(
    inventory: &'i Inventory,
    path: &str,
    name: &str,
) -> Result<&'i str, Finding> {
    match inventory.attribute(path, name) {
        Some(Value::Text(text)) => Ok(text),
        Some(other) => Err(Finding::at(
            path,
            format!("attribute {name} is {other:?}; it must be a string"),
        )),
        None => Err(Finding::at(path, format!("attribute {name} is missing"))),
    }
}
