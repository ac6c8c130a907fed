//! Text files and JSON, whole or not at all.

use std::io::Write as _;
use std::path::Path;

use serde::Serialize;

use super::{Replace, write_stream};
use crate::Error;

/// Writes a text file, whole or not at all; an existing file is replaced.
///
/// # Errors
/// [`Error::File`] for a place where no file can be; [`Error::NoRoom`] on a full disk; [`Error::Io`] where the system refuses.
pub fn write_text(path: &Path, text: &str) -> Result<(), Error> {
    write_stream(path, Replace::Overwrite, |out| {
        out.write_all(text.as_bytes())
    })
}

/// Writes a value as indented JSON, whole or not at all; an existing file is replaced. Numbers that aren't finite become `null`.
///
/// # Errors
/// As [`write_text`]; [`Error::File`] if the value has no JSON form (a map with keys that aren't text).
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<(), Error> {
    let text = serde_json::to_string_pretty(value).map_err(|error| Error::File {
        path: path.to_owned(),
        message: format!("cannot be written as JSON: {error}"),
    })?;
    write_text(path, &(text + "\n"))
}
