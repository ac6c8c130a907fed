//! Attachment columns: K X = P' L_bᵀ in the complement of the rigid and kept motions.
//!
//! They come from the one factorization of K + σ M by conjugate gradients, for which that factor is an almost exact
//! preconditioner: the condition number is 1 + σ/ω²_{k+1}, with ω²_{k+1} the lowest eigenvalue that is not kept.

use faer::{Mat, MatRef};

use crate::block_algebra::{
    absolute_product, add_combination, column_dots, gram, symmetric_product,
};
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
/// Each sweep reduces the residual by this factor before the true residual is taken again.
const SWEEP_REDUCTION: f64 = 1e-7;
/// A force of which less than this fraction is left after its rigid and kept parts are removed is rounding.
const INERT_FORCE: f64 = 1e-12;

/// Projectors onto the complement of the rigid and kept motions.
pub struct Complement<'a> {
    shapes: [MatRef<'a, f64>; 2],
    mass_shapes: [MatRef<'a, f64>; 2],
    /// Relative precision of the stiffness entries.
    precision: f64,
}

impl<'a> Complement<'a> {
    /// The complement of the rigid motions and the kept modes.
    pub fn of(rigid: &'a RigidBodyModes, modes: &'a FreeModes) -> Self {
        Self {
            shapes: [rigid.shapes.as_ref(), modes.shapes.as_ref()],
            mass_shapes: [rigid.mass_shapes.as_ref(), modes.mass_shapes.as_ref()],
            precision: rigid.stiffness_precision,
        }
    }

    /// The complement of the rigid motions alone.
    fn rigid_only(&self) -> Self {
        let none = |shapes: MatRef<'a, f64>| shapes.subcols(0, 0);
        Self {
            shapes: [self.shapes[0], none(self.shapes[0])],
            mass_shapes: [self.mass_shapes[0], none(self.mass_shapes[0])],
            precision: self.precision,
        }
    }

    /// P' (f - K x)
    fn residual(&self, model: &Model, forces: &Mat<f64>, columns: &Mat<f64>) -> Mat<f64> {
        let mut residual = forces - symmetric_product(&model.stiffness, columns.as_ref());
        self.project_force(&mut residual);
        residual
    }

    /// x -= Φₐ (M Φₐ)ᵀ x
    fn project_motion(&self, x: &mut Mat<f64>) {
        for (shapes, mass_shapes) in self.shapes.iter().zip(&self.mass_shapes) {
            let amounts = gram(*mass_shapes, x.as_ref());
            add_combination(x.as_mut(), *shapes, amounts.as_ref(), -1.0);
        }
    }

    /// f -= M Φₐ Φₐᵀ f
    fn project_force(&self, f: &mut Mat<f64>) {
        for (shapes, mass_shapes) in self.shapes.iter().zip(&self.mass_shapes) {
            let amounts = gram(*shapes, f.as_ref());
            add_combination(f.as_mut(), *mass_shapes, amounts.as_ref(), -1.0);
        }
    }
}

/// P' L_bᵀ: what the interface forces do beyond moving the part as the rigid and kept motions.
pub struct AttachmentForces {
    /// Over the model's dofs, (n_c, n_b).
    columns: Mat<f64>,
    /// Rows whose force only moves the part rigidly.
    pub inert: Vec<bool>,
    /// Rows whose force only excites rigid and kept motions; the inert ones among them.
    pub spent: Vec<bool>,
    /// Weight of each dof in norms: moments count over the part's size, so that norms have one unit.
    weights: Vec<f64>,
}

impl AttachmentForces {
    /// Projects L_bᵀ. What is left of a force at rounding level must not pass for a direction of its own: it is zero.
    pub fn of(
        model: &Model,
        localization: &Localization,
        complement: &Complement,
        length: f64,
    ) -> Self {
        let weights: Vec<f64> = model
            .dofs
            .iter()
            .map(|dof| {
                if dof.direction.is_rotation() {
                    1.0 / length
                } else {
                    1.0
                }
            })
            .collect();
        let mut columns = localization.attachment_columns(model.len());
        let whole = weighted_norms(columns.as_ref(), &weights);
        let is_rounding = |columns: &Mat<f64>| -> Vec<bool> {
            let left = weighted_norms(columns.as_ref(), &weights);
            left.iter()
                .zip(&whole)
                .map(|(left, whole)| *left <= INERT_FORCE * whole)
                .collect()
        };
        let rigid = complement.rigid_only();
        for _ in 0..2 {
            rigid.project_force(&mut columns);
        }
        let inert = is_rounding(&columns);
        for _ in 0..2 {
            complement.project_force(&mut columns);
        }
        let spent = is_rounding(&columns);
        for (j, _) in spent.iter().enumerate().filter(|(_, spent)| **spent) {
            columns.as_mut().col_mut(j).fill(0.0);
        }
        Self {
            columns,
            inert,
            spent,
            weights,
        }
    }

    /// How well given columns X solve K X = P' L_bᵀ.
    pub fn judge(
        &self,
        model: &Model,
        complement: &Complement,
        columns: Mat<f64>,
    ) -> SolvedColumns {
        let residual = complement.residual(model, &self.columns, &columns);
        let relative_residuals = self.relative_norms(residual.as_ref());
        let absolute =
            self.relative_norms(absolute_product(&model.stiffness, columns.as_ref()).as_ref());
        let roundings = absolute
            .into_iter()
            .map(|r| complement.precision * r)
            .collect();
        SolvedColumns {
            columns,
            relative_residuals,
            roundings,
            iterations: 0,
        }
    }

    /// Refinement sweeps around preconditioned conjugate gradients, all columns at once.
    pub fn solve(
        &self,
        model: &Model,
        complement: &Complement,
        factor: &PositiveFactor,
        observer: &mut dyn Observer,
    ) -> SolvedColumns {
        let mut columns = Mat::zeros(self.columns.nrows(), self.columns.ncols());
        let mut best = columns.clone();
        let mut best_worst = f64::INFINITY;
        let mut iterations = 0;
        for sweep in 0..SWEEPS {
            observer.progress(sweep as f64 / SWEEPS as f64);
            let residual = complement.residual(model, &self.columns, &columns);
            let worst = self
                .relative_norms(residual.as_ref())
                .into_iter()
                .fold(0.0, f64::max);
            let stagnates = worst > 0.5 * best_worst;
            if worst < best_worst {
                best.copy_from(&columns);
                best_worst = worst;
            }
            if best_worst <= RESIDUAL_AIM || stagnates {
                break;
            }
            iterations += conjugate_gradients(model, complement, factor, residual, &mut columns);
            complement.project_motion(&mut columns);
            complement.project_motion(&mut columns);
        }
        SolvedColumns {
            iterations,
            ..self.judge(model, complement, best)
        }
    }

    /// Norm of each column over that of its force; 0 where there is no force.
    fn relative_norms(&self, r: MatRef<'_, f64>) -> Vec<f64> {
        let forces = weighted_norms(self.columns.as_ref(), &self.weights);
        let pairs = weighted_norms(r, &self.weights).into_iter().zip(forces);
        pairs
            .map(|(r, f)| if f > 0.0 { r / f } else { 0.0 })
            .collect()
    }
}

/// Attachment columns with what they leave of their equation.
pub struct SolvedColumns {
    /// X, (n_c, n_b).
    pub columns: Mat<f64>,
    /// ‖K x - f‖ / ‖f‖ per column.
    pub relative_residuals: Vec<f64>,
    /// The part of it that rounding in K x explains, ε ‖|K| |x|‖ / ‖f‖.
    pub roundings: Vec<f64>,
    /// Preconditioned iterations made.
    pub iterations: usize,
}

impl SolvedColumns {
    /// The column whose residual exceeds its limit most: its number, residual and rounding.
    pub fn worst(&self) -> Option<(usize, f64, f64)> {
        let columns = self
            .relative_residuals
            .iter()
            .zip(&self.roundings)
            .enumerate();
        columns
            .map(|(j, (residual, rounding))| (j, *residual, *rounding))
            .max_by(|a, b| {
                let excess = |(_, residual, rounding): &(usize, f64, f64)| {
                    residual / residual_limit(*rounding)
                };
                excess(a).total_cmp(&excess(b))
            })
    }
}

/// What the attachments' residual may be: as small as it should be, or as rounding allows.
pub fn residual_limit(rounding: f64) -> f64 {
    RESIDUAL_LIMIT.max(RESIDUAL_OVER_ROUNDING * rounding)
}

fn weighted_norms(x: MatRef<'_, f64>, weights: &[f64]) -> Vec<f64> {
    x.col_iter()
        .map(|column| {
            column
                .iter()
                .zip(weights)
                .map(|(value, w)| (value * w) * (value * w))
                .sum::<f64>()
                .sqrt()
        })
        .collect()
}

/// Adds to `x` an approximate solution of K dx = r in the complement; returns the iterations made.
fn conjugate_gradients(
    model: &Model,
    complement: &Complement,
    factor: &PositiveFactor,
    mut r: Mat<f64>,
    x: &mut Mat<f64>,
) -> usize {
    let precondition = |r: &Mat<f64>| {
        let mut z = r.clone();
        factor.solve_in_place(z.as_mut());
        complement.project_motion(&mut z);
        z
    };
    let add_scaled = |y: &mut Mat<f64>, factors: &[f64], p: &Mat<f64>, sign: f64| {
        for (j, factor) in factors.iter().enumerate() {
            let source = p.col(j);
            y.as_mut()
                .col_mut(j)
                .iter_mut()
                .zip(source.iter())
                .for_each(|(y, p)| *y += sign * factor * p);
        }
    };
    let mut z = precondition(&r);
    let mut p = z.clone();
    let mut rz = column_dots(r.as_ref(), z.as_ref());
    let start = rz.clone();
    let target: f64 = SWEEP_REDUCTION * SWEEP_REDUCTION;
    for iteration in 1..=ITERATIONS_PER_SWEEP {
        let kp = symmetric_product(&model.stiffness, p.as_ref());
        let curvature = column_dots(p.as_ref(), kp.as_ref());
        // A finished column stands still: its step is zero.
        let step: Vec<f64> = (0..rz.len())
            .map(|j| {
                if rz[j] > target * start[j] && curvature[j] > 0.0 {
                    rz[j] / curvature[j]
                } else {
                    0.0
                }
            })
            .collect();
        if step.iter().all(|s| *s == 0.0) {
            return iteration - 1;
        }
        add_scaled(x, &step, &p, 1.0);
        add_scaled(&mut r, &step, &kp, -1.0);
        complement.project_force(&mut r);
        z = precondition(&r);
        let next = column_dots(r.as_ref(), z.as_ref());
        let momentum: Vec<f64> = (0..rz.len())
            .map(|j| if rz[j] > 0.0 { next[j] / rz[j] } else { 0.0 })
            .collect();
        let mut direction = z.clone();
        add_scaled(&mut direction, &momentum, &p, 1.0);
        p = direction;
        rz = next;
    }
    ITERATIONS_PER_SWEEP
}
