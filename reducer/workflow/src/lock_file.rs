//! Files that hold locks. They are empty and stay; the system lets go of the locks of a process however it ends.

use std::fs::{File, TryLockError};
use std::io;
use std::path::Path;

/// The file, made if it isn't there.
pub(crate) fn open(path: &Path) -> io::Result<File> {
    let mut options = File::options();
    options.read(true).write(true).create(true).truncate(false);
    options.open(path)
}

/// Its lock, if nobody else has it.
pub(crate) fn claimed(path: &Path) -> io::Result<Option<File>> {
    let lock = open(path)?;
    match lock.try_lock() {
        Ok(()) => Ok(Some(lock)),
        Err(TryLockError::WouldBlock) => Ok(None),
        Err(TryLockError::Error(error)) => Err(error),
    }
}
