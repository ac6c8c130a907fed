//! Room for the columns of a Krylov basis, touched only as far as it is used.

use faer::{MatMut, MatRef};

use crate::Error;
use crate::block_algebra::copy;
use crate::zeros;

/// Doubles of a cache line: every column starts on one.
const LINE: usize = 8;

/// Columns of length n, of which the first ones are in use.
pub struct KrylovBasis {
    /// Column after column, as far as they are in use.
    values: Vec<f64>,
    /// Where the first column starts.
    start: usize,
    rows: usize,
    stride: usize,
    capacity: usize,
}

impl KrylovBasis {
    /// Room for `capacity` columns of `rows` rows.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn with_capacity(rows: usize, capacity: usize) -> Result<Self, Error> {
        let stride = rows.next_multiple_of(LINE);
        let length = stride.saturating_mul(capacity).saturating_add(LINE);
        let mut values: Vec<f64> = Vec::new();
        values
            .try_reserve_exact(length)
            .map_err(|_| Error::OutOfMemory {
                what: "the modes (ask for fewer)",
            })?;
        let start = values.as_ptr().align_offset(LINE * size_of::<f64>());
        let start = if start < LINE { start } else { 0 };
        values.resize(start, 0.0);
        Ok(Self {
            values,
            start,
            rows,
            stride,
            capacity,
        })
    }

    /// Columns that there is room for.
    pub fn capacity(&self) -> usize {
        self.capacity
    }

    /// Some columns, set before.
    pub fn columns(&self, first: usize, count: usize) -> MatRef<'_, f64> {
        let values = &self.values[self.start + first * self.stride..];
        MatRef::from_column_major_slice_with_stride(values, self.rows, count, self.stride)
    }

    /// Replaces columns from `first` on.
    pub fn set(&mut self, first: usize, columns: MatRef<'_, f64>) {
        assert!(first + columns.ncols() <= self.capacity);
        let used = self.start + (first + columns.ncols()) * self.stride;
        zeros::extend(&mut self.values, used);
        let values = &mut self.values[self.start + first * self.stride..];
        let (rows, stride) = (self.rows, self.stride);
        copy(
            columns,
            MatMut::from_column_major_slice_with_stride_mut(values, rows, columns.ncols(), stride),
        );
    }

    /// Moves `count` columns from `from` to `to`.
    pub fn shift(&mut self, from: usize, to: usize, count: usize) {
        let from = self.start + from * self.stride;
        let to = self.start + to * self.stride;
        self.values
            .copy_within(from..from + count * self.stride, to);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use faer::Mat;

    #[test]
    fn columns_stay_where_they_are_put() {
        let mut basis = KrylovBasis::with_capacity(13, 6).unwrap();
        let columns = Mat::from_fn(13, 3, |i, j| (100 * j + i) as f64);
        basis.set(0, Mat::zeros(13, 2).as_ref());
        basis.set(2, columns.as_ref());
        assert_eq!(basis.columns(2, 3), columns.as_ref());
        assert_eq!(basis.columns(0, 2).norm_max(), 0.0);
        basis.shift(3, 1, 2);
        assert_eq!(basis.columns(1, 2), columns.as_ref().subcols(1, 2));
        assert_eq!(basis.columns(0, 1).col(0).as_ptr() as usize % 64, 0);
        assert!(KrylovBasis::with_capacity(usize::MAX / 8, 100).is_err());
    }
}
