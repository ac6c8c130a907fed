//! PETSc binary files (`MatView` and `VecView` of a binary viewer): objects without names, one after the other, big-endian.
//!
//! A matrix has its class id 1211216, rows, columns and entries, then the number of entries of each row, 0-based columns and values; -1
//! entries stand for a matrix in full, row after row. Builds of PETSc with 64-bit indices write all integers with 8 bytes. No file says
//! how wide its values are: they are read as real double precision, and the lengths must agree with that.

use std::path::Path;

use dcb_formats::Error;

use crate::binary::file::BinaryFile;
use crate::binary::hashed::hashed;
use crate::matrix::storage::collected::{obstacle_of_shape, square};
use crate::matrix::storage::compressed::{Along, Pattern};
use crate::matrix::storage::dense::dense;
use crate::matrix::storage::number::{Kind, Number};
use crate::matrix::storage::stream::indices;
use crate::stored::{Content, Listed, Reading, StoredMatrix};

const MATRIX: u32 = 1_211_216;
const VECTOR: u32 = 1_211_214;
const INDEX_SET: u32 = 1_211_218;
/// Bytes of a value, as it is read.
const VALUE: u64 = 8;
/// Bytes of a value in other builds, and how those are called.
const OTHER_VALUES: [(u64, &str); 3] = [
    (4, "single precision"),
    (16, "complex numbers"),
    (2 * VALUE, "quadruple precision"),
];

/// Whether a file begins with a matrix or vector of PETSc.
pub fn recognises(start: &[u8]) -> bool {
    let at = |offset: usize| start.get(offset..offset + 4);
    let is_class = |offset| {
        at(offset).is_some_and(|id| id == MATRIX.to_be_bytes() || id == VECTOR.to_be_bytes())
    };
    is_class(0) || (start.starts_with(&[0; 4]) && is_class(4))
}

/// The matrices of a file, numbered from 1 on where there are several.
///
/// # Errors
/// [`Error::File`] with the place for what isn't PETSc's, or doesn't fit the file; [`Error::Io`].
pub fn list(path: &Path) -> Result<Vec<Listed>, Error> {
    let matrices = Matrix::all(path)?;
    let count = matrices.len();
    let listed = matrices.iter().enumerate().map(|(number, matrix)| Listed {
        name: name(number, count),
        shape: Some((matrix.rows, matrix.columns)),
        obstacle: obstacle_of_shape(matrix.rows, matrix.columns),
    });
    Ok(listed.collect())
}

/// Reads matrices by their place in the list.
///
/// # Errors
/// As [`list`]; [`Error::File`] with the place for matrices that aren't square, places outside, values that aren't finite.
pub fn read(path: &Path, wanted: &[usize]) -> Result<Reading, Error> {
    let (matrices, sha256) = hashed(path, || {
        let found = Matrix::all(path)?;
        let read = wanted.iter().map(|&number| {
            let matrix = found.get(number).ok_or_else(|| Error::File {
                path: path.into(),
                message: format!("has {} matrices, not {}", found.len(), number + 1),
            })?;
            matrix.read(path, name(number, found.len()))
        });
        read.collect()
    })?;
    Ok(Reading { matrices, sha256 })
}

fn name(number: usize, count: usize) -> String {
    match count {
        1 => String::new(),
        _ => (number + 1).to_string(),
    }
}

/// A matrix of a file, before its entries are read.
struct Matrix {
    rows: u64,
    columns: u64,
    /// `None` for a matrix in full.
    entries: Option<u64>,
    integers: Kind,
    /// Where the header ends.
    at: u64,
}

impl Matrix {
    /// All of a file.
    fn all(path: &Path) -> Result<Vec<Self>, Error> {
        let mut file = BinaryFile::open_parts(path)?;
        let mut found = Vec::new();
        while file.remaining() > 0 {
            found.extend(next(&mut file)?);
        }
        Ok(found)
    }

    /// Bytes of the header's integers.
    fn width(&self) -> u64 {
        Number::big(self.integers).size() as u64
    }

    /// Bytes behind the header, with values of some width; `None` beyond 64 bits.
    fn bytes(&self, value: u64) -> Option<u64> {
        let Some(entries) = self.entries else {
            return self.rows.checked_mul(self.columns)?.checked_mul(value);
        };
        let integers = self.rows.checked_add(entries)?.checked_mul(self.width())?;
        integers.checked_add(entries.checked_mul(value)?)
    }

    fn read(&self, path: &Path, name: String) -> Result<StoredMatrix, Error> {
        let mut file = BinaryFile::open_parts(path)?;
        file.pass_over(self.at)?;
        let size = square(self.rows, self.columns).map_err(|message| file.refused(message))?;
        let value = Number::big(Kind::F64);
        let content = match self.entries {
            None => dense(&mut file, value, Along::Rows, size)?,
            Some(entries) => self.compressed(&mut file, size, entries)?,
        };
        Ok(StoredMatrix::unlabelled(name, size as usize, content))
    }

    fn compressed(&self, file: &mut BinaryFile, size: u32, entries: u64) -> Result<Content, Error> {
        let integer = Number::big(self.integers);
        let mut starts = indices(file, integer, u64::from(size))?;
        let mut total = 0_u64;
        for length in &mut starts {
            (*length, total) = (total as u32, total + u64::from(*length));
            if total > entries || total > u64::from(u32::MAX) {
                return Err(file.refused(format!(
                    "its rows have more than {entries} entries together; the file is damaged"
                )));
            }
        }
        if total != entries {
            return Err(file.refused(format!(
                "its rows have {total} entries together, but {entries} are announced; the file is damaged"
            )));
        }
        starts.push(total as u32);
        let columns = indices(file, integer, entries)?;
        let pattern = Pattern::checked(Along::Rows, size, starts, columns);
        let pattern = pattern.map_err(|message| file.refused(message))?;
        pattern.with_values(file, Number::big(Kind::F64))
    }
}

/// The header of the next object, if it is a matrix; the rest of it is passed over.
fn next(file: &mut BinaryFile) -> Result<Option<Matrix>, Error> {
    let mut class = u32::from_be_bytes(file.take()?);
    let integers = match class {
        0 => {
            class = u32::from_be_bytes(file.take()?);
            Kind::I64
        }
        _ => Kind::I32,
    };
    let matrix = match class {
        MATRIX => {
            let rows = size(file, integers, "rows")?;
            let columns = size(file, integers, "columns")?;
            let entries = integer(file, integers)?;
            let entries = match entries {
                -1 => None,
                _ => Some(
                    u64::try_from(entries)
                        .map_err(|_| file.refused(format!("{entries} entries are announced")))?,
                ),
            };
            Matrix {
                rows,
                columns,
                entries,
                integers,
                at: file.position(),
            }
        }
        VECTOR | INDEX_SET => {
            let length = size(file, integers, "numbers")?;
            let each = match class {
                VECTOR => VALUE,
                _ => Number::big(integers).size() as u64,
            };
            let bytes = file.room_for(length, each, "numbers")?;
            file.pass_over(bytes)?;
            return Ok(None);
        }
        other => {
            return Err(file.refused(format!(
                "found {other} where a PETSc object begins with its class id, such as {MATRIX} for a matrix; the file is cut off or damaged, \
                 or holds numbers that aren't real double precision"
            )));
        }
    };
    pass_over(file, &matrix)?;
    Ok(Some(matrix))
}

/// Goes to the end of a matrix; if the file doesn't go on there, says what it may be.
fn pass_over(file: &mut BinaryFile, matrix: &Matrix) -> Result<(), Error> {
    let left = file.remaining();
    let fits = matrix.bytes(VALUE).filter(|&bytes| bytes <= left);
    if let Some(bytes) = fits {
        file.pass_over(bytes)?;
        if file.remaining() == 0 || begins_object(file)? {
            return Ok(());
        }
    }
    let other = OTHER_VALUES
        .iter()
        .find(|(value, _)| matrix.bytes(*value) == Some(left));
    let entries = matrix.entries.map_or("in full".into(), |entries| {
        format!("with {entries} entries")
    });
    let announced = format!(
        "a matrix of {} x {} {entries} in real double precision",
        matrix.rows, matrix.columns
    );
    Err(file.refused(match (other, fits) {
        (Some((value, called)), _) => format!(
            "{announced} doesn't fit the {left} bytes behind its header, but one with values of {value} bytes does ({called}); write it \
             from a PETSc that is configured with real double precision"
        ),
        (None, None) => {
            format!("{announced} doesn't fit the {left} bytes that are left; the file is cut off or damaged")
        }
        (None, Some(_)) => format!(
            "something that isn't a PETSc object comes after {announced}; the file is damaged, or holds numbers that aren't real double \
             precision"
        ),
    }))
}

/// Whether an object begins here; stays here.
fn begins_object(file: &mut BinaryFile) -> Result<bool, Error> {
    let start: [u8; 8] = match file.remaining() {
        0..8 => return Ok(false),
        _ => file.peek()?,
    };
    let is_index_set = |id: &[u8]| id == INDEX_SET.to_be_bytes();
    Ok(recognises(&start)
        || is_index_set(&start[..4])
        || (start.starts_with(&[0; 4]) && is_index_set(&start[4..])))
}

fn integer(file: &mut BinaryFile, kind: Kind) -> Result<i64, Error> {
    Ok(match kind {
        Kind::I64 => i64::from_be_bytes(file.take()?),
        _ => i64::from(i32::from_be_bytes(file.take()?)),
    })
}

fn size(file: &mut BinaryFile, kind: Kind, of: &str) -> Result<u64, Error> {
    let found = integer(file, kind)?;
    u64::try_from(found).map_err(|_| file.refused(format!("{found} {of} are announced")))
}
