//! Quantities over a basis, over combinations S of its columns.

use dcb_formats::superelement::Inertia;
use faer::{Mat, MatRef};

/// Sᵀ f.
pub(super) fn worked(work: &[f64], columns: MatRef<'_, f64>) -> Vec<f64> {
    (columns.col_iter())
        .map(|column| column.iter().zip(work).map(|(s, f)| s * f).sum())
        .collect()
}

/// Invariants over the basis Ψ S.
pub(super) fn over(whole: &Inertia, columns: MatRef<'_, f64>) -> Inertia {
    Inertia {
        l1: &whole.l1 * columns,
        i1: columns
            .col_iter()
            .map(|column| combined(&whole.i1, column.iter()))
            .collect(),
        i3: &whole.i3 * columns,
        l3: congruent(&whole.l3, columns),
        i2: congruent(&whole.i2, columns),
        ..whole.clone()
    }
}

fn combined<'a>(blocks: &[[[f64; 3]; 3]], weights: impl Iterator<Item = &'a f64>) -> [[f64; 3]; 3] {
    let mut sum = [[0.0; 3]; 3];
    for (block, weight) in blocks.iter().zip(weights) {
        for (sum, row) in sum.iter_mut().zip(block) {
            for (sum, entry) in sum.iter_mut().zip(row) {
                *sum += weight * entry;
            }
        }
    }
    sum
}

/// Sᵀ A S for each A.
pub(super) fn congruent(matrices: &[Mat<f64>], columns: MatRef<'_, f64>) -> Vec<Mat<f64>> {
    matrices
        .iter()
        .map(|matrix| squeezed(matrix, columns))
        .collect()
}

/// Sᵀ A S.
pub(super) fn squeezed(matrix: &Mat<f64>, columns: MatRef<'_, f64>) -> Mat<f64> {
    columns.transpose() * (matrix * columns)
}
