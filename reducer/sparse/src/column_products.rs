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
            products.add(
                modes,
                columns.subcols(0, first + count),
                first,
                product.as_ref(),
            );
        }
        products
    }

    /// Enters K times the columns from `first` on, the last ones of those `known` so far.
    pub fn add(
        &mut self,
        modes: MatRef<'_, f64>,
        known: MatRef<'_, f64>,
        first: usize,
        product: MatRef<'_, f64>,
    ) {
        enter_symmetric(&mut self.columns, first, &gram(known, product));
        self.modes
            .as_mut()
            .subcols_mut(first, product.ncols())
            .copy_from(gram(modes, product));
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
