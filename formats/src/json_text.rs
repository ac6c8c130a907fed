//! JSON texts that people write: bounded in size, comments allowed, and files that are something else told apart.

use std::io::Read;
use std::path::Path;

use crate::Error;
use crate::description::without_comments;

/// Largest text, bytes. Objects nest at most 128 deep, which is the JSON reader's own limit.
const LARGEST: u64 = 64 << 20;

/// All of a source; `what` it should be, with its article, and what another file is, by how it begins.
///
/// # Errors
/// [`Error::File`] where it can't be read, is too long, is another file, empty, or no text.
pub(crate) fn read(
    path: &Path,
    source: impl Read,
    what: &str,
    other_file: fn(&[u8], &Path) -> Option<String>,
) -> Result<String, Error> {
    let whole = |message: String| Error::File {
        path: path.to_owned(),
        message,
    };
    let mut bytes = Vec::new();
    source
        .take(LARGEST + 1)
        .read_to_end(&mut bytes)
        .map_err(|source| Error::io(path, "cannot read", source))?;
    if bytes.len() as u64 > LARGEST {
        return Err(whole(format!(
            "has more than {} MiB; expected {what} (JSON)",
            LARGEST >> 20
        )));
    }
    if let Some(other) = other_file(&bytes, path) {
        return Err(whole(other));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        whole(format!(
            "is not UTF-8 text ({error}); expected {what} (JSON)"
        ))
    })?;
    match text.trim().is_empty() {
        true => Err(whole(format!("is empty; expected {what} (JSON)"))),
        false => Ok(text),
    }
}

/// The text with blanks in place of comments, and no mark of its byte order.
///
/// # Errors
/// [`Error::File`] for a comment that doesn't end.
pub(crate) fn stripped(text: &str, path: &Path) -> Result<String, Error> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let text = without_comments(text.as_bytes(), path)?;
    // Blanks in place of comments leave it UTF-8.
    Ok(String::from_utf8_lossy(&text).into_owned())
}
