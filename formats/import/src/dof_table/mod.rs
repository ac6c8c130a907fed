//! Tables of degrees of freedom (`--dofs FILE`): what the rows of a matrix without labels belong to. One file for each kind, told by content.

mod ansys_vector;
mod array;
mod calculix;
mod direction;
mod lines;
mod plain;

use std::path::Path;

use dcb_formats::Error;
use dcb_formats::matrix::blocks::TextBlocks;
use rustc_hash::FxHashMap;

use crate::stored::RowLabel;
use crate::stored::row_key::RowKey;

/// A table of degrees of freedom.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DofTable {
    /// Label of each row, all different.
    pub rows: Vec<RowLabel>,
    /// SHA-256 of the file's bytes, hexadecimal.
    pub sha256: String,
    /// Remarks for the user, a sentence each.
    pub notes: Vec<String>,
}

/// Reads a table for a matrix of so many rows. `name` picks one of several where a file has them; text tables have no names.
///
/// # Errors
/// [`Error::Line`] for lines that can't be of such a table, rows that come twice, other counts of rows than the matrix has;
/// [`Error::File`] for a name where none can be, and for files that are no table.
pub fn read(path: &Path, name: Option<&str>, row_count: usize) -> Result<DofTable, Error> {
    let text = TextBlocks::open(path)?;
    let start = text.pending();
    if start.iter().take(1 << 10).any(|byte| *byte == 0) {
        drop(text);
        return array::read(path, name, row_count);
    }
    if let Some(name) = name {
        return Err(Error::File {
            path: path.into(),
            message: format!("is text with one table, which has no name; leave `#{name}` out"),
        });
    }
    let read = if ansys_vector::recognises(start) {
        ansys_vector::read
    } else if calculix::recognises(start) {
        calculix::read
    } else {
        plain::read
    };
    drop(text);
    read(path, row_count)
}

/// As messages list them.
const KINDS: &str = "CalculiX's .dof file, the mapping table of Ansys' HBMAT, the map of APDL Math as Matrix Market array, or lines `label direction` (17 uy)";

/// Rows of a table while they are read.
struct RowList {
    keys: Vec<RowKey>,
    /// Line of each.
    lines: Vec<u32>,
    row_count: usize,
}

impl RowList {
    fn new(row_count: usize) -> Self {
        Self {
            keys: Vec::new(),
            lines: Vec::new(),
            row_count,
        }
    }

    /// Adds the next row.
    fn push(&mut self, key: RowKey, line: u64) -> Result<(), String> {
        if self.keys.len() == self.row_count {
            return Err(format!(
                "one row more than the {} of the matrix; this table belongs to another one",
                self.row_count
            ));
        }
        self.keys.push(key);
        self.lines.push(u32::try_from(line).unwrap_or(u32::MAX));
        Ok(())
    }

    /// All rows, each once. `twice` says what to do where one comes again.
    fn finish(self, path: &Path, twice: &str) -> Result<Vec<RowLabel>, Error> {
        if self.keys.len() < self.row_count {
            return Err(Error::File {
                path: path.into(),
                message: format!(
                    "has {} rows, the matrix {}; this table belongs to another one, or is cut off",
                    self.keys.len(),
                    self.row_count
                ),
            });
        }
        let mut first = FxHashMap::default();
        for (key, line) in self.keys.iter().zip(&self.lines) {
            if let Some(before) = first.insert(*key, *line) {
                return Err(Error::Line {
                    path: path.into(),
                    line: u64::from(*line),
                    message: format!("{key} is in line {before} already; {twice}"),
                });
            }
        }
        Ok(self.keys.into_iter().map(RowKey::label).collect())
    }
}
