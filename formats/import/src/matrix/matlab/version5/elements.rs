//! The elements of a MATLAB file of version 5: each has a type and a length, and whole ones may be compressed.

use std::fs::File;
use std::io::{ErrorKind, Read, Take};
use std::path::{Path, PathBuf};

use dcb_formats::Error;
use flate2::read::ZlibDecoder;

use super::{is_version_4, is_version_5};
use crate::binary::file::{BinaryFile, ByteOrder};
use crate::matrix::storage::number::{Kind, Number};
use crate::matrix::storage::stream::Stream;

const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// Class of a structure.
const STRUCTURE: u32 = 2;
/// Structures in structures, at most.
const DEEPEST: usize = 6;
/// Letters of a name, at most; MATLAB's are up to 63.
const LONGEST_NAME: u64 = 255;
/// Letters of the names of a structure's fields together, at most.
const LONGEST_NAMES: u64 = 1 << 16;
/// Sizes of an array, at most.
const MOST_SIZES: u64 = 32;

/// Storage of a numeric matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Class {
    /// Compressed columns.
    Sparse,
    /// Column after column.
    Dense,
}

/// A numeric array of a file.
#[derive(Debug)]
pub(super) struct Found {
    /// With the structures that it is in, `/` between them.
    pub(super) name: String,
    pub(super) class: Class,
    pub(super) sizes: Vec<u64>,
    pub(super) is_complex: bool,
    pub(super) is_logical: bool,
}

impl Found {
    /// Rows and columns, where there are no further sizes.
    pub(super) fn shape(&self) -> Option<(u64, u64)> {
        match self.sizes[..] {
            [rows, columns] => Some((rows, columns)),
            _ => None,
        }
    }
}

/// Takes a numeric array and its elements after the name, as many as it wants.
type Visit<'v> = dyn FnMut(&Found, &mut Body<'_>) -> Result<(), Error> + 'v;

/// Visits the numeric arrays of a file, in file order.
///
/// # Errors
/// [`Error::File`] with the place; those of the visit.
pub(super) fn walk(path: &Path, visit: &mut Visit<'_>) -> Result<(), Error> {
    let mut file = BinaryFile::open_parts(path)?;
    let order = header(path, &mut file)?;
    while file.remaining() > 0 {
        let [kind, length] = words(file.take()?, order);
        file.room_for(length.into(), 1, "bytes of an element")?;
        match kind {
            COMPRESSED => {
                let mut inflated = Inflated::of(path, &mut file, length.into());
                let mut word = [0; 8];
                inflated.fill(&mut word)?;
                let [kind, inner] = words(word, order);
                if kind == MATRIX {
                    let mut body = Body::of(&mut inflated, order, inner.into());
                    array(&mut body, "", 0, visit)?;
                }
                file.pass_over(length.into())?;
            }
            MATRIX => {
                let end = file.position() + u64::from(length);
                let mut body = Body::of(&mut file, order, length.into());
                array(&mut body, "", 0, visit)?;
                file.pass_over(end - file.position())?;
            }
            1..=18 => {
                let padded = u64::from(length).next_multiple_of(8);
                file.pass_over(padded.min(file.remaining()))?;
            }
            other => {
                return Err(Stream::refused(
                    &file,
                    format!("an element of the unknown type {other}; the file is damaged"),
                ));
            }
        }
    }
    Ok(())
}

/// Version and order of bytes.
fn header(path: &Path, file: &mut BinaryFile) -> Result<ByteOrder, Error> {
    let mut start = vec![0; file.remaining().min(128) as usize];
    file.fill(&mut start)?;
    let refused = |message: &str| Error::File {
        path: path.into(),
        message: message.into(),
    };
    match start.last() {
        _ if !is_version_5(&start) && is_version_4(&start) => Err(refused(
            "is a MATLAB file of version 4, which is not read; save it again with `-v7` (in SciPy: savemat with format=\"5\")",
        )),
        _ if !is_version_5(&start) => Err(refused("is no MATLAB file of version 5")),
        Some(b'M') => Ok(ByteOrder::Little),
        _ => Ok(ByteOrder::Big),
    }
}

fn words(bytes: [u8; 8], order: ByteOrder) -> [u32; 2] {
    let [a, b, c, d, e, f, g, h] = bytes;
    [[a, b, c, d], [e, f, g, h]].map(|word| match order {
        ByteOrder::Little => u32::from_le_bytes(word),
        ByteOrder::Big => u32::from_be_bytes(word),
    })
}

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
struct Inflated<'f> {
    path: PathBuf,
    /// Where the element is in the file.
    at: u64,
    decoder: ZlibDecoder<Take<&'f mut File>>,
}

impl<'f> Inflated<'f> {
    fn of(path: &Path, file: &'f mut BinaryFile, length: u64) -> Self {
        Self {
            path: path.into(),
            at: file.position(),
            decoder: ZlibDecoder::new(file.part(length)),
        }
    }
}

impl Stream for Inflated<'_> {
    fn fill(&mut self, buffer: &mut [u8]) -> Result<(), Error> {
        self.decoder
            .read_exact(buffer)
            .map_err(|error| match error.kind() {
                ErrorKind::UnexpectedEof => self.refused("it ends too early".into()),
                ErrorKind::InvalidInput | ErrorKind::InvalidData => {
                    self.refused(format!("it can't be decompressed: {error}"))
                }
                _ => Error::io(&self.path, "cannot read", error),
            })
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
        let mut buffer = [0; 1 << 12];
        let mut left = count;
        while left > 0 {
            let part = left.min(buffer.len() as u64) as usize;
            self.fill(&mut buffer[..part])?;
            left -= part as u64;
        }
        Ok(())
    }
}

/// What is left of an element that consists of others.
pub(super) struct Body<'s> {
    source: &'s mut dyn Elements,
    order: ByteOrder,
    left: u64,
}

/// Type and length of an element; up to four bytes of data may be in it.
struct Tag {
    kind: u32,
    bytes: u64,
    /// Up to a multiple of eight.
    padding: u64,
    inside: Option<[u8; 4]>,
}

impl<'s> Body<'s> {
    fn of(source: &'s mut dyn Elements, order: ByteOrder, left: u64) -> Self {
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

    fn tag(&mut self) -> Result<Tag, Error> {
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
    fn bytes(&mut self, most: u64) -> Result<Vec<u8>, Error> {
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

    fn leave_out_rest(&mut self) -> Result<(), Error> {
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

/// Visits an array, or the fields of a structure.
fn array(
    body: &mut Body<'_>,
    within: &str,
    depth: usize,
    visit: &mut Visit<'_>,
) -> Result<(), Error> {
    // An empty array in a structure may be written so.
    if body.left == 0 {
        return Ok(());
    }
    let order = body.order;
    let flags = body.bytes(8)?;
    let Some(flags) = flags.first_chunk().map(|flags| words(*flags, order)[0]) else {
        return Err(body.refused("an array without class; the file is damaged".into()));
    };
    let class = match flags & 0xff {
        STRUCTURE => None,
        5 => Some(Class::Sparse),
        6..=15 => Some(Class::Dense),
        // Cells, characters, objects, functions.
        _ => return body.leave_out_rest(),
    };
    let sizes = sizes(body)?;
    let name = body.bytes(LONGEST_NAME)?;
    let name = format!("{within}{}", String::from_utf8_lossy(&name));
    match class {
        Some(class) => {
            let found = Found {
                name,
                class,
                sizes,
                is_complex: flags & 0x0800 != 0,
                is_logical: flags & 0x0200 != 0,
            };
            visit(&found, body)?;
        }
        None if sizes == [1, 1] && depth < DEEPEST => fields(body, &name, depth, visit)?,
        None => {}
    }
    body.leave_out_rest()
}

/// Sizes of an array: 32-bit integers.
fn sizes(body: &mut Body<'_>) -> Result<Vec<u64>, Error> {
    let bytes = body.bytes(4 * MOST_SIZES)?;
    let (words, _) = bytes.as_chunks::<4>();
    let size = |word: &[u8; 4]| match body.order {
        ByteOrder::Little => i32::from_le_bytes(*word),
        ByteOrder::Big => i32::from_be_bytes(*word),
    };
    let sizes = words.iter().map(|word| u64::try_from(size(word)));
    let sizes: Result<Vec<u64>, _> = sizes.collect();
    sizes.map_err(|_| body.refused("an array with a negative size; the file is damaged".into()))
}

/// Visits the fields of a structure.
fn fields(
    body: &mut Body<'_>,
    name: &str,
    depth: usize,
    visit: &mut Visit<'_>,
) -> Result<(), Error> {
    let order = body.order;
    let length = body.bytes(8)?;
    let length = match (length.first_chunk(), order) {
        (Some(word), ByteOrder::Little) => u32::from_le_bytes(*word),
        (Some(word), ByteOrder::Big) => u32::from_be_bytes(*word),
        (None, _) => 0,
    };
    if length == 0 || u64::from(length) > LONGEST_NAME {
        return Err(body.refused(format!(
            "names of fields with {length} letters; the file is damaged"
        )));
    }
    let names = body.bytes(LONGEST_NAMES)?;
    for field in names.chunks_exact(length as usize) {
        let field = field.split(|&byte| byte == 0).next().unwrap_or_default();
        let within = format!("{name}/{}", String::from_utf8_lossy(field));
        let tag = body.tag()?;
        if tag.kind != MATRIX || tag.inside.is_some() {
            return Err(body.refused(format!("a field of type {}; the file is damaged", tag.kind)));
        }
        let mut inner = Body::of(&mut *body.source, order, tag.bytes);
        array(&mut inner, &within, depth + 1, visit)?;
        body.source.leave_out(tag.padding)?;
    }
    Ok(())
}
