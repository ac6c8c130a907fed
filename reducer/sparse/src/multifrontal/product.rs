//! Products of a front's columns, `C - A Bᵀ`: nearly all the arithmetic of a factorization.
//!
//! faer's kernels read B where it stands, whose columns are as far from each other as a front is tall. The `gemm` crate packs it first: with
//! 192 columns and 400 to 6000 rows its products take 0.8 to 0.9 of the time with AVX2, and 0.7 to 0.9 with AVX-512.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

/// Fewer operations than this are left to faer, which has kernels for small products.
const LARGE: usize = 1 << 21;

/// Subtracts `left rightᵀ` from `target`, or replaces it by the negative.
pub(super) fn subtract_product(
    target: MatMut<'_, f64>,
    left: MatRef<'_, f64>,
    right: MatRef<'_, f64>,
    accumulate: Accum,
) {
    let (rows, columns, depth) = (target.nrows(), target.ncols(), left.ncols());
    if rows * columns * depth < LARGE || !packs_faster() {
        return matmul(target, accumulate, left, right.transpose(), -1.0, Par::Seq);
    }
    assert_eq!(
        (left.nrows(), right.nrows(), right.ncols()),
        (rows, columns, depth)
    );
    let across = right.transpose();
    // SAFETY: three matrices of these sizes, the first of which nobody else has; their strides are their own.
    unsafe {
        gemm::gemm(
            rows,
            columns,
            depth,
            target.as_ptr_mut(),
            target.col_stride(),
            target.row_stride(),
            accumulate == Accum::Add,
            left.as_ptr(),
            left.col_stride(),
            left.row_stride(),
            across.as_ptr(),
            across.col_stride(),
            across.row_stride(),
            1.0,
            -1.0,
            false,
            false,
            false,
            gemm::Parallelism::None,
        );
    }
}

/// Whether products that are packed first are faster on this processor.
fn packs_faster() -> bool {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::is_x86_feature_detected as has;
        has!("avx2") && has!("fma")
    }
    #[cfg(not(target_arch = "x86_64"))]
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    #[test]
    fn products_of_any_size_are_sums_over_the_columns() {
        for (rows, columns, depth) in [(3, 2, 1), (40, 30, 20), (150, 130, 120), (300, 192, 190)] {
            // Parts of taller matrices, as in a front.
            let tall = Mat::from_fn(rows + columns + 9, depth, |i, j| {
                ((i * (j + 3)) as f64).sin()
            });
            let (left, right) = (
                tall.as_ref().subrows(4, rows),
                tall.as_ref().subrows(7, columns),
            );
            let before = Mat::from_fn(rows + 5, columns, |i, j| (i + 2 * j) as f64);
            for (accumulate, factor) in [(Accum::Add, 1.0), (Accum::Replace, 0.0)] {
                let mut found = before.clone();
                subtract_product(found.as_mut().subrows_mut(5, rows), left, right, accumulate);
                for i in 0..rows {
                    for j in 0..columns {
                        let sum: f64 = (0..depth).map(|k| left[(i, k)] * right[(j, k)]).sum();
                        let expected = factor * before[(i + 5, j)] - sum;
                        assert!((found[(i + 5, j)] - expected).abs() < 1e-12 * depth as f64);
                    }
                }
                assert_eq!(found.as_ref().subrows(0, 5), before.as_ref().subrows(0, 5));
            }
        }
    }
}
