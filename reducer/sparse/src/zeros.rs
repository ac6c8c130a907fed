//! Large blocks of zeros and copies of blocks, written by all threads: at the first touch of a page the system has to find and clear it,
//! and on a virtual machine its host as well, which takes much longer than writing it.

use std::mem::MaybeUninit;

use faer::{Mat, MatRef};
use rayon::prelude::*;

/// Entries written by one task.
const CHUNK: usize = 1 << 17;

/// Zeros appended until there are `length` values.
pub(crate) fn extend<T: Copy + Default + Send>(values: &mut Vec<T>, length: usize) {
    let more = length.saturating_sub(values.len());
    values.reserve(more);
    write(&mut values.spare_capacity_mut()[..more]);
    let length = values.len() + more;
    // SAFETY: there is room for them, and those that are new have just been written.
    unsafe { values.set_len(length) };
}

/// Zeros in place of all values.
pub(crate) fn fill(values: &mut [f64]) {
    match values.len() > CHUNK {
        true => values
            .par_chunks_mut(CHUNK)
            .for_each(|chunk| chunk.fill(0.0)),
        false => values.fill(0.0),
    }
}

/// A matrix of zeros.
pub(crate) fn matrix(rows: usize, columns: usize) -> Mat<f64> {
    if rows * columns <= CHUNK {
        return Mat::zeros(rows, columns);
    }
    written(rows, columns, |room, _| write(room))
}

/// A matrix like another one.
pub(crate) fn copy_of(from: MatRef<'_, f64>) -> Mat<f64> {
    if from.nrows() * from.ncols() <= CHUNK {
        return from.to_owned();
    }
    written(from.nrows(), from.ncols(), |room, stride| {
        room.par_chunks_mut(stride)
            .zip(from.par_col_iter())
            .for_each(|(room, column)| {
                let (column_room, between) = room.split_at_mut(column.nrows());
                for (to, value) in column_room.iter_mut().zip(column.iter()) {
                    to.write(*value);
                }
                for to in between {
                    to.write(0.0);
                }
            });
    })
}

/// A matrix whose memory, columns that start a stride apart, is written whole by `write`.
fn written(
    rows: usize,
    columns: usize,
    write: impl FnOnce(&mut [MaybeUninit<f64>], usize),
) -> Mat<f64> {
    let mut matrix: Mat<f64> = Mat::with_capacity(rows, columns);
    let stride = matrix.col_stride().unsigned_abs();
    let start = matrix.as_ptr_mut().cast::<MaybeUninit<f64>>();
    // SAFETY: columns of a matrix stand a stride apart, and there is room for so many; nobody else knows the memory yet.
    let room = unsafe { std::slice::from_raw_parts_mut(start, stride * columns) };
    write(room, stride);
    // SAFETY: there is room for these dimensions, and all entries have been written.
    unsafe { matrix.set_dims(rows, columns) };
    matrix
}

fn write<T: Copy + Default + Send>(room: &mut [MaybeUninit<T>]) {
    room.par_chunks_mut(CHUNK).for_each(|chunk| {
        for value in chunk {
            value.write(T::default());
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_of_any_size_are_zero_or_copies() {
        for (rows, columns) in [(0, 3), (3, 0), (1, 1), (7, 5), (50_001, 7)] {
            let made = matrix(rows, columns);
            assert_eq!((made.nrows(), made.ncols()), (rows, columns));
            assert_eq!(made.norm_max(), 0.0);
            let some = Mat::from_fn(rows, columns, |i, j| (3 * i + 7 * j) as f64);
            assert_eq!(copy_of(some.as_ref()), some);
        }
        let mut values = vec![1.0, 2.0];
        extend(&mut values, 300_000);
        assert_eq!((values.len(), values[1]), (300_000, 2.0));
        assert!(values[2..].iter().all(|value| *value == 0.0));
        extend(&mut values, 10);
        assert_eq!(values.len(), 300_000);
    }
}
