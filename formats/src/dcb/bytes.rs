//! Bytes of a file, taken one field after the other; running out of them is an error, never a panic.

use std::fs::File;
use std::os::unix::fs::FileExt;

/// A file of known length.
#[derive(Debug)]
pub(super) struct FileBytes {
    file: File,
    length: u64,
}

impl FileBytes {
    /// `length` is the file's.
    pub(super) fn new(file: File, length: u64) -> Self {
        Self { file, length }
    }

    /// Number of bytes.
    pub(super) fn length(&self) -> u64 {
        self.length
    }

    /// `count` bytes from `offset` on, if the file has them: nothing is allocated for more than that.
    pub(super) fn read(&self, offset: u64, count: u64) -> Result<Vec<u8>, String> {
        let whole = offset
            .checked_add(count)
            .is_some_and(|end| end <= self.length);
        let size = usize::try_from(count).ok().filter(|_| whole);
        let size = size.ok_or_else(|| {
            format!(
                "{count} bytes from byte {offset} on leave the file of {} bytes",
                self.length
            )
        })?;
        let mut bytes = vec![0; size];
        self.file
            .read_exact_at(&mut bytes, offset)
            .map_err(|error| format!("cannot be read: {error}"))?;
        Ok(bytes)
    }

    /// Reals from `offset` on.
    pub(super) fn read_reals(&self, offset: u64, reals: &mut [f64]) -> Result<(), String> {
        let mut at = offset;
        for part in reals.chunks_mut(8192) {
            let bytes = self.read(at, 8 * part.len() as u64)?;
            let (words, _) = bytes.as_chunks::<8>();
            part.iter_mut()
                .zip(words)
                .for_each(|(real, word)| *real = f64::from_le_bytes(*word));
            at += bytes.len() as u64;
        }
        Ok(())
    }
}

/// A place in some bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cursor<'b>(&'b [u8]);

impl<'b> Cursor<'b> {
    /// At the first byte.
    pub(super) fn new(bytes: &'b [u8]) -> Self {
        Self(bytes)
    }

    /// The next bytes.
    pub(super) fn take(&mut self, count: usize) -> Result<&'b [u8], String> {
        let (taken, rest) = self
            .0
            .split_at_checked(count)
            .ok_or("a header ends too early")?;
        self.0 = rest;
        Ok(taken)
    }

    /// The next bytes as a little-endian number, at most 8 of them.
    pub(super) fn number(&mut self, count: usize) -> Result<u64, String> {
        Ok(little_endian(self.take(count)?))
    }

    /// The next byte.
    pub(super) fn byte(&mut self) -> Result<u8, String> {
        Ok(self.take(1)?[0])
    }

    /// Bytes left.
    pub(super) fn left(&self) -> usize {
        self.0.len()
    }
}

fn little_endian(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .rev()
        .fold(0, |number, &byte| (number << 8) | u64::from(byte))
}
