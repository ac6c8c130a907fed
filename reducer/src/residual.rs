//! Residual flexibility: the static response to unit interface forces that the kept modes leave out.
//!
//! The columns X = G_res L_bᵀ solve K X = P' L_bᵀ with P' = I - M Φₐ Φₐᵀ, Φₐ = [rigid, kept], and Φₐᵀ M X = 0
//! (`docs/theory.md`, mean-axis generalized inverse). They come from the one factorization of K + σ M by conjugate gradients in the
//! complement of Φₐ, where that factor is an almost exact preconditioner: the condition number is 1 + σ/ω²_{k+1}.

use faer::{Mat, MatRef};

use crate::block_algebra::{absolute_product, add_combination, gram, symmetric_product, symmetrized};
use crate::condensation::Model;
use crate::error::Error;
use crate::factorization::PositiveFactor;
use crate::free_modes::FreeModes;
use crate::localization::Localization;
use crate::observer::Observer;
use crate::residual_filter::Filter;
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
/// A row depends on others when less than this fraction of its flexibility is left after they are taken out.
const DEPENDENT_ROW: f64 = 1e-9;

/// G_res L_bᵀ and what follows from it. Rows and columns of output interfaces are zero throughout.
#[derive(Clone, Debug)]
pub struct ResidualFlexibility {
    /// G_res L_bᵀ over the model's dofs, (n_c, n_b).
    pub shapes: Mat<f64>,
    /// M G_res L_bᵀ, (n_c, n_b).
    pub mass_shapes: Mat<f64>,
    /// F_res, (n_b, n_b).
    pub flexibility: Mat<f64>,
    /// M_res, (n_b, n_b).
    pub mass: Mat<f64>,
    /// F_res with no mode kept, (n_b, n_b).
    pub flexibility0: Mat<f64>,
    /// diag(M_res) with no mode kept.
    pub mass_diagonal0: Vec<f64>,
    /// L_b G_res L_bᵀ with output rows; `None` without output interfaces.
    pub output_shapes: Option<Mat<f64>>,
    /// T_r, (n_b, rank).
    pub transform: Mat<f64>,
    /// σ², ascending.
    pub sigma_squared: Vec<f64>,
    /// Directions with residual flexibility but too little mass for the transform: kept statically.
    pub static_directions: usize,
    /// Condition number of the scaled F_res over the directions that it has.
    pub condition: f64,
    /// Number of directions that the scaled F_res has.
    pub flexibility_rank: usize,
    /// Largest relative residual ‖K x - f‖ / ‖f‖ of the columns.
    pub residual: f64,
    /// The part of it that rounding in K x explains, ε ‖|K| |x|‖ / ‖f‖.
    pub residual_rounding: f64,
    /// Preconditioned iterations made.
    pub iterations: usize,
    /// Rows that depend on others, by name.
    pub dependencies: Vec<Dependency>,
}

/// A row of L_b that is a combination of others as far as elastic motion goes.
#[derive(Clone, Debug, PartialEq)]
pub struct Dependency {
    /// The row.
    pub row: String,
    /// The rows that it depends on; empty if it sees no elastic motion at all.
    pub depends_on: Vec<String>,
}

/// Projectors onto the complement of the rigid and kept motions.
struct Complement<'a> {
    shapes: [MatRef<'a, f64>; 2],
    mass_shapes: [MatRef<'a, f64>; 2],
}

impl Complement<'_> {
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

impl ResidualFlexibility {
    /// Solves for the attachment columns and forms F_res, M_res and the transform.
    ///
    /// # Errors
    /// [`Error::AttachmentsNotConverged`], or [`Error::NotPositive`] if F_res has a negative eigenvalue beyond rounding.
    pub fn compute(
        model: &Model,
        localization: &Localization,
        rigid: &RigidBodyModes,
        modes: &FreeModes,
        factor: &PositiveFactor,
        observer: &mut dyn Observer,
    ) -> Result<Self, Error> {
        let complement = Complement {
            shapes: [rigid.shapes.as_ref(), modes.shapes.as_ref()],
            mass_shapes: [rigid.mass_shapes.as_ref(), modes.mass_shapes.as_ref()],
        };
        let weights: Vec<f64> =
            model.dofs.iter().map(|dof| if dof.direction.is_rotation() { 1.0 / rigid.length } else { 1.0 }).collect();
        let mut forces = localization.attachment_columns(model.len());
        // A force that only moves the rigid (or the rigid and kept) motions leaves rounding, which must not pass for a
        // direction of its own.
        let whole = weighted_norms(forces.as_ref(), &weights);
        let is_rounding = |forces: &Mat<f64>| -> Vec<bool> {
            weighted_norms(forces.as_ref(), &weights).iter().zip(&whole).map(|(left, whole)| *left <= INERT_FORCE * whole).collect()
        };
        let rigid_only = Complement {
            shapes: [complement.shapes[0], complement.shapes[0].subcols(0, 0)],
            mass_shapes: [complement.mass_shapes[0], complement.mass_shapes[0].subcols(0, 0)],
        };
        rigid_only.project_force(&mut forces);
        rigid_only.project_force(&mut forces);
        let inert = is_rounding(&forces);
        complement.project_force(&mut forces);
        complement.project_force(&mut forces);
        let spent = is_rounding(&forces);
        for (j, _) in spent.iter().enumerate().filter(|(_, spent)| **spent) {
            forces.as_mut().col_mut(j).fill(0.0);
        }
        let solved = solve_columns(model, &complement, factor, forces, &weights, observer);
        if let Some((row, residual, rounding)) = solved.worst().filter(|(_, r, rounding)| *r > residual_limit(*rounding)) {
            return Err(Error::AttachmentsNotConverged {
                residual,
                iterations: solved.iterations,
                tolerance: residual_limit(rounding),
                row: localization.row_name(row),
            });
        }
        Self::from_columns(model, localization, modes, solved, &inert, &spent)
    }

    fn from_columns(
        model: &Model,
        localization: &Localization,
        modes: &FreeModes,
        solved: SolvedColumns,
        inert: &[bool],
        spent: &[bool],
    ) -> Result<Self, Error> {
        let n_b = localization.len();
        let (residual, residual_rounding) = solved.worst().map_or((0.0, 0.0), |(_, residual, rounding)| (residual, rounding));
        let shapes = solved.columns;
        let mass_shapes = symmetric_product(&model.mass, shapes.as_ref());
        let at_interfaces = localization.apply(shapes.as_ref());
        // Rows that feel elastic motion, and those among them that feel some beyond the kept modes.
        let elastic = |i: usize| localization.is_attachment(i) && !inert[i];
        let attached = |i: usize, j: usize| elastic(i) && elastic(j);
        let open = |i: usize, j: usize| attached(i, j) && !spent[i] && !spent[j];
        let raw = Mat::from_fn(n_b, n_b, |i, j| if open(i, j) { at_interfaces[(i, j)] } else { 0.0 });
        let has_outputs = (0..n_b).any(|row| !localization.is_attachment(row));
        let flexibility = symmetrized(raw.as_ref());
        let mass = symmetrized(gram(shapes.as_ref(), mass_shapes.as_ref()).as_ref());
        // With no mode kept: G = Φ Ω⁻² Φᵀ + G_res over the kept elastic modes.
        let seen = localization.apply(modes.shapes.as_ref());
        let with_modes = |base: &Mat<f64>, power: i32| {
            Mat::from_fn(n_b, n_b, |i, j| {
                let from_modes: f64 = match attached(i, j) {
                    true => (modes.zero_count..modes.count())
                        .map(|k| seen[(i, k)] * seen[(j, k)] / modes.eigenvalues[k].powi(power))
                        .sum(),
                    false => 0.0,
                };
                base[(i, j)] + from_modes
            })
        };
        let (flexibility0, mass0) = (with_modes(&flexibility, 1), with_modes(&mass, 2));
        let mass_diagonal0: Vec<f64> = (0..n_b).map(|i| mass0[(i, i)].max(0.0)).collect();
        let filter = Filter::of(&flexibility, &mass, &flexibility0, &mass0)?;
        Ok(Self {
            shapes,
            mass_shapes,
            mass,
            output_shapes: has_outputs.then_some(at_interfaces),
            dependencies: dependencies(&flexibility0, localization),
            flexibility: filter.flexibility,
            flexibility0,
            mass_diagonal0,
            transform: filter.transform,
            sigma_squared: filter.sigma_squared,
            static_directions: filter.static_directions,
            condition: filter.condition,
            flexibility_rank: filter.flexibility_rank,
            residual,
            residual_rounding,
            iterations: solved.iterations,
        })
    }

    /// Number of attachment coordinates that a reader keeps.
    pub fn rank(&self) -> usize {
        self.sigma_squared.len()
    }
}

struct SolvedColumns {
    columns: Mat<f64>,
    relative_residuals: Vec<f64>,
    roundings: Vec<f64>,
    iterations: usize,
}

impl SolvedColumns {
    /// The column whose residual exceeds its limit most: its number, residual and rounding.
    fn worst(&self) -> Option<(usize, f64, f64)> {
        let columns = self.relative_residuals.iter().zip(&self.roundings).enumerate();
        columns.map(|(j, (residual, rounding))| (j, *residual, *rounding)).max_by(|a, b| {
            let excess = |(_, residual, rounding): &(usize, f64, f64)| residual / residual_limit(*rounding);
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
        .map(|column| column.iter().zip(weights).map(|(value, w)| (value * w) * (value * w)).sum::<f64>().sqrt())
        .collect()
}

fn dots(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Vec<f64> {
    (0..a.ncols()).map(|j| a.col(j).transpose() * b.col(j)).collect()
}

/// Refinement sweeps around preconditioned conjugate gradients, all columns at once.
fn solve_columns(
    model: &Model,
    complement: &Complement,
    factor: &PositiveFactor,
    forces: Mat<f64>,
    weights: &[f64],
    observer: &mut dyn Observer,
) -> SolvedColumns {
    let norms = weighted_norms(forces.as_ref(), weights);
    let relative = |r: MatRef<'_, f64>| -> Vec<f64> {
        let scaled = weighted_norms(r, weights).into_iter().zip(&norms);
        scaled.map(|(r, f)| if *f > 0.0 { r / f } else { 0.0 }).collect()
    };
    let mut columns = Mat::zeros(forces.nrows(), forces.ncols());
    let mut best = columns.clone();
    let mut best_residuals = relative(forces.as_ref());
    let mut iterations = 0;
    for sweep in 0..SWEEPS {
        observer.progress(sweep as f64 / SWEEPS as f64);
        let mut residual = &forces - symmetric_product(&model.stiffness, columns.as_ref());
        complement.project_force(&mut residual);
        let now = relative(residual.as_ref());
        let worst = |r: &[f64]| r.iter().copied().fold(0.0, f64::max);
        let stagnates = sweep > 0 && worst(&now) > 0.5 * worst(&best_residuals);
        if sweep == 0 || worst(&now) < worst(&best_residuals) {
            best.copy_from(&columns);
            best_residuals = now;
        }
        if worst(&best_residuals) <= RESIDUAL_AIM || stagnates {
            break;
        }
        iterations += conjugate_gradients(model, complement, factor, residual, &mut columns);
        complement.project_motion(&mut columns);
        complement.project_motion(&mut columns);
    }
    let roundings = relative(absolute_product(&model.stiffness, best.as_ref()).as_ref());
    let roundings = roundings.into_iter().map(|r| f64::EPSILON * r).collect();
    SolvedColumns { columns: best, relative_residuals: best_residuals, roundings, iterations }
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
            y.as_mut().col_mut(j).iter_mut().zip(source.iter()).for_each(|(y, p)| *y += sign * factor * p);
        }
    };
    let mut z = precondition(&r);
    let mut p = z.clone();
    let mut rz = dots(r.as_ref(), z.as_ref());
    let start = rz.clone();
    let target: f64 = SWEEP_REDUCTION * SWEEP_REDUCTION;
    for iteration in 1..=ITERATIONS_PER_SWEEP {
        let kp = symmetric_product(&model.stiffness, p.as_ref());
        let curvature = dots(p.as_ref(), kp.as_ref());
        // A finished column stands still: its step is zero.
        let step: Vec<f64> = (0..rz.len())
            .map(|j| if rz[j] > target * start[j] && curvature[j] > 0.0 { rz[j] / curvature[j] } else { 0.0 })
            .collect();
        if step.iter().all(|s| *s == 0.0) {
            return iteration - 1;
        }
        add_scaled(x, &step, &p, 1.0);
        add_scaled(&mut r, &step, &kp, -1.0);
        complement.project_force(&mut r);
        z = precondition(&r);
        let next = dots(r.as_ref(), z.as_ref());
        let momentum: Vec<f64> = (0..rz.len()).map(|j| if rz[j] > 0.0 { next[j] / rz[j] } else { 0.0 }).collect();
        let mut direction = z.clone();
        add_scaled(&mut direction, &momentum, &p, 1.0);
        p = direction;
        rz = next;
    }
    ITERATIONS_PER_SWEEP
}

/// Rows that are combinations of others: Cholesky with pivoting on the scaled static flexibility, largest remainder first.
fn dependencies(flexibility0: &Mat<f64>, localization: &Localization) -> Vec<Dependency> {
    let n_b = flexibility0.nrows();
    let attached: Vec<usize> = (0..n_b).filter(|row| localization.is_attachment(*row)).collect();
    let largest = attached.iter().map(|i| flexibility0[(*i, *i)]).fold(0.0, f64::max);
    let mut found = Vec::new();
    let scale = |i: usize| flexibility0[(i, i)].max(0.0).sqrt();
    let (mut open, inert): (Vec<usize>, Vec<usize>) =
        attached.iter().partition(|i| flexibility0[(**i, **i)] > 1e-24 * largest && scale(**i) > 0.0);
    for row in inert {
        found.push(Dependency { row: localization.row_name(row), depends_on: Vec::new() });
    }
    // Remaining part of each row, as coefficients over the pivots' orthonormal directions.
    let mut parts: Vec<Vec<f64>> = vec![Vec::new(); n_b];
    let mut pivots: Vec<usize> = Vec::new();
    let left = |parts: &[Vec<f64>], i: usize| 1.0 - parts[i].iter().map(|p| p * p).sum::<f64>();
    while let Some(position) = (0..open.len()).max_by(|a, b| {
        left(&parts, open[*a]).total_cmp(&left(&parts, open[*b])).then(open[*b].cmp(&open[*a]))
    }) {
        let pivot = open[position];
        let remaining = left(&parts, pivot);
        if remaining < DEPENDENT_ROW {
            break;
        }
        open.remove(position);
        for i in open.iter().copied() {
            let cosine = flexibility0[(i, pivot)] / (scale(i) * scale(pivot));
            let known: f64 = parts[i].iter().zip(&parts[pivot]).map(|(a, b)| a * b).sum();
            parts[i].push((cosine - known) / remaining.sqrt());
        }
        parts[pivot].push(remaining.sqrt());
        pivots.push(pivot);
    }
    open.sort_unstable();
    for row in open {
        // Back substitution: row = Σ c_p pivot_p in scaled terms.
        let mut coefficients = vec![0.0; pivots.len()];
        for k in (0..pivots.len()).rev() {
            let later: f64 =
                (k + 1..pivots.len()).map(|l| coefficients[l] * parts[pivots[l]].get(k).copied().unwrap_or(0.0)).sum();
            coefficients[k] = (parts[row][k] - later) / parts[pivots[k]][k];
        }
        let involved = pivots.iter().zip(&coefficients).filter(|(_, c)| c.abs() > 1e-6);
        found.push(Dependency {
            row: localization.row_name(row),
            depends_on: involved.map(|(pivot, _)| localization.row_name(*pivot)).collect(),
        });
    }
    found
}
