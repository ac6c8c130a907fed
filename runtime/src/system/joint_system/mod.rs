//! The system of the joints: what is left of a Newton iteration once every body is eliminated.
//!
//! ```text
//! (Λ + diag(c)) δλ = b,      Λ = Σ_bodies G (N S⁻¹ Nᵀ) Gᵀ
//! ```
//! G holds the gradients of the rows at the markers, c the compliance of springs (zero for constraints). Two rows meet where they
//! touch the same body, so the pattern is that of the mechanism's graph and is analysed once. Rows are scaled to a unit
//! diagonal, which takes lengths, angles and masses out of every tolerance.
//!
//! All rows at one body meet each other. Where a rigid body has very many, it is not eliminated but stays among the unknowns, so that the
//! entries grow with the rows and not with their square:
//!
//! ```text
//! | Λ + diag(c)  B | | δλ |   | b |
//! | -Bᵀ          S | | v  | = | 0 |      Λ without those bodies, v their motions for the forces δλ
//! ```
//!
//! `redundancy.rs` leaves alone what does nothing.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::lu::partial_pivoting;
use faer::perm::PermRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::lu::{
    LuRef, LuSymbolicParams, NumericLu, SymbolicLu, factorize_symbolic_lu,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Conj, Mat, MatMut, Par, Spec};

use super::number::Number;
use super::redundancy::Redundancy;

/// Up to this many rows the system is inverted as a dense matrix; above, its sparsity pays.
const DENSE_ROWS: usize = 24;

/// The joints' system: pattern, values and factor. Everything is allocated when it is made.
pub struct JointSystem<T: Number = f64> {
    /// Number of rows; unknowns beyond them are motions of bodies.
    pub(super) rows: usize,
    pattern: SymbolicSparseColMat<usize>,
    values: Vec<T>,
    /// Index of each diagonal entry among the values.
    diagonal: Vec<usize>,
    /// Contributions of bodies among the unknowns to Λ_ii, by rows.
    beyond: Vec<T>,
    /// 1/√Λ_ii by rows, and the same of S by motions.
    pub(super) scale: Vec<f64>,
    /// Addition of the last factor to Λ + c on the diagonal of the scaled matrix.
    pub(super) regularization: f64,
    factor: Factor<T>,
    stack: MemBuffer,
    scaled: Vec<T>,
    /// All unknowns, where there are more than rows.
    extended: Vec<T>,
    pub(super) redundancy: Redundancy<T>,
}

enum Factor<T: Number> {
    Dense {
        matrix: Mat<T>,
        inverse: Mat<T>,
        /// The inverse by columns without padding.
        columns: Vec<T>,
        permutation: [Vec<usize>; 2],
    },
    Sparse {
        symbolic: Box<SymbolicLu<usize>>,
        numeric: Box<NumericLu<usize, T>>,
    },
}

impl<T: Number> JointSystem<T> {
    /// The system of `rows` rows and so many `motions` of bodies after them, whose entries are at `(row, column)` of `pairs`; pairs may
    /// repeat and come in any order. Also returned: the place of each pair among the values. `None` if memory is short.
    pub fn with_pattern(
        rows: usize,
        motions: usize,
        pairs: &[(usize, usize)],
    ) -> Option<(Self, Vec<usize>)> {
        let unknowns = rows + motions;
        let mut sorted: Vec<(usize, usize)> = pairs
            .iter()
            .map(|(row, column)| (*column, *row))
            .chain((0..unknowns).map(|unknown| (unknown, unknown)))
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
        let diagonal = (0..unknowns).map(|row| place(row, row)).collect();
        let mut starts = vec![0; unknowns + 1];
        for (column, _) in &sorted {
            starts[column + 1] += 1;
        }
        for column in 0..unknowns {
            starts[column + 1] += starts[column];
        }
        let row_indices: Vec<usize> = sorted.iter().map(|(_, row)| *row).collect();
        let count = row_indices.len();
        let pattern =
            SymbolicSparseColMat::new_checked(unknowns, unknowns, starts, None, row_indices);
        let (factor, scratch) = if unknowns <= DENSE_ROWS {
            Factor::dense(unknowns)
        } else {
            Factor::sparse(&pattern)?
        };
        let system = Self {
            rows,
            pattern,
            values: vec![T::of(0.0); count],
            diagonal,
            beyond: vec![T::of(0.0); rows],
            scale: vec![1.0; unknowns],
            regularization: 0.0,
            factor,
            stack: MemBuffer::try_new(scratch).ok()?,
            scaled: vec![T::of(0.0); unknowns],
            extended: vec![T::of(0.0); if motions > 0 { unknowns } else { 0 }],
            redundancy: Redundancy::default(),
        };
        Some((system, places))
    }

    /// The entries, to be overwritten before `factor`, and what bodies among the unknowns add to Λ_ii of each row.
    pub fn values_mut(&mut self) -> (&mut [T], &mut [T]) {
        (&mut self.values, &mut self.beyond)
    }

    /// Λ_ii + c of a row.
    pub fn diagonal(&self, row: usize) -> T {
        self.values[self.diagonal[row]] + self.beyond[row]
    }

    /// Adds to the diagonal.
    pub fn add_to_diagonal(&mut self, row: usize, more: T) {
        self.values[self.diagonal[row]] += more;
    }

    /// The compliance that the regularization of the last factor gives a row.
    pub fn regularizing_compliance(&self, row: usize) -> f64 {
        self.regularization / self.scale[row].powi(2)
    }

    /// Factors the system with `regularization` added to the unit diagonal of the scaled matrix. Returns whether it is regular.
    pub fn factor(&mut self, regularization: f64) -> bool {
        let zero = T::of(0.0);
        let beyond = self.beyond.iter().chain(std::iter::repeat(&zero));
        for ((scale, diagonal), beyond) in self.scale.iter_mut().zip(&self.diagonal).zip(beyond) {
            let entry = (self.values[*diagonal] + *beyond).modulus();
            *scale = if entry > 0.0 { 1.0 / entry.sqrt() } else { 1.0 };
        }
        self.redundancy.is_known = false;
        self.factor_scaled(regularization)
    }

    /// The same with the scales of another system's last factor and the directions that do nothing there: of the same rows at another shift.
    pub fn factor_beside(&mut self, other: &JointSystem) -> bool {
        self.scale.copy_from_slice(&other.scale);
        self.redundancy.adopt(&other.redundancy);
        self.factor_scaled(other.regularization)
    }

    fn factor_scaled(&mut self, regularization: f64) -> bool {
        let rows = self.pattern.row_idx();
        let starts = self.pattern.col_ptr();
        for column in 0..self.scale.len() {
            let entries = starts[column]..starts[column + 1];
            for (value, row) in self.values[entries.clone()].iter_mut().zip(&rows[entries]) {
                *value = value.times(self.scale[*row] * self.scale[column]);
            }
        }
        for diagonal in &self.diagonal[..self.rows] {
            self.values[*diagonal] += T::of(regularization);
        }
        self.regularization = regularization;
        let matrix = SparseColMatRef::new(self.pattern.as_ref(), self.values.as_slice());
        self.factor.compute(matrix, MemStack::new(&mut self.stack))
    }

    /// Solves with the last factor, in place, without the directions that are known to do nothing.
    pub fn solve(&mut self, right_hand_side: &mut [T]) {
        for (b, scale) in right_hand_side.iter_mut().zip(&self.scale) {
            *b = b.times(*scale);
        }
        self.remove_scaled(right_hand_side, 1);
        self.solve_scaled(right_hand_side);
        self.remove_scaled(right_hand_side, 2);
        for (x, scale) in right_hand_side.iter_mut().zip(&self.scale) {
            *x = x.times(*scale);
        }
    }

    pub(super) fn solve_scaled(&mut self, right_hand_side: &mut [T]) {
        if self.extended.is_empty() {
            return self.solve_unknowns(right_hand_side);
        }
        let mut extended = std::mem::take(&mut self.extended);
        extended[..self.rows].copy_from_slice(right_hand_side);
        extended[self.rows..].fill(T::of(0.0));
        self.solve_unknowns(&mut extended);
        right_hand_side.copy_from_slice(&extended[..self.rows]);
        self.extended = extended;
    }

    fn solve_unknowns(&mut self, right_hand_side: &mut [T]) {
        match &self.factor {
            Factor::Dense { columns, .. } => {
                self.scaled.fill(T::of(0.0));
                T::add_own_columns(&mut self.scaled, columns, right_hand_side);
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

impl JointSystem {
    /// How much the last factor enlarges a right-hand side, in the scaled system: about one over its smallest eigenvalue. `probe` has
    /// a number for each row and is overwritten.
    pub fn amplification(&mut self, probe: &mut [f64]) -> f64 {
        for (row, (entry, scale)) in probe.iter_mut().zip(&self.scale).enumerate() {
            // Rows of different weight, so that symmetry hides no direction.
            *entry = (1.0 + 0.1 * row as f64).cos() / scale;
        }
        self.solve(probe);
        largest(
            probe
                .iter()
                .zip(&self.scale)
                .map(|(entry, scale)| entry / scale),
        )
    }

    /// About the largest force that a unit of change in all rows takes, whatever their axes: it grows without bound where rows come to depend on each other.
    /// `probe` has a number for each row and is overwritten.
    pub fn largest_force(&mut self, probe: &mut [f64]) -> f64 {
        let mut most = 0.0_f64;
        // At right angles to each other, in pairs of rows too: a direction that turns is seen by one of them.
        for sign in [1.0, -1.0] {
            for (row, entry) in probe.iter_mut().enumerate() {
                *entry = if row % 2 == 0 { 1.0 } else { sign };
            }
            self.solve(probe);
            most = most.max(largest(probe.iter().copied()));
        }
        most
    }
}

/// The largest size; infinite where one isn't a number, which a maximum would drop.
fn largest(numbers: impl Iterator<Item = f64>) -> f64 {
    numbers.fold(0.0, |most, number| match number.is_nan() {
        true => f64::INFINITY,
        false => most.max(number.abs()),
    })
}

impl<T: Number> Factor<T> {
    fn dense(rows: usize) -> (Self, StackReq) {
        let scratch = StackReq::any_of(&[
            partial_pivoting::factor::lu_in_place_scratch::<usize, T>(
                rows,
                rows,
                Par::Seq,
                Spec::default(),
            ),
            partial_pivoting::inverse::inverse_scratch::<usize, T>(rows, Par::Seq),
        ]);
        let factor = Self::Dense {
            matrix: Mat::zeros(rows, rows),
            inverse: Mat::zeros(rows, rows),
            columns: vec![T::of(0.0); rows * rows],
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
            symbolic.factorize_numeric_lu_scratch::<T>(Par::Seq, Spec::default()),
            symbolic.solve_in_place_scratch::<T>(1, Par::Seq),
        ]);
        let factor = Self::Sparse {
            symbolic: Box::new(symbolic),
            numeric: Box::new(NumericLu::new()),
        };
        Some((factor, scratch))
    }

    fn compute(&mut self, entries: SparseColMatRef<'_, usize, T>, stack: &mut MemStack) -> bool {
        match self {
            Self::Dense {
                matrix,
                inverse,
                columns,
                permutation: [forward, backward],
            } => {
                let rows = matrix.nrows();
                matrix.fill(T::of(0.0));
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
                columns.iter().all(nalgebra::ComplexField::is_finite)
            }
            Self::Sparse { symbolic, numeric } => symbolic
                .factorize_numeric_lu(numeric, entries, Par::Seq, stack, Spec::default())
                .is_ok(),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
mod tests;
