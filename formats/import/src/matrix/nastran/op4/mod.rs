//! Nastran's OUTPUT4: what binary and ASCII files have in common.
//!
//! A matrix is stored by columns; columns of zeros are left out, and one behind the last ends the matrix. A column is dense, from its first
//! row on, or has strings: runs of rows with a length and a first row, as two integers (*bigmat*) or packed into one. The letters of a name
//! count, the rest of its eight characters is blank or NUL.

pub mod binary;
mod records;
pub mod text;

use crate::matrix::storage::collected::{LARGEST_SIZE, obstacle_of_shape, square};
use crate::stored::Listed;

/// Rows from which on strings have two integers whatever the header says.
const BIGMAT_ROWS: u64 = 1 << 16;

/// What stands before the columns of a matrix.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) name: String,
    pub(super) columns: u64,
    pub(super) rows: u64,
    /// Strings have two integers.
    pub(super) is_bigmat: bool,
    form: i64,
    pub(super) numbers: Numbers,
}

/// Type of the numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Numbers {
    Single,
    Double,
    ComplexSingle,
    ComplexDouble,
}

impl Numbers {
    fn of(kind: i64) -> Option<Self> {
        Some(match kind {
            1 => Self::Single,
            2 => Self::Double,
            3 => Self::ComplexSingle,
            4 => Self::ComplexDouble,
            _ => return None,
        })
    }

    pub(super) fn is_complex(self) -> bool {
        matches!(self, Self::ComplexSingle | Self::ComplexDouble)
    }

    pub(super) fn is_double(self) -> bool {
        matches!(self, Self::Double | Self::ComplexDouble)
    }
}

impl Header {
    /// Of the integers of a header, in their order.
    ///
    /// # Errors
    /// They can't be those of a matrix.
    pub(super) fn new([columns, rows, form, kind]: [i64; 4], name: &[u8]) -> Result<Self, String> {
        let refused = |what: &str| {
            Err(format!(
                "a matrix of {columns} columns, {rows} rows, form {form} and type {kind} is announced; {what}"
            ))
        };
        let Some(numbers) = Numbers::of(kind) else {
            return refused("types are 1 to 4");
        };
        if columns < 1 || rows == 0 || columns.max(rows.saturating_abs()) > LARGEST_SIZE as i64 {
            return refused("expected one row and column at least, and 2147483647 at most");
        }
        if !(0..=99).contains(&form) {
            return refused("forms are 1 to 13");
        }
        Ok(Self {
            name: name_of(name),
            columns: columns.unsigned_abs(),
            rows: rows.unsigned_abs(),
            is_bigmat: rows < 0 || rows.unsigned_abs() >= BIGMAT_ROWS,
            form,
            numbers,
        })
    }

    fn obstacle(&self) -> Option<String> {
        if self.numbers.is_complex() {
            return Some("complex".into());
        }
        obstacle_of_shape(self.rows, self.columns).or(match self.form {
            1 | 2 | 6 => None,
            4 | 5 => Some(format!("a triangular factor (form {})", self.form)),
            form => Some(format!(
                "of form {form}; stiffness and mass have form 1 or 6"
            )),
        })
    }

    pub(super) fn listed(&self) -> Listed {
        Listed {
            name: self.name.clone(),
            shape: Some((self.rows, self.columns)),
            obstacle: self.obstacle(),
        }
    }

    /// Rows of a matrix that is to be read.
    ///
    /// # Errors
    /// It can't be a stiffness or mass matrix.
    pub(super) fn size(&self) -> Result<u32, String> {
        if self.numbers.is_complex() {
            return Err(format!(
                "the matrix `{}` is complex; stiffness and mass are real",
                self.name
            ));
        }
        let named = |message: String| format!("the matrix `{}`: {message}", self.name);
        let size = square(self.rows, self.columns).map_err(named)?;
        match self.obstacle() {
            Some(obstacle) => Err(format!("the matrix `{}` is {obstacle}", self.name)),
            None => Ok(size),
        }
    }
}

/// A name without what fills it up; characters that aren't printed are questions.
fn name_of(name: &[u8]) -> String {
    let letters = name.iter().map(|&byte| match byte {
        0 => ' ',
        b' '..=b'~' => char::from(byte),
        _ => '?',
    });
    letters.collect::<String>().trim().to_owned()
}

/// Numbers that follow each other in a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Run {
    /// 1-based.
    pub(super) first_row: u64,
    /// How many words the numbers take, or how many numbers there are where the column is dense.
    pub(super) length: u64,
}

impl Run {
    /// Of the one integer that begins a string of a matrix that isn't *bigmat*.
    pub(super) fn packed(integer: i64) -> Option<Self> {
        // 32 bits may be filled up to the sign.
        let integer = match u64::try_from(integer) {
            Ok(integer) => integer,
            Err(_) => u64::from(i32::try_from(integer).ok()?.cast_unsigned()),
        };
        Some(Self {
            first_row: integer & 0xffff,
            length: (integer >> 16).checked_sub(1)?,
        })
    }

    /// Of the two integers that begin a string of a *bigmat* matrix.
    pub(super) fn unpacked(length: i64, first_row: i64) -> Option<Self> {
        Some(Self {
            first_row: u64::try_from(first_row).ok()?,
            length: u64::try_from(length).ok()?.checked_sub(1)?,
        })
    }
}

/// Where the numbers of a matrix may be: columns rise, and rows in a column.
#[derive(Debug)]
pub(super) struct Places {
    rows: u64,
    column: u64,
    /// The first row that the next run may begin with.
    row: u64,
}

impl Places {
    pub(super) fn new(header: &Header) -> Self {
        Self {
            rows: header.rows,
            column: 0,
            row: 1,
        }
    }

    /// 1-based column that is stored here.
    pub(super) fn column(&self) -> u64 {
        self.column
    }

    /// Goes to a column.
    ///
    /// # Errors
    /// It can't come here.
    pub(super) fn begin(&mut self, column: u64) -> Result<(), String> {
        if column <= self.column {
            return Err(match (column, self.column) {
                (0, _) => "column 0; columns are counted from 1".into(),
                (_, before) => format!("column {column} comes after column {before}; columns rise"),
            });
        }
        self.column = column;
        self.row = 1;
        Ok(())
    }

    /// Takes the rows of a run of so many entries.
    ///
    /// # Errors
    /// They aren't behind those before, or not in the matrix.
    pub(super) fn take(&mut self, first_row: u64, count: u64) -> Result<(), String> {
        let end = first_row.saturating_add(count);
        if first_row < self.row || end > self.rows + 1 {
            return Err(format!(
                "column {}: {count} entries from row {first_row} on; expected rows {} to {}",
                self.column, self.row, self.rows
            ));
        }
        self.row = end;
        Ok(())
    }
}
