//! Products of many attachment columns with K and M, of which only inner products are kept: a block of columns is
//! multiplied at a time, so that no second array is as large as the columns.

use dcb_formats::SparseMatrix;
use faer::{Mat, MatRef};

use crate::block_algebra::{gram, symmetric_product};

/// Columns multiplied together.
pub const BLOCK: usize = 16;

/// Xᵀ K X and Φᵀ K X.
#[derive(Clone, Debug)]
pub struct StiffnessProducts {
    /// Xᵀ K X, (n_b, n_b), symmetric.
    pub columns: Mat<f64>,
    /// Φᵀ K X, (n_k, n_b).
    pub modes: Mat<f64>,
}

impl StiffnessProducts {
    /// Room for the products of `column_count` columns.
    pub fn empty(mode_count: usize, column_count: usize) -> Self {
        Self {
            columns: Mat::zeros(column_count, column_count),
            modes: Mat::zeros(mode_count, column_count),
        }
    }

    /// Of given columns X, (n, n_b), and modes Φ, (n, n_k).
    pub fn of(stiffness: &SparseMatrix, modes: MatRef<'_, f64>, columns: MatRef<'_, f64>) -> Self {
        let mut products = Self::empty(modes.ncols(), columns.ncols());
        for first in (0..columns.ncols()).step_by(BLOCK) {
            let count = BLOCK.min(columns.ncols() - first);
            let product = symmetric_product(stiffness, columns.subcols(first, count));
            let known = columns.subcols(0, first + count);
            products.enter(modes, known, first..first + count, product.as_ref());
        }
        products
    }

    /// Enters K times some of the columns `known` so far, new ones or ones that have changed; in ascending order.
    pub fn enter(
        &mut self,
        modes: MatRef<'_, f64>,
        known: MatRef<'_, f64>,
        entered: impl IntoIterator<Item = usize>,
        product: MatRef<'_, f64>,
    ) {
        let with_columns = gram(known, product);
        let with_modes = gram(modes, product);
        for (j, column) in entered.into_iter().enumerate() {
            for i in 0..known.ncols() {
                self.columns[(i, column)] = with_columns[(i, j)];
                self.columns[(column, i)] = with_columns[(i, j)];
            }
            self.modes.col_mut(column).copy_from(with_modes.col(j));
        }
    }
}

/// Xᵀ M X, (n_b, n_b), of columns X, (n, n_b).
pub fn mass_products(mass: &SparseMatrix, columns: MatRef<'_, f64>) -> Mat<f64> {
    let n_b = columns.ncols();
    let mut products = Mat::zeros(n_b, n_b);
    for first in (0..n_b).step_by(BLOCK) {
        let count = BLOCK.min(n_b - first);
        let product = symmetric_product(mass, columns.subcols(first, count));
        let upper = gram(columns.subcols(0, first + count), product.as_ref());
        enter_symmetric(&mut products, first, &upper);
    }
    products
}

/// Enters columns from `first` on of a symmetric matrix, down to the diagonal, and their mirror image.
pub fn enter_symmetric(matrix: &mut Mat<f64>, first: usize, upper: &Mat<f64>) {
    for j in 0..upper.ncols() {
        for i in 0..=first + j {
            matrix[(i, first + j)] = upper[(i, j)];
            matrix[(first + j, i)] = upper[(i, j)];
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use faer::sparse::Triplet;

    /// A chain of springs, each dof held besides.
    fn chain(n: u32) -> SparseMatrix {
        let mut entries = Vec::new();
        for i in 0..n {
            entries.push(Triplet::new(i, i, 3.0 + f64::from(i % 5)));
            if i > 0 {
                entries.push(Triplet::new(i, i - 1, -1.0));
                entries.push(Triplet::new(i - 1, i, -1.0));
            }
        }
        SparseMatrix::try_new_from_triplets(n as usize, n as usize, &entries).unwrap()
    }

    #[test]
    fn columns_that_change_later_have_the_products_of_the_final_ones() {
        let (n, count) = (60, 40);
        let stiffness = chain(n as u32);
        let modes = Mat::from_fn(n, 3, |i, j| ((i + 1) as f64 * (0.3 + j as f64)).sin());
        let last = Mat::from_fn(n, count, |i, j| ((i * (j + 2)) as f64 * 0.37).cos());
        let changed = [1, 7, 18, 21];
        let mut columns = last.clone();
        for column in changed {
            columns.col_mut(column).iter_mut().for_each(|x| *x *= 1.5);
        }
        let mut products = StiffnessProducts::empty(3, count);
        let add =
            |products: &mut StiffnessProducts, columns: &Mat<f64>, first: usize, end: usize| {
                let known = columns.as_ref().subcols(0, end);
                let block = known.subcols(first, end - first);
                let product = symmetric_product(&stiffness, block);
                products.enter(modes.as_ref(), known, first..end, product.as_ref());
            };
        add(&mut products, &columns, 0, 16);
        add(&mut products, &columns, 16, 32);
        for column in changed {
            columns.col_mut(column).copy_from(last.col(column));
        }
        let some = crate::block_algebra::some_columns(last.as_ref(), &changed);
        let product = symmetric_product(&stiffness, some.as_ref());
        let known = columns.as_ref().subcols(0, 32);
        products.enter(modes.as_ref(), known, changed, product.as_ref());
        add(&mut products, &columns, 32, count);

        let dense = stiffness.to_dense();
        let expected = last.transpose() * &dense * &last;
        assert!((&products.columns - &expected).norm_max() < 1e-11);
        let expected = modes.transpose() * &dense * &last;
        assert!((&products.modes - &expected).norm_max() < 1e-11);
    }
}
