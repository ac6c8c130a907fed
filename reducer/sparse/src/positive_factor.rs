//! A Cholesky factor of `K + σ M` and the solutions made with it.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use faer::MatMut;

use crate::factor_store::FactorValues;
use crate::multifrontal::{Fronts, Real, solve_columns};
use crate::refinement::{Refined, Refinement};

/// Right-hand sides solved together. Reading the factor limits the speed for few of them, arithmetic for many.
pub(crate) const FEW_COLUMNS: usize = 8;
const SOME_COLUMNS: usize = 16;
const MANY_COLUMNS: usize = 32;

/// Solutions made with the factors of one analysis.
#[derive(Debug, Default)]
pub(crate) struct Solves {
    pub(crate) columns: AtomicU64,
    pub(crate) passes: AtomicU64,
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
    pub(crate) fronts: &'a Fronts,
    pub(crate) values: &'a FactorValues,
    pub(crate) solves: &'a Solves,
    pub(crate) refinement: Option<Refinement<'a>>,
    pub(crate) least_accurate: Mutex<Refined>,
}

impl PositiveFactor<'_> {
    /// Replaces every column of `block` by the solution for it.
    pub fn solve_in_place(&self, block: MatMut<'_, f64>) {
        let mut rest = block;
        while rest.ncols() > 0 {
            let width = MANY_COLUMNS.min(rest.ncols());
            let (columns, after) = rest.split_at_col_mut(width);
            self.solves.count(width);
            match (self.values, &self.refinement) {
                (FactorValues::Double(values), _) => self.solve(values, columns),
                (FactorValues::Single(values), None) => self.solve(values, columns),
                (FactorValues::Single(values), Some(refinement)) => {
                    let refined = refinement.solve_in_place(columns, |x| self.solve(values, x));
                    self.note(refined);
                }
            }
            rest = after;
        }
    }

    /// At most [`MANY_COLUMNS`] columns.
    fn solve<T: Real>(&self, values: &[T], columns: MatMut<'_, f64>) {
        match columns.ncols() {
            count if count <= FEW_COLUMNS => {
                solve_columns::<T, FEW_COLUMNS>(self.fronts, values, columns);
            }
            count if count <= SOME_COLUMNS => {
                solve_columns::<T, SOME_COLUMNS>(self.fronts, values, columns);
            }
            _ => solve_columns::<T, MANY_COLUMNS>(self.fronts, values, columns),
        }
    }

    fn note(&self, refined: Refined) {
        let mut known = self
            .least_accurate
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        known.include(refined);
    }

    /// Most steps and largest residual of the refinements made with this factor; zeros for one in double precision.
    pub fn least_accurate(&self) -> Refined {
        *self
            .least_accurate
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}
