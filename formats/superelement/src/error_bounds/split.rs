//! Complex matrices as two real ones.
//!
//! What is complex here are weights of λ: most factors are real, so that a product is two real products and a sum goes along whole columns.

use faer::{Mat, c64};

/// A complex matrix by its parts.
pub(super) struct Split {
    pub re: Mat<f64>,
    pub im: Mat<f64>,
}

impl Split {
    /// Σ weight · matrix, all (rows, columns).
    pub(super) fn sum(rows: usize, columns: usize, terms: &[(c64, &Mat<f64>)]) -> Self {
        let mut sum = Self {
            re: Mat::zeros(rows, columns),
            im: Mat::zeros(rows, columns),
        };
        vectorized(
            #[inline(always)]
            || {
                for j in 0..columns {
                    let (re, im) = sum.column_mut(j);
                    for (weight, matrix) in terms {
                        let parts = re.iter_mut().zip(im.iter_mut());
                        for ((re, im), value) in parts.zip(matrix.col_as_slice(j)) {
                            *re += weight.re * value;
                            *im += weight.im * value;
                        }
                    }
                }
            },
        );
        sum
    }

    /// left · right
    pub(super) fn after(left: &Mat<f64>, right: &Self) -> Self {
        Self {
            re: left * &right.re,
            im: left * &right.im,
        }
    }

    /// leftᵀ · right
    pub(super) fn after_transposed(left: &Mat<f64>, right: &Self) -> Self {
        Self {
            re: left.transpose() * &right.re,
            im: left.transpose() * &right.im,
        }
    }

    /// left · right
    pub(super) fn before(left: &Self, right: &Mat<f64>) -> Self {
        Self {
            re: &left.re * right,
            im: &left.im * right,
        }
    }

    /// diag(weights) · matrix
    pub(super) fn weighted_rows(weights: &[c64], matrix: &Mat<f64>) -> Self {
        let of = |part: fn(&c64) -> f64| {
            let parts: Vec<f64> = weights.iter().map(part).collect();
            let mut weighted = matrix.clone();
            for j in 0..weighted.ncols() {
                let entries = weighted.col_as_slice_mut(j).iter_mut();
                entries.zip(&parts).for_each(|(value, part)| *value *= part);
            }
            weighted
        };
        Self {
            re: of(|weight| weight.re),
            im: of(|weight| weight.im),
        }
    }

    /// diag(weights) · self
    pub(super) fn scale_rows(&mut self, weights: impl Iterator<Item = c64> + Clone) {
        for j in 0..self.re.ncols() {
            let (re, im) = self.column_mut(j);
            for ((re, im), weight) in re.iter_mut().zip(im).zip(weights.clone()) {
                scale(re, im, weight);
            }
        }
    }

    /// self · diag(weights)
    pub(super) fn scale_columns(&mut self, weights: impl Iterator<Item = c64>) {
        vectorized(
            #[inline(always)]
            || {
                for (j, weight) in weights.enumerate() {
                    let (re, im) = self.column_mut(j);
                    for (re, im) in re.iter_mut().zip(im) {
                        scale(re, im, weight);
                    }
                }
            },
        );
    }

    /// self += factor · other
    pub(super) fn add(&mut self, factor: f64, other: &Self) {
        for (own, other) in [(&mut self.re, &other.re), (&mut self.im, &other.im)] {
            for j in 0..own.ncols() {
                let pairs = own.col_as_slice_mut(j).iter_mut();
                for (own, other) in pairs.zip(other.col_as_slice(j)) {
                    *own += factor * other;
                }
            }
        }
    }

    /// Some columns.
    pub(super) fn columns(&self, places: &[usize]) -> Self {
        let of = |part: &Mat<f64>| {
            let mut columns = Mat::zeros(part.nrows(), places.len());
            for (j, place) in places.iter().enumerate() {
                let column = columns.col_as_slice_mut(j);
                column.copy_from_slice(part.col_as_slice(*place));
            }
            columns
        };
        Self {
            re: of(&self.re),
            im: of(&self.im),
        }
    }

    pub(super) fn at(&self, i: usize, j: usize) -> c64 {
        c64::new(self.re[(i, j)], self.im[(i, j)])
    }

    /// Both parts of a column.
    pub(super) fn column(&self, j: usize) -> (&[f64], &[f64]) {
        (self.re.col_as_slice(j), self.im.col_as_slice(j))
    }

    #[inline(always)]
    fn column_mut(&mut self, j: usize) -> (&mut [f64], &mut [f64]) {
        (self.re.col_as_slice_mut(j), self.im.col_as_slice_mut(j))
    }
}

/// With the widest vector instructions of the machine that runs this.
pub(super) fn vectorized(run: impl FnOnce()) {
    pulp::Arch::new().dispatch(run);
}

#[inline(always)]
fn scale(re: &mut f64, im: &mut f64, weight: c64) {
    (*re, *im) = (
        *re * weight.re - *im * weight.im,
        *re * weight.im + *im * weight.re,
    );
}
