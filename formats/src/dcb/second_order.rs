//! The second-order change of inertia: six matrices in memory, (n, n, 3, 3) in the file.

use faer::Mat;

use super::check::rules;
use crate::hdf5_files::inventory::Finding;

/// Which of xx, yy, zz, xy, yz, zx entry (a, b) of a symmetric tensor is.
const COMPONENTS: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];

/// (n, n, 3, 3) from the matrices xx, yy, zz, xy, yz, zx.
pub(super) fn to_values(components: &[Mat<f64>]) -> Vec<f64> {
    let n = components.first().map_or(0, Mat::nrows);
    let mut values = Vec::with_capacity(9 * n * n);
    for k in 0..n {
        for l in 0..n {
            values.extend(
                COMPONENTS
                    .as_flattened()
                    .iter()
                    .map(|&component| components[component][(k, l)]),
            );
        }
    }
    values
}

/// Six matrices xx, yy, zz, xy, yz, zx from (n, n, 3, 3).
pub(super) fn from_values(values: &[f64], n: usize) -> Result<Vec<Mat<f64>>, Finding> {
    // Blocks (k, k) are sums of squares: their traces give the scale of all others.
    let trace = |k: usize| {
        [0, 4, 8]
            .iter()
            .map(|ab| values[9 * (k * n + k) + ab])
            .sum::<f64>()
            .max(0.0)
    };
    for (entry, block) in values.chunks_exact(9).enumerate() {
        let (k, l) = (entry / n, entry % n);
        let allowed = rules::SYMMETRY_TOLERANCE * (trace(k) * trace(l)).sqrt();
        let skew = [(1, 3), (2, 6), (5, 7)]
            .iter()
            .any(|&(ab, ba)| (block[ab] - block[ba]).abs() > allowed);
        if skew {
            return Err(Finding::at(
                "/inertia/I2",
                format!("isn't symmetric in (a, b) at (k, l) = ({k}, {l})"),
            ));
        }
    }
    let mut first = [0; 6];
    for (entry, &component) in COMPONENTS.as_flattened().iter().enumerate().rev() {
        first[component] = entry;
    }
    Ok(first
        .iter()
        .map(|&entry| Mat::from_fn(n, n, |k, l| values[9 * (k * n + l) + entry]))
        .collect())
}
