//! Eviction from the cache: entries that weren't used for long, and files that killed processes left.

use std::io;
use std::path::Path;

use dcb_formats::output::remove_leftover;

use super::{Cache, Key, SUPERELEMENT};
use crate::lock_file;

/// Whether an entry could be removed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Removal {
    /// It is gone.
    Removed,
    /// Another process uses it.
    InUse,
}

impl Cache {
    /// Removes an entry that nobody uses.
    ///
    /// # Errors
    /// Its files can't be removed.
    pub fn remove(&self, key: &Key) -> io::Result<Removal> {
        let Some(_lock) = lock_file::claimed(&self.lock_path(key))? else {
            return Ok(Removal::InUse);
        };
        self.remove_files(key)?;
        Ok(Removal::Removed)
    }

    /// Removes entries, those first that weren't used for the longest time, until the rest is within the limit; `newest` stays. What
    /// can't be removed, or is in use, stays too.
    pub(super) fn make_room(&self, newest: &Key) {
        self.remove_leftovers();
        let entries = self.entries();
        let mut total: u64 = entries.iter().map(|entry| entry.record.bytes).sum();
        for entry in entries.iter().rev().filter(|entry| entry.key != *newest) {
            if total <= self.limit {
                return;
            }
            if matches!(self.remove(&entry.key), Ok(Removal::Removed)) {
                total -= entry.record.bytes;
            }
        }
    }

    /// Removes unfinished files, and superelements without record, of keys that nobody works on.
    pub fn remove_leftovers(&self) {
        for name in self.names() {
            let (named, is_partial) = match name.strip_prefix('.') {
                Some(rest) => (rest, true),
                None => (name.as_str(), false),
            };
            let Some(key) = named.get(..64).and_then(Key::parse) else {
                continue;
            };
            let is_left = match is_partial {
                true => name.ends_with(".partial"),
                false => name.ends_with(SUPERELEMENT) && !self.record_path(&key).exists(),
            };
            if is_left && let Ok(Some(_lock)) = lock_file::claimed(&self.lock_path(&key)) {
                let path = self.folder().join(&name);
                if is_partial {
                    remove_leftover(&path);
                } else if !self.record_path(&key).exists() {
                    // Not finished meanwhile.
                    let _ = std::fs::remove_file(path);
                }
            }
        }
    }

    /// Removes the files of an entry, the record first: without it there is no entry. Who calls holds the lock.
    pub(super) fn remove_files(&self, key: &Key) -> io::Result<()> {
        remove_if_there(&self.record_path(key))?;
        remove_if_there(&self.superelement_path(key))?;
        let unfinished = format!(".{key}.");
        for name in self.names() {
            if name.starts_with(&unfinished) {
                remove_leftover(&self.folder().join(name));
            }
        }
        Ok(())
    }
}

fn remove_if_there(path: &Path) -> io::Result<()> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}
