//! A fixed basis inside a multiple root, and a fixed sign for a simple one, so that a reduction is repeatable.
//!
//! Inside an eigenspace any rotation is as good as any other. The rule here depends only on the space: the dof that moves
//! most (the first of those that tie) is given to the first vector alone, then the same among what is left. Every
//! vector's sign makes its own such dof positive. Internal rows, whose units are anybody's, don't count unless nothing else moves.

use faer::MatMut;
use faer::reborrow::Reborrow;

/// Eigenvalues closer than this, relatively, are treated as one root: rotating among them costs no more residual than
/// this, and computed copies of one root differ by less.
const SAME_ROOT: f64 = 1e-9;
/// Rows whose size is within this of the largest tie, and the first of them is taken.
const TIE: f64 = 1e-6;

/// Runs (first, count) of eigenvalues that are one root each; ascending input.
pub fn clusters(eigenvalues: &[f64]) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for (i, value) in eigenvalues.iter().enumerate() {
        match runs.last_mut() {
            Some((_, count)) if value - eigenvalues[i - 1] <= SAME_ROOT * value.abs() => {
                *count += 1
            }
            _ => runs.push((i, 1)),
        }
    }
    runs
}

/// Rotates the columns of an orthonormal basis of an eigenspace into the fixed basis, and fixes their signs; `is_internal` tells the rows
/// that belong to no node.
pub fn canonical_basis(mut x: MatMut<'_, f64>, is_internal: impl Fn(usize) -> bool) {
    let count = x.ncols();
    for first in 0..count {
        let row = leading_row(x.rb(), first, &is_internal);
        // A Householder reflection of the remaining columns turns this row into (length, 0, …, 0).
        let entries: Vec<f64> = (first..count).map(|j| x[(row, j)]).collect();
        let length = entries.iter().map(|e| e * e).sum::<f64>().sqrt();
        if length == 0.0 {
            return;
        }
        if entries.len() > 1 {
            let mut v = entries.clone();
            v[0] += if entries[0] >= 0.0 { length } else { -length };
            reflect(x.as_mut().subcols_mut(first, v.len()), &v);
        }
        if x[(row, first)] < 0.0 {
            x.as_mut().col_mut(first).iter_mut().for_each(|x| *x = -*x);
        }
    }
}

/// The Householder reflection `x - 2 (x v) vᵀ / vᵀv`.
fn reflect(mut x: MatMut<'_, f64>, v: &[f64]) {
    let v_squared: f64 = v.iter().map(|e| e * e).sum();
    for i in 0..x.nrows() {
        let along: f64 = v.iter().enumerate().map(|(j, e)| e * x[(i, j)]).sum();
        for (j, e) in v.iter().enumerate() {
            x[(i, j)] -= 2.0 * along / v_squared * e;
        }
    }
}

/// First row whose length over the columns from `first` on ties with the longest.
fn leading_row(
    x: faer::MatRef<'_, f64>,
    first: usize,
    is_internal: impl Fn(usize) -> bool,
) -> usize {
    let mut lengths = vec![0.0; x.nrows()];
    for column in x.subcols(first, x.ncols() - first).col_iter() {
        for (length, value) in lengths.iter_mut().zip(column.iter()) {
            *length += value * value;
        }
    }
    let moves = |(row, length): (usize, &f64)| *length > 0.0 && !is_internal(row);
    if lengths.iter().enumerate().any(moves) {
        for (row, length) in lengths.iter_mut().enumerate() {
            if is_internal(row) {
                *length = 0.0;
            }
        }
    }
    let longest = lengths.iter().copied().fold(0.0, f64::max);
    lengths
        .iter()
        .position(|length| *length >= (1.0 - TIE) * longest)
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    #[test]
    fn the_basis_depends_only_on_the_space() {
        let a = Mat::from_fn(9, 1, |i, _| ((i as f64) * 0.7).sin());
        let b = Mat::from_fn(9, 1, |i, _| ((i as f64) * 1.3 + 0.4).cos());
        let basis = |angle: f64, flip: f64| {
            let mut x = Mat::from_fn(9, 2, |i, j| match j {
                0 => angle.cos() * a[(i, 0)] + angle.sin() * b[(i, 0)],
                _ => flip * (angle.cos() * b[(i, 0)] - angle.sin() * a[(i, 0)]),
            });
            canonical_basis(x.as_mut(), |_| false);
            x
        };
        let reference = basis(0.0, 1.0);
        for (angle, flip) in [(0.3, 1.0), (2.0, -1.0), (-1.1, 1.0)] {
            let other = basis(angle, flip);
            assert!(
                dcb_sparse::block_algebra::largest_entry((&other - &reference).as_ref()) < 1e-14
            );
        }
    }

    #[test]
    fn runs_of_equal_eigenvalues() {
        assert_eq!(
            clusters(&[1.0, 1.0 + 1e-12, 2.0, 3.0, 3.0, 3.0]),
            vec![(0, 2), (2, 1), (3, 3)]
        );
    }
}
