//! The header of an array that NumPy saved: a dictionary with type, order and shape, written as Python writes it.
//!
//! It is read here and not by a library because nothing in it may nest, and no size in it is believed.

use dcb_formats::Error;

use crate::binary::file::ByteOrder;
use crate::matrix::storage::number::{Kind, Number};
use crate::matrix::storage::stream::Stream;

const MAGIC: &[u8; 6] = b"\x93NUMPY";
/// Bytes of a header, at most; NumPy's own limit is 10 000.
const LONGEST: u64 = 1 << 16;
/// Axes of an array, at most: as in NumPy.
const MOST_AXES: usize = 64;

/// Type of an array's elements.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Element {
    /// Integers, reals, and truth values as 0 and 1.
    Number(Number),
    /// A real and an imaginary part.
    Complex,
    /// Letters of so many bytes each.
    Text {
        letters: u64,
        bytes_each: u64,
        order: ByteOrder,
    },
    /// Pickled Python objects.
    Object,
    /// Anything else, as the file calls it.
    Other(String),
}

/// Type, order and shape of an array.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Header {
    pub(super) element: Element,
    /// Column after column.
    pub(super) is_fortran: bool,
    pub(super) shape: Vec<u64>,
    /// Bytes in front of the data.
    pub(super) length: u64,
}

impl Header {
    /// Reads it; the data come next.
    pub(super) fn read(stream: &mut (impl Stream + ?Sized)) -> Result<Self, Error> {
        let mut start = [0; 10];
        stream.fill(&mut start)?;
        let [magic @ .., major, _, low, high] = start;
        if magic != *MAGIC {
            return Err(stream.refused("is no array that NumPy saved".into()));
        }
        let (length, before) = match major {
            1 => (u64::from(u16::from_le_bytes([low, high])), 10),
            2 | 3 => {
                let mut more = [0; 2];
                stream.fill(&mut more)?;
                (
                    u64::from(u32::from_le_bytes([low, high, more[0], more[1]])),
                    12,
                )
            }
            _ => {
                return Err(stream.refused(format!(
                    "an array of NumPy's format {major}, which isn't known"
                )));
            }
        };
        if length > LONGEST {
            return Err(stream.refused(format!(
                "a header of {length} bytes; at most {LONGEST} are supported"
            )));
        }
        let mut text = vec![0; length as usize];
        stream.fill(&mut text)?;
        let parsed = Text(&text).header(before + length);
        parsed.ok_or_else(|| {
            stream.refused("a header that NumPy doesn't write; the file is damaged".into())
        })
    }

    /// Number of elements; `None` beyond 64 bits.
    pub(super) fn count(&self) -> Option<u64> {
        self.shape
            .iter()
            .try_fold(1_u64, |count, size| count.checked_mul(*size))
    }

    /// Bytes of the whole file of the array; `None` beyond 64 bits, or where they don't follow from the type.
    pub(super) fn file_bytes(&self) -> Option<u64> {
        let each = match &self.element {
            Element::Number(number) => number.size() as u64,
            Element::Text {
                letters,
                bytes_each,
                ..
            } => letters.checked_mul(*bytes_each)?,
            Element::Complex | Element::Object | Element::Other(_) => return None,
        };
        self.count()?.checked_mul(each)?.checked_add(self.length)
    }

    /// The type of its numbers, if it has numbers.
    pub(super) fn number(&self) -> Option<Number> {
        match self.element {
            Element::Number(number) => Some(number),
            _ => None,
        }
    }
}

/// What is left of a header's text.
struct Text<'t>(&'t [u8]);

impl<'t> Text<'t> {
    fn header(mut self, length: u64) -> Option<Header> {
        let (mut element, mut is_fortran, mut shape) = (None, None, None);
        self.expect(b'{')?;
        while !self.takes(b'}') {
            let key = self.quoted()?;
            self.expect(b':')?;
            match key {
                b"descr" => element = Some(self.element()?),
                b"fortran_order" => is_fortran = Some(self.truth()?),
                b"shape" => shape = Some(self.shape()?),
                _ => return None,
            }
            self.takes(b',');
        }
        self.trim();
        self.0.is_empty().then_some(())?;
        Some(Header {
            element: element?,
            is_fortran: is_fortran?,
            shape: shape?,
            length,
        })
    }

    fn trim(&mut self) {
        self.0 = self.0.trim_ascii_start();
    }

    /// Whether this is next; then it is taken.
    fn takes(&mut self, byte: u8) -> bool {
        self.trim();
        match self.0.strip_prefix(&[byte]) {
            Some(rest) => {
                self.0 = rest;
                true
            }
            None => false,
        }
    }

    fn expect(&mut self, byte: u8) -> Option<()> {
        self.takes(byte).then_some(())
    }

    fn quoted(&mut self) -> Option<&'t [u8]> {
        self.trim();
        let (quote, rest) = self.0.split_first()?;
        matches!(quote, b'\'' | b'"').then_some(())?;
        let end = rest.iter().position(|byte| byte == quote)?;
        self.0 = &rest[end + 1..];
        Some(&rest[..end])
    }

    fn truth(&mut self) -> Option<bool> {
        self.trim();
        for (word, value) in [(&b"True"[..], true), (b"False", false)] {
            if let Some(rest) = self.0.strip_prefix(word) {
                self.0 = rest;
                return Some(value);
            }
        }
        None
    }

    fn shape(&mut self) -> Option<Vec<u64>> {
        self.expect(b'(')?;
        let mut sizes = Vec::new();
        while !self.takes(b')') {
            self.trim();
            let digits = self
                .0
                .iter()
                .take_while(|byte| byte.is_ascii_digit())
                .count();
            let (number, rest) = self.0.split_at(digits);
            sizes.push(std::str::from_utf8(number).ok()?.parse().ok()?);
            // Python 2 wrote long integers so.
            self.0 = rest.strip_prefix(b"L").unwrap_or(rest);
            self.takes(b',');
            (sizes.len() <= MOST_AXES).then_some(())?;
        }
        Some(sizes)
    }

    fn element(&mut self) -> Option<Element> {
        self.trim();
        if !self.0.starts_with(b"[") {
            return of_name(self.quoted()?);
        }
        // A record: its fields end before the next key.
        let end = [&b"'fortran_order'"[..], b"'shape'"]
            .iter()
            .filter_map(|key| find(self.0, key))
            .min()?;
        let (fields, rest) = self.0.split_at(end);
        self.0 = rest;
        let has_objects = [&b"'|O'"[..], b"'O'", b"'|O8'", b"'|O4'"]
            .iter()
            .any(|name| find(fields, name).is_some());
        Some(match has_objects {
            true => Element::Object,
            false => Element::Other("records".into()),
        })
    }
}

fn find(text: &[u8], wanted: &[u8]) -> Option<usize> {
    text.windows(wanted.len())
        .position(|window| window == wanted)
}

/// The type with a name such as `<f8`.
fn of_name(name: &[u8]) -> Option<Element> {
    let name = std::str::from_utf8(name).ok()?;
    let mut letters = name.chars();
    let order = match letters.next()? {
        '<' | '|' => ByteOrder::Little,
        '>' => ByteOrder::Big,
        _ => return None,
    };
    let kind = letters.next()?;
    let size = letters.as_str();
    let kind = match (kind, size) {
        ('O', _) => return Some(Element::Object),
        ('c', _) => return Some(Element::Complex),
        ('S', letters) => {
            return Some(Element::Text {
                letters: letters.parse().ok()?,
                bytes_each: 1,
                order,
            });
        }
        ('U', letters) => {
            return Some(Element::Text {
                letters: letters.parse().ok()?,
                bytes_each: 4,
                order,
            });
        }
        ('i', "1") => Kind::I8,
        ('i', "2") => Kind::I16,
        ('i', "4") => Kind::I32,
        ('i', "8") => Kind::I64,
        ('u' | 'b', "1") => Kind::U8,
        ('u', "2") => Kind::U16,
        ('u', "4") => Kind::U32,
        ('u', "8") => Kind::U64,
        ('f', "4") => Kind::F32,
        ('f', "8") => Kind::F64,
        _ => return Some(Element::Other(format!("{kind}{size}"))),
    };
    Some(Element::Number(Number { kind, order }))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn header(text: &str) -> Option<Header> {
        Text(text.as_bytes()).header(0)
    }

    #[test]
    fn headers_of_numpy_are_read() {
        let found =
            header("{'descr': '>f8', 'fortran_order': True, 'shape': (3, 4), }    \n").unwrap();
        assert_eq!(
            (found.is_fortran, found.shape.as_slice(), found.count()),
            (true, &[3, 4][..], Some(12))
        );
        assert_eq!(found.number(), Some(Number::big(Kind::F64)));
        let found = header("{'shape': (7L,), 'descr': '|O', 'fortran_order': False}").unwrap();
        assert_eq!((found.element, found.shape), (Element::Object, vec![7]));
        let found = header("{'descr': '<i4', 'fortran_order': False, 'shape': (), }").unwrap();
        assert_eq!(found.count(), Some(1));
        for (fields, element) in [
            ("('a', '<f8')", Element::Other("records".into())),
            ("('a', '|O')", Element::Object),
        ] {
            let text = format!("{{'descr': [{fields}], 'fortran_order': False, 'shape': (2,), }}");
            assert_eq!(header(&text).unwrap().element, element);
        }
    }

    #[test]
    fn nothing_else_is() {
        for text in [
            "",
            "{",
            "{}",
            "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 4)",
            "{'descr': '<f8', 'fortran_order': False, 'shape': (-3, 4)}",
            "{'descr': '<f8', 'fortran_order': 0, 'shape': (3, 4)}",
            "{'descr': '<f8', 'fortran_order': False, 'shape': (99999999999999999999,)}",
            "{'descr': 'f8', 'fortran_order': False, 'shape': (3,)}",
            "{'descr': '<f8', 'fortran_order': False, 'shape': (3,)} more",
            "{'descr': '<f8', 'fortran_order': False, 'shape': (3,), 'other': 1}",
            "((((((((((((",
        ] {
            assert_eq!(header(text), None, "{text}");
        }
        let many = format!(
            "{{'descr': '<f8', 'fortran_order': False, 'shape': ({})}}",
            "1,".repeat(100)
        );
        assert_eq!(header(&many), None);
        let large =
            header("{'descr': '<f8', 'fortran_order': False, 'shape': (9223372036854775808, 4)}")
                .unwrap();
        assert_eq!((large.count(), large.file_bytes()), (None, None));
    }
}
