//! Rows of L_b that say the same as others, by name.

use faer::Mat;

use crate::model::localization::Localization;

/// A row depends on others when less than this fraction of its flexibility is left after they are taken out.
const DEPENDENT_ROW: f64 = 1e-9;

/// A row of L_b that is a combination of others as far as elastic motion goes.
#[derive(Clone, Debug, PartialEq)]
pub struct Dependency {
    /// The row.
    pub row: String,
    /// The rows that it depends on; empty if it sees no elastic motion at all.
    pub depends_on: Vec<String>,
}

/// Rows that are combinations of others: Cholesky with pivoting on the scaled static flexibility, largest remainder first.
pub fn dependencies(flexibility0: &Mat<f64>, localization: &Localization) -> Vec<Dependency> {
    let n_b = flexibility0.nrows();
    let attached: Vec<usize> = (0..n_b)
        .filter(|row| localization.is_attachment(*row))
        .collect();
    let mut found = Vec::new();
    let scale = |i: usize| flexibility0[(i, i)].max(0.0).sqrt();
    // Rows that feel rounding alone have been set to zero; how large the others are is the user's choice.
    let (mut open, inert): (Vec<usize>, Vec<usize>) =
        attached.iter().partition(|i| scale(**i) > 0.0);
    for row in inert {
        found.push(Dependency {
            row: localization.row_name(row),
            depends_on: Vec::new(),
        });
    }
    // Remaining part of each row, as coefficients over the pivots' orthonormal directions.
    let mut parts: Vec<Vec<f64>> = vec![Vec::new(); n_b];
    let mut pivots: Vec<usize> = Vec::new();
    let left = |parts: &[Vec<f64>], i: usize| 1.0 - parts[i].iter().map(|p| p * p).sum::<f64>();
    while let Some(position) = (0..open.len()).max_by(|a, b| {
        left(&parts, open[*a])
            .total_cmp(&left(&parts, open[*b]))
            .then(open[*b].cmp(&open[*a]))
    }) {
        let pivot = open[position];
        let remaining = left(&parts, pivot);
        if remaining < DEPENDENT_ROW {
            break;
        }
        open.remove(position);
        for i in open.iter().copied() {
            let cosine = flexibility0[(i, pivot)] / (scale(i) * scale(pivot));
            let known: f64 = parts[i].iter().zip(&parts[pivot]).map(|(a, b)| a * b).sum();
            parts[i].push((cosine - known) / remaining.sqrt());
        }
        parts[pivot].push(remaining.sqrt());
        pivots.push(pivot);
    }
    open.sort_unstable();
    for row in open {
        // Back substitution: row = Σ c_p pivot_p in scaled terms.
        let mut coefficients = vec![0.0; pivots.len()];
        for k in (0..pivots.len()).rev() {
            let later: f64 = (k + 1..pivots.len())
                .map(|l| coefficients[l] * parts[pivots[l]].get(k).copied().unwrap_or(0.0))
                .sum();
            coefficients[k] = (parts[row][k] - later) / parts[pivots[k]][k];
        }
        let involved = pivots
            .iter()
            .zip(&coefficients)
            .filter(|(_, c)| c.abs() > 1e-6);
        found.push(Dependency {
            row: localization.row_name(row),
            depends_on: involved
                .map(|(pivot, _)| localization.row_name(*pivot))
                .collect(),
        });
    }
    found
}
