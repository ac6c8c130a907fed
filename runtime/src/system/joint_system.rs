//! The system of the joints: what is left of a Newton iteration once every body is eliminated.
//!
//! ```text
//! (Λ + diag(c)) δλ = b,      Λ = Σ_bodies G (N S⁻¹ Nᵀ) Gᵀ
//! ```
//! G holds the gradients of the rows at the markers, c the compliance of springs (zero for constraints). Two rows meet where they
//! touch the same body, so the pattern is that of the mechanism's graph and is analysed once. Rows are scaled to a unit
//! diagonal, which takes lengths, angles and masses out of every tolerance.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::lu::partial_pivoting;
use faer::perm::PermRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::lu::{
    LuRef, LuSymbolicParams, NumericLu, SymbolicLu, factorize_symbolic_lu,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Conj, Mat, MatMut, Par, Spec};

use crate::kernel::add_columns;

/// Up to this many rows the system is inverted as a dense matrix; above, its sparsity pays.
const DENSE_ROWS: usize = 24;

/// The joints' system: pattern, values and factor. Everything is allocated when it is made.
pub struct JointSystem {
    pattern: SymbolicSparseColMat<usize>,
    values: Vec<f64>,
    /// Index of each diagonal entry among the values.
    diagonal: Vec<usize>,
    /// 1/√Λ_ii by rows.
    scale: Vec<f64>,
    /// What the last factor has beyond Λ + c on the diagonal of the scaled matrix.
    regularization: f64,
    factor: Factor,
    stack: MemBuffer,
    scaled: Vec<f64>,
    null_space: NullSpace,
}

/// Directions of δλ that do nothing, in the scaled system.
#[derive(Default)]
struct NullSpace {
    /// Orthonormal, one after the other.
    basis: Vec<f64>,
    /// Whether they belong to the last factor.
    is_known: bool,
    /// Whether they belong to an earlier one: a good guess.
    was_known: bool,
}

/// Inverse iterations for the null space.
const NULL_ITERATIONS: usize = 4;
/// How nearly a direction's compliance must be the regularization alone.
const NULL: f64 = 1e-4;

enum Factor {
    Dense {
        matrix: Mat<f64>,
        inverse: Mat<f64>,
        /// The inverse by columns without padding.
        columns: Vec<f64>,
        permutation: [Vec<usize>; 2],
    },
    Sparse {
        symbolic: Box<SymbolicLu<usize>>,
        numeric: Box<NumericLu<usize, f64>>,
    },
}

impl JointSystem {
    /// The system of `rows` rows whose entries are at `(row, column)` of `pairs`; pairs may repeat and come in any order.
    /// Also returned: the place of each pair among the values. `None` if memory is short.
    pub fn with_pattern(rows: usize, pairs: &[(usize, usize)]) -> Option<(Self, Vec<usize>)> {
        let mut sorted: Vec<(usize, usize)> = pairs
            .iter()
            .map(|(row, column)| (*column, *row))
            .chain((0..rows).map(|row| (row, row)))
            .collect();
        sorted.sort_unstable();
        sorted.dedup();
        let place = |row: usize, column: usize| {
            sorted
                .binary_search(&(column, row))
                .unwrap_or_else(|insertion| insertion)
        };
        let places = pairs
            .iter()
            .map(|(row, column)| place(*row, *column))
            .collect();
        let diagonal = (0..rows).map(|row| place(row, row)).collect();
        let mut starts = vec![0; rows + 1];
        for (column, _) in &sorted {
            starts[column + 1] += 1;
        }
        for column in 0..rows {
            starts[column + 1] += starts[column];
        }
        let row_indices: Vec<usize> = sorted.iter().map(|(_, row)| *row).collect();
        let count = row_indices.len();
        let pattern = SymbolicSparseColMat::new_checked(rows, rows, starts, None, row_indices);
        let (factor, scratch) = if rows <= DENSE_ROWS {
            Factor::dense(rows)
        } else {
            Factor::sparse(&pattern)?
        };
        let system = Self {
            pattern,
            values: vec![0.0; count],
            diagonal,
            scale: vec![1.0; rows],
            regularization: 0.0,
            factor,
            stack: MemBuffer::try_new(scratch).ok()?,
            scaled: vec![0.0; rows],
            null_space: NullSpace::default(),
        };
        Some((system, places))
    }

    /// The entries, to be overwritten before `factor`.
    pub fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    /// The diagonal entry of a row.
    pub fn diagonal(&self, row: usize) -> f64 {
        self.values[self.diagonal[row]]
    }

    /// Adds to the diagonal.
    pub fn add_to_diagonal(&mut self, row: usize, more: f64) {
        self.values[self.diagonal[row]] += more;
    }

    /// The compliance that the regularization of the last factor gives a row.
    pub fn regularizing_compliance(&self, row: usize) -> f64 {
        self.regularization / self.scale[row].powi(2)
    }

    /// Factors the system with `regularization` added to the unit diagonal of the scaled matrix. Returns whether it is regular.
    pub fn factor(&mut self, regularization: f64) -> bool {
        for (scale, diagonal) in self.scale.iter_mut().zip(&self.diagonal) {
            let entry = self.values[*diagonal].abs();
            *scale = if entry > 0.0 { 1.0 / entry.sqrt() } else { 1.0 };
        }
        let rows = self.pattern.row_idx();
        let starts = self.pattern.col_ptr();
        for column in 0..self.scale.len() {
            let entries = starts[column]..starts[column + 1];
            for (value, row) in self.values[entries.clone()].iter_mut().zip(&rows[entries]) {
                *value *= self.scale[*row] * self.scale[column];
            }
        }
        for diagonal in &self.diagonal {
            self.values[*diagonal] += regularization;
        }
        self.regularization = regularization;
        self.null_space.is_known = false;
        let matrix = SparseColMatRef::new(self.pattern.as_ref(), self.values.as_slice());
        self.factor.compute(matrix, MemStack::new(&mut self.stack))
    }

    /// Makes room for so many redundant rows.
    pub fn expect_redundant(&mut self, count: usize) {
        self.null_space.basis = vec![0.0; count * self.scale.len()];
        self.forget_redundant();
    }

    /// Looks for as many directions as are expected in which only the regularization of the last factor resists, by inverse iteration. They
    /// are known if there are as many and `may_hold` for each of them, which has an entry for each row.
    pub fn find_redundant(&mut self, may_hold: impl Fn(usize, f64) -> bool) {
        let rows = self.scale.len();
        let mut basis = std::mem::take(&mut self.null_space.basis);
        if !self.null_space.was_known {
            for (place, entry) in basis.iter_mut().enumerate() {
                // No symmetry hides a direction.
                *entry = (1.0 + 0.7 * place as f64).cos();
            }
        }
        let mut is_known = false;
        let is_possible = !basis.is_empty() && self.regularization > 0.0;
        for _ in 0..if is_possible { NULL_ITERATIONS } else { 0 } {
            is_known = true;
            for place in 0..basis.len() / rows {
                let (known, rest) = basis.split_at_mut(place * rows);
                let direction = &mut rest[..rows];
                for earlier in known.chunks_exact(rows) {
                    remove(direction, earlier);
                }
                normalize(direction);
                self.solve_scaled(direction);
                for earlier in known.chunks_exact(rows) {
                    remove(direction, earlier);
                }
                let growth = normalize(direction) * self.regularization;
                is_known &= (growth - 1.0).abs() < NULL;
            }
            if is_known {
                break;
            }
        }
        let mut directions = basis.chunks_exact(rows.max(1));
        let held = directions.all(|direction| {
            let mut entries = direction.iter().enumerate();
            entries.all(|(row, entry)| may_hold(row, *entry))
        });
        self.null_space = NullSpace {
            is_known: is_known && held,
            was_known: is_known,
            basis,
        };
    }

    /// Whether the directions that do nothing are known for the last factor.
    pub fn knows_redundant(&self) -> bool {
        self.null_space.is_known
    }

    /// Forgets them.
    pub fn forget_redundant(&mut self) {
        (self.null_space.is_known, self.null_space.was_known) = (false, false);
    }

    /// Takes out of δλ what does nothing.
    pub fn remove_redundant(&self, forces: &mut [f64]) {
        for (force, scale) in forces.iter_mut().zip(&self.scale) {
            *force /= scale;
        }
        self.remove_scaled(forces);
        for (force, scale) in forces.iter_mut().zip(&self.scale) {
            *force *= scale;
        }
    }

    /// Takes out of λ what only the regularization ε of the last factor resists, λ − ε (Λ + ε)⁻¹ λ in the scaled system, whether or not its
    /// directions are known. `probe` has a number for each row and is overwritten.
    pub fn share_redundant(&mut self, forces: &mut [f64], probe: &mut [f64]) {
        // What rounding of Λ leaves of them goes the second time.
        for _ in 0..2 {
            for (entry, (force, scale)) in probe.iter_mut().zip(forces.iter().zip(&self.scale)) {
                *entry = force / scale;
            }
            self.solve_scaled(probe);
            for (force, (entry, scale)) in forces.iter_mut().zip(probe.iter().zip(&self.scale)) {
                *force -= self.regularization * entry * scale;
            }
        }
    }

    fn remove_scaled(&self, scaled: &mut [f64]) {
        if self.null_space.is_known {
            for direction in self.null_space.basis.chunks_exact(self.scale.len()) {
                remove(scaled, direction);
            }
        }
    }

    /// How much the last factor enlarges a right-hand side, in the scaled system: about one over its smallest eigenvalue. `probe` has
    /// a number for each row and is overwritten.
    pub fn amplification(&mut self, probe: &mut [f64]) -> f64 {
        for (row, (entry, scale)) in probe.iter_mut().zip(&self.scale).enumerate() {
            // Rows of different weight, so that symmetry hides no direction.
            *entry = (1.0 + 0.1 * row as f64).cos() / scale;
        }
        self.solve(probe);
        let mut most = 0.0_f64;
        for (entry, scale) in probe.iter().zip(&self.scale) {
            let size = (entry / scale).abs();
            most = if size.is_nan() {
                f64::INFINITY
            } else {
                most.max(size)
            };
        }
        most
    }

    /// Solves with the last factor, in place, without the directions that are known to do nothing.
    pub fn solve(&mut self, right_hand_side: &mut [f64]) {
        for (b, scale) in right_hand_side.iter_mut().zip(&self.scale) {
            *b *= scale;
        }
        self.remove_scaled(right_hand_side);
        self.solve_scaled(right_hand_side);
        self.remove_scaled(right_hand_side);
        for (x, scale) in right_hand_side.iter_mut().zip(&self.scale) {
            *x *= scale;
        }
    }

    fn solve_scaled(&mut self, right_hand_side: &mut [f64]) {
        match &self.factor {
            Factor::Dense { columns, .. } => {
                self.scaled.fill(0.0);
                add_columns(&mut self.scaled, columns, right_hand_side);
                right_hand_side.copy_from_slice(&self.scaled);
            }
            Factor::Sparse { symbolic, numeric } => {
                let rows = right_hand_side.len();
                LuRef::new_unchecked(symbolic, numeric).solve_in_place_with_conj(
                    Conj::No,
                    MatMut::from_column_major_slice_mut(right_hand_side, rows, 1),
                    Par::Seq,
                    MemStack::new(&mut self.stack),
                );
            }
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Takes a direction of length one out of another.
fn remove(of: &mut [f64], direction: &[f64]) {
    let amount = dot(of, direction);
    for (entry, other) in of.iter_mut().zip(direction) {
        *entry -= amount * other;
    }
}

/// Makes the length one; what it was.
fn normalize(direction: &mut [f64]) -> f64 {
    let length = dot(direction, direction).sqrt();
    for entry in direction.iter_mut() {
        *entry /= length;
    }
    length
}

impl Factor {
    fn dense(rows: usize) -> (Self, StackReq) {
        let scratch = StackReq::any_of(&[
            partial_pivoting::factor::lu_in_place_scratch::<usize, f64>(
                rows,
                rows,
                Par::Seq,
                Spec::default(),
            ),
            partial_pivoting::inverse::inverse_scratch::<usize, f64>(rows, Par::Seq),
        ]);
        let factor = Self::Dense {
            matrix: Mat::zeros(rows, rows),
            inverse: Mat::zeros(rows, rows),
            columns: vec![0.0; rows * rows],
            permutation: [vec![0; rows], vec![0; rows]],
        };
        (factor, scratch)
    }

    fn sparse(pattern: &SymbolicSparseColMat<usize>) -> Option<(Self, StackReq)> {
        // The supernodal factorization would allocate in every call.
        let params = LuSymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SIMPLICIAL,
            ..LuSymbolicParams::default()
        };
        let symbolic = factorize_symbolic_lu(pattern.as_ref(), params).ok()?;
        let scratch = StackReq::any_of(&[
            symbolic.factorize_numeric_lu_scratch::<f64>(Par::Seq, Spec::default()),
            symbolic.solve_in_place_scratch::<f64>(1, Par::Seq),
        ]);
        let factor = Self::Sparse {
            symbolic: Box::new(symbolic),
            numeric: Box::new(NumericLu::new()),
        };
        Some((factor, scratch))
    }

    fn compute(&mut self, entries: SparseColMatRef<'_, usize, f64>, stack: &mut MemStack) -> bool {
        match self {
            Self::Dense {
                matrix,
                inverse,
                columns,
                permutation: [forward, backward],
            } => {
                let rows = matrix.nrows();
                matrix.fill(0.0);
                for column in 0..rows {
                    for (row, value) in entries
                        .row_idx_of_col(column)
                        .zip(entries.val_of_col(column))
                    {
                        matrix[(row, column)] = *value;
                    }
                }
                let (_, permutation): (_, PermRef<'_, usize>) =
                    partial_pivoting::factor::lu_in_place(
                        matrix.as_mut(),
                        forward,
                        backward,
                        Par::Seq,
                        stack,
                        Spec::default(),
                    );
                partial_pivoting::inverse::inverse(
                    inverse.as_mut(),
                    matrix.as_ref(),
                    matrix.as_ref(),
                    permutation,
                    Par::Seq,
                    stack,
                );
                if rows > 0 {
                    for (column, plain) in inverse.col_iter().zip(columns.chunks_exact_mut(rows)) {
                        for (entry, value) in plain.iter_mut().zip(column.iter()) {
                            *entry = *value;
                        }
                    }
                }
                columns.iter().all(|entry| entry.is_finite())
            }
            Self::Sparse { symbolic, numeric } => symbolic
                .factorize_numeric_lu(numeric, entries, Par::Seq, stack, Spec::default())
                .is_ok(),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
mod tests {
    use super::*;

    /// A ring of rows, each meeting its two neighbours, with very different units; small is dense, large is sparse.
    #[test]
    fn ring_is_solved_whatever_its_size_and_units() {
        for rows in [1, 5, DENSE_ROWS, DENSE_ROWS + 1, 200] {
            let pairs: Vec<_> = (0..rows)
                .flat_map(|row| [0, 1, rows - 1].map(|shift| (row, (row + shift) % rows)))
                .collect();
            let (mut system, places) = JointSystem::with_pattern(rows, &pairs).unwrap();
            let unit = |row: usize| if row.is_multiple_of(2) { 1e6 } else { 1e-3 };
            let entry = |row: usize, column: usize| {
                let weight = if row == column {
                    3.0
                } else {
                    -1.0 + 0.01 * row as f64 / rows as f64
                };
                weight * unit(row) * unit(column)
            };
            let mut dense = Mat::<f64>::zeros(rows, rows);
            for round in 0..2 {
                system.values_mut().fill(0.0);
                dense.fill(0.0);
                for ((row, column), place) in pairs.iter().zip(&places) {
                    let value = entry(*row, *column) * (1.0 + f64::from(round));
                    system.values_mut()[*place] = value;
                    dense[(*row, *column)] = value;
                }
                assert!(system.factor(0.0));
            }
            let expected: Vec<f64> = (0..rows)
                .map(|row| (row as f64).sin() / unit(row))
                .collect();
            let mut solution: Vec<f64> = (0..rows)
                .map(|row| (0..rows).map(|k| dense[(row, k)] * expected[k]).sum())
                .collect();
            system.solve(&mut solution);
            for row in 0..rows {
                let error = (solution[row] - expected[row]).abs() * unit(row);
                assert!(error < 1e-12, "{rows} rows, row {row}: {error:e}");
            }
        }
    }

    /// The projector away from two directions, in very different units.
    #[test]
    fn directions_that_do_nothing_are_found_and_left_alone() {
        for rows in [6, DENSE_ROWS + 16] {
            let pairs: Vec<_> = (0..rows)
                .flat_map(|row| (0..rows).map(move |column| (row, column)))
                .collect();
            let (mut system, places) = JointSystem::with_pattern(rows, &pairs).unwrap();
            let unit = |row: usize| if row.is_multiple_of(3) { 1e5 } else { 1e-2 };
            let mut directions: Vec<Vec<f64>> = [0.9, 2.3]
                .map(|w: f64| {
                    (0..rows)
                        .map(|row| (w * (row as f64 + 1.0)).sin())
                        .collect()
                })
                .to_vec();
            normalize(&mut directions[0]);
            let (first, second) = directions.split_at_mut(1);
            remove(&mut second[0], &first[0]);
            normalize(&mut second[0]);
            let entry = |row: usize, column: usize| {
                let shared: f64 = directions.iter().map(|n| n[row] * n[column]).sum();
                (f64::from(u8::from(row == column)) - shared) * unit(row) * unit(column)
            };
            let times = |x: &[f64]| -> Vec<f64> {
                let row = |row: usize| (0..rows).map(|k| entry(row, k) * x[k]).sum();
                (0..rows).map(row).collect()
            };
            let mut factor = |expected: usize| {
                system.values_mut().fill(0.0);
                for ((row, column), place) in pairs.iter().zip(&places) {
                    system.values_mut()[*place] = entry(*row, *column);
                }
                system.expect_redundant(expected);
                assert!(system.factor(1e-7));
                system.find_redundant(|_, _| true);
                system.knows_redundant()
            };
            assert!(!factor(3) && !factor(0) && factor(2), "{rows}");
            let forces: Vec<f64> = (0..rows)
                .map(|row| (row as f64).cos() / unit(row))
                .collect();
            let demand = times(&forces);
            let mut solved = demand.clone();
            system.solve(&mut solved);
            let mut left = forces.clone();
            system.remove_redundant(&mut left);
            for found in [&solved, &left] {
                for (row, (found, demand)) in times(found).iter().zip(&demand).enumerate() {
                    assert!((found - demand).abs() < 1e-6 * unit(row), "{rows} {row}");
                }
            }
            // Nothing of the directions is in the solution, so that both are the same.
            for (row, (solved, left)) in solved.iter().zip(&left).enumerate() {
                assert!((solved - left).abs() * unit(row) < 1e-6, "{rows} {row}");
            }
            assert!(
                forces
                    .iter()
                    .zip(&left)
                    .any(|(a, b)| (a - b).abs() > 1e-3 * a.abs())
            );
        }
    }
}
