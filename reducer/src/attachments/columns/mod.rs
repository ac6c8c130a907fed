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
mod postponed;
mod solved;

use dcb_sparse::block_algebra::{
    absolute_product, add_combination, add_scaled_columns, copied, some_columns, zeros,
};
use dcb_sparse::column_products::BLOCK;
use dcb_sparse::factorization::PositiveFactor;
use faer::{Mat, MatRef, concat};
use rayon::prelude::*;

use crate::error::Error;
use crate::model::condensation::Model;
use crate::model::rigid_body::RigidBodyModes;
use crate::modes::free_modes::FreeModes;
use crate::observer::Observer;

pub use complement::Complement;
pub use loads::Loads;
use postponed::Postponed;
use solved::Collected;
pub use solved::SolvedColumns;

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
    /// Norms of their shapes φ, and of M φ.
    kept_norms: Vec<f64>,
    kept_force_norms: Vec<f64>,
    /// ω², (rad/s)².
    kept_eigenvalues: &'a [f64],
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

    /// Takes further columns in.
    fn extend(&mut self, by: Self) {
        self.columns = concat![[self.columns, by.columns]];
        self.norms.extend(by.norms);
        self.inert.extend(by.inert);
        self.spent.extend(by.spent);
    }
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
            kept_force_norms: weighted_norms(modes.mass_shapes.as_ref(), &weights),
            kept_eigenvalues: &modes.eigenvalues,
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

    /// Solves for all columns, block by block. Columns that one solution doesn't suffice for wait until there is a block of them.
    ///
    /// # Errors
    /// [`Error::Interrupted`], and those of solving.
    pub fn solve(
        &self,
        factor: &PositiveFactor,
        observer: &mut dyn Observer,
    ) -> Result<SolvedColumns, Error> {
        let n_b = self.loads.len();
        let mut collected = Collected::new(self, zeros(self.model.len(), n_b));
        let mut postponed = Postponed::default();
        for first in (0..n_b).step_by(BLOCK) {
            observer.advance(first as f64 / n_b as f64)?;
            let forces = self.forces(first, BLOCK.min(n_b - first));
            let solution = self.first_solution(factor, &forces)?;
            let open = solution.open();
            let rows: Vec<usize> = open.iter().map(|j| first + j).collect();
            let waiting = forces.some(&open);
            let solution = self.without_kept_modes(&forces, solution);
            collected.enter(forces, solution);
            if postponed.len() + rows.len() > BLOCK {
                self.refine(factor, std::mem::take(&mut postponed), &mut collected)?;
            }
            postponed.extend(rows, waiting);
        }
        self.refine(factor, postponed, &mut collected)?;
        Ok(collected.finish())
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
        let n_b = self.loads.len();
        let mut collected = Collected::new(self, columns);
        for first in (0..n_b).step_by(BLOCK) {
            let rows: Vec<usize> = (first..n_b.min(first + BLOCK)).collect();
            let forces = self.forces(first, rows.len());
            let solution = self.solution(&forces, collected.some(&rows), 0);
            collected.enter(forces, solution);
        }
        collected.finish()
    }

    /// Refines the columns that were put off, and enters them anew.
    fn refine(
        &self,
        factor: &PositiveFactor,
        postponed: Postponed,
        collected: &mut Collected,
    ) -> Result<(), Error> {
        let Some((rows, forces)) = postponed.columns else {
            return Ok(());
        };
        let begun = self.solution(&forces, collected.some(&rows), 1);
        collected.replace(&rows, self.refined(factor, &forces, begun)?);
        Ok(())
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

    /// The part of relative residuals that rounding in K x explains, ε ‖|K| |x|‖ / ‖f‖, with the norms ‖f‖ of the forces.
    fn roundings(&self, columns: &Mat<f64>, norms: &[f64]) -> Vec<f64> {
        let absolute = absolute_product(&self.model.stiffness, columns.as_ref());
        let sizes = relative(&self.norms(absolute.as_ref()), norms);
        sizes.iter().map(|size| self.precision * size).collect()
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
