//! Products of a tall array with a few columns, for the inner loop: n coordinates times at most a few columns each.
//!
//! Arrays are column-major, `columns[k * n..][..n]` being column k. The widest instructions of the machine are chosen at run time.

use pulp::{Arch, Simd, WithSimd};

use crate::frame::stacked::{add_scaled, dot};

/// `y += Σ_k factors[k] columns_k`
pub fn add_columns(y: &mut [f64], columns: &[f64], factors: &[f64]) {
    if !y.is_empty() {
        debug_assert_eq!(columns.len(), y.len() * factors.len());
        Arch::new().dispatch(AddColumns {
            y,
            columns,
            factors,
        });
    }
}

/// `products[k] += columns_k · x`
pub fn add_products(products: &mut [f64], columns: &[f64], x: &[f64]) {
    if !x.is_empty() {
        debug_assert_eq!(columns.len(), x.len() * products.len());
        Arch::new().dispatch(AddProducts {
            products,
            columns,
            x,
        });
    }
}

struct AddColumns<'a> {
    y: &'a mut [f64],
    columns: &'a [f64],
    factors: &'a [f64],
}

impl WithSimd for AddColumns<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for (column, factor) in self.columns.chunks_exact(self.y.len()).zip(self.factors) {
            add_scaled(simd, *factor, column, self.y);
        }
    }
}

struct AddProducts<'a> {
    products: &'a mut [f64],
    columns: &'a [f64],
    x: &'a [f64],
}

impl WithSimd for AddProducts<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let columns = self.columns.chunks_exact(self.x.len());
        for (column, product) in columns.zip(self.products) {
            *product += dot(simd, column, self.x);
        }
    }
}
