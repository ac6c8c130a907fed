//! Attachment columns: K X = P' L_bᵀ in the complement of the rigid and kept motions.
//!
//! They come from the one factorization by refinement. On springs (`crate::model::regularization`) one solution mostly reaches rounding. With a
//! shift it leaves about σ/ω²_{k+1}, ω²_{k+1} the lowest eigenvalue that is not kept, so that two do; conjugate gradients with the factor as
//! preconditioner go on where they don't. P' has taken the kept modes out of the forces, so that they don't come back; only
//! motions without stiffness are projected out on the way, because the factor enlarges what rounding leaves of them. The columns are
//! solved in blocks: nothing but X itself is ever as wide as L_bᵀ.

mod complement;
mod iteration;
mod loads;

use std::convert::Infallible;

use dcb_sparse::block_algebra::{
    absolute_product, add_combination, add_scaled_columns, copied, copy, some_columns, zeros,
};
use dcb_sparse::column_products::{BLOCK, StiffnessProducts};
use dcb_sparse::factorization::PositiveFactor;
use faer::reborrow::*;
use faer::{Mat, MatRef};
use rayon::prelude::*;

use crate::error::Error;
use crate::model::condensation::Model;
use crate::model::rigid_body::RigidBodyModes;
use crate::modes::free_modes::FreeModes;
use crate::observer::Observer;

pub use complement::Complement;
use iteration::Solution;
pub use loads::Loads;

/// Relative residual above which the columns are refused, where double precision can tell that much.
pub const RESIDUAL_LIMIT: f64 = 1e-8;
/// Otherwise the residual may be this many times the rounding in K x itself, ε ‖|K| |x|‖ / ‖f‖ (slender and thin parts).
const RESIDUAL_OVER_ROUNDING: f64 = 10.0;
/// A force of which less than this fraction is left after its rigid and kept parts are removed is rounding.
const INERT_FORCE: f64 = 1e-12;

/// K X = P' L_bᵀ, or with other forces in place of L_bᵀ, to be solved or to be checked.
pub struct AttachmentProblem<'a> {
    model: &'a Model<'a>,
    loads: Loads<'a>,
    rigid: Complement<'a>,
    kept: Complement<'a>,
    /// Norms of their shapes.
    kept_norms: Vec<f64>,
    /// Kept modes without stiffness.
    loose: Complement<'a>,
    /// Relative precision of the stiffness entries.
    precision: f64,
    /// Weight of each dof in norms: moments count over the part's size, so that norms have one unit.
    weights: Vec<f64>,
}

/// Some columns of P' L_bᵀ: what the interface forces do beyond moving the part as the rigid and kept motions.
struct ProjectedForces {
    columns: Mat<f64>,
    norms: Vec<f64>,
    inert: Vec<bool>,
    spent: Vec<bool>,
}

impl ProjectedForces {
    /// Some of the columns.
    fn some(&self, columns: &[usize]) -> Self {
        let flags = |of: &[bool]| columns.iter().map(|j| of[*j]).collect();
        Self {
            columns: some_columns(self.columns.as_ref(), columns),
            norms: columns.iter().map(|j| self.norms[*j]).collect(),
            inert: flags(&self.inert),
            spent: flags(&self.spent),
        }
    }
}

/// Attachment columns with what they leave of their equation.
pub struct SolvedColumns {
    /// X, (n_c, n_b).
    pub columns: Mat<f64>,
    /// Xᵀ K X and Φᵀ K X.
    pub stiffness: StiffnessProducts,
    /// Rows whose force only moves the part rigidly.
    pub inert: Vec<bool>,
    /// Rows whose force only excites rigid and kept motions; the inert ones among them.
    pub spent: Vec<bool>,
    /// Preconditioned iterations made, the most of any block.
    pub iterations: usize,
    /// The column whose residual exceeds its limit most; `None` without columns.
    pub worst: Option<WorstColumn>,
}

/// Residual of an attachment column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorstColumn {
    /// Its row of L_b, or its place among the forces.
    pub row: usize,
    /// ‖K x - f‖ / ‖f‖.
    pub residual: f64,
    /// The part of it that rounding in K x explains, ε ‖|K| |x|‖ / ‖f‖.
    pub rounding: f64,
}

impl<'a> AttachmentProblem<'a> {
    /// The problem of a model, forces on it and the modes that are kept.
    pub fn new(
        model: &'a Model,
        loads: Loads<'a>,
        rigid: &'a RigidBodyModes,
        modes: &'a FreeModes,
    ) -> Self {
        let weights = model.unit_amounts(rigid.length);
        Self {
            model,
            loads,
            rigid: Complement::of_rigid(rigid),
            kept: Complement::of_modes(modes),
            loose: Complement::of_loose_modes(modes),
            precision: rigid.stiffness_precision,
            kept_norms: weighted_norms(modes.shapes.as_ref(), &weights),
            weights,
        }
    }

    /// Columns of P' L_bᵀ. What is left of a force at rounding level must not pass for a direction of its own: it is zero.
    fn forces(&self, first: usize, count: usize) -> ProjectedForces {
        let rows = first..first + count;
        let mut columns = self.loads.columns(self.model.len(), rows.clone());
        let whole = self.norms(columns.as_ref());
        let rounding_alone = |norms: &[f64]| -> Vec<bool> {
            let pairs = norms.iter().zip(&whole);
            pairs
                .map(|(left, whole)| *left <= INERT_FORCE * whole)
                .collect()
        };
        // What they do along the kept modes, from their few entries; no rigid motion changes it.
        let along_kept = self.loads.work(self.kept.shapes, rows);
        for _ in 0..2 {
            self.rigid.project_force(&mut columns);
        }
        let inert = rounding_alone(&self.norms(columns.as_ref()));
        add_combination(
            columns.as_mut(),
            self.kept.mass_shapes,
            along_kept.as_ref(),
            -1.0,
        );
        self.rigid.project_force(&mut columns);
        // Again: what rounding left of large parts.
        self.kept.project_force(&mut columns);
        self.rigid.project_force(&mut columns);
        let mut norms = self.norms(columns.as_ref());
        let spent = rounding_alone(&norms);
        for (j, _) in spent.iter().enumerate().filter(|(_, spent)| **spent) {
            columns.as_mut().col_mut(j).fill(0.0);
            norms[j] = 0.0;
        }
        ProjectedForces {
            columns,
            norms,
            inert,
            spent,
        }
    }

    /// P' f: the forces without what moves the part rigidly or as its kept modes, (n_c, n).
    pub fn relieved(&self) -> Mat<f64> {
        self.forces(0, self.loads.len()).columns
    }

    /// Solves for all columns, block by block.
    ///
    /// # Errors
    /// [`Error::Interrupted`], and those of solving.
    pub fn solve(
        &self,
        factor: &PositiveFactor,
        observer: &mut dyn Observer,
    ) -> Result<SolvedColumns, Error> {
        let n_b = self.loads.len();
        let columns = zeros(self.model.len(), n_b);
        self.by_blocks(columns, |forces, first, _| {
            observer.advance(first as f64 / n_b as f64)?;
            self.solve_block(factor, forces)
        })
    }

    /// The error of columns that don't satisfy their equation.
    ///
    /// # Errors
    /// [`Error::AttachmentsNotConverged`] naming the worst.
    pub fn refuse_unconverged(&self, solved: &SolvedColumns) -> Result<(), Error> {
        let refused = solved.worst.filter(|worst| {
            worst.residual.is_nan() || worst.residual > residual_limit(worst.rounding)
        });
        match refused {
            Some(worst) => Err(Error::AttachmentsNotConverged {
                residual: worst.residual,
                iterations: solved.iterations,
                tolerance: residual_limit(worst.rounding),
                row: self.loads.name(worst.row),
            }),
            None => Ok(()),
        }
    }

    /// How well given columns X solve K X = P' L_bᵀ.
    pub fn judge(&self, columns: Mat<f64>) -> SolvedColumns {
        let Ok(judged) = self.by_blocks(columns, |forces, _, x| {
            Ok::<_, Infallible>(self.solution(forces, x.to_owned(), 0))
        });
        judged
    }

    /// Replaces the columns block by block, and evaluates what they leave and what follows from K X.
    fn by_blocks<E>(
        &self,
        mut columns: Mat<f64>,
        mut solve: impl FnMut(&ProjectedForces, usize, MatRef<'_, f64>) -> Result<Solution, E>,
    ) -> Result<SolvedColumns, E> {
        let n_b = columns.ncols();
        let mut stiffness = StiffnessProducts::empty(self.kept.shapes.ncols(), n_b);
        let (mut inert, mut spent) = (Vec::new(), Vec::new());
        let mut residuals = Vec::with_capacity(n_b);
        let mut norms = Vec::with_capacity(n_b);
        let mut iterations = 0;
        for first in (0..n_b).step_by(BLOCK) {
            let count = BLOCK.min(n_b - first);
            let forces = self.forces(first, count);
            let block = columns.as_mut().subcols_mut(first, count);
            let solution = solve(&forces, first, block.rb())?;
            copy(solution.x.as_ref(), block);
            iterations = iterations.max(solution.iterations);
            let known = columns.as_ref().subcols(0, first + count);
            stiffness.add(self.kept.shapes, known, first, solution.product.as_ref());
            residuals.extend(solution.residuals);
            norms.extend(forces.norms);
            inert.extend(forces.inert);
            spent.extend(forces.spent);
        }
        let worst = self.worst(&columns, &residuals, &norms);
        Ok(SolvedColumns {
            columns,
            stiffness,
            inert,
            spent,
            iterations,
            worst,
        })
    }

    /// f - K x without its rigid part, which no x can change.
    fn remainder(&self, forces: &ProjectedForces, product: &Mat<f64>) -> Mat<f64> {
        let mut left = copied(forces.columns.as_ref());
        add_scaled_columns(
            left.as_mut(),
            &vec![-1.0; product.ncols()],
            product.as_ref(),
        );
        self.project_force(&mut left);
        left
    }

    /// Takes the part along motions without stiffness out of forces.
    fn project_force(&self, forces: &mut Mat<f64>) {
        self.rigid.project_force(forces);
        self.loose.project_force(forces);
    }

    /// Takes motions without stiffness out.
    fn project_motion(&self, x: &mut Mat<f64>) {
        self.rigid.project_motion(x);
        self.loose.project_motion(x);
    }

    /// The column whose residual exceeds its limit most. Rounding is evaluated where it matters: for residuals above the limit, and for the
    /// largest one.
    fn worst(&self, columns: &Mat<f64>, residuals: &[f64], norms: &[f64]) -> Option<WorstColumn> {
        let largest =
            (0..residuals.len()).max_by(|a, b| residuals[*a].total_cmp(&residuals[*b]))?;
        let asked: Vec<usize> = (0..residuals.len())
            .filter(|j| *j == largest || residuals[*j] > RESIDUAL_LIMIT)
            .collect();
        let candidates = asked.chunks(BLOCK).flat_map(|asked| {
            let block = some_columns(columns.as_ref(), asked);
            let absolute = absolute_product(&self.model.stiffness, block.as_ref());
            let sizes = self.norms(absolute.as_ref());
            let scales: Vec<f64> = asked.iter().map(|j| norms[*j]).collect();
            let roundings = relative(&sizes, &scales);
            asked
                .iter()
                .zip(roundings)
                .map(|(row, rounding)| WorstColumn {
                    row: *row,
                    residual: residuals[*row],
                    rounding: self.precision * rounding,
                })
                .collect::<Vec<_>>()
        });
        let excess = |column: &WorstColumn| column.residual / residual_limit(column.rounding);
        candidates.max_by(|a, b| excess(a).total_cmp(&excess(b)))
    }

    fn norms(&self, x: MatRef<'_, f64>) -> Vec<f64> {
        weighted_norms(x, &self.weights)
    }
}

/// Ratios; 0 where there is nothing to divide by.
fn relative(sizes: &[f64], scales: &[f64]) -> Vec<f64> {
    let pairs = sizes.iter().zip(scales);
    pairs
        .map(|(size, scale)| if *scale > 0.0 { size / scale } else { 0.0 })
        .collect()
}

/// Limit of the attachments' residual: as small as it should be, or as rounding allows.
pub fn residual_limit(rounding: f64) -> f64 {
    RESIDUAL_LIMIT.max(RESIDUAL_OVER_ROUNDING * rounding)
}

fn weighted_norms(x: MatRef<'_, f64>, weights: &[f64]) -> Vec<f64> {
    x.par_col_iter()
        .map(|column| {
            let weighted = column.iter().zip(weights).map(|(value, w)| value * w);
            weighted.map(|value| value * value).sum::<f64>().sqrt()
        })
        .collect()
}
