//! Binary files: sizes are believed as far as the rest of the file can hold them.

use std::fs::{File, Metadata};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Take};
use std::path::{Path, PathBuf};

use dcb_formats::Error;

/// Order of the bytes of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ByteOrder {
    /// The lowest first.
    Little,
    /// The highest first.
    Big,
}

/// A binary file, read in any order; [`hashed`](crate::binary::hashed::hashed) gives its digest.
pub struct BinaryFile {
    path: PathBuf,
    file: File,
    length: u64,
    at: u64,
}

impl BinaryFile {
    /// Opens a file to read parts of it.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::File`] for a pipe or device.
    pub(crate) fn open_parts(path: &Path) -> Result<Self, Error> {
        regular(path)?;
        let cannot_open = |source| Error::io(path, "cannot read", source);
        let file = File::open(path).map_err(cannot_open)?;
        let length = file.metadata().map_err(cannot_open)?.len();
        Ok(Self {
            path: path.into(),
            file,
            length,
            at: 0,
        })
    }

    /// Leaves bytes out without reading them.
    ///
    /// # Errors
    /// As [`BinaryFile::room_for`]; [`Error::Io`].
    pub(crate) fn pass_over(&mut self, count: u64) -> Result<(), Error> {
        self.at += self.room_for(count, 1, "bytes")?;
        self.file
            .seek(SeekFrom::Start(self.at))
            .map_err(|source| Error::io(&self.path, "cannot read", source))?;
        Ok(())
    }

    /// So many of the next bytes, for another reader. They are still to be passed over.
    pub(crate) fn part(&mut self, count: u64) -> Take<&mut File> {
        (&mut self.file).take(count)
    }

    /// The next `N` bytes, which come again.
    ///
    /// # Errors
    /// As [`BinaryFile::fill`].
    pub(crate) fn peek<const N: usize>(&mut self) -> Result<[u8; N], Error> {
        let before = self.at;
        let bytes = self.take()?;
        self.at = before;
        self.pass_over(0)?;
        Ok(bytes)
    }

    /// Where the next byte is.
    pub fn position(&self) -> u64 {
        self.at
    }

    /// Bytes that are left.
    pub fn remaining(&self) -> u64 {
        self.length - self.at
    }

    /// An error of this file at the place that was reached.
    pub fn refused(&self, message: impl Into<String>) -> Error {
        self.refused_at(self.at, message)
    }

    /// An error of this file at a place.
    pub(crate) fn refused_at(&self, at: u64, message: impl Into<String>) -> Error {
        Error::File {
            path: self.path.clone(),
            message: format!("at byte {at}: {}", message.into()),
        }
    }

    /// Refuses a number of items that the rest of the file can't hold; otherwise their bytes.
    ///
    /// # Errors
    /// [`Error::File`] with both sizes.
    pub fn room_for(&self, count: u64, bytes_each: u64, items: &str) -> Result<u64, Error> {
        match count.checked_mul(bytes_each) {
            Some(bytes) if bytes <= self.remaining() => Ok(bytes),
            _ => Err(self.refused(format!(
                "{count} {items} of {bytes_each} bytes are announced, but {} bytes are left; the file is cut off or damaged",
                self.remaining()
            ))),
        }
    }

    /// Fills a buffer.
    ///
    /// # Errors
    /// [`Error::File`] if the file ends before; [`Error::Io`].
    pub fn fill(&mut self, buffer: &mut [u8]) -> Result<(), Error> {
        if buffer.len() as u64 > self.remaining() {
            return Err(self.refused(format!(
                "the file ends {} bytes too early; it is cut off",
                buffer.len() as u64 - self.remaining()
            )));
        }
        match self.file.read_exact(buffer) {
            Ok(()) => {
                self.at += buffer.len() as u64;
                Ok(())
            }
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => {
                Err(self.refused("the file became shorter while it was read"))
            }
            Err(source) => Err(Error::io(&self.path, "cannot read", source)),
        }
    }

    /// The next `N` bytes.
    ///
    /// # Errors
    /// As [`BinaryFile::fill`].
    pub fn take<const N: usize>(&mut self) -> Result<[u8; N], Error> {
        let mut bytes = [0; N];
        self.fill(&mut bytes)?;
        Ok(bytes)
    }
}

/// What the system says of a file; pipes, devices and folders are refused, without opening them.
pub(crate) fn regular(path: &Path) -> Result<Metadata, Error> {
    let cannot_read = |source| Error::io(path, "cannot read", source);
    let found = std::fs::metadata(path).map_err(cannot_read)?;
    match (found.is_file(), found.is_dir()) {
        (true, _) => Ok(found),
        (_, true) => Err(cannot_read(ErrorKind::IsADirectory.into())),
        _ => Err(pipe(path)),
    }
}

fn pipe(path: &Path) -> Error {
    Error::File {
        path: path.into(),
        message: "is a pipe or device; binary matrices are read from files, whose length is known"
            .into(),
    }
}

/// Whether a file is packed by gzip.
pub(crate) fn is_gzipped(path: &Path) -> Result<bool, Error> {
    let mut start = Vec::new();
    let file = File::open(path).map_err(|source| Error::io(path, "cannot read", source))?;
    file.take(2)
        .read_to_end(&mut start)
        .map_err(|source| Error::io(path, "cannot read", source))?;
    Ok(start == [0x1f, 0x8b])
}
