//! What the messages of an object header say: shapes, element types, storage, links and attributes (IV.A.2 of the
//! HDF5 File Format Specification).

use super::attributes::Value;
use super::bytes::Cursor;
use super::contract::Element;
use super::object_header::UNDEFINED;
use super::text::Texts;

/// Axes of a dataset, at most.
const MOST_AXES: usize = 8;
/// Deflate can't do better than 1:1032.
const LARGEST_DEFLATE_RATIO: u64 = 1032;
/// A larger chunk makes no sense and would be allocated whole.
const LARGEST_CHUNK_BYTES: u64 = 1 << 26;

/// Shape of a dataspace; a scalar has no axes.
pub(super) fn shape(body: &[u8]) -> Result<Vec<usize>, String> {
    let mut at = Cursor::new(body);
    let version = at.byte()?;
    let rank = at.byte()? as usize;
    let _flags = at.byte()?;
    let kind = at.byte()?;
    match (version, kind) {
        (1, _) => drop(at.take(4)?),
        (2, 0 | 1) => {}
        _ => {
            return Err(format!(
                "has an empty dataspace or one of version {version}"
            ));
        }
    }
    if rank > MOST_AXES || (version == 2 && kind == 0 && rank > 0) {
        return Err(format!("has {rank} axes"));
    }
    let size = |at: &mut Cursor| {
        at.number(8)
            .and_then(|size| usize::try_from(size).map_err(|_| format!("has an axis of {size}")))
    };
    (0..rank).map(|_| size(&mut at)).collect()
}

/// Number of elements.
pub(super) fn count(shape: &[usize]) -> Result<usize, String> {
    let count = shape
        .iter()
        .try_fold(1_usize, |product, &size| product.checked_mul(size));
    count.ok_or_else(|| format!("its shape {shape:?} is impossible"))
}

/// Element type: one of three.
pub(super) fn element(body: &[u8]) -> Result<Element, String> {
    const REAL: &[u8] = &[0, 0, 64, 0, 52, 11, 0, 52, 0xff, 0x03, 0, 0];
    const INTEGER: &[u8] = &[0, 0, 64, 0];
    let mut at = Cursor::new(body);
    let class = at.byte()? & 0x0f;
    let bits = [at.byte()?, at.byte()?, at.byte()?];
    let size = at.number(4)?;
    let properties = at.take(at.left().min(12))?;
    match (class, size) {
        (1, 8) if bits[0] & 0x41 == 0 && properties == REAL => Ok(Element::Real),
        (0, 8) if bits[0] & 0x09 == 0x08 && properties.starts_with(INTEGER) => Ok(Element::Integer),
        (9, 16) if bits[0] & 0x0f == 1 => Ok(Element::Text),
        _ => Err("holds something else than little-endian f64, little-endian i64 or variable-length strings".to_owned()),
    }
}

/// How a dataset's elements are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Storage {
    /// In one piece from this byte on; anywhere if there are no elements.
    Contiguous(u64),
    /// In chunks, to be read by HDF5.
    Chunked,
}

/// Storage of a dataset of `bytes` bytes and `rank` axes, in a file of `file_bytes`: believed only if the file can hold it.
pub(super) fn storage(
    body: &[u8],
    bytes: u64,
    rank: usize,
    file_bytes: u64,
) -> Result<Storage, String> {
    let mut at = Cursor::new(body);
    let version = at.byte()?;
    let class = at.byte()?;
    match (version, class) {
        (3 | 4, 1) => {
            let (offset, stored) = (at.number(8)?, at.number(8)?);
            let fits = offset
                .checked_add(bytes)
                .is_some_and(|end| end <= file_bytes);
            match bytes {
                0 => Ok(Storage::Contiguous(0)),
                _ if fits && stored == bytes => Ok(Storage::Contiguous(offset)),
                _ => Err(format!(
                    "needs {bytes} bytes, but {stored} are stored from byte {offset} of a file of {file_bytes}"
                )),
            }
        }
        (4, 2) => {
            let _flags = at.byte()?;
            let axes = at.byte()? as usize;
            let width = at.byte()? as usize;
            if axes != rank + 1 || !(1..=8).contains(&width) {
                return Err(format!("has {rank} axes and chunks of {axes}"));
            }
            let mut chunk_bytes = 1_u64; // the last "axis" is the size of an element
            for _ in 0..axes {
                chunk_bytes = chunk_bytes.saturating_mul(at.number(width)?);
            }
            if chunk_bytes > LARGEST_CHUNK_BYTES {
                return Err(format!(
                    "has chunks of {chunk_bytes} bytes; at most {LARGEST_CHUNK_BYTES} make sense"
                ));
            }
            if bytes / LARGEST_DEFLATE_RATIO > file_bytes {
                return Err(format!(
                    "needs {bytes} bytes, but a file of {file_bytes} can't hold them, however compressed"
                ));
            }
            Ok(Storage::Chunked)
        }
        _ => Err("isn't stored contiguously (field arrays may also be in chunks)".to_owned()),
    }
}

/// Refuses filters other than deflate, shuffle and fletcher32.
pub(super) fn check_filters(body: &[u8]) -> Result<(), String> {
    let mut at = Cursor::new(body);
    let (version, filters) = (at.byte()?, at.byte()?);
    for _ in 0..filters {
        let id = at.number(2)?;
        if version != 2 || !(1..=3).contains(&id) {
            return Err(format!(
                "has filter {id}; only deflate, shuffle and fletcher32 are allowed"
            ));
        }
        let _flags = at.number(2)?;
        let values = at.number(2)? as usize;
        at.take(4 * values)?;
    }
    Ok(())
}

/// Name and address of a link.
pub(super) fn link(body: &[u8]) -> Result<(String, u64), String> {
    let mut at = Cursor::new(body);
    let (_version, flags) = (at.byte()?, at.byte()?);
    let kind = if flags & 0x08 != 0 { at.byte()? } else { 0 };
    if flags & 0x04 != 0 {
        at.number(8)?;
    }
    if flags & 0x10 != 0 {
        at.byte()?;
    }
    let length = at.number(1 << (flags & 3))?;
    let name = at.take(usize::try_from(length).unwrap_or(usize::MAX))?;
    let name =
        std::str::from_utf8(name).map_err(|_| "the name of a link isn't UTF-8".to_owned())?;
    if name.is_empty() || name == "." || name.contains(['/', '\0']) {
        return Err(format!("{name:.40?} can't be the name of a link"));
    }
    if kind != 0 {
        return Err(format!(
            "{name:.40?} is a soft or external link; only datasets and groups may stand here"
        ));
    }
    Ok((name.to_owned(), at.number(8)?))
}

/// Refuses links or attributes outside the header: `extra` bytes of the message come before their address if bit 0 is set.
pub(super) fn check_compact(body: &[u8], extra: usize) -> Result<(), String> {
    let mut at = Cursor::new(body);
    let (_version, flags) = (at.byte()?, at.byte()?);
    if flags & 1 != 0 {
        at.take(extra)?;
    }
    match at.number(8)? {
        UNDEFINED => Ok(()),
        _ => Err(
            "has links or attributes outside its header, which isn't allowed (docs/format.md)"
                .to_owned(),
        ),
    }
}

/// Name and value of an attribute.
pub(super) fn attribute(body: &[u8], texts: &mut Texts) -> Result<(String, Value), String> {
    let mut at = Cursor::new(body);
    let (version, flags) = (at.byte()?, at.byte()?);
    if version != 3 || flags != 0 {
        return Err(format!(
            "has an attribute of version {version}, or one that shares its type"
        ));
    }
    let (name_size, type_size, space_size) = (
        at.number(2)? as usize,
        at.number(2)? as usize,
        at.number(2)? as usize,
    );
    let _encoding = at.byte()?;
    let name = at.take(name_size)?;
    let name = name
        .strip_suffix(&[0])
        .and_then(|name| std::str::from_utf8(name).ok());
    let name = name
        .ok_or("the name of an attribute isn't UTF-8")?
        .to_owned();
    let told = |message: String| format!("attribute {name} {message}");
    let element = element(at.take(type_size)?).map_err(told)?;
    let shape = shape(at.take(space_size)?).map_err(told)?;
    let value = match (element, shape.as_slice()) {
        (Element::Real, []) => Value::Real(f64::from_bits(at.number(8)?)),
        (Element::Integer, []) => Value::Integer(at.number(8)?.cast_signed()),
        (Element::Text, []) => Value::Text(texts.next(&mut at).map_err(told)?),
        (Element::Text, [length]) if *length <= at.left() => Value::Texts(
            (0..*length)
                .map(|_| texts.next(&mut at))
                .collect::<Result<_, _>>()
                .map_err(told)?,
        ),
        _ => {
            return Err(told(format!(
                "is of shape {shape:?}; it must be a string, a list of them, one real or one integer"
            )));
        }
    };
    Ok((name, value))
}
