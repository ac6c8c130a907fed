//! OUTPUT4 files of Nastran: binary, little-endian, 32-bit integers, dense columns of doubles. No digit is lost.
//!
//! Records as Fortran writes them, with their length in bytes before and after: a header (columns, rows, form, type, name of eight letters), one record a column
//! (number, first row, words, numbers), and one with a column beyond the last.

use faer::Mat;

/// Form of a symmetric matrix; both triangles are stored.
const SYMMETRIC: i32 = 6;
/// Doubles.
const DOUBLE: i32 = 2;

/// Matrices one after another.
pub(crate) fn file(matrices: &[(&str, &Mat<f64>)]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (name, of) in matrices {
        let (rows, columns) = (integer(of.nrows()), integer(of.ncols()));
        let mut header = words(&[columns, rows, SYMMETRIC, DOUBLE]);
        header.extend(format!("{name:<8}").bytes().take(8));
        record(&mut bytes, &header);
        for j in 0..of.ncols() {
            let mut column = words(&[integer(j + 1), 1, 2 * rows]);
            column.extend((0..of.nrows()).flat_map(|i| of[(i, j)].to_le_bytes()));
            record(&mut bytes, &column);
        }
        let mut last = words(&[columns + 1, 1, 2]);
        last.extend(1_f64.to_le_bytes());
        record(&mut bytes, &last);
    }
    bytes
}

fn words(of: &[i32]) -> Vec<u8> {
    of.iter().flat_map(|word| word.to_le_bytes()).collect()
}

fn record(bytes: &mut Vec<u8>, data: &[u8]) {
    let length = integer(data.len()).to_le_bytes();
    bytes.extend(length);
    bytes.extend(data);
    bytes.extend(length);
}

/// Sizes of reduced matrices are far below 2³¹.
fn integer(of: usize) -> i32 {
    i32::try_from(of).unwrap_or(i32::MAX)
}
