//! Banner, comments and size line of a Matrix Market file.

use std::path::Path;

use super::banner::{Banner, SizeLine};
use super::foreign;
use crate::Error;

/// How the entries follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Layout {
    /// `row column value` lines; a vector's lines leave the column out.
    Coordinate,
    /// Values only, column after column.
    Array,
}

/// Type of the values.
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
pub(super) struct MatrixHeader {
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

/// Rows and columns that any file may have: 64 MiB of column pointers.
const UNQUESTIONED_DIMENSION: u64 = 1 << 24;
/// Beyond that, rows or columns per byte of text; a stiffness matrix has about 1/1000, a diagonal mass 1/20.
const DIMENSION_PER_BYTE: u64 = 4;

impl MatrixHeader {
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
        let banner_line = lines.next_filled().unwrap_or_default();
        let bad = |line, message: String| Error::Line {
            path: path.into(),
            line,
            message,
        };
        let banner =
            Banner::of(text, banner_line).map_err(|message| bad(lines.number.max(1), message))?;
        let sizes = loop {
            match lines.next_filled() {
                None => return Ok(None),
                Some(line) if line.starts_with(b"%") => {}
                Some(line) => break line,
            }
        };
        let size_line = lines.number;
        let SizeLine {
            rows,
            columns,
            entries,
        } = banner
            .sizes(sizes)
            .map_err(|message| bad(size_line, message))?;
        Ok(Some(Self {
            is_vector: banner.is_vector,
            layout: banner.layout,
            field: banner.field,
            symmetry: banner.symmetry,
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
pub fn shown(text: &[u8]) -> String {
    let start = String::from_utf8_lossy(&text[..text.len().min(SHOWN_LENGTH)]);
    let ellipsis = if text.len() > SHOWN_LENGTH { "…" } else { "" };
    format!("{}{ellipsis}", start.escape_debug())
}
