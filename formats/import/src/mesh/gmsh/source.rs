//! The bytes of a `.msh` file: numbers as text or binary, sections by their names.

use std::path::{Path, PathBuf};

use dcb_formats::Error;
use dcb_formats::snapshot::read_small;

use super::super::fields;
use crate::binary::file::ByteOrder;
use crate::text::line_blocks::BYTE_ORDER_MARK;

/// Bytes of the longest mesh.
const LONGEST_FILE: u64 = 1 << 36;

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    /// Between blanks and line ends.
    Text,
    /// 32-bit integers, 64-bit reals, and sizes of so many bytes.
    Binary { order: ByteOrder, size: usize },
}

/// A file in memory and a place in it.
pub(super) struct Source {
    path: PathBuf,
    bytes: Vec<u8>,
    at: usize,
    pub encoding: Encoding,
}

impl Source {
    /// Reads a file; gives its SHA-256 too.
    pub fn open(path: &Path) -> Result<(Self, String), Error> {
        let (bytes, sha256) = read_small(path, LONGEST_FILE)?;
        let source = Self {
            path: path.into(),
            at: match bytes.starts_with(BYTE_ORDER_MARK) {
                true => BYTE_ORDER_MARK.len(),
                false => 0,
            },
            bytes,
            encoding: Encoding::Text,
        };
        Ok((source, sha256))
    }

    /// Bytes of the whole file.
    pub fn len(&self) -> u64 {
        self.bytes.len() as u64
    }

    /// Bytes of a size in a binary file.
    pub fn width(&self) -> usize {
        match self.encoding {
            Encoding::Text => 1,
            Encoding::Binary { size, .. } => size,
        }
    }

    /// An error here: by line in text files, by byte in binary ones.
    pub fn refused(&self, message: impl Into<String>) -> Error {
        let message = message.into();
        match self.encoding {
            Encoding::Text => {
                let before = self.bytes[..self.at].trim_ascii_end();
                let ends = before.iter().filter(|byte| **byte == b'\n').count();
                Error::Line {
                    path: self.path.clone(),
                    line: 1 + ends as u64,
                    message,
                }
            }
            Encoding::Binary { .. } => Error::File {
                path: self.path.clone(),
                message: format!("at byte {}: {message}", self.at),
            },
        }
    }

    fn skip_blanks(&mut self) {
        let rest = &self.bytes[self.at..];
        let blanks = rest.iter().position(|byte| !byte.is_ascii_whitespace());
        self.at += blanks.unwrap_or(rest.len());
    }

    /// The rest of this line, or the next one that isn't empty; `None` at the end of the file. Its end is passed.
    pub fn line(&mut self) -> Option<&[u8]> {
        self.skip_blanks();
        if self.at == self.bytes.len() {
            return None;
        }
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|byte| *byte == b'\n');
        let line = &rest[..length.unwrap_or(rest.len())];
        self.at += line.len() + usize::from(length.is_some());
        Some(line.trim_ascii())
    }

    /// The name of the next section, without `$`; `None` at the end of the file.
    pub fn section(&mut self) -> Result<Option<String>, Error> {
        let Some(line) = self.line() else {
            return Ok(None);
        };
        let name = line.strip_prefix(b"$").unwrap_or_default();
        let is_name = !name.is_empty() && name.iter().all(u8::is_ascii_alphanumeric);
        match is_name && !name.starts_with(b"End") {
            true => Ok(Some(String::from_utf8_lossy(name).into_owned())),
            false => {
                let shown = fields::shown(&line[..line.len().min(40)]);
                Err(self.refused(format!("{shown}; expected a section such as $Nodes")))
            }
        }
    }

    /// Passes the end of a section.
    pub fn end_section(&mut self, name: &str) -> Result<(), Error> {
        let expected = format!("$End{name}");
        match self.line() {
            Some(line) if line == expected.as_bytes() => Ok(()),
            _ => Err(self.refused(format!(
                "{expected} isn't where the counts of ${name} end; the file is damaged or cut off"
            ))),
        }
    }

    /// Passes a section that isn't needed.
    pub fn skip_section(&mut self, name: &str) -> Result<(), Error> {
        let end = format!("\n$End{name}");
        // The line end before may be the one that was passed.
        let from = self.at.saturating_sub(1);
        let rest = &self.bytes[from..];
        let mut starts = rest.windows(end.len());
        match starts.position(|bytes| bytes == end.as_bytes()) {
            Some(length) => {
                self.at = from + length + end.len();
                Ok(())
            }
            None => Err(self.refused(format!("${name} has no end; the file is cut off"))),
        }
    }

    /// Refuses counts that the rest of the file can't hold, with so many bytes each if it is binary.
    pub fn room_for(&self, count: u64, bytes: usize, items: &str) -> Result<usize, Error> {
        let each = match self.encoding {
            Encoding::Text => 2,
            Encoding::Binary { .. } => bytes as u64,
        };
        let left = (self.bytes.len() - self.at) as u64;
        // The last number of a text may have nothing behind it.
        match count.checked_mul(each) {
            Some(needed) if needed <= left + 1 => Ok(count as usize),
            _ => Err(self.refused(format!(
                "{count} {items} are announced, but only {left} bytes are left; the file is damaged or cut off"
            ))),
        }
    }

    fn token(&mut self) -> Result<&[u8], Error> {
        self.skip_blanks();
        let rest = &self.bytes[self.at..];
        if rest.is_empty() {
            return Err(self.refused("the file ends too early; it is cut off"));
        }
        let length = rest.iter().position(u8::is_ascii_whitespace);
        let length = length.unwrap_or(rest.len());
        self.at += length;
        Ok(&self.bytes[self.at - length..self.at])
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], Error> {
        match self.bytes[self.at..].first_chunk::<N>() {
            Some(bytes) => {
                self.at += N;
                Ok(*bytes)
            }
            None => Err(self.refused("the file ends too early; it is cut off")),
        }
    }

    /// An `int` of the format.
    pub fn int(&mut self) -> Result<i64, Error> {
        match self.encoding {
            Encoding::Text => self.text_integer(),
            Encoding::Binary { order, .. } => {
                let bytes = self.take()?;
                Ok(i64::from(match order {
                    ByteOrder::Little => i32::from_le_bytes(bytes),
                    ByteOrder::Big => i32::from_be_bytes(bytes),
                }))
            }
        }
    }

    /// A `size_t` of the format.
    pub fn size(&mut self) -> Result<u64, Error> {
        let number = match self.encoding {
            Encoding::Text => self.text_integer()?,
            Encoding::Binary { size: 4, .. } => self.int()?,
            Encoding::Binary { order, .. } => {
                let bytes = self.take()?;
                match order {
                    ByteOrder::Little => i64::from_le_bytes(bytes),
                    ByteOrder::Big => i64::from_be_bytes(bytes),
                }
            }
        };
        u64::try_from(number).map_err(|_| self.refused(format!("{number} is no count")))
    }

    fn text_integer(&mut self) -> Result<i64, Error> {
        let token = self.token()?;
        let number = fields::integer(token);
        number.map_err(|message| self.refused(message))
    }

    /// A label of a node or an element, as a `size_t`.
    pub fn label(&mut self) -> Result<u32, Error> {
        let number = self.size()?;
        self.as_label(i64::try_from(number).unwrap_or(i64::MAX))
    }

    /// A label, as an `int`.
    pub fn int_label(&mut self) -> Result<u32, Error> {
        let number = self.int()?;
        self.as_label(number)
    }

    fn as_label(&self, number: i64) -> Result<u32, Error> {
        fields::as_label(number).map_err(|message| self.refused(message))
    }

    /// A finite real number.
    pub fn real(&mut self) -> Result<f64, Error> {
        let number = match self.encoding {
            Encoding::Text => {
                let token = self.token()?;
                fields::real(token)
            }
            Encoding::Binary { order, .. } => {
                let bytes = self.take()?;
                let number = match order {
                    ByteOrder::Little => f64::from_le_bytes(bytes),
                    ByteOrder::Big => f64::from_be_bytes(bytes),
                };
                match number.is_finite() {
                    true => Ok(number),
                    false => Err(format!("{number} is not finite")),
                }
            }
        };
        number.map_err(|message| self.refused(message))
    }

    /// A point.
    pub fn point(&mut self) -> Result<[f64; 3], Error> {
        Ok([self.real()?, self.real()?, self.real()?])
    }

    /// Tells the byte order by the integer 1, and passes it.
    pub fn byte_order(&mut self) -> Result<ByteOrder, Error> {
        match self.take()? {
            [1, 0, 0, 0] => Ok(ByteOrder::Little),
            [0, 0, 0, 1] => Ok(ByteOrder::Big),
            _ => Err(self.refused(
                "the number 1 that tells the byte order isn't there; the file is damaged",
            )),
        }
    }
}
