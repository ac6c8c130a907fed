//! Arrays that NumPy saved (`.npz` and `.npy`), and the sparse matrices that SciPy makes of them.
//!
//! `scipy.sparse.save_npz` writes the pieces of one matrix, with no name; the same pieces under names that begin alike (`K_data`,
//! `K_indices`, `K_indptr`) are the matrix `K`. An array with two axes is a matrix, its zeros are no entries. The table `dof_ref` labels
//! the rows. Pickled objects are never read.

mod arrays;
mod found;
mod header;

use std::path::Path;

use dcb_formats::Error;

use self::arrays::Arrays;
use self::found::{Found, Storage, matrices};
use crate::binary::file::BinaryFile;
use crate::binary::hashed::hashed;
use crate::matrix::labels::{DOF_REF, IntegerTable};
use crate::matrix::storage::collected::{Collected, square};
use crate::matrix::storage::compressed::{Along, Pattern};
use crate::matrix::storage::dense::dense;
use crate::matrix::storage::number::Number;
use crate::matrix::storage::stream::{Stream, each_reals, indices, integers};
use crate::stored::{Content, Listed, Reading, StoredMatrix};

/// Whether a file begins as an archive whose first member is an array, or as an array.
pub fn recognises(start: &[u8]) -> bool {
    is_archive(start) || start.starts_with(b"\x93NUMPY")
}

fn is_archive(start: &[u8]) -> bool {
    let Some([low, high]) = start.get(26..28) else {
        return false;
    };
    let length = usize::from(u16::from_le_bytes([*low, *high]));
    let name = start.get(30..30 + length);
    start.starts_with(b"PK\x03\x04") && name.is_some_and(|name| name.ends_with(b".npy"))
}

/// The matrices of a file.
///
/// # Errors
/// [`Error::Location`] with the array, [`Error::File`]: pickled arrays, damaged archives, pieces that don't go together; [`Error::Io`].
pub fn list(path: &Path) -> Result<Vec<Listed>, Error> {
    let listed = matrices(&open(path)?)?.into_iter().map(|found| Listed {
        name: found.name,
        shape: Some(found.shape),
        obstacle: found.obstacle,
    });
    Ok(listed.collect())
}

fn open(path: &Path) -> Result<Arrays, Error> {
    let mut file = BinaryFile::open_parts(path)?;
    let mut start = vec![0; file.remaining().min(1 << 12) as usize];
    file.fill(&mut start)?;
    Arrays::of(path, start.starts_with(b"PK"))
}

/// Reads matrices by their place in the list; a table `dof_ref` labels their rows.
///
/// # Errors
/// As [`list`]; [`Error::Location`] with the array for places outside, values that aren't finite, labels that can't be.
pub fn read(path: &Path, wanted: &[usize]) -> Result<Reading, Error> {
    let (matrices, sha256) = hashed(path, || {
        let arrays = open(path)?;
        let found = matrices(&arrays)?;
        let matrix = |number: &usize| match found.get(*number) {
            Some(found) => matrix(&arrays, found),
            None => Err(arrays.refused("", format!("{} isn't there", number + 1))),
        };
        let mut read = wanted.iter().map(matrix).collect::<Result<Vec<_>, _>>()?;
        let labels = match arrays.is_archive() {
            true => table_of(&arrays, DOF_REF)?,
            false => None,
        };
        if let Some(labels) = labels {
            let labelled = labels.label_rows(&mut read);
            labelled.map_err(|message| arrays.refused(DOF_REF, message))?;
        }
        Ok(read)
    })?;
    Ok(Reading { matrices, sha256 })
}

/// Reads an array of integers with one or two columns, by name without regard to case; of a file with one array, that one.
pub(crate) fn table(path: &Path, name: &str) -> Result<Option<IntegerTable>, Error> {
    table_of(&open(path)?, name)
}

fn table_of(arrays: &Arrays, name: &str) -> Result<Option<IntegerTable>, Error> {
    let is_meant = |found: &str| found.is_empty() || found.eq_ignore_ascii_case(name);
    let Some(array) = arrays.list.iter().position(|array| is_meant(&array.name)) else {
        return Ok(None);
    };
    let found = &arrays.list[array];
    let header = &found.header;
    let columns = match header.shape[..] {
        [_] => 1,
        [_, columns] => columns,
        _ => {
            return Err(arrays.refused(
                &found.name,
                format!("of shape {:?} is no table of dofs", header.shape),
            ));
        }
    };
    let (Some(number), Some(count)) = (header.number(), header.count()) else {
        return Err(arrays.refused(&found.name, "has no integers; a table of dofs has"));
    };
    // The others are no tables, and may be large.
    if !matches!(columns, 1 | 2) {
        let message = format!("{columns} columns; a table of dofs has one or two");
        return Err(arrays.refused(&found.name, message));
    }
    let values = arrays.with_data(array, |stream| integers(stream, number, count))?;
    let table = IntegerTable::of(columns, values, header.is_fortran);
    table
        .map(Some)
        .map_err(|message| arrays.refused(&found.name, message))
}

fn matrix(arrays: &Arrays, found: &Found) -> Result<StoredMatrix, Error> {
    let data = found.storage.data();
    let refused = |message: String| arrays.refused(&arrays.list[data].name, message);
    let number = match (&found.obstacle, arrays.list[data].header.number()) {
        (None, Some(number)) => number,
        (obstacle, _) => {
            let found = obstacle.as_deref().unwrap_or("not numeric");
            return Err(refused(format!(
                "is {found}; stiffness and mass are real and square"
            )));
        }
    };
    let size = square(found.shape.0, found.shape.1).map_err(refused)?;
    let content = match found.storage {
        Storage::Dense { data } => {
            let along = match arrays.list[data].header.is_fortran {
                true => Along::Columns,
                false => Along::Rows,
            };
            arrays.with_data(data, |stream| dense(stream, number, along, size))?
        }
        Storage::Compressed {
            along,
            starts,
            across,
            data,
        } => {
            let pattern = pattern(arrays, along, size, starts, across)?;
            let count = linear(arrays, data)?.1;
            if count < pattern.len() {
                return Err(too_few(arrays, data, count, pattern.len()));
            }
            arrays.with_data(data, |stream| pattern.with_values(stream, number))?
        }
        Storage::Blocks {
            starts,
            across,
            data,
            size: block,
        } => blocks(arrays, size, [starts, across, data], block)?,
        Storage::Places {
            rows,
            columns,
            data,
        } => places(arrays, size, [rows, columns, data])?,
        Storage::Diagonals { offsets, data } => diagonals(arrays, size, offsets, data)?,
    };
    Ok(StoredMatrix {
        digits: number.digits(),
        ..StoredMatrix::unlabelled(found.name.clone(), size as usize, content)
    })
}

/// Type and number of the elements of an array with one axis.
fn linear(arrays: &Arrays, array: usize) -> Result<(Number, u64), Error> {
    let found = &arrays.list[array];
    match (found.header.number(), &found.header.shape[..]) {
        (Some(number), [count]) => Ok((number, *count)),
        _ => Err(arrays.refused(
            &found.name,
            format!(
                "of shape {:?}; expected numbers in one row",
                found.header.shape
            ),
        )),
    }
}

fn too_few(arrays: &Arrays, data: usize, count: u64, needed: u64) -> Error {
    let message = format!("has {count} numbers, but there are {needed} places");
    arrays.refused(&arrays.list[data].name, message)
}

fn pattern(
    arrays: &Arrays,
    along: Along,
    lines: u32,
    starts: usize,
    across: usize,
) -> Result<Pattern, Error> {
    let list = |array: usize| {
        let (number, count) = linear(arrays, array)?;
        arrays.with_data(array, |stream| indices(stream, number, count))
    };
    let checked = Pattern::checked(along, lines, list(starts)?, list(across)?);
    checked.map_err(|message| arrays.refused(&arrays.list[across].name, message))
}

/// A matrix of blocks, each row after row. Zeros only fill blocks up and are no entries.
fn blocks(
    arrays: &Arrays,
    size: u32,
    [starts, across, data]: [usize; 3],
    block: u32,
) -> Result<Content, Error> {
    let header = &arrays.list[data].header;
    if header.is_fortran || !size.is_multiple_of(block) {
        let message = format!(
            "of shape {:?} doesn't go with {size} rows, or isn't in C order",
            header.shape
        );
        return Err(arrays.refused(&arrays.list[data].name, message));
    }
    let pattern = pattern(arrays, Along::Rows, size / block, starts, across)?;
    let (Some(number), [count, ..]) = (header.number(), &header.shape[..]) else {
        return Err(arrays.refused(&arrays.list[data].name, "has no numbers"));
    };
    if *count < pattern.len() {
        return Err(too_few(arrays, data, *count, pattern.len()));
    }
    let mut collected = Collected::default();
    let mut place = pattern.places();
    let (mut at, mut row, mut column) = ((0, 0), 0, 0);
    arrays.with_data(data, |stream| {
        let each = u64::from(block) * u64::from(block);
        each_reals(stream, number, pattern.len() * each, |_, batch| {
            for &value in batch {
                if (row, column) == (0, 0) {
                    at = place.next().unwrap_or_default();
                }
                if value != 0.0 {
                    collected.add(at.0 * block + row, at.1 * block + column, value)?;
                }
                column += 1;
                if column == block {
                    (row, column) = ((row + 1) % block, 0);
                }
            }
            Ok(())
        })
    })?;
    Ok(collected.content())
}

/// Entries with a row, a column and a value each, in three arrays that are read side by side.
fn places(arrays: &Arrays, size: u32, [rows, columns, data]: [usize; 3]) -> Result<Content, Error> {
    let [row, column, value] = [rows, columns, data].map(|array| linear(arrays, array));
    let ((row, row_count), (column, column_count), (value, count)) = (row?, column?, value?);
    if row_count != count || column_count != count {
        let message = format!(
            "has {count} numbers, but there are {row_count} rows and {column_count} columns"
        );
        return Err(arrays.refused(&arrays.list[data].name, message));
    }
    let mut collected = Collected::default();
    arrays.with_data(rows, |rows| {
        arrays.with_data(columns, |columns| {
            arrays.with_data(data, |data| {
                let (mut row_batch, mut column_batch) = (Vec::new(), Vec::new());
                each_reals(data, value, count, |first, batch| {
                    next_indices(rows, row, batch.len(), &mut row_batch)?;
                    next_indices(columns, column, batch.len(), &mut column_batch)?;
                    let places = row_batch.iter().zip(&column_batch);
                    for ((entry, &value), (&row, &column)) in (first..).zip(batch).zip(places) {
                        if row >= size || column >= size {
                            return Err(format!(
                                "entry {} is at the 0-based row {row}, column {column}; the matrix has {size} of them",
                                entry + 1
                            ));
                        }
                        collected.add(row, column, value)?;
                    }
                    Ok(())
                })
            })
        })
    })?;
    Ok(collected.content())
}

/// So many indices that come next, in place of those before.
fn next_indices(
    stream: &mut dyn Stream,
    number: Number,
    count: usize,
    into: &mut Vec<u32>,
) -> Result<(), String> {
    let mut bytes = vec![0; count * number.size()];
    stream.fill(&mut bytes).map_err(|error| error.to_string())?;
    into.clear();
    number.indices(&bytes, into);
    Ok(())
}

/// Diagonals, each as long as the widest matrix that they are for: entry (j - offset, j). Zeros and what is outside are no entries.
fn diagonals(arrays: &Arrays, size: u32, offsets: usize, data: usize) -> Result<Content, Error> {
    let (number, count) = linear(arrays, offsets)?;
    let header = &arrays.list[data].header;
    let (Some(value), &[lines, length]) = (header.number(), &header.shape[..]) else {
        let message = format!(
            "of shape {:?}; expected a row for each diagonal",
            header.shape
        );
        return Err(arrays.refused(&arrays.list[data].name, message));
    };
    let offsets_of = arrays.with_data(offsets, |stream| integers(stream, number, count))?;
    let mut sorted = offsets_of.clone();
    sorted.sort_unstable();
    if lines != count || sorted.windows(2).any(|pair| pair[0] == pair[1]) {
        let message = format!(
            "has {count} diagonals, some of them twice, or not as many as the {lines} rows of numbers"
        );
        return Err(arrays.refused(&arrays.list[offsets].name, message));
    }
    let mut collected = Collected::default();
    arrays.with_data(data, |stream| {
        let (mut line, mut column) = (0_u64, 0_u64);
        each_reals(stream, value, lines * length, |_, batch| {
            for &value in batch {
                let row = i128::from(column) - i128::from(offsets_of[line as usize]);
                let inside = (0..i128::from(size)).contains(&row) && column < u64::from(size);
                if value != 0.0 && inside {
                    collected.add(row as u32, column as u32, value)?;
                }
                match header.is_fortran {
                    true => {
                        line += 1;
                        (line, column) = (line % lines, column + line / lines);
                    }
                    false => {
                        column += 1;
                        (line, column) = (line + column / length, column % length);
                    }
                }
            }
            Ok(())
        })
    })?;
    Ok(collected.content())
}
