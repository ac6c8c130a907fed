//! Sparse factorizations of `K + σ M` (Cholesky, for solving) and `K - μ M` (LDLᵀ, for counting eigenvalues) over one
//! symbolic analysis.
//!
//! The order is nested dissection on the nodes ([`crate::ordering`]), the numbers are made by [`crate::multifrontal`].

use std::sync::atomic::{AtomicU64, Ordering};

use dcb_formats::SparseMatrix;
use faer::MatMut;

use crate::error::Error;
pub use crate::multifrontal::NotPositive;
use crate::multifrontal::{Cholesky, Fronts, Indefinite, Matrix, eliminate, solve_columns};
use crate::ordering::{QuotientGraph, nested_dissection};

/// Right-hand sides solved together: one or two of the widest registers.
const FEW_COLUMNS: usize = 8;
const MANY_COLUMNS: usize = 16;

/// The pattern of `K + σ M` analysed once, with room for one factor.
pub struct SymmetricFactor {
    fronts: Fronts,
    values: Vec<f64>,
    solves: Solves,
}

/// Solutions made with the factors of one analysis.
#[derive(Debug, Default)]
struct Solves {
    columns: AtomicU64,
    passes: AtomicU64,
}

impl Solves {
    /// One pass over the factor for `columns` right-hand sides.
    fn count(&self, columns: usize) {
        self.columns.fetch_add(columns as u64, Ordering::Relaxed);
        self.passes.fetch_add(1, Ordering::Relaxed);
    }
}

/// `K + σ M = L Lᵀ`, ready to solve.
pub struct PositiveFactor<'a> {
    fronts: &'a Fronts,
    values: &'a [f64],
    solves: &'a Solves,
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

impl SymmetricFactor {
    /// Orders and analyses the union of the patterns of two symmetric matrices in full storage; rows of the same
    /// `group` (a node) are kept together.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] if the factor doesn't fit the machine.
    pub fn analyse(
        stiffness: &SparseMatrix,
        mass: &SparseMatrix,
        groups: &[u32],
    ) -> Result<Self, Error> {
        let graph = QuotientGraph::of_points(&[stiffness, mass], groups);
        let fronts = Fronts::analyse(&graph, &nested_dissection(&graph));
        Ok(Self {
            fronts,
            values: Vec::new(),
            solves: Solves::default(),
        })
    }

    /// Number of stored entries of the factor, padding included.
    pub fn stored_entries(&self) -> usize {
        self.fronts.stored_entries()
    }

    /// Number of entries of the factor's lower triangle, padding of the fronts included.
    pub fn factor_entries(&self) -> usize {
        self.fronts.factor_entries()
    }

    /// Memory of the stored factor.
    pub fn stored_bytes(&self) -> usize {
        size_of_val(self.values.as_slice())
    }

    /// Floating-point operations of a factorization.
    pub fn flops(&self) -> f64 {
        self.fronts.flops()
    }

    /// Columns solved so far, by all factors together.
    pub fn solve_columns(&self) -> u64 {
        self.solves.columns.load(Ordering::Relaxed)
    }

    /// Passes over the factor so far: one forward and one backward sweep for a block of up to 16 columns.
    pub fn solve_passes(&self) -> u64 {
        self.solves.passes.load(Ordering::Relaxed)
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
        let matrix = Matrix {
            stiffness,
            mass,
            shift,
        };
        if self.values.is_empty() {
            self.values = vec![0.0; self.fronts.stored_entries()];
        }
        eliminate(
            &self.fronts,
            matrix,
            &Cholesky::<f64>::default(),
            &mut self.values,
        )?;
        Ok(PositiveFactor {
            fronts: &self.fronts,
            values: &self.values,
            solves: &self.solves,
        })
    }

    /// Counts the negative eigenvalues of `K - shift · M`, which are the eigenvalues of the pencil below `shift`
    /// (Sylvester), by a factorization with pivoting inside supernodes. Leaves the factor as it is.
    pub fn inertia(&self, stiffness: &SparseMatrix, mass: &SparseMatrix, shift: f64) -> Inertia {
        let matrix = Matrix {
            stiffness,
            mass,
            shift: -shift,
        };
        let Ok(signs) = eliminate(&self.fronts, matrix, &Indefinite, &mut []) else {
            return Inertia {
                negative: 0,
                zero: stiffness.ncols(),
                negative_dofs: Vec::new(),
            };
        };
        Inertia {
            negative: signs.negative,
            zero: signs.zero,
            negative_dofs: signs
                .negative_positions
                .iter()
                .map(|position| self.fronts.forward[*position] as usize)
                .collect(),
        }
    }
}

impl PositiveFactor<'_> {
    /// Replaces every column of `block` by the solution for it.
    pub fn solve_in_place(&self, block: MatMut<'_, f64>) {
        let mut rest = block;
        while rest.ncols() > 0 {
            let few = rest.ncols() <= FEW_COLUMNS;
            let width = if few {
                rest.ncols()
            } else {
                MANY_COLUMNS.min(rest.ncols())
            };
            let (columns, after) = rest.split_at_col_mut(width);
            self.solves.count(width);
            if few {
                solve_columns::<f64, FEW_COLUMNS>(self.fronts, self.values, columns);
            } else {
                solve_columns::<f64, MANY_COLUMNS>(self.fronts, self.values, columns);
            }
            rest = after;
        }
    }
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
        let factor = SymmetricFactor::analyse(&stiffness, &mass, &groups).unwrap();
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
        assert_eq!((factor.solve_columns(), factor.solve_passes()), (19, 2));
        let product = crate::block_algebra::symmetric_product(&stiffness, x.as_ref())
            + faer::Scale(0.01) * crate::block_algebra::symmetric_product(&mass, x.as_ref());
        assert!(crate::block_algebra::largest_entry((&product - &rhs).as_ref()) < 1e-11);
        // Below the lowest eigenvalue the matrix is indefinite and says so.
        assert!(factor.factorize(&stiffness, &mass, -1.0).is_err());
    }
}
