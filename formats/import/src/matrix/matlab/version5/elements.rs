//! The elements of a MATLAB file of version 5: each has a type and a length, and whole ones may be compressed.

use std::fs::File;
use std::io::{ErrorKind, Read, Take};
use std::path::{Path, PathBuf};

use dcb_formats::Error;
use flate2::read::ZlibDecoder;

use crate::binary::file::{BinaryFile, ByteOrder};
use crate::matrix::storage::number::{Kind, Number};
use crate::matrix::storage::stream::Stream;

pub(super) fn words(bytes: [u8; 8], order: ByteOrder) -> [u32; 2] {
    let [a, b, c, d, e, f, g, h] = bytes;
    [[a, b, c, d], [e, f, g, h]].map(|word| match order {
        ByteOrder::Little => u32::from_le_bytes(word),
        ByteOrder::Big => u32::from_be_bytes(word),
    })
}

/// Bytes that take no time to decompress.
const FEW: u64 = 1 << 12;

/// Bytes of which some can be left out.
pub(super) trait Elements: Stream {
    /// Leaves out so many bytes.
    fn leave_out(&mut self, count: u64) -> Result<(), Error>;
}

impl Elements for BinaryFile {
    fn leave_out(&mut self, count: u64) -> Result<(), Error> {
        self.pass_over(count)
    }
}

/// The bytes of a compressed element.
pub(super) struct Inflated<'f> {
    path: PathBuf,
    /// Where the element is in the file.
    at: u64,
    /// Bytes that are left out as soon as something behind them is wanted.
    skipped: u64,
    decoder: ZlibDecoder<Take<&'f mut File>>,
}

impl<'f> Inflated<'f> {
    pub(super) fn of(path: &Path, file: &'f mut BinaryFile, length: u64) -> Self {
        Self {
            path: path.into(),
            at: file.position(),
            skipped: 0,
            decoder: ZlibDecoder::new(file.part(length)),
        }
    }

    /// Reads to the end, where the checksum is, unless much of what comes last was left out.
    ///
    /// # Errors
    /// The checksum is another.
    pub(super) fn finish(mut self) -> Result<(), Error> {
        if self.skipped > FEW {
            return Ok(());
        }
        match std::io::copy(&mut self.decoder, &mut std::io::sink()) {
            Ok(_) => Ok(()),
            Err(error) => Err(self.broken(error)),
        }
    }

    fn broken(&self, error: std::io::Error) -> Error {
        match error.kind() {
            ErrorKind::UnexpectedEof => self.refused("it ends too early".into()),
            ErrorKind::InvalidInput | ErrorKind::InvalidData => {
                self.refused(format!("it can't be decompressed: {error}"))
            }
            _ => Error::io(&self.path, "cannot read", error),
        }
    }
}

impl Stream for Inflated<'_> {
    fn fill(&mut self, buffer: &mut [u8]) -> Result<(), Error> {
        let mut passed = [0; 1 << 12];
        while self.skipped > 0 {
            let part = self.skipped.min(passed.len() as u64) as usize;
            let read = self.decoder.read_exact(&mut passed[..part]);
            read.map_err(|error| self.broken(error))?;
            self.skipped -= part as u64;
        }
        let read = self.decoder.read_exact(buffer);
        read.map_err(|error| self.broken(error))
    }

    fn held(&self) -> u64 {
        self.decoder.get_ref().limit()
    }

    fn refused(&self, message: String) -> Error {
        Error::File {
            path: self.path.clone(),
            message: format!("in the compressed element at byte {}: {message}", self.at),
        }
    }
}

impl Elements for Inflated<'_> {
    fn leave_out(&mut self, count: u64) -> Result<(), Error> {
        self.skipped = self.skipped.saturating_add(count);
        Ok(())
    }
}

/// What is left of an element that consists of others.
pub(super) struct Body<'s> {
    pub(super) source: &'s mut dyn Elements,
    pub(super) order: ByteOrder,
    pub(super) left: u64,
}

/// Type and length of an element; up to four bytes of data may be in it.
pub(super) struct Tag {
    pub(super) kind: u32,
    pub(super) bytes: u64,
    /// Up to a multiple of eight.
    pub(super) padding: u64,
    pub(super) inside: Option<[u8; 4]>,
}

impl<'s> Body<'s> {
    pub(super) fn of(source: &'s mut dyn Elements, order: ByteOrder, left: u64) -> Self {
        Self {
            source,
            order,
            left,
        }
    }

    /// An error at this place.
    pub(super) fn refused(&self, message: String) -> Error {
        self.source.refused(message)
    }

    fn overrun(&self) -> Error {
        self.refused("an element is longer than the one that it is in; the file is damaged".into())
    }

    pub(super) fn tag(&mut self) -> Result<Tag, Error> {
        self.left = self.left.checked_sub(8).ok_or_else(|| self.overrun())?;
        let mut bytes = [0; 8];
        self.source.fill(&mut bytes)?;
        let [first, second] = words(bytes, self.order);
        let small = first >> 16;
        if small > 4 {
            return Err(self.refused(format!(
                "a small element of {small} bytes; the file is damaged"
            )));
        }
        if small > 0 {
            let [_, _, _, _, data @ ..] = bytes;
            return Ok(Tag {
                kind: first & 0xffff,
                bytes: small.into(),
                padding: 0,
                inside: Some(data),
            });
        }
        let bytes = u64::from(second);
        self.left = self.left.checked_sub(bytes).ok_or_else(|| self.overrun())?;
        let padding = (bytes.next_multiple_of(8) - bytes).min(self.left);
        self.left -= padding;
        Ok(Tag {
            kind: first,
            bytes,
            padding,
            inside: None,
        })
    }

    fn part(&mut self, tag: Tag) -> Part<'_> {
        Part {
            source: &mut *self.source,
            order: self.order,
            kind: tag.kind,
            bytes: tag.bytes,
            left: tag.bytes,
            padding: tag.padding,
            inside: tag.inside,
        }
    }

    /// The next element, which has numbers.
    ///
    /// # Errors
    /// It has something else.
    pub(super) fn numbers(&mut self) -> Result<Part<'_>, Error> {
        let tag = self.tag()?;
        if kind_of(tag.kind).is_none() {
            return Err(self.refused(format!(
                "an element of type {} where numbers are expected; the file is damaged",
                tag.kind
            )));
        }
        Ok(self.part(tag))
    }

    /// The bytes of the next element, not more than some.
    pub(super) fn bytes(&mut self, most: u64) -> Result<Vec<u8>, Error> {
        let tag = self.tag()?;
        if tag.bytes > most {
            return Err(self.refused(format!(
                "{} bytes of a name or of sizes; at most {most} are supported",
                tag.bytes
            )));
        }
        let mut part = self.part(tag);
        let mut bytes = vec![0; part.left as usize];
        part.fill(&mut bytes)?;
        part.finish()?;
        Ok(bytes)
    }

    pub(super) fn leave_out_rest(&mut self) -> Result<(), Error> {
        self.source.leave_out(std::mem::take(&mut self.left))
    }
}

/// Kind of number of a type.
fn kind_of(kind: u32) -> Option<Kind> {
    Some(match kind {
        1 => Kind::I8,
        2 => Kind::U8,
        3 => Kind::I16,
        4 => Kind::U16,
        5 => Kind::I32,
        6 => Kind::U32,
        7 => Kind::F32,
        9 => Kind::F64,
        12 => Kind::I64,
        13 => Kind::U64,
        _ => return None,
    })
}

/// The data of an element.
pub(super) struct Part<'b> {
    source: &'b mut dyn Elements,
    order: ByteOrder,
    kind: u32,
    bytes: u64,
    left: u64,
    padding: u64,
    inside: Option<[u8; 4]>,
}

impl Part<'_> {
    /// Type of its numbers.
    pub(super) fn number(&self) -> Number {
        Number {
            kind: kind_of(self.kind).unwrap_or(Kind::U8),
            order: self.order,
        }
    }

    /// How many they are.
    pub(super) fn count(&self) -> u64 {
        self.bytes / self.number().size() as u64
    }

    /// The error of a matrix that needs another number of them.
    pub(super) fn too_few(&self, rows: u64, columns: u64) -> Error {
        self.refused(format!(
            "{} numbers for {rows} x {columns}; the file is damaged",
            self.count()
        ))
    }

    /// Leaves out the rest.
    pub(super) fn finish(self) -> Result<(), Error> {
        match self.inside {
            Some(_) => Ok(()),
            None => self.source.leave_out(self.left + self.padding),
        }
    }
}

impl Stream for Part<'_> {
    fn fill(&mut self, buffer: &mut [u8]) -> Result<(), Error> {
        let count = buffer.len() as u64;
        let at = (self.bytes - self.left) as usize;
        self.left = match self.left.checked_sub(count) {
            Some(left) => left,
            None => {
                return Err(self.refused("an element ends too early; the file is damaged".into()));
            }
        };
        match self.inside {
            Some(data) => buffer.copy_from_slice(&data[at..at + buffer.len()]),
            None => self.source.fill(buffer)?,
        }
        Ok(())
    }

    fn held(&self) -> u64 {
        self.left.min(self.source.held())
    }

    fn refused(&self, message: String) -> Error {
        self.source.refused(message)
    }
}
