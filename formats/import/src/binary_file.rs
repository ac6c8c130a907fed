//! Binary files, read once from the beginning: sizes are believed as far as the rest of the file can hold them.

use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use dcb_formats::Error;
use dcb_formats::snapshot::Snapshot;

/// Order of the bytes of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ByteOrder {
    /// The lowest first.
    Little,
    /// The highest first.
    Big,
}

/// A binary file.
pub struct BinaryFile {
    path: PathBuf,
    file: Snapshot,
    length: u64,
    at: u64,
}

/// Bytes that are turned into numbers at a time.
const BATCH: usize = 1 << 16;

impl BinaryFile {
    /// Opens a file; a pipe is refused, because its length isn't known.
    ///
    /// # Errors
    /// As [`Snapshot::open`]; [`Error::File`] for a pipe.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let file = Snapshot::open(path)?;
        let Some(length) = file.length() else {
            return Err(Error::File {
                path: path.into(),
                message: "is a pipe; binary matrices are read from files, whose length is known"
                    .into(),
            });
        };
        Ok(Self {
            path: path.into(),
            file,
            length,
            at: 0,
        })
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
        Error::File {
            path: self.path.clone(),
            message: format!("at byte {}: {}", self.at, message.into()),
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

    /// Leaves bytes out; they are hashed all the same.
    ///
    /// # Errors
    /// As [`BinaryFile::fill`].
    pub fn skip(&mut self, count: u64) -> Result<(), Error> {
        let mut rest = self.room_for(count, 1, "bytes")?;
        let mut buffer = vec![0; BATCH.min(rest as usize)];
        while rest > 0 {
            let part = buffer.len().min(rest as usize);
            self.fill(&mut buffer[..part])?;
            rest -= part as u64;
        }
        Ok(())
    }

    /// So many items of `N` bytes, each turned into something. Memory is taken only for what is there.
    ///
    /// # Errors
    /// As [`BinaryFile::room_for`] and [`BinaryFile::fill`].
    pub fn items<const N: usize, T>(
        &mut self,
        count: u64,
        items: &str,
        of: impl Fn([u8; N]) -> T,
    ) -> Result<Vec<T>, Error> {
        self.room_for(count, N as u64, items)?;
        let mut found = Vec::with_capacity(count as usize);
        let mut buffer = vec![0; (BATCH - BATCH % N).min(count as usize * N)];
        while found.len() < count as usize {
            let part = buffer.len().min((count as usize - found.len()) * N);
            self.fill(&mut buffer[..part])?;
            let (chunks, _) = buffer[..part].as_chunks::<N>();
            found.extend(chunks.iter().map(|bytes| of(*bytes)));
        }
        Ok(found)
    }

    /// SHA-256 of the whole file, hexadecimal.
    ///
    /// # Errors
    /// As [`Snapshot::finish`].
    pub fn finish(self) -> Result<String, Error> {
        self.file.finish()
    }
}
