//! The zip itself.

use std::io::{Cursor, Write as _};
use std::path::Path;

use dcb_formats::output::{Replace, write_stream};
use dcb_runtime::error::Error;
use zip::write::SimpleFileOptions;
use zip::{DateTime, ZipWriter};

/// A file of the archive.
pub struct Member {
    name: String,
    content: Vec<u8>,
    /// Permissions.
    mode: u32,
}

impl Member {
    pub fn new(name: String, content: Vec<u8>) -> Self {
        let mode = 0o644;
        Self {
            name,
            content,
            mode,
        }
    }

    pub fn text(name: &str, content: String) -> Self {
        Self::new(name.to_owned(), content.into_bytes())
    }

    /// One that is loaded as a program.
    pub fn executable(name: String, content: Vec<u8>) -> Self {
        let mode = 0o755;
        Self {
            name,
            content,
            mode,
        }
    }
}

/// Writes an archive, whole or not at all; the same members give the same bytes at any time of day.
pub fn write(members: Vec<Member>, target: &Path, replace: Replace) -> Result<(), Error> {
    let packed = pack(members).map_err(|error| dcb_formats::Error::File {
        path: target.to_owned(),
        message: format!("the archive can't be made: {error}"),
    })?;
    Ok(write_stream(target, replace, |out| out.write_all(&packed))?)
}

fn pack(members: Vec<Member>) -> zip::result::ZipResult<Vec<u8>> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for member in members {
        let options = SimpleFileOptions::default()
            .last_modified_time(DateTime::default())
            .large_file(u32::try_from(member.content.len()).is_err())
            .unix_permissions(member.mode);
        zip.start_file(member.name, options)?;
        zip.write_all(&member.content)?;
    }
    Ok(zip.finish()?.into_inner())
}
