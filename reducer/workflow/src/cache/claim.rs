//! Who finds an entry, and who has to make it.

use std::fs::{File, TryLockError};
use std::io;
use std::time::SystemTime;

use dcb_formats::dcb::{Contents, SuperelementFile, WriteOptions, write_superelement};

use dcb_formats::output::Replace;
use dcb_formats::output::write_json;

use super::{Cache, Entry, Key, Record, Request};
use crate::lock_file;
use dcb_reducer::error::Error;

/// Outcome of a request.
#[derive(Debug)]
pub enum Claim<'c> {
    /// It was made before.
    Found(Box<Entry>),
    /// It is to be made, by nobody else meanwhile.
    Missing(Box<Reservation<'c>>),
}

/// The right to make an entry.
#[derive(Debug)]
pub struct Reservation<'c> {
    cache: &'c Cache,
    request: Request,
    /// Defect of the entry that was there and has been removed.
    pub damage: Option<String>,
    _lock: File,
}

/// Outcome of keeping a superelement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stored {
    /// It is kept.
    Kept,
    /// It is larger than the whole cache may be.
    TooLarge {
        /// Its size.
        bytes: u64,
    },
}

impl Cache {
    /// Finds the entry of a request, or reserves its place. Where another process makes it just now, says so by `waiting` and waits.
    ///
    /// # Errors
    /// The folder can't be used, or its file system has no locks.
    pub fn claim(&self, request: &Request, waiting: impl Fn()) -> io::Result<Claim<'_>> {
        let key = request.key();
        let lock = lock_file::open(&self.lock_path(&key))?;
        wait(lock.try_lock_shared(), &waiting, || lock.lock_shared())?;
        if let Some(Ok(found)) = self.read(&key) {
            return Ok(Claim::Found(Box::new(self.used(&key, found, lock))));
        }
        lock.unlock()?;
        wait(lock.try_lock(), &waiting, || lock.lock())?;
        // Somebody may have made it in between.
        let damage = match self.read(&key) {
            Some(Ok(found)) => {
                return Ok(Claim::Found(Box::new(self.used(&key, found, lock))));
            }
            Some(Err(damage)) => Some(damage),
            None => None,
        };
        self.remove_files(&key)?;
        Ok(Claim::Missing(Box::new(Reservation {
            cache: self,
            request: request.clone(),
            damage,
            _lock: lock,
        })))
    }

    /// An entry with every byte that the dynamics can see compared with its hash; what is wrong with it if something is.
    fn read(&self, key: &Key) -> Option<Result<(SuperelementFile, Record), String>> {
        let text = match std::fs::read(self.record_path(key)) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return None,
            Err(error) => return Some(Err(error.to_string())),
            Ok(text) => text,
        };
        let checked = || {
            let record: Record = serde_json::from_slice(&text)
                .map_err(|error| format!("{}: {error}", self.record_path(key).display()))?;
            let file = SuperelementFile::open(self.superelement_path(key))
                .map_err(|error| error.to_string())?;
            if file.digest() != record.digest || record.request.key() != *key {
                let path = self.record_path(key);
                return Err(format!("{}: is of another superelement", path.display()));
            }
            file.verify_digests().map_err(|error| error.to_string())?;
            Ok((file, record))
        };
        Some(checked())
    }

    fn used(&self, key: &Key, (file, record): (SuperelementFile, Record), lock: File) -> Entry {
        // Where the cache may be read and not written, the use isn't noted.
        let _ = File::options()
            .write(true)
            .open(self.record_path(key))
            .and_then(|record| record.set_modified(SystemTime::now()));
        Entry {
            file,
            path: self.superelement_path(key),
            record,
            _lock: lock,
        }
    }
}

/// Waits for a lock that can't be had at once.
fn wait(
    tried: Result<(), TryLockError>,
    waiting: impl Fn(),
    lock: impl FnOnce() -> io::Result<()>,
) -> io::Result<()> {
    match tried {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => {
            waiting();
            lock()
        }
        Err(TryLockError::Error(error)) => Err(error),
    }
}

impl Reservation<'_> {
    /// Keeps what was made of the request in `seconds`, and then as much else as the limit leaves room for.
    ///
    /// # Errors
    /// It can't be written: a full disk, for example. No part of it is left.
    pub fn store(self, contents: &Contents<'_>, seconds: f64) -> Result<Stored, Error> {
        let key = self.request.key();
        let path = self.cache.superelement_path(&key);
        let options = WriteOptions {
            replace_existing: Replace::Overwrite,
            ..WriteOptions::default()
        };
        write_superelement(&path, contents, &options)?;
        let told = |source| dcb_formats::Error::io(&path, "cannot keep", source);
        let bytes = std::fs::metadata(&path).map_err(told)?.len();
        if bytes > self.cache.limit {
            self.cache.remove_files(&key).map_err(told)?;
            return Ok(Stored::TooLarge { bytes });
        }
        let record = Record {
            digest: SuperelementFile::open(&path)?.digest().to_owned(),
            bytes,
            ..Record::of(&self.request, contents.superelement, seconds)
        };
        if let Err(error) = write_json(&self.cache.record_path(&key), &record) {
            let _ = self.cache.remove_files(&key);
            return Err(error.into());
        }
        self.cache.make_room(&key);
        Ok(Stored::Kept)
    }
}
