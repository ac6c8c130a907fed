//! Files of which parts are read in any order, while another thread reads and hashes the whole of them.

use std::fs::Metadata;
use std::io::{ErrorKind, Read};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::SystemTime;

use dcb_formats::Error;
use dcb_formats::snapshot::{Snapshot, changed};

use crate::binary::file::regular;

/// Bytes that are read together.
const READ_TOGETHER: usize = 1 << 18;

/// What tells one file at a path from another one, and from itself before a write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Identity {
    length: u64,
    modified: Option<SystemTime>,
    number: (u64, u64),
}

impl Identity {
    fn of(path: &Path) -> Result<Self, Error> {
        let found = regular(path)?;
        Ok(Self {
            length: found.len(),
            modified: found.modified().ok(),
            number: number(&found),
        })
    }
}

/// Device and number of a file.
#[cfg(unix)]
fn number(found: &Metadata) -> (u64, u64) {
    use std::os::unix::fs::MetadataExt;
    (found.dev(), found.ino())
}

#[cfg(not(unix))]
fn number(_: &Metadata) -> (u64, u64) {
    (0, 0)
}

/// What `work` makes of a file that it opens itself, and the SHA-256 of all its bytes, hexadecimal. A file that can't be used isn't
/// read to its end.
///
/// # Errors
/// Those of `work`; [`Error::Io`]; [`Error::File`] if the file at this path was changed or replaced meanwhile.
pub(crate) fn hashed<T: Send>(
    path: &Path,
    work: impl FnOnce() -> Result<T, Error> + Send,
) -> Result<(T, String), Error> {
    let before = Identity::of(path)?;
    let has_failed = AtomicBool::new(false);
    let (found, whole) = rayon::join(
        || {
            let found = work();
            has_failed.store(found.is_err(), Ordering::Relaxed);
            found
        },
        || read_through(path, &has_failed),
    );
    let found = found?;
    let sha256 = whole?.finish()?;
    match Identity::of(path)? == before {
        true => Ok((found, sha256)),
        false => Err(changed(path)),
    }
}

/// Reads a file to its end, or until that is of no use.
fn read_through(path: &Path, has_failed: &AtomicBool) -> Result<Snapshot, Error> {
    let mut file = Snapshot::open(path)?;
    let mut buffer = vec![0; READ_TOGETHER];
    while !has_failed.load(Ordering::Relaxed) {
        match file.read(&mut buffer) {
            Ok(0) => break,
            Ok(_) => {}
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(Error::io(path, "cannot read", error)),
        }
    }
    Ok(file)
}
