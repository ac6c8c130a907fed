//! What travels through files: a matrix's lower triangle with its order, blocks of columns. Numbers are little-endian.

use std::fs::File;
use std::io::{self, BufWriter, Read, Write};

use faer::{MatMut, MatRef};

use crate::multifrontal::Matrix;

/// Writes the lower triangle of `K + σ M` without entries that are zero, and the place of each row in the order of elimination.
///
/// # Errors
/// Of writing.
pub fn write_matrix(file: File, matrix: Matrix<'_>, order: &[u32]) -> io::Result<()> {
    let columns = || 0..matrix.stiffness.ncols();
    let mut out = BufWriter::with_capacity(1 << 20, file);
    let entries: usize = columns().map(|column| lower(matrix, column).count()).sum();
    for size in [order.len() as u64, entries as u64] {
        out.write_all(&size.to_le_bytes())?;
    }
    for column in columns() {
        for (row, _) in lower(matrix, column) {
            out.write_all(&(row + 1).to_le_bytes())?;
        }
    }
    for column in columns() {
        for _ in lower(matrix, column) {
            out.write_all(&(column as u32 + 1).to_le_bytes())?;
        }
    }
    for column in columns() {
        for (_, value) in lower(matrix, column) {
            out.write_all(&value.to_le_bytes())?;
        }
    }
    for place in order {
        out.write_all(&(place + 1).to_le_bytes())?;
    }
    out.flush()
}

/// Rows and values of a column of `K + σ M` from the diagonal down: both matrices have their rows in ascending order.
fn lower(matrix: Matrix<'_>, column: usize) -> impl Iterator<Item = (u32, f64)> {
    let below = |of: &'_ dcb_formats::SparseMatrix| {
        let rows = of.row_idx_of_col_raw(column);
        rows.partition_point(|row| (*row as usize) < column)
    };
    let rest = |of| {
        let from = below(of);
        let rows = of.row_idx_of_col_raw(column)[from..].iter().copied();
        rows.zip(of.val_of_col(column)[from..].iter().copied())
            .peekable()
    };
    let (mut stiffness, mut mass) = (rest(matrix.stiffness), rest(matrix.mass));
    std::iter::from_fn(move || {
        let next = [stiffness.peek(), mass.peek()];
        let row = next.into_iter().flatten().map(|entry| entry.0).min()?;
        let k = stiffness.next_if(|entry| entry.0 == row);
        let m = mass.next_if(|entry| entry.0 == row);
        let value = k.map_or(0.0, |entry| entry.1) + matrix.shift * m.map_or(0.0, |entry| entry.1);
        Some((row, value))
    })
    .filter(move |(row, value)| *value != 0.0 || *row as usize == column)
}

/// Writes columns one after the other.
///
/// # Errors
/// Of writing.
pub fn write_block(file: &mut File, columns: MatRef<'_, f64>) -> io::Result<()> {
    let mut bytes = Vec::with_capacity(8 * columns.nrows());
    for column in columns.col_iter() {
        bytes.clear();
        for value in column.iter() {
            bytes.extend_from_slice(&value.to_le_bytes());
        }
        file.write_all(&bytes)?;
    }
    Ok(())
}

/// Reads columns back.
///
/// # Errors
/// Of reading.
pub fn read_block(file: &mut File, columns: MatMut<'_, f64>) -> io::Result<()> {
    let mut bytes = vec![0; 8 * columns.nrows()];
    for column in columns.col_iter_mut() {
        file.read_exact(&mut bytes)?;
        for (value, bytes) in column.iter_mut().zip(bytes.as_chunks::<8>().0) {
            *value = f64::from_le_bytes(*bytes);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use dcb_formats::SparseMatrix;
    use faer::Mat;
    use faer::sparse::Triplet;

    #[test]
    fn the_lower_triangle_of_the_sum_is_written_with_its_order() {
        let matrix = |entries: &[(u32, u32, f64)]| {
            let entries: Vec<_> = (entries.iter())
                .map(|(row, column, value)| Triplet::new(*row, *column, *value))
                .collect();
            SparseMatrix::try_new_from_triplets(3, 3, &entries).unwrap()
        };
        let stiffness = matrix(&[(0, 0, 2.0), (1, 0, -1.0), (0, 1, -1.0), (1, 1, 3.0)]);
        let mass = matrix(&[(0, 0, 1.0), (1, 0, 2.0), (0, 1, 2.0), (2, 1, 4.0)]);
        let sum = Matrix {
            stiffness: &stiffness,
            mass: &mass,
            shift: 0.5,
        };
        let of = |column| lower(sum, column).collect::<Vec<_>>();
        // (1, 0) cancels.
        assert_eq!(of(0), [(0, 2.5)]);
        assert_eq!(of(1), [(1, 3.0), (2, 2.0)]);
        assert_eq!(of(2), []);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("matrix");
        write_matrix(File::create(&path).unwrap(), sum, &[2, 0, 1]).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!(bytes.len(), 16 + 3 * 16 + 3 * 4);
        let whole = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        assert_eq!((bytes[0], bytes[8]), (3, 3));
        assert_eq!([16, 20, 24].map(whole), [1, 2, 3]);
        assert_eq!([28, 32, 36].map(whole), [1, 2, 2]);
        assert_eq!([64, 68, 72].map(whole), [3, 1, 2]);
    }

    #[test]
    fn columns_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("block");
        let columns = Mat::from_fn(7, 3, |i, j| (i as f64 + 0.1).sin() - j as f64);
        write_block(&mut File::create(&path).unwrap(), columns.as_ref()).unwrap();
        let mut read = Mat::zeros(7, 3);
        read_block(&mut File::open(&path).unwrap(), read.as_mut()).unwrap();
        assert_eq!(read, columns);
        let mut more = Mat::zeros(7, 4);
        assert!(read_block(&mut File::open(&path).unwrap(), more.as_mut()).is_err());
    }
}
