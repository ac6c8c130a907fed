//! The bytes of a matrix file: mapped, hashed and, if gzipped, decompressed in memory.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;
use memmap2::Mmap;
use sha2::{Digest, Sha256};

use crate::Error;

const GZIP_MAGIC: &[u8] = &[0x1f, 0x8b];

/// A file as it is on disk.
pub(super) enum FileBytes {
    /// A regular file. Cutting it off while it is read ends the process (SIGBUS), as for every mapped file.
    Mapped(Mmap),
    /// An empty file, a pipe or a device.
    Owned(Vec<u8>),
}

impl FileBytes {
    /// Maps a regular file, reads anything else.
    ///
    /// # Errors
    /// [`Error::Io`] for a missing or unreadable file and for a folder.
    pub(super) fn open(path: &Path) -> Result<Self, Error> {
        let refused = |source| Error::Io {
            path: path.into(),
            action: "cannot read",
            source,
        };
        let mut file = File::open(path).map_err(refused)?;
        let metadata = file.metadata().map_err(refused)?;
        if metadata.is_dir() {
            return Err(refused(std::io::ErrorKind::IsADirectory.into()));
        }
        if metadata.is_file() && metadata.len() > 0 {
            // SAFETY: the map is private and read-only; only another process cutting the file off could disturb it.
            return unsafe { Mmap::map(&file) }
                .map(Self::Mapped)
                .map_err(refused);
        }
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(refused)?;
        Ok(Self::Owned(bytes))
    }

    /// The bytes, still compressed if they were.
    pub(super) fn as_slice(&self) -> &[u8] {
        match self {
            Self::Mapped(map) => map,
            Self::Owned(bytes) => bytes,
        }
    }
}

/// The text of the file. gzip is known by its first bytes, whatever the file's name;
/// every member is read, and memory grows with the data that come out, not with a size the file states.
///
/// # Errors
/// [`Error::File`] for damaged or truncated gzip data.
pub(super) fn text_of<'a>(path: &Path, stored: &'a [u8]) -> Result<Cow<'a, [u8]>, Error> {
    let unusable = |message| Error::File {
        path: path.into(),
        message,
    };
    if !stored.starts_with(GZIP_MAGIC) {
        return Ok(Cow::Borrowed(stored));
    }
    let mut text = Vec::new();
    match MultiGzDecoder::new(stored).read_to_end(&mut text) {
        Ok(_) => Ok(Cow::Owned(text)),
        Err(source) => Err(unusable(gzip_failure(&source, text.len()))),
    }
}

/// Why decompression ended early: the file, or the memory that its text needs.
fn gzip_failure(source: &std::io::Error, decompressed: usize) -> String {
    match source.kind() {
        ErrorKind::OutOfMemory => format!(
            "not enough memory to decompress it: more than {decompressed} bytes of text are needed"
        ),
        _ => format!(
            "gzip data damaged or cut off after {decompressed} decompressed bytes: {source}"
        ),
    }
}

/// SHA-256 in lower-case hexadecimal.
pub(super) fn sha256_hex(bytes: &[u8]) -> String {
    let mut hex = String::with_capacity(64);
    for byte in Sha256::digest(bytes) {
        // Writing to a String can't fail.
        let _ = write!(hex, "{byte:02x}");
    }
    hex
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_memory_is_not_called_damage() {
        let memory = gzip_failure(&ErrorKind::OutOfMemory.into(), 4096);
        assert!(memory.contains("not enough memory"), "{memory}");
        assert!(!memory.contains("damaged"), "{memory}");
        let damage = gzip_failure(&ErrorKind::UnexpectedEof.into(), 4096);
        assert!(damage.contains("damaged or cut off after 4096"), "{damage}");
    }
}
