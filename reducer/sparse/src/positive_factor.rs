//! A Cholesky factor of `K + σ M` and the solutions made with it.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use faer::MatMut;

use crate::Error;
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

/// The entries of a factor.
pub(crate) enum Entries<'a> {
    /// In this process.
    Here {
        fronts: &'a Fronts,
        values: &'a FactorValues,
    },
    /// In other processes.
    #[cfg(feature = "ranks")]
    OnRanks(&'a crate::ranks::Ranks),
}

/// `K + σ M = L Lᵀ`, ready to solve.
pub struct PositiveFactor<'a> {
    pub(crate) entries: Entries<'a>,
    pub(crate) solves: &'a Solves,
    pub(crate) refinement: Option<Refinement<'a>>,
    pub(crate) least_accurate: Mutex<Refined>,
}

impl PositiveFactor<'_> {
    /// Replaces every column of `block` by the solution for it.
    ///
    /// # Errors
    /// [`Error::Ranks`] or [`Error::File`] if other processes hold the factor and don't answer.
    pub fn solve_in_place(&self, block: MatMut<'_, f64>) -> Result<(), Error> {
        let mut rest = block;
        while rest.ncols() > 0 {
            let width = MANY_COLUMNS.min(rest.ncols());
            let (columns, after) = rest.split_at_col_mut(width);
            self.solves.count(width);
            match &self.entries {
                Entries::Here { fronts, values } => self.solve_here(fronts, values, columns),
                #[cfg(feature = "ranks")]
                Entries::OnRanks(ranks) => ranks.solve_in_place(columns)?,
            }
            rest = after;
        }
        Ok(())
    }

    /// At most [`MANY_COLUMNS`] columns.
    fn solve_here(&self, fronts: &Fronts, values: &FactorValues, columns: MatMut<'_, f64>) {
        match (values, &self.refinement) {
            (FactorValues::Double(values), _) => solve(fronts, values, columns),
            (FactorValues::Single(values), None) => solve(fronts, values, columns),
            (FactorValues::Single(values), Some(refinement)) => {
                let refined = refinement.solve_in_place(columns, |x| solve(fronts, values, x));
                self.note(refined);
            }
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

/// At most [`MANY_COLUMNS`] columns.
fn solve<T: Real>(fronts: &Fronts, values: &[T], columns: MatMut<'_, f64>) {
    match columns.ncols() {
        count if count <= FEW_COLUMNS => solve_columns::<T, FEW_COLUMNS>(fronts, values, columns),
        count if count <= SOME_COLUMNS => solve_columns::<T, SOME_COLUMNS>(fronts, values, columns),
        _ => solve_columns::<T, MANY_COLUMNS>(fronts, values, columns),
    }
}
