//! PETSc's binary files: sparse matrices are written, vectors written and read. Big-endian, 32-bit integers, doubles.
//!
//! ```text
//! Mat   1211216, rows, columns, entries, then entries of each row, column indices, values
//! Vec   1211214, length, values
//! ```
//! Several objects in one file follow each other without a gap.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Error, ErrorKind, Read, Write};
use std::path::Path;

use dcb_formats::SparseMatrix;
use faer::{Mat, MatRef};

const MATRIX_ID: i32 = 1_211_216;
const VECTOR_ID: i32 = 1_211_214;
/// Bytes before the values of a vector.
const VECTOR_HEADER: u64 = 8;
/// Values read at a time.
const CHUNK: usize = 8192;

fn count(value: usize) -> io::Result<i32> {
    let too_many = || {
        let message = format!("{value} entries are more than PETSc's 32-bit files can count");
        Error::new(ErrorKind::InvalidInput, message)
    };
    i32::try_from(value).map_err(|_| too_many())
}

/// Writes a symmetric matrix in full storage (its columns are the rows that the format wants).
///
/// # Errors
/// Of writing, and [`ErrorKind::InvalidInput`] for more than 2³¹ entries.
pub fn write_symmetric(out: &mut impl Write, matrix: &SparseMatrix) -> io::Result<()> {
    let columns = || (0..matrix.ncols()).map(|column| matrix.row_idx_of_col_raw(column));
    let entries = columns().map(<[u32]>::len).sum();
    for number in [
        MATRIX_ID,
        count(matrix.nrows())?,
        count(matrix.ncols())?,
        count(entries)?,
    ] {
        out.write_all(&number.to_be_bytes())?;
    }
    for rows in columns() {
        out.write_all(&count(rows.len())?.to_be_bytes())?;
    }
    for row in columns().flatten() {
        out.write_all(&row.to_be_bytes())?;
    }
    for column in 0..matrix.ncols() {
        for value in matrix.val_of_col(column) {
            out.write_all(&value.to_be_bytes())?;
        }
    }
    Ok(())
}

/// Writes each column as a vector.
///
/// # Errors
/// As [`write_symmetric`].
pub fn write_vectors(out: &mut impl Write, columns: MatRef<'_, f64>) -> io::Result<()> {
    for column in columns.col_iter() {
        out.write_all(&VECTOR_ID.to_be_bytes())?;
        out.write_all(&count(columns.nrows())?.to_be_bytes())?;
        for value in column.iter() {
            out.write_all(&value.to_be_bytes())?;
        }
    }
    Ok(())
}

/// Writes a new file through a buffer.
///
/// # Errors
/// Of creating it and of `write`.
pub fn create(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> io::Result<()> {
    let mut out = BufWriter::new(File::create_new(path)?);
    write(&mut out)?;
    out.flush()
}

/// Reads a file of exactly `columns` vectors of `rows` values, (rows, columns). Nothing is allocated before the file's
/// length is known to fit.
///
/// # Errors
/// Of reading, and [`ErrorKind::InvalidData`] for anything else in the file.
pub fn read_vectors(path: &Path, rows: usize, columns: usize) -> io::Result<Mat<f64>> {
    let (mut input, bytes) = open(path)?;
    let expected = (rows as u64)
        .checked_mul(8)
        .and_then(|values| values.checked_add(VECTOR_HEADER))
        .and_then(|each| each.checked_mul(columns as u64));
    if expected != Some(bytes) {
        return Err(invalid(format!(
            "{bytes} bytes are not {columns} vectors of {rows} values"
        )));
    }
    let mut read = Mat::zeros(rows, columns);
    for column in 0..columns {
        read_header(&mut input, rows)?;
        let mut row = 0;
        read_values(&mut input, rows, |value| {
            read[(row, column)] = value;
            row += 1;
        })?;
    }
    Ok(read)
}

/// Reads a file of two short vectors: the first of any length up to `limit`, the second of one number.
///
/// # Errors
/// As [`read_vectors`].
pub fn read_list_and_number(path: &Path, limit: usize) -> io::Result<(Vec<f64>, f64)> {
    let (mut input, bytes) = open(path)?;
    let length = bytes.checked_sub(2 * VECTOR_HEADER + 8).map(|b| b / 8);
    let Some(length) = length.filter(|length| *length <= limit as u64) else {
        return Err(invalid(format!(
            "{bytes} bytes are not a list of up to {limit} numbers"
        )));
    };
    let (mut list, mut number) = (Vec::with_capacity(length as usize), 0.0);
    read_header(&mut input, length as usize)?;
    read_values(&mut input, length as usize, |value| list.push(value))?;
    read_header(&mut input, 1)?;
    read_values(&mut input, 1, |value| number = value)?;
    Ok((list, number))
}

fn invalid(message: String) -> Error {
    Error::new(ErrorKind::InvalidData, message)
}

fn open(path: &Path) -> io::Result<(BufReader<File>, u64)> {
    let file = File::open(path)?;
    let bytes = file.metadata()?.len();
    Ok((BufReader::new(file), bytes))
}

fn read_header(input: &mut impl Read, length: usize) -> io::Result<()> {
    let mut number = [0; 4];
    for expected in [VECTOR_ID, count(length)?] {
        input.read_exact(&mut number)?;
        let found = i32::from_be_bytes(number);
        if found != expected {
            return Err(invalid(format!(
                "{found} where {expected} begins a vector of {length} values"
            )));
        }
    }
    Ok(())
}

fn read_values(input: &mut impl Read, length: usize, mut take: impl FnMut(f64)) -> io::Result<()> {
    let mut bytes = vec![0; 8 * CHUNK.min(length)];
    let mut left = length;
    while left > 0 {
        let some = &mut bytes[..8 * CHUNK.min(left)];
        input.read_exact(some)?;
        for value in some.as_chunks::<8>().0 {
            let value = f64::from_be_bytes(*value);
            if !value.is_finite() {
                return Err(invalid(format!("a value is {value}")));
            }
            take(value);
        }
        left -= some.len() / 8;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use faer::sparse::Triplet;

    fn hexadecimal(bytes: &[u8]) -> String {
        bytes.iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// Both literals are what petsc4py 3.18 wrote: `createAIJ` of [[2, -1, 0], [-1, 2.5, 0], [0, 0, 1]] and two `createSeq(2)`.
    #[test]
    fn files_are_those_that_petsc_writes() {
        let entries = [
            (0, 0, 2.0),
            (1, 0, -1.0),
            (0, 1, -1.0),
            (1, 1, 2.5),
            (2, 2, 1.0),
        ];
        let triplets = entries.map(|(row, column, value)| Triplet::new(row, column, value));
        let matrix = SparseMatrix::try_new_from_triplets(3, 3, &triplets).unwrap();
        let mut written = Vec::new();
        write_symmetric(&mut written, &matrix).unwrap();
        assert_eq!(hexadecimal(&written), PETSC_MATRIX);
        let columns = Mat::from_fn(2, 2, |i, j| [[1.0, -0.5], [0.1, 1e300]][j][i]);
        let mut written = Vec::new();
        write_vectors(&mut written, columns.as_ref()).unwrap();
        assert_eq!(hexadecimal(&written), PETSC_VECTORS);
    }

    const PETSC_MATRIX: &str = "00127b500000000300000003000000050000000200000002000000010000000000000001000000000000000100000002\
        4000000000000000bff0000000000000bff000000000000040040000000000003ff0000000000000";
    const PETSC_VECTORS: &str = "00127b4e000000023ff0000000000000bfe000000000000000127b4e000000023fb999999999999a7e37e43c8800759c";

    #[test]
    fn vectors_come_back_and_nothing_else_is_accepted() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("vectors");
        // Longer than a chunk.
        let columns = Mat::from_fn(CHUNK + 3, 2, |i, j| (i as f64 + 0.1).sin() - j as f64);
        create(&path, |out| write_vectors(out, columns.as_ref())).unwrap();
        assert_eq!(read_vectors(&path, CHUNK + 3, 2).unwrap(), columns);
        for (rows, count) in [(CHUNK + 3, 1), (CHUNK + 2, 2), (usize::MAX, 2), (0, 0)] {
            let refused = read_vectors(&path, rows, count).unwrap_err();
            assert_eq!(refused.kind(), ErrorKind::InvalidData, "{refused}");
        }
        // The right length, but another object, another count, or no number.
        let good = std::fs::read(&path).unwrap();
        for (place, byte) in [(3, 0x50), (7, 0), (8, 0x7f)] {
            let mut bad = good.clone();
            bad[place] = byte;
            bad[place + 1] |= if place == 8 { 0xf0 } else { 0 };
            std::fs::write(&path, &bad).unwrap();
            let refused = read_vectors(&path, CHUNK + 3, 2).unwrap_err();
            assert_eq!(refused.kind(), ErrorKind::InvalidData, "{refused}");
        }
    }

    #[test]
    fn a_list_is_as_long_as_its_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("list");
        let write = |list: &[f64]| {
            let mut bytes = Vec::new();
            let list = Mat::from_fn(list.len(), 1, |i, _| list[i]);
            write_vectors(&mut bytes, list.as_ref()).unwrap();
            write_vectors(&mut bytes, Mat::from_fn(1, 1, |_, _| 7.0).as_ref()).unwrap();
            std::fs::write(&path, bytes).unwrap();
        };
        write(&[3.0, 2.0]);
        assert_eq!(
            read_list_and_number(&path, 2).unwrap(),
            (vec![3.0, 2.0], 7.0)
        );
        assert!(read_list_and_number(&path, 1).is_err());
        write(&[]);
        assert_eq!(read_list_and_number(&path, 2).unwrap(), (Vec::new(), 7.0));
        std::fs::write(&path, [0; 5]).unwrap();
        assert!(read_list_and_number(&path, 2).is_err());
    }
}
