//! The numbers of a data array: text, base64 or raw bytes, deflated or not.

use std::io::Read;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::read::ZlibDecoder;

use super::super::fields;
use crate::binary::file::ByteOrder;

/// Element types of arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Real(usize),
    Signed(usize),
    Unsigned(usize),
}

impl Kind {
    pub fn of(name: &str) -> Option<Self> {
        Some(match name {
            "Float32" => Self::Real(4),
            "Float64" => Self::Real(8),
            "Int8" => Self::Signed(1),
            "Int16" => Self::Signed(2),
            "Int32" => Self::Signed(4),
            "Int64" => Self::Signed(8),
            "UInt8" => Self::Unsigned(1),
            "UInt16" => Self::Unsigned(2),
            "UInt32" => Self::Unsigned(4),
            "UInt64" => Self::Unsigned(8),
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::Real(size) | Self::Signed(size) | Self::Unsigned(size) => size,
        }
    }
}

/// How binary arrays of a file are written.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    pub order: ByteOrder,
    /// Bytes of the lengths before the data: 4 or 8.
    pub header: usize,
    pub compression: Compression,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Compression {
    None,
    Zlib,
}

/// Where the numbers are.
#[derive(Clone, Copy, Debug)]
pub(super) enum Data<'a> {
    Text(&'a str),
    Base64(&'a [u8]),
    Raw(&'a [u8]),
}

/// An array before its numbers are read.
#[derive(Clone, Copy, Debug)]
pub(super) struct DataArray<'a> {
    pub kind: Kind,
    pub data: Data<'a>,
}

impl DataArray<'_> {
    /// As many finite numbers.
    pub fn reals(&self, count: usize, layout: Layout) -> Result<Vec<f64>, String> {
        if let Data::Text(text) = self.data {
            return words(text, count, fields::real);
        }
        let bytes = self.bytes(count, layout)?;
        let numbers: Vec<f64> = match self.kind {
            Kind::Real(4) => each(&bytes, layout.order, |bytes| {
                f64::from(f32::from_ne_bytes(bytes))
            }),
            Kind::Real(_) => each(&bytes, layout.order, f64::from_ne_bytes),
            _ => return Err("has whole numbers, expected Float64 or Float32".into()),
        };
        match numbers.iter().find(|number| !number.is_finite()) {
            None => Ok(numbers),
            Some(number) => Err(format!("has the number {number}, which is not finite")),
        }
    }

    /// As many whole numbers.
    pub fn integers(&self, count: usize, layout: Layout) -> Result<Vec<i64>, String> {
        if let Kind::Real(_) = self.kind {
            return Err("has real numbers, expected whole ones".into());
        }
        if let Data::Text(text) = self.data {
            return words(text, count, fields::integer);
        }
        let bytes = self.bytes(count, layout)?;
        let order = layout.order;
        Ok(match self.kind {
            Kind::Signed(1) => each(&bytes, order, |bytes| i64::from(i8::from_ne_bytes(bytes))),
            Kind::Signed(2) => each(&bytes, order, |bytes| i64::from(i16::from_ne_bytes(bytes))),
            Kind::Signed(4) => each(&bytes, order, |bytes| i64::from(i32::from_ne_bytes(bytes))),
            Kind::Unsigned(1) => each(&bytes, order, |bytes| i64::from(u8::from_ne_bytes(bytes))),
            Kind::Unsigned(2) => each(&bytes, order, |bytes| i64::from(u16::from_ne_bytes(bytes))),
            Kind::Unsigned(4) => each(&bytes, order, |bytes| i64::from(u32::from_ne_bytes(bytes))),
            // Beyond 2^63 they come out negative, which nothing here may be.
            _ => each(&bytes, order, i64::from_ne_bytes),
        })
    }

    /// The bytes of so many numbers.
    fn bytes(&self, count: usize, layout: Layout) -> Result<Vec<u8>, String> {
        let decoded;
        let stored = match self.data {
            Data::Raw(bytes) => bytes,
            Data::Base64(text) => {
                decoded = from_base64(text)?;
                &decoded
            }
            Data::Text(_) => return Err("is text".into()),
        };
        let needed = count
            .checked_mul(self.kind.size())
            .ok_or("is larger than any file")?;
        let bytes = match layout.compression {
            Compression::None => stored_bytes(stored, layout)?.to_vec(),
            Compression::Zlib => inflated(stored, layout, needed)?,
        };
        match bytes.len() == needed {
            true => Ok(bytes),
            false => Err(format!("has {} bytes, expected {needed}", bytes.len())),
        }
    }
}

const CUT_OFF: &str = "ends too early; the file is cut off or damaged";

/// A length before the data, and what follows it.
fn length(bytes: &[u8], layout: Layout) -> Result<(u64, &[u8]), String> {
    let (head, rest) = bytes.split_at_checked(layout.header).ok_or(CUT_OFF)?;
    let mut number = [0; 8];
    for (at, byte) in head.iter().enumerate() {
        let place = match layout.order {
            ByteOrder::Little => at,
            ByteOrder::Big => head.len() - 1 - at,
        };
        number[place] = *byte;
    }
    Ok((u64::from_le_bytes(number), rest))
}

/// The bytes behind their length.
fn stored_bytes(bytes: &[u8], layout: Layout) -> Result<&[u8], String> {
    let (length, rest) = length(bytes, layout)?;
    let length = usize::try_from(length).ok();
    length
        .and_then(|length| rest.get(..length))
        .ok_or_else(|| CUT_OFF.into())
}

/// Blocks of zlib streams behind their number, sizes and compressed sizes.
fn inflated(bytes: &[u8], layout: Layout, needed: usize) -> Result<Vec<u8>, String> {
    let (blocks, rest) = length(bytes, layout)?;
    let (block, rest) = length(rest, layout)?;
    let (last, mut rest) = length(rest, layout)?;
    if blocks > (rest.len() / layout.header) as u64 {
        return Err(CUT_OFF.into());
    }
    let mut sizes = Vec::new();
    for _ in 0..blocks {
        let (size, after) = length(rest, layout)?;
        sizes.push(size);
        rest = after;
    }
    let mut found = Vec::new();
    for (at, size) in sizes.iter().enumerate() {
        let whole = if at + 1 == sizes.len() && last > 0 {
            last
        } else {
            block
        };
        let size = usize::try_from(*size).map_err(|_| CUT_OFF)?;
        let (packed, after) = rest.split_at_checked(size).ok_or(CUT_OFF)?;
        rest = after;
        let before = found.len();
        // Nothing is made that isn't wanted.
        let room = whole.min((needed - before) as u64 + 1);
        ZlibDecoder::new(packed)
            .take(room)
            .read_to_end(&mut found)
            .map_err(|error| format!("has damaged zlib data: {error}"))?;
        let made = (found.len() - before) as u64;
        if made != whole || found.len() > needed {
            return Err(format!(
                "has a block of {made} bytes or more, expected {whole}, and {needed} in all"
            ));
        }
    }
    Ok(found)
}

/// Base64 in one or several pieces, each with its padding; blanks and line ends between don't matter.
fn from_base64(text: &[u8]) -> Result<Vec<u8>, String> {
    let refused = |error| format!("has damaged base64: {error}");
    let visible: Vec<u8> = text
        .iter()
        .copied()
        .filter(|byte| !byte.is_ascii_whitespace())
        .collect();
    let mut rest = &visible[..];
    let mut bytes = Vec::with_capacity(rest.len() / 4 * 3);
    while !rest.is_empty() {
        let padding = rest
            .iter()
            .position(|byte| *byte == b'=')
            .unwrap_or(rest.len());
        let end = rest[padding..].iter().position(|byte| *byte != b'=');
        let end = end.map_or(rest.len(), |length| padding + length);
        STANDARD
            .decode_vec(&rest[..end], &mut bytes)
            .map_err(refused)?;
        rest = &rest[end..];
    }
    Ok(bytes)
}

/// As many words as numbers.
fn words<T>(
    text: &str,
    count: usize,
    of: impl Fn(&[u8]) -> Result<T, String>,
) -> Result<Vec<T>, String> {
    let mut found = Vec::new();
    for word in text.as_bytes().split(u8::is_ascii_whitespace) {
        if !word.is_empty() {
            if found.len() == count {
                return Err(format!("has more than {count} numbers"));
            }
            found.push(of(word)?);
        }
    }
    match found.len() == count {
        true => Ok(found),
        false => Err(format!("has {} numbers, expected {count}", found.len())),
    }
}

/// Each number of bytes in an order.
fn each<const N: usize, T>(bytes: &[u8], order: ByteOrder, of: impl Fn([u8; N]) -> T) -> Vec<T> {
    let is_native = (order == ByteOrder::Little) == cfg!(target_endian = "little");
    let (chunks, _) = bytes.as_chunks::<N>();
    let native = chunks.iter().map(|chunk| {
        let mut bytes = *chunk;
        if !is_native {
            bytes.reverse();
        }
        of(bytes)
    });
    native.collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn base64_in_pieces_is_read_through() {
        let pieces = [
            STANDARD.encode("abcd"),
            STANDARD.encode("efg"),
            STANDARD.encode("h"),
        ];
        assert_eq!(
            from_base64(pieces.join("\n ").as_bytes()).unwrap(),
            b"abcdefgh"
        );
        assert!(from_base64(b"ab!d").is_err());
    }

    #[test]
    fn lengths_of_both_orders_and_widths() {
        let of = |order, header| Layout {
            order,
            header,
            compression: Compression::None,
        };
        assert_eq!(
            length(&[2, 1, 0, 0, 9], of(ByteOrder::Little, 4)),
            Ok((258, &[9][..]))
        );
        assert_eq!(
            length(&[0, 0, 0, 0, 0, 0, 1, 2], of(ByteOrder::Big, 8)),
            Ok((258, &[][..]))
        );
        assert!(length(&[0, 0], of(ByteOrder::Big, 4)).is_err());
    }
}
