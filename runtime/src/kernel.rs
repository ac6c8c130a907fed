//! Products of a tall array with a few columns, for the inner loop: n coordinates times at most a few columns each.
//!
//! Arrays are column-major, `columns[k * n..][..n]` being column k. The widest instructions of the machine are chosen at run time.

use pulp::Arch;

/// `y += Σ_k factors[k] columns_k`
pub fn add_columns(y: &mut [f64], columns: &[f64], factors: &[f64]) {
    let n = y.len();
    if n == 0 {
        return;
    }
    debug_assert_eq!(columns.len(), n * factors.len());
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for (column, factor) in columns.chunks_exact(n).zip(factors) {
                for (y, x) in y.iter_mut().zip(column) {
                    *y += factor * x;
                }
            }
        },
    );
}

/// `products[k] += columns_k · x`
pub fn add_products(products: &mut [f64], columns: &[f64], x: &[f64]) {
    let n = x.len();
    if n == 0 {
        return;
    }
    debug_assert_eq!(columns.len(), n * products.len());
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for (column, product) in columns.chunks_exact(n).zip(products) {
                *product += dot(column, x);
            }
        },
    );
}

/// `a · b` with four partial sums, so that the sum is not one chain of additions.
#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a_blocks, b_blocks) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = a_blocks
        .remainder()
        .iter()
        .zip(b_blocks.remainder())
        .map(|(a, b)| a * b)
        .sum();
    for (a, b) in a_blocks.zip(b_blocks) {
        for i in 0..4 {
            sums[i] += a[i] * b[i];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}
