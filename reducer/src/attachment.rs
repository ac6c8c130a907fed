//! Attachment columns: K X = P' L_bᵀ in the complement of the rigid and kept motions.
//!
//! They come from the one factorization of K + σ M by conjugate gradients, for which that factor is an almost exact
//! preconditioner: the condition number is 1 + σ/ω²_{k+1}, with ω²_{k+1} the lowest eigenvalue that is not kept. P' has taken the
//! kept modes out of the forces, so that they don't come back; only motions without stiffness are projected out on
//! the way, because the factor enlarges what rounding leaves of them. The columns are solved in blocks: nothing but X itself is ever as wide as L_bᵀ.

use faer::{Mat, MatRef};
use rayon::prelude::*;

use crate::block_algebra::{
    absolute_product, add_combination, column_dots, combination, gram, symmetric_product,
};
use crate::column_products::{BLOCK, StiffnessProducts};
use crate::condensation::Model;
use crate::factorization::PositiveFactor;
use crate::free_modes::FreeModes;
use crate::localization::Localization;
use crate::observer::Observer;
use crate::rigid_body::RigidBodyModes;

/// Relative residual of the attachment columns that is aimed at.
const RESIDUAL_AIM: f64 = 1e-13;
/// Relative residual above which the columns are refused, where double precision can tell that much.
pub const RESIDUAL_LIMIT: f64 = 1e-8;
/// Otherwise the residual may be this many times the rounding in K x itself, ε ‖|K| |x|‖ / ‖f‖ (slender and thin parts).
const RESIDUAL_OVER_ROUNDING: f64 = 10.0;
/// Sweeps of refinement and iterations in each.
const SWEEPS: usize = 6;
const ITERATIONS_PER_SWEEP: usize = 60;
/// Share of kept modes in an attachment column that is left there.
const MODE_CONTENT: f64 = 1e-10;
/// A force of which less than this fraction is left after its rigid and kept parts are removed is rounding.
const INERT_FORCE: f64 = 1e-12;

/// Projectors onto the complement of some motions.
struct Complement<'a> {
    shapes: MatRef<'a, f64>,
    mass_shapes: MatRef<'a, f64>,
}

impl Complement<'_> {
    /// x -= Φₐ (M Φₐ)ᵀ x
    fn project_motion(&self, x: &mut Mat<f64>) {
        let amounts = gram(self.mass_shapes, x.as_ref());
        add_combination(x.as_mut(), self.shapes, amounts.as_ref(), -1.0);
    }

    /// f -= M Φₐ Φₐᵀ f
    fn project_force(&self, f: &mut Mat<f64>) {
        let amounts = gram(self.shapes, f.as_ref());
        add_combination(f.as_mut(), self.mass_shapes, amounts.as_ref(), -1.0);
    }
}

/// K X = P' L_bᵀ, to be solved or to be checked.
pub struct AttachmentProblem<'a> {
    model: &'a Model<'a>,
    localization: &'a Localization,
    rigid: Complement<'a>,
    kept: Complement<'a>,
    /// Kept modes without stiffness.
    loose: Complement<'a>,
    /// Relative precision of the stiffness entries.
    precision: f64,
    /// Weight of each dof in norms: moments count over the part's size, so that norms have one unit.
    weights: Vec<f64>,
}

/// Some columns of P' L_bᵀ: what the interface forces do beyond moving the part as the rigid and kept motions.
struct Forces {
    columns: Mat<f64>,
    norms: Vec<f64>,
    inert: Vec<bool>,
    spent: Vec<bool>,
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

/// What an attachment column leaves of its equation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorstColumn {
    /// Its row of L_b.
    pub row: usize,
    /// ‖K x - f‖ / ‖f‖.
    pub residual: f64,
    /// The part of it that rounding in K x explains, ε ‖|K| |x|‖ / ‖f‖.
    pub rounding: f64,
}

impl<'a> AttachmentProblem<'a> {
    /// The problem of a model, its interfaces and the modes that are kept.
    pub fn new(
        model: &'a Model,
        localization: &'a Localization,
        rigid: &'a RigidBodyModes,
        modes: &'a FreeModes,
    ) -> Self {
        let weights = model
            .dofs
            .iter()
            .map(|dof| match dof.direction.is_rotation() {
                true => 1.0 / rigid.length,
                false => 1.0,
            })
            .collect();
        Self {
            model,
            localization,
            rigid: Complement {
                shapes: rigid.shapes.as_ref(),
                mass_shapes: rigid.mass_shapes.as_ref(),
            },
            kept: Complement {
                shapes: modes.shapes.as_ref(),
                mass_shapes: modes.mass_shapes.as_ref(),
            },
            loose: Complement {
                shapes: modes.shapes.as_ref().subcols(0, modes.zero_count),
                mass_shapes: modes.mass_shapes.as_ref().subcols(0, modes.zero_count),
            },
            precision: rigid.stiffness_precision,
            weights,
        }
    }

    /// Columns of P' L_bᵀ. What is left of a force at rounding level must not pass for a direction of its own: it is zero.
    fn forces(&self, first: usize, count: usize) -> Forces {
        let mut columns = self
            .localization
            .attachment_columns(self.model.len(), first..first + count);
        let whole = self.norms(columns.as_ref());
        let rounding_alone = |norms: &[f64]| -> Vec<bool> {
            let pairs = norms.iter().zip(&whole);
            pairs
                .map(|(left, whole)| *left <= INERT_FORCE * whole)
                .collect()
        };
        for _ in 0..2 {
            self.rigid.project_force(&mut columns);
        }
        let inert = rounding_alone(&self.norms(columns.as_ref()));
        for _ in 0..2 {
            self.kept.project_force(&mut columns);
            self.rigid.project_force(&mut columns);
        }
        let mut norms = self.norms(columns.as_ref());
        let spent = rounding_alone(&norms);
        for (j, _) in spent.iter().enumerate().filter(|(_, spent)| **spent) {
            columns.as_mut().col_mut(j).fill(0.0);
            norms[j] = 0.0;
        }
        Forces {
            columns,
            norms,
            inert,
            spent,
        }
    }

    /// Solves for all columns, block by block.
    pub fn solve(&self, factor: &PositiveFactor, observer: &mut dyn Observer) -> SolvedColumns {
        let columns = Mat::zeros(self.model.len(), self.localization.len());
        self.by_blocks(columns, |forces, block, share| {
            observer.progress(share);
            self.solve_block(factor, forces, block)
        })
    }

    /// How well given columns X solve K X = P' L_bᵀ.
    pub fn judge(&self, columns: Mat<f64>) -> SolvedColumns {
        self.by_blocks(columns, |_, _, _| 0)
    }

    /// Improves the columns block by block, and evaluates what they leave and what follows from K X.
    fn by_blocks(
        &self,
        mut columns: Mat<f64>,
        mut improve: impl FnMut(&Forces, &mut Mat<f64>, f64) -> usize,
    ) -> SolvedColumns {
        let n_b = columns.ncols();
        let mut stiffness = StiffnessProducts::empty(self.kept.shapes.ncols(), n_b);
        let (mut inert, mut spent) = (Vec::new(), Vec::new());
        let mut residuals = Vec::with_capacity(n_b);
        let mut norms = Vec::with_capacity(n_b);
        let mut iterations = 0;
        for first in (0..n_b).step_by(BLOCK) {
            let count = BLOCK.min(n_b - first);
            let forces = self.forces(first, count);
            let mut block = columns.as_ref().subcols(first, count).to_owned();
            iterations = iterations.max(improve(&forces, &mut block, first as f64 / n_b as f64));
            columns.as_mut().subcols_mut(first, count).copy_from(&block);
            let product = symmetric_product(&self.model.stiffness, block.as_ref());
            let known = columns.as_ref().subcols(0, first + count);
            stiffness.add(self.kept.shapes, known, first, product.as_ref());
            let left = self.remainder(&forces, product);
            residuals.extend(relative(&self.norms(left.as_ref()), &forces.norms));
            norms.extend(forces.norms);
            inert.extend(forces.inert);
            spent.extend(forces.spent);
        }
        let worst = self.worst(&columns, &residuals, &norms);
        SolvedColumns {
            columns,
            stiffness,
            inert,
            spent,
            iterations,
            worst,
        }
    }

    /// f - K x without its rigid part, which no x can change.
    fn remainder(&self, forces: &Forces, product: Mat<f64>) -> Mat<f64> {
        let mut left = product;
        left.par_col_iter_mut()
            .zip(forces.columns.par_col_iter())
            .for_each(|(left, forces)| {
                for (left, force) in left.iter_mut().zip(forces.iter()) {
                    *left = force - *left;
                }
            });
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
            let mut block = Mat::zeros(columns.nrows(), asked.len());
            for (to, from) in asked.iter().enumerate() {
                block.as_mut().col_mut(to).copy_from(columns.col(*from));
            }
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

    /// Refinement sweeps around preconditioned conjugate gradients; returns the iterations made.
    fn solve_block(&self, factor: &PositiveFactor, forces: &Forces, x: &mut Mat<f64>) -> usize {
        let mut left = forces.columns.clone();
        let mut best: Option<(f64, Mat<f64>)> = None;
        let mut iterations = 0;
        for _ in 0..SWEEPS {
            iterations += self.conjugate_gradients(factor, forces, left, x);
            self.project_motion(x);
            let product = symmetric_product(&self.model.stiffness, x.as_ref());
            left = self.remainder(forces, product);
            let worst = relative(&self.norms(left.as_ref()), &forces.norms)
                .into_iter()
                .fold(0.0, f64::max);
            match &best {
                // What doesn't become much better any more is as good as rounding allows.
                Some((before, better)) if worst > 0.5 * before => {
                    if worst > *before {
                        x.copy_from(better);
                    }
                    break;
                }
                _ if worst <= RESIDUAL_AIM => break,
                _ => best = Some((worst, x.clone())),
            }
        }
        self.remove_kept_modes(x);
        iterations
    }

    /// Takes kept modes out where the columns hold more of them than [`MODE_CONTENT`]. The exact solution has none; but with
    /// modes that rounding leaves a residual, to take them out costs the columns as much of theirs.
    fn remove_kept_modes(&self, x: &mut Mat<f64>) {
        let amounts = gram(self.kept.mass_shapes, x.as_ref());
        let content = combination(self.kept.shapes, amounts.as_ref());
        let shares = relative(&self.norms(content.as_ref()), &self.norms(x.as_ref()));
        if shares.into_iter().any(|share| share > MODE_CONTENT) {
            *x -= content;
        }
    }

    /// Adds to `x` an approximate solution of K dx = r in the complement of the motions without stiffness.
    fn conjugate_gradients(
        &self,
        factor: &PositiveFactor,
        forces: &Forces,
        mut r: Mat<f64>,
        x: &mut Mat<f64>,
    ) -> usize {
        let precondition = |r: &Mat<f64>| {
            let mut z = r.clone();
            factor.solve_in_place(z.as_mut());
            self.project_motion(&mut z);
            z
        };
        let mut p: Mat<f64> = Mat::zeros(0, 0);
        let mut rz = Vec::new();
        for iteration in 0..ITERATIONS_PER_SWEEP {
            let left = relative(&self.norms(r.as_ref()), &forces.norms);
            let open: Vec<bool> = left.iter().map(|left| *left > RESIDUAL_AIM).collect();
            if !open.contains(&true) {
                return iteration;
            }
            let z = precondition(&r);
            let next = column_dots(r.as_ref(), z.as_ref());
            if iteration == 0 {
                p = z;
            } else {
                let momentum: Vec<f64> = next
                    .iter()
                    .zip(&rz)
                    .map(|(next, rz): (&f64, &f64)| if *rz > 0.0 { next / rz } else { 0.0 })
                    .collect();
                let mut direction = z;
                add_scaled(&mut direction, &momentum, &p, 1.0);
                p = direction;
            }
            rz = next;
            let kp = symmetric_product(&self.model.stiffness, p.as_ref());
            let curvature = column_dots(p.as_ref(), kp.as_ref());
            // A finished column stands still: its step is zero.
            let step: Vec<f64> = (0..rz.len())
                .map(|j| match open[j] && rz[j] > 0.0 && curvature[j] > 0.0 {
                    true => rz[j] / curvature[j],
                    false => 0.0,
                })
                .collect();
            add_scaled(x, &step, &p, 1.0);
            add_scaled(&mut r, &step, &kp, -1.0);
            self.project_force(&mut r);
        }
        ITERATIONS_PER_SWEEP
    }

    fn norms(&self, x: MatRef<'_, f64>) -> Vec<f64> {
        weighted_norms(x, &self.weights)
    }
}

/// y += sign · factorⱼ p, column by column.
fn add_scaled(y: &mut Mat<f64>, factors: &[f64], p: &Mat<f64>, sign: f64) {
    y.par_col_iter_mut()
        .zip(p.par_col_iter())
        .zip(factors)
        .for_each(|((y, p), factor)| {
            for (y, p) in y.iter_mut().zip(p.iter()) {
                *y += sign * factor * p;
            }
        });
}

/// Ratios; 0 where there is nothing to divide by.
fn relative(sizes: &[f64], scales: &[f64]) -> Vec<f64> {
    let pairs = sizes.iter().zip(scales);
    pairs
        .map(|(size, scale)| if *scale > 0.0 { size / scale } else { 0.0 })
        .collect()
}

/// What the attachments' residual may be: as small as it should be, or as rounding allows.
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
