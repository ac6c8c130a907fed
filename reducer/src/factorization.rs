//! Sparse factorizations of `K + σ M` (Cholesky, for solving) and `K - μ M` (LBLᵀ, for counting eigenvalues) over one
//! symbolic analysis and one value array.
//!
//! The order is nested dissection on the nodes ([`crate::ordering`]), the numerical kernels are faer's supernodal ones,
//! sequential: one factorization is the same to the last bit whatever the number of threads. Right-hand sides are
//! solved in parallel blocks of fixed width, for the same reason.

use dcb_formats::SparseMatrix;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltError;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use faer::{Conj, MatMut, Par, Side};
use rayon::prelude::*;

use crate::error::Error;
use crate::ordering::{Ordering, QuotientGraph, nested_dissection};

/// Right-hand sides solved together; fixed, so that the kernels see the same shapes whatever the number of threads.
const SOLVE_COLUMNS: usize = 8;

/// The pattern of `K + σ M` analysed once, with room for one factor.
pub struct SymmetricFactor {
    symbolic: SymbolicCholesky<usize>,
    ordering: Ordering,
    values: Vec<f64>,
}

/// `K + σ M = L Lᵀ`, ready to solve.
pub struct PositiveFactor<'a> {
    factor: LltRef<'a, usize, f64>,
}

/// Signs of the pivots of a symmetric matrix; by Sylvester's law those of its eigenvalues.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Inertia {
    /// Number of negative eigenvalues.
    pub negative: usize,
    /// Number of exactly zero pivots; anything but 0 makes the count worthless.
    pub zero: usize,
    /// Original dofs at which the first negative pivots stood (at most [`Inertia::LISTED`]).
    pub negative_dofs: Vec<usize>,
}

impl Inertia {
    /// How many negative pivots are listed by dof.
    pub const LISTED: usize = 8;
}

/// `K + shift · M`, lower triangle, on the union of both patterns; 64-bit indices, because a factor may have more entries
/// than 32 bits count.
fn shifted_lower(
    stiffness: &SparseMatrix,
    mass: &SparseMatrix,
    shift: f64,
) -> SparseColMat<usize, f64> {
    let n = stiffness.ncols();
    let mut starts = Vec::with_capacity(n + 1);
    starts.push(0_usize);
    let capacity = (stiffness.compute_nnz() + n) / 2;
    let (mut rows, mut values) = (Vec::with_capacity(capacity), Vec::with_capacity(capacity));
    for column in 0..n {
        let (k_rows, k_values) = (
            stiffness.row_idx_of_col_raw(column),
            stiffness.val_of_col(column),
        );
        let (m_rows, m_values) = (mass.row_idx_of_col_raw(column), mass.val_of_col(column));
        let mut k = k_rows.partition_point(|row| (*row as usize) < column);
        let mut m = m_rows.partition_point(|row| (*row as usize) < column);
        while k < k_rows.len() || m < m_rows.len() {
            let k_row = k_rows.get(k).copied().unwrap_or(u32::MAX);
            let m_row = m_rows.get(m).copied().unwrap_or(u32::MAX);
            let mut value = 0.0;
            if k_row <= m_row {
                value += k_values[k];
                k += 1;
            }
            if m_row <= k_row {
                value += shift * m_values[m];
                m += 1;
            }
            rows.push(k_row.min(m_row) as usize);
            values.push(value);
        }
        starts.push(rows.len());
    }
    let symbolic = SymbolicSparseColMat::new_checked(n, n, starts, None, rows);
    SparseColMat::new(symbolic, values)
}

impl SymmetricFactor {
    /// Orders and analyses the union of the patterns of two symmetric matrices in full storage; rows of the same
    /// `group` (a node) are kept together.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] if the factor doesn't fit the index type or the machine.
    pub fn analyse(
        stiffness: &SparseMatrix,
        mass: &SparseMatrix,
        groups: &[u32],
    ) -> Result<Self, Error> {
        let graph = QuotientGraph::of_points(&[stiffness, mass], groups);
        let ordering = Ordering::of_dofs(&graph, &nested_dissection(&graph));
        let pattern = shifted_lower(stiffness, mass, 0.0);
        let n = pattern.ncols();
        let wide = |order: &[u32]| -> Vec<usize> { order.iter().map(|i| *i as usize).collect() };
        let (forward, inverse) = (wide(&ordering.forward), wide(&ordering.inverse));
        let permutation = faer::perm::PermRef::new_checked(&forward, &inverse, n);
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let symbolic = factorize_symbolic_cholesky(
            pattern.symbolic(),
            Side::Lower,
            SymmetricOrdering::Custom(permutation),
            parameters,
        )
        .map_err(|_| Error::OutOfMemory {
            what: "the symbolic factorization",
        })?;
        let mut values = Vec::new();
        values
            .try_reserve_exact(symbolic.len_val())
            .map_err(|_| Error::OutOfMemory { what: "the factor" })?;
        values.resize(symbolic.len_val(), 0.0);
        Ok(Self {
            symbolic,
            ordering,
            values,
        })
    }

    /// Number of stored entries of the factor, padding included.
    pub fn stored_entries(&self) -> usize {
        self.values.len()
    }

    /// Factorizes `K + shift · M`.
    ///
    /// # Errors
    /// [`NotPositive`] with the original dof whose pivot was not positive.
    pub fn factorize(
        &mut self,
        stiffness: &SparseMatrix,
        mass: &SparseMatrix,
        shift: f64,
    ) -> Result<PositiveFactor<'_>, NotPositive> {
        let matrix = shifted_lower(stiffness, mass, shift);
        let scratch = self
            .symbolic
            .factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        let mut memory = MemBuffer::new(scratch);
        let factor = self
            .symbolic
            .factorize_numeric_llt(
                &mut self.values,
                matrix.as_ref(),
                Side::Lower,
                Default::default(),
                Par::Seq,
                MemStack::new(&mut memory),
                Default::default(),
            )
            .map_err(|LltError::NonPositivePivot { index }| NotPositive {
                dof: self
                    .ordering
                    .forward
                    .get(index)
                    .map_or(0, |dof| *dof as usize),
            })?;
        Ok(PositiveFactor { factor })
    }

    /// Counts the negative eigenvalues of `K - shift · M`, which are the eigenvalues of the pencil below `shift`
    /// (Sylvester), by a factorization with pivoting inside supernodes. Overwrites the factor.
    pub fn inertia(
        &mut self,
        stiffness: &SparseMatrix,
        mass: &SparseMatrix,
        shift: f64,
    ) -> Inertia {
        let matrix = shifted_lower(stiffness, mass, -shift);
        let n = matrix.ncols();
        let scratch = self
            .symbolic
            .factorize_numeric_intranode_lblt_scratch::<f64>(Par::Seq, Default::default());
        let mut memory = MemBuffer::new(scratch);
        let mut subdiagonal = vec![0.0; n];
        let (mut forward, mut inverse) = (vec![0_usize; n], vec![0_usize; n]);
        self.symbolic.factorize_numeric_intranode_lblt(
            &mut self.values,
            &mut subdiagonal,
            &mut forward,
            &mut inverse,
            matrix.as_ref(),
            Side::Lower,
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        );
        let mut inertia = Inertia {
            negative: 0,
            zero: 0,
            negative_dofs: Vec::new(),
        };
        let mut count = |pivot: f64, position: usize| {
            if pivot < 0.0 {
                inertia.negative += 1;
                if inertia.negative_dofs.len() < Inertia::LISTED {
                    inertia
                        .negative_dofs
                        .push(self.ordering.forward[forward[position]] as usize);
                }
            } else if pivot.is_nan() || pivot == 0.0 {
                inertia.zero += 1;
            }
        };
        let SymbolicCholeskyRaw::Supernodal(supernodes) = self.symbolic.raw() else {
            // The analysis forces the supernodal variant; if it ever didn't, the count would be worthless.
            return Inertia {
                negative: 0,
                zero: n,
                negative_dofs: Vec::new(),
            };
        };
        for s in 0..supernodes.n_supernodes() {
            let begin = supernodes.supernode_begin()[s];
            let columns = supernodes.supernode_end()[s] - begin;
            let first_value = supernodes.col_ptr_for_val()[s];
            let rows = (supernodes.col_ptr_for_val()[s + 1] - first_value) / columns.max(1);
            let diagonal = |j: usize| self.values[first_value + j * rows + j];
            let mut j = 0;
            while j < columns {
                let below = subdiagonal[begin + j];
                if below == 0.0 {
                    count(diagonal(j), begin + j);
                    j += 1;
                } else {
                    // A 2x2 pivot [[a, b], [b, c]]: the signs of its eigenvalues from its determinant and trace.
                    let (a, c) = (diagonal(j), diagonal(j + 1));
                    let determinant = a * c - below * below;
                    let trace = a + c;
                    let (first, second) = if determinant < 0.0 {
                        (1.0, -1.0)
                    } else {
                        (trace, determinant * trace)
                    };
                    count(first, begin + j);
                    count(second, begin + j + 1);
                    j += 2;
                }
            }
        }
        inertia
    }
}

impl PositiveFactor<'_> {
    /// Replaces every column of `block` by the solution for it.
    pub fn solve_in_place(&self, block: MatMut<'_, f64>) {
        let scratch = self
            .factor
            .symbolic()
            .solve_in_place_scratch::<f64>(SOLVE_COLUMNS, Par::Seq);
        block.par_col_chunks_mut(SOLVE_COLUMNS).for_each(|columns| {
            let mut memory = MemBuffer::new(scratch);
            self.factor.solve_in_place_with_conj(
                Conj::No,
                columns,
                Par::Seq,
                MemStack::new(&mut memory),
            );
        });
    }
}

/// A pivot of a matrix that should be positive definite was not positive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotPositive {
    /// Original dof of the pivot.
    pub dof: usize,
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use faer::Mat;
    use faer::sparse::Triplet;

    /// Fixed-free chain of `n` unit springs and masses: eigenvalues 4 sin²((2k+1)π/(4n+2)).
    fn chain(n: u32) -> (SparseMatrix, SparseMatrix) {
        let mut k = Vec::new();
        for i in 0..n {
            k.push(Triplet::new(i, i, if i + 1 == n { 1.0 } else { 2.0 }));
            if i > 0 {
                k.push(Triplet::new(i, i - 1, -1.0));
                k.push(Triplet::new(i - 1, i, -1.0));
            }
        }
        let m: Vec<_> = (0..n).map(|i| Triplet::new(i, i, 1.0)).collect();
        let size = n as usize;
        (
            SparseMatrix::try_new_from_triplets(size, size, &k).unwrap(),
            SparseMatrix::try_new_from_triplets(size, size, &m).unwrap(),
        )
    }

    #[test]
    fn inertia_counts_the_eigenvalues_below_the_shift() {
        let n = 200;
        let (stiffness, mass) = chain(n);
        let groups: Vec<u32> = (0..n).collect();
        let mut factor = SymmetricFactor::analyse(&stiffness, &mass, &groups).unwrap();
        let eigenvalue = |k: u32| {
            let angle = f64::from(2 * k + 1) * std::f64::consts::PI / f64::from(4 * n + 2);
            4.0 * angle.sin().powi(2)
        };
        for k in [0, 1, 7, 100, 198] {
            let between = 0.5 * (eigenvalue(k) + eigenvalue(k + 1));
            let inertia = factor.inertia(&stiffness, &mass, between);
            assert_eq!((inertia.negative, inertia.zero), (k as usize + 1, 0));
            assert_eq!(
                inertia.negative_dofs.len(),
                (k as usize + 1).min(Inertia::LISTED)
            );
        }
    }

    #[test]
    fn solutions_satisfy_the_shifted_system() {
        let (stiffness, mass) = chain(500);
        let groups: Vec<u32> = (0..500).map(|i| i / 3).collect();
        let mut factor = SymmetricFactor::analyse(&stiffness, &mass, &groups).unwrap();
        let rhs = Mat::from_fn(500, 19, |i, j| ((i * (j + 1)) as f64).sin());
        let mut x = rhs.clone();
        factor
            .factorize(&stiffness, &mass, 0.01)
            .unwrap()
            .solve_in_place(x.as_mut());
        let product = crate::block_algebra::symmetric_product(&stiffness, x.as_ref())
            + faer::Scale(0.01) * crate::block_algebra::symmetric_product(&mass, x.as_ref());
        assert!(crate::block_algebra::largest_entry((&product - &rhs).as_ref()) < 1e-11);
        // Below the lowest eigenvalue the matrix is indefinite and says so.
        assert!(factor.factorize(&stiffness, &mass, -1.0).is_err());
    }
}
