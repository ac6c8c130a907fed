//! One block of attachment columns: refinement with the factor of K + σ M, and conjugate gradients where that is slow.

use dcb_sparse::block_algebra::{
    add_combination, add_scaled_columns, column_dots, copied, gram, set_columns, some_columns,
    symmetric_product, zeros,
};
use dcb_sparse::factorization::PositiveFactor;
use faer::Mat;

use super::{AttachmentProblem, ProjectedForces, relative};

use crate::error::Error;

/// Relative residual of the attachment columns that is aimed at.
const RESIDUAL_AIM: f64 = 1e-12;
/// Sweeps of refinement and iterations in each.
const SWEEPS: usize = 6;
const ITERATIONS_PER_SWEEP: usize = 60;
/// A sweep with the factor that leaves less than this share of a residual is followed by another one.
const FAST: f64 = 1e-2;
/// Share of kept modes in an attachment column that is always left there, and that is left where taking it out costs accuracy.
const MODE_CONTENT: f64 = 1e-10;
const LARGEST_MODE_CONTENT: f64 = 2e-9;
/// Relative residual that columns without kept modes may have.
const CLEANED_RESIDUAL: f64 = 1e-12;

/// A block of columns on the way.
pub struct Solution {
    pub x: Mat<f64>,
    /// K x.
    pub product: Mat<f64>,
    /// Residual forces; before anything was solved all forces are, and not held here.
    pub left: Mat<f64>,
    /// Its norm over that of the forces.
    pub residuals: Vec<f64>,
    pub iterations: usize,
}

impl Solution {
    /// Columns whose residuals are above the aim, or no numbers.
    fn open(&self) -> Vec<usize> {
        let is_open = |j: &usize| self.residuals[*j].is_nan() || self.residuals[*j] > RESIDUAL_AIM;
        (0..self.residuals.len()).filter(is_open).collect()
    }

    /// Whether any column is more than zero.
    fn is_begun(&self) -> bool {
        self.product.ncols() > 0
    }

    /// The largest residual; one that is no number is larger than any other.
    fn worst(&self) -> f64 {
        let largest = self.residuals.iter().copied().max_by(f64::total_cmp);
        largest.unwrap_or(0.0)
    }

    /// Takes over some columns, in this order those of another solution.
    fn replace(&mut self, columns: &[usize], by: Self) {
        if columns.len() == self.residuals.len() {
            *self = by;
            return;
        }
        if !self.is_begun() {
            // What isn't open at first has no force.
            let nothing = || zeros(by.x.nrows(), self.residuals.len());
            (self.x, self.product, self.left) = (nothing(), nothing(), nothing());
        }
        let pairs = [
            (&mut self.x, &by.x),
            (&mut self.product, &by.product),
            (&mut self.left, &by.left),
        ];
        for (to, from) in pairs {
            set_columns(to.as_mut(), columns, from.as_ref());
        }
        for (place, residual) in columns.iter().zip(by.residuals) {
            self.residuals[*place] = residual;
        }
    }
}

/// How residuals are made smaller.
#[derive(Clone, Copy)]
enum Sweep {
    /// One solution with the factor of K + σ M.
    Factor,
    /// Conjugate gradients with that factor as preconditioner.
    ConjugateGradients,
}

impl AttachmentProblem<'_> {
    /// Sweeps of refinement until the residuals are small or as good as rounding allows, each for the columns that are still open. The factor
    /// alone mostly takes a residual to rounding; where it doesn't, because the shift is not small beside the first eigenvalue, conjugate gradients go on.
    pub(super) fn solve_block(
        &self,
        factor: &PositiveFactor,
        forces: &ProjectedForces,
    ) -> Result<Solution, Error> {
        let mut best = Solution {
            x: Mat::zeros(0, 0),
            product: Mat::zeros(0, 0),
            left: Mat::zeros(0, 0),
            residuals: relative(&forces.norms, &forces.norms),
            iterations: 0,
        };
        let mut iterations = 0;
        let mut sweep = Sweep::Factor;
        for _ in 0..SWEEPS {
            let open = best.open();
            if open.is_empty() {
                break;
            }
            let chosen = (open.len() < forces.norms.len()).then(|| forces.some(&open));
            let forces = chosen.as_ref().unwrap_or(forces);
            let left = match best.is_begun() {
                true => some_columns(best.left.as_ref(), &open),
                false => copied(forces.columns.as_ref()),
            };
            let (mut x, made) = match sweep {
                Sweep::Factor => (solved(factor, left)?, 1),
                Sweep::ConjugateGradients => self.conjugate_gradients(factor, forces, left)?,
            };
            iterations += made;
            if best.is_begun() {
                add_scaled_columns(
                    x.as_mut(),
                    &vec![1.0; open.len()],
                    some_columns(best.x.as_ref(), &open).as_ref(),
                );
            }
            self.project_motion(&mut x);
            let next = self.solution(forces, x, 0);
            let share = next.worst() / best.worst();
            if share < 1.0 {
                best.replace(&open, next);
            }
            sweep = match sweep {
                Sweep::Factor if share <= FAST => Sweep::Factor,
                // What doesn't become much better any more is as good as rounding allows.
                Sweep::ConjugateGradients if share.is_nan() || share > 0.5 => break,
                _ => Sweep::ConjugateGradients,
            };
        }
        if !best.is_begun() {
            let nothing = zeros(forces.columns.nrows(), forces.columns.ncols());
            return Ok(self.solution(forces, nothing, iterations));
        }
        best.iterations = iterations;
        Ok(self.without_kept_modes(forces, best))
    }

    /// A block of columns with what they leave.
    pub(super) fn solution(
        &self,
        forces: &ProjectedForces,
        x: Mat<f64>,
        iterations: usize,
    ) -> Solution {
        let product = symmetric_product(&self.model.stiffness, x.as_ref());
        let left = self.remainder(forces, &product);
        Solution {
            residuals: relative(&self.norms(left.as_ref()), &forces.norms),
            x,
            product,
            left,
            iterations,
        }
    }

    /// Takes kept modes out where the columns hold more of them than [`MODE_CONTENT`]. The exact solution has none; but with
    /// modes that rounding leaves a residual, to take them out can cost the columns as much of theirs.
    fn without_kept_modes(&self, forces: &ProjectedForces, solution: Solution) -> Solution {
        let amounts = gram(self.kept.mass_shapes, solution.x.as_ref());
        let sizes = self.norms(solution.x.as_ref());
        let share = |j: usize| {
            let content: f64 = (0..amounts.nrows())
                .map(|k| (amounts[(k, j)] * self.kept_norms[k]).powi(2))
                .sum();
            content.sqrt() / sizes[j]
        };
        let shares = (0..sizes.len()).filter(|j| sizes[*j] > 0.0).map(share);
        let largest = shares.fold(0.0, f64::max);
        if largest <= MODE_CONTENT {
            return solution;
        }
        let mut x = copied(solution.x.as_ref());
        add_combination(x.as_mut(), self.kept.shapes, amounts.as_ref(), -1.0);
        let cleaned = self.solution(forces, x, solution.iterations);
        let costs = cleaned.worst() > CLEANED_RESIDUAL.max(solution.worst());
        match costs && largest <= LARGEST_MODE_CONTENT {
            true => solution,
            false => cleaned,
        }
    }

    /// An approximate solution of K z = r without motions that have no stiffness.
    fn precondition(&self, factor: &PositiveFactor, r: Mat<f64>) -> Result<Mat<f64>, Error> {
        let mut z = solved(factor, r)?;
        self.project_motion(&mut z);
        Ok(z)
    }

    /// An approximate solution of K x = r in the complement of the motions without stiffness, and the iterations made.
    fn conjugate_gradients(
        &self,
        factor: &PositiveFactor,
        forces: &ProjectedForces,
        mut r: Mat<f64>,
    ) -> Result<(Mat<f64>, usize), Error> {
        let mut x = zeros(r.nrows(), r.ncols());
        let mut p: Mat<f64> = Mat::zeros(0, 0);
        let mut rz = Vec::new();
        for iteration in 0..ITERATIONS_PER_SWEEP {
            let left = relative(&self.norms(r.as_ref()), &forces.norms);
            let open: Vec<bool> = left.iter().map(|left| *left > RESIDUAL_AIM).collect();
            if !open.contains(&true) {
                return Ok((x, iteration));
            }
            let mut z = self.precondition(factor, copied(r.as_ref()))?;
            let next = column_dots(r.as_ref(), z.as_ref());
            if iteration > 0 {
                let momentum: Vec<f64> = next
                    .iter()
                    .zip(&rz)
                    .map(|(next, rz): (&f64, &f64)| if *rz > 0.0 { next / rz } else { 0.0 })
                    .collect();
                add_scaled_columns(z.as_mut(), &momentum, p.as_ref());
            }
            p = z;
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
            add_scaled_columns(x.as_mut(), &step, p.as_ref());
            let back: Vec<f64> = step.iter().map(|step| -step).collect();
            add_scaled_columns(r.as_mut(), &back, kp.as_ref());
            self.project_force(&mut r);
        }
        Ok((x, ITERATIONS_PER_SWEEP))
    }
}

/// The solutions of (K + σ M) z = r.
fn solved(factor: &PositiveFactor, mut r: Mat<f64>) -> Result<Mat<f64>, Error> {
    factor.solve_in_place(r.as_mut())?;
    Ok(r)
}
