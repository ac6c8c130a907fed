//! The numeric arrays of a file, those in structures too.

use std::path::Path;

use dcb_formats::Error;

use super::elements::{Body, Inflated, words};
use super::{is_version_4, is_version_5};
use crate::binary::file::{BinaryFile, ByteOrder};
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
                    inflated.finish()?;
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
