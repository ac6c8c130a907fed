//! The rank of constraints: which rows of a positive semi-definite matrix depend on the others.
//!
//! A Cholesky factorization with diagonal pivoting of the matrix scaled to a unit diagonal. Its columns are asked for one by one and only where
//! a pivot is; they are kept sparse, because a mechanism's rows meet only where they touch the same body. The order of the pivots is that of
//! a dense factorization, so what it finds is the same; the work is far from the cube of the number of rows.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Scaled pivots of the joints' system below this are redundant constraints.
const DEPENDENT: f64 = 1e-9;
/// Entries of a column below this part of its pivot are rounding.
const NEGLIGIBLE: f64 = 1e-14;

/// A column that is being summed up.
pub(crate) struct SparseColumn {
    values: Vec<f64>,
    is_touched: Vec<bool>,
    touched: Vec<usize>,
}

impl SparseColumn {
    fn of(rows: usize) -> Self {
        Self {
            values: vec![0.0; rows],
            is_touched: vec![false; rows],
            touched: Vec::new(),
        }
    }

    /// Adds to the entry of a row.
    pub(crate) fn add(&mut self, row: usize, more: f64) {
        if !self.is_touched[row] {
            self.is_touched[row] = true;
            self.touched.push(row);
        }
        self.values[row] += more;
    }

    fn clear(&mut self) {
        for row in self.touched.drain(..) {
            self.values[row] = 0.0;
            self.is_touched[row] = false;
        }
    }
}

/// Result of a factorization.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Dependence {
    /// Rows that depend on the others, ascending.
    pub rows: Vec<usize>,
    /// Multiplications that it took to find them.
    pub operations: usize,
}

/// A pivot to come: its value, which may have become smaller, and its row.
struct Candidate(f64, usize);

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0).then(self.1.cmp(&other.1))
    }
}
impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Candidate {}

/// Rows of a positive semi-definite matrix that depend on the others: what a Cholesky factorization with diagonal pivoting of the
/// scaled matrix leaves below 1e-9. The matrix is given by its diagonal, (n), and by its columns: `column` adds the entries of one.
pub(crate) fn dependent_rows(
    diagonal: &[f64],
    mut column: impl FnMut(usize, &mut SparseColumn),
) -> Dependence {
    let n = diagonal.len();
    let scale: Vec<f64> = diagonal
        .iter()
        .map(|entry| match entry.abs() {
            entry if entry > 0.0 => 1.0 / entry.sqrt(),
            _ => 1.0,
        })
        .collect();
    // What earlier pivots leave of the diagonal.
    let mut left: Vec<f64> = diagonal
        .iter()
        .zip(&scale)
        .map(|(entry, scale)| entry * (scale * scale))
        .collect();
    let mut candidates: BinaryHeap<Candidate> = left
        .iter()
        .enumerate()
        .map(|(row, pivot)| Candidate(*pivot, row))
        .collect();
    let mut is_pivot = vec![false; n];
    let mut columns: Vec<Vec<(usize, f64)>> = Vec::new();
    // Where earlier columns meet a row, and by which factor they change its column.
    let mut earlier: Vec<Vec<(usize, f64)>> = vec![Vec::new(); n];
    let mut sum = SparseColumn::of(n);
    let mut operations = 0;
    while let Some(Candidate(pivot, chosen)) = candidates.pop() {
        if pivot.total_cmp(&left[chosen]) != Ordering::Equal {
            candidates.push(Candidate(left[chosen], chosen));
            continue;
        }
        if pivot <= DEPENDENT {
            break;
        }
        is_pivot[chosen] = true;
        column(chosen, &mut sum);
        for row in &sum.touched {
            sum.values[*row] *= scale[*row] * scale[chosen];
        }
        operations += sum.touched.len();
        for (place, factor) in &earlier[chosen] {
            for (row, entry) in &columns[*place] {
                sum.add(*row, -entry * factor);
            }
            operations += columns[*place].len();
        }
        let mut kept = Vec::new();
        for row in &sum.touched {
            let entry = sum.values[*row];
            // What is dependent already never becomes a pivot.
            if is_pivot[*row] || left[*row] <= DEPENDENT || entry.abs() <= NEGLIGIBLE * pivot {
                continue;
            }
            let factor = entry / pivot;
            left[*row] -= entry * factor;
            earlier[*row].push((columns.len(), factor));
            kept.push((*row, entry));
        }
        sum.clear();
        columns.push(kept);
    }
    Dependence {
        rows: (0..n).filter(|row| !is_pivot[*row]).collect(),
        operations,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
mod tests {
    use super::*;
    use faer::Mat;

    /// Right-looking and dense, as in a textbook.
    fn dense_way(mut lambda: Mat<f64>) -> Vec<usize> {
        let n = lambda.nrows();
        let scale: Vec<f64> = (0..n).map(|i| 1.0 / lambda[(i, i)].sqrt()).collect();
        lambda = Mat::from_fn(n, n, |i, j| lambda[(i, j)] * (scale[i] * scale[j]));
        let mut left: Vec<usize> = (0..n).collect();
        while !left.is_empty() {
            let pivots = left.iter().map(|i| lambda[(*i, *i)]).enumerate();
            let (position, pivot) = pivots.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
            if pivot <= DEPENDENT {
                break;
            }
            let chosen = left.remove(position);
            for &j in &left {
                let factor = lambda[(chosen, j)] / pivot;
                for &i in &left {
                    let change = lambda[(i, chosen)] * factor;
                    lambda[(i, j)] -= change;
                }
            }
        }
        left
    }

    /// Λ of a chain of bodies: `hinges` rows between neighbours, of which `rank` are independent, and masses of very different size.
    fn chain(bodies: usize, hinges: usize, rank: usize) -> Vec<Vec<(usize, f64)>> {
        let random = |i: usize| ((1.0 + 12.9898 * i as f64).sin() * 43758.5453).fract();
        let gradient = |row: usize, k: usize| match k < rank {
            true => random(row * rank + k) + f64::from(u8::from(row % rank == k)),
            false => 0.0,
        };
        let compliance = |body: usize| 10.0_f64.powi((body % 7) as i32 - 3);
        let rows = bodies * hinges;
        let meet = |row: usize, other: usize| -> f64 {
            let (a, b) = (row / hinges, other / hinges);
            // Joint j is between the bodies j - 1 and j.
            let shared = match a.abs_diff(b) {
                0 if a > 0 => compliance(a) + compliance(a - 1),
                0 => compliance(a),
                1 => -compliance(a.min(b)),
                _ => 0.0,
            };
            shared
                * (0..rank)
                    .map(|k| gradient(row, k) * gradient(other, k))
                    .sum::<f64>()
        };
        (0..rows)
            .map(|row| {
                let joint = row / hinges;
                let near = joint.saturating_sub(1) * hinges..((joint + 2) * hinges).min(rows);
                near.map(|other| (other, meet(row, other))).collect()
            })
            .collect()
    }

    fn found(columns: &[Vec<(usize, f64)>]) -> Dependence {
        let entry = |row: usize| columns[row].iter().find(|(other, _)| *other == row);
        let diagonal: Vec<f64> = (0..columns.len())
            .map(|row| entry(row).unwrap().1)
            .collect();
        dependent_rows(&diagonal, |row, sum| {
            for (other, entry) in &columns[row] {
                sum.add(*other, *entry);
            }
        })
    }

    #[test]
    fn dependent_rows_are_those_of_a_dense_factorization() {
        for (bodies, hinges, rank) in [(1, 9, 5), (4, 7, 3), (12, 5, 5), (20, 6, 4)] {
            let columns = chain(bodies, hinges, rank);
            let mut dense = Mat::zeros(columns.len(), columns.len());
            for (j, column) in columns.iter().enumerate() {
                for (i, entry) in column {
                    dense[(*i, j)] = *entry;
                }
            }
            let sparse = found(&columns).rows;
            assert_eq!(sparse.len(), bodies * (hinges - rank));
            assert_eq!(sparse, dense_way(dense), "{bodies} {hinges} {rank}");
        }
    }

    /// Eight times as many rows would take a dense factorization 512 times the work. Between two bodies the work grows with the hinges.
    #[test]
    fn work_grows_far_slower_than_the_cube_of_the_rows() {
        let work = |bodies, hinges| found(&chain(bodies, hinges, 5)).operations as f64;
        let (chain, pair) = (work(160, 8) / work(20, 8), work(1, 320) / work(1, 40));
        assert!(chain < 40.0 && pair < 10.0, "{chain} {pair}");
    }

    #[test]
    fn rows_of_zeros_and_numbers_that_are_not_finite_end() {
        assert_eq!(dependent_rows(&[0.0, 1.0], |_, _| ()).rows, [0]);
        let _ = dependent_rows(&[f64::NAN, 1.0], |row, sum| sum.add(1 - row, f64::NAN));
    }
}
