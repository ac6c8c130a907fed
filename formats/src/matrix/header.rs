//! Banner, comments and size line of a Matrix Market file.

use std::path::Path;

use super::foreign;
use super::number::{NotANumber, unsigned};
use crate::Error;

/// How the entries follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Layout {
    /// `row column value` lines; a vector's lines leave the column out.
    Coordinate,
    /// Values only, column after column.
    Array,
}

/// What a value is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Field {
    /// Decimal number (`real`, `double`).
    Real,
    /// Whole number.
    Integer,
    /// No value; every entry is 1.
    Pattern,
}

/// Which entries the file leaves out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Symmetry {
    /// None.
    General,
    /// a_ji = a_ij.
    Symmetric,
    /// a_ji = -a_ij, zero diagonal.
    Skew,
    /// The complex conjugate: for real values the same as symmetric.
    Hermitian,
}

/// Everything before the entries.
#[derive(Clone, Copy, Debug)]
pub(super) struct Header {
    pub(super) is_vector: bool,
    pub(super) layout: Layout,
    pub(super) field: Field,
    pub(super) symmetry: Symmetry,
    pub(super) rows: usize,
    pub(super) columns: usize,
    /// Entries that the file claims to have. Nothing is allocated from it.
    pub(super) entries: u64,
    /// 1-based line of the sizes.
    pub(super) size_line: u64,
    /// Byte offset of the line after the sizes.
    pub(super) body_start: usize,
}

/// faer indexes with the positive half of 32 bits.
const LARGEST_DIMENSION: u64 = i32::MAX as u64;
/// Rows and columns that any file may have: 64 MiB of column pointers.
const UNQUESTIONED_DIMENSION: u64 = 1 << 24;
/// Beyond that, rows or columns per byte of text; a stiffness matrix has about 1/1000, a diagonal mass 1/20.
const DIMENSION_PER_BYTE: u64 = 4;

impl Header {
    /// Reads and checks everything up to the size line; `None` if the text ends before it.
    ///
    /// # Errors
    /// [`Error::Line`] with what was found and what is expected, [`Error::File`] for binary files of another format.
    pub(super) fn read(path: &Path, text: &[u8]) -> Result<Option<Self>, Error> {
        if let Some(message) = foreign::binary_format(text) {
            return Err(Error::File {
                path: path.into(),
                message,
            });
        }
        let mut lines = Lines {
            text,
            start: 0,
            number: 0,
        };
        let banner = lines.next_filled().unwrap_or_default();
        let bad = |line, message: String| Error::Line {
            path: path.into(),
            line,
            message,
        };
        let at_banner = |message| bad(lines.number.max(1), message);
        let words: Vec<String> = banner
            .split(u8::is_ascii_whitespace)
            .filter(|word| !word.is_empty())
            .map(shown)
            .collect();
        let is_banner = ["%%matrixmarket", "%matrixmarket"].iter().any(|known| {
            words
                .first()
                .is_some_and(|word| word.eq_ignore_ascii_case(known))
        });
        if !is_banner {
            return Err(at_banner(foreign::text_format(text, banner)));
        }
        if banner.contains(&b'\r') {
            return Err(at_banner(
                "lines end with a bare carriage return; expected LF or CRLF".into(),
            ));
        }
        let [_, object, layout, field, symmetry] = words.as_slice() else {
            return Err(at_banner(format!(
                "{} words in the banner; expected `%%MatrixMarket matrix coordinate real symmetric` or the like",
                words.len()
            )));
        };
        let is_vector = match object.to_ascii_lowercase().as_str() {
            "matrix" => false,
            "vector" => true,
            _ => {
                return Err(at_banner(format!(
                    "object `{object}`; expected `matrix` or `vector`"
                )));
            }
        };
        let layout = match layout.to_ascii_lowercase().as_str() {
            "coordinate" => Layout::Coordinate,
            "array" => Layout::Array,
            _ => {
                return Err(at_banner(format!(
                    "format `{layout}`; expected `coordinate` or `array`"
                )));
            }
        };
        let field = match field.to_ascii_lowercase().as_str() {
            "real" | "double" => Field::Real,
            "integer" | "unsigned-integer" => Field::Integer,
            "pattern" => Field::Pattern,
            "complex" => {
                return Err(at_banner(
                    "complex values; expected real ones (`real`, `integer` or `pattern`)".into(),
                ));
            }
            _ => {
                return Err(at_banner(format!(
                    "field `{field}`; expected `real`, `integer` or `pattern`"
                )));
            }
        };
        let symmetry = match symmetry.to_ascii_lowercase().as_str() {
            "general" => Symmetry::General,
            "symmetric" => Symmetry::Symmetric,
            "skew-symmetric" => Symmetry::Skew,
            "hermitian" => Symmetry::Hermitian,
            _ => {
                let expected = "`general`, `symmetric` or `skew-symmetric`";
                return Err(at_banner(format!(
                    "symmetry `{symmetry}`; expected {expected}"
                )));
            }
        };
        if layout == Layout::Array && field == Field::Pattern {
            return Err(at_banner(
                "`array pattern` has neither places nor values; expected `coordinate pattern`"
                    .into(),
            ));
        }
        if is_vector && symmetry != Symmetry::General {
            return Err(at_banner(
                "a vector with a symmetry; expected `general`".into(),
            ));
        }

        let sizes = loop {
            match lines.next_filled() {
                None => return Ok(None),
                Some(line) if line.starts_with(b"%") => {}
                Some(line) => break line,
            }
        };
        let size_line = lines.number;
        let names: &[&str] = match (is_vector, layout) {
            (false, Layout::Coordinate) => &["rows", "columns", "entries"],
            (false, Layout::Array) => &["rows", "columns"],
            (true, Layout::Coordinate) => &["rows", "entries"],
            (true, Layout::Array) => &["rows"],
        };
        let numbers = size_numbers(sizes, names).map_err(|message| bad(size_line, message))?;
        let (rows, columns) = if is_vector {
            (numbers[0], 1)
        } else {
            (numbers[0], numbers[1])
        };
        let largest = rows.max(columns);
        if largest > LARGEST_DIMENSION {
            return Err(bad(
                size_line,
                format!(
                    "{rows} rows and {columns} columns; at most {LARGEST_DIMENSION} are supported"
                ),
            ));
        }
        if symmetry != Symmetry::General && rows != columns {
            return Err(bad(
                size_line,
                format!("{rows} rows and {columns} columns in a {} matrix", words[4]),
            ));
        }
        let entries = match (layout, symmetry) {
            (Layout::Coordinate, _) => numbers[names.len() - 1],
            (Layout::Array, Symmetry::General) => rows * columns,
            (Layout::Array, Symmetry::Symmetric | Symmetry::Hermitian) => rows * (rows + 1) / 2,
            (Layout::Array, Symmetry::Skew) => rows * rows.saturating_sub(1) / 2,
        };
        Ok(Some(Self {
            is_vector,
            layout,
            field,
            symmetry,
            rows: rows as usize,
            columns: columns as usize,
            entries,
            size_line,
            body_start: lines.start,
        }))
    }

    /// Whether a text of so many bytes may have so many rows and columns.
    ///
    /// # Errors
    /// [`Error::Line`] with the numbers.
    pub(super) fn check_dimensions(&self, path: &Path, text_length: u64) -> Result<(), Error> {
        let (rows, columns) = (self.rows, self.columns);
        let plausible = UNQUESTIONED_DIMENSION.max(text_length.saturating_mul(DIMENSION_PER_BYTE));
        if rows.max(columns) as u64 > plausible {
            return Err(Error::Line {
                path: path.into(),
                line: self.size_line,
                message: format!(
                    "{rows} rows and {columns} columns announced by a file of {text_length} bytes; at most {plausible} are plausible"
                ),
            });
        }
        Ok(())
    }

    /// Whether an entry stands for its mirror image too.
    pub(super) fn is_mirrored(&self) -> bool {
        self.symmetry != Symmetry::General
    }
}

/// Walks over lines that are not blank.
struct Lines<'a> {
    text: &'a [u8],
    start: usize,
    number: u64,
}

impl<'a> Lines<'a> {
    /// The next line with something on it, trimmed.
    fn next_filled(&mut self) -> Option<&'a [u8]> {
        while self.start < self.text.len() {
            let rest = &self.text[self.start..];
            let length = rest
                .iter()
                .position(|&byte| byte == b'\n')
                .unwrap_or(rest.len());
            self.start = (self.start + length + 1).min(self.text.len());
            self.number += 1;
            let line = rest[..length].trim_ascii();
            if !line.is_empty() {
                return Some(line);
            }
        }
        None
    }
}

/// Characters of a file that a message repeats at most.
const SHOWN_LENGTH: usize = 40;

/// Text of a file as a message can carry it: short, printable.
pub(super) fn shown(text: &[u8]) -> String {
    let start = String::from_utf8_lossy(&text[..text.len().min(SHOWN_LENGTH)]);
    let ellipsis = if text.len() > SHOWN_LENGTH { "…" } else { "" };
    format!("{}{ellipsis}", start.escape_debug())
}

/// Reads the numbers of the size line.
fn size_numbers(line: &[u8], names: &[&str]) -> Result<Vec<u64>, String> {
    let words: Vec<&[u8]> = line
        .split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
        .collect();
    if words.len() != names.len() {
        return Err(format!(
            "size line `{}`; expected `{}`",
            shown(line),
            names.join(" ")
        ));
    }
    let number = |(word, name): (&&[u8], &&str)| match unsigned(word) {
        Ok((value, length)) if length == word.len() => Ok(value),
        Err(NotANumber::OutOfRange) => Err(format!("`{}` {name} is beyond 64 bits", shown(word))),
        _ => Err(format!(
            "`{}` as the number of {name}; expected a whole number, not negative",
            shown(word)
        )),
    };
    words.iter().zip(names).map(number).collect()
}
