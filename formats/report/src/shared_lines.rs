//! Lines that several processes add to one file, on one machine or on several with a common file system that has locks. Each line is
//! written under a lock of the file, and is on disk before the next one is.

use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use dcb_formats::Error;

/// The file, and how far it is known.
#[derive(Debug)]
pub struct SharedLines {
    path: PathBuf,
    file: File,
    /// Bytes that were read or written: whole lines.
    known: u64,
    /// Lines among them.
    count: u64,
}

/// While it lives, no other process reads or writes the lines.
pub struct Alone(File);

impl Drop for Alone {
    fn drop(&mut self) {
        // The lock ends with the process at the latest.
        let _ = self.0.unlock();
    }
}

impl SharedLines {
    /// Opens the file, or makes it; nothing of it is known yet.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn open(path: &Path) -> Result<Self, Error> {
        let mut options = File::options();
        options.read(true).write(true).create(true).truncate(false);
        let file = (options.open(path)).map_err(|error| Error::io(path, "cannot write", error))?;
        Ok(Self {
            path: path.to_owned(),
            file,
            known: 0,
            count: 0,
        })
    }

    /// Where the file is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Waits until no other process reads or writes the lines.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn alone(&self) -> Result<Alone, Error> {
        let refused = |error| Error::io(&self.path, "cannot lock", error);
        let lock = self.file.try_clone().map_err(refused)?;
        match lock.lock() {
            // A file system without locks has one process at a time.
            Err(error) if error.kind() != io::ErrorKind::Unsupported => Err(refused(error)),
            _ => Ok(Alone(lock)),
        }
    }

    /// Hands over each whole line that isn't known yet, with its number from 1. One that `take` refuses stays unknown.
    ///
    /// # Errors
    /// [`Error::Io`], and those of `take`.
    pub fn read<E: From<Error>>(
        &mut self,
        mut take: impl FnMut(u64, &str) -> Result<(), E>,
    ) -> Result<(), E> {
        let text = self.rest()?;
        // Only what ends in a line break was written completely.
        for line in text.split_inclusive('\n') {
            let Some(whole) = line.strip_suffix('\n') else {
                break;
            };
            take(self.count + 1, whole)?;
            self.known += line.len() as u64;
            self.count += 1;
        }
        Ok(())
    }

    /// The text after the known lines.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn rest(&mut self) -> Result<String, Error> {
        let mut text = String::new();
        (self.file.seek(SeekFrom::Start(self.known)))
            .and_then(|_| self.file.read_to_string(&mut text))
            .map_err(|error| Error::io(&self.path, "cannot read", error))?;
        Ok(text)
    }

    /// Known lines.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Writes a line after the known ones, in the place of half a line that a killed process left there, and waits until the disk has it.
    ///
    /// # Errors
    /// [`Error::Io`]: a full disk, for example. The known lines stay.
    pub fn append(&mut self, line: &str) -> Result<(), Error> {
        let line = format!("{line}\n");
        let written = (self.file.set_len(self.known))
            .and_then(|()| self.file.seek(SeekFrom::Start(self.known)))
            .and_then(|_| self.file.write_all(line.as_bytes()))
            .and_then(|()| self.file.sync_data());
        let size = line.len() as u64;
        if let Err(error) = written {
            // Half a line must not stand before the next one.
            let _ = self.file.set_len(self.known);
            return Err(Error::not_written(&self.path, size, error));
        }
        self.known += size;
        self.count += 1;
        Ok(())
    }
}
