//! Blocks of attachment columns: refinement with the factor of K + σ M, and conjugate gradients where that is slow.

use dcb_sparse::block_algebra::{
    add_combination, add_scaled_columns, column_dots, copied, gram, set_columns, some_columns,
    symmetric_product, zeros,
};
use dcb_sparse::factorization::PositiveFactor;
use faer::{ColRef, Mat};

use super::{AttachmentProblem, ProjectedForces, relative};

use crate::error::Error;

/// Relative residual of the attachment columns that is aimed at.
const RESIDUAL_AIM: f64 = 1e-12;
/// One up to this is small enough after a second solution if it is not above rounding in K x.
const RESIDUAL_AT_ROUNDING: f64 = 1e-11;
/// Sweeps of refinement and iterations in each.
const SWEEPS: usize = 6;
const ITERATIONS_PER_SWEEP: usize = 60;
/// A sweep with the factor that leaves less than this share of a residual is followed by another one.
const FAST: f64 = 1e-2;
/// Share of kept modes in an attachment column that is always left there, and that is left where taking it out costs accuracy.
const MODE_CONTENT: f64 = 1e-10;
const LARGEST_MODE_CONTENT: f64 = 1e-9;
/// Relative residual that columns without kept modes may have.
const CLEANED_RESIDUAL: f64 = 1e-12;

/// A block of columns on the way.
pub struct Solution {
    pub x: Mat<f64>,
    /// K x.
    pub product: Mat<f64>,
    /// Residual forces.
    pub left: Mat<f64>,
    /// Its norm over that of the forces.
    pub residuals: Vec<f64>,
    pub iterations: usize,
}

impl Solution {
    /// The largest residual; one that is no number is larger than any other.
    fn worst(&self) -> f64 {
        largest(&self.residuals)
    }

    /// Columns whose residuals are above the aim, or no numbers.
    pub fn open(&self) -> Vec<usize> {
        let is_open = |j: &usize| self.residuals[*j].is_nan() || self.residuals[*j] > RESIDUAL_AIM;
        (0..self.residuals.len()).filter(is_open).collect()
    }

    /// Takes over some columns, in this order those of another solution.
    fn replace(&mut self, columns: &[usize], by: Self) {
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
    pub(super) fn refined(
        &self,
        factor: &PositiveFactor,
        forces: &ProjectedForces,
        begun: Solution,
    ) -> Result<Solution, Error> {
        let mut best = begun;
        let mut open: Vec<usize> = (0..best.residuals.len()).collect();
        let mut sweep = match best.worst() <= FAST {
            true => Sweep::Factor,
            false => Sweep::ConjugateGradients,
        };
        for _ in 1..SWEEPS {
            let chosen = forces.some(&open);
            let before = some_columns(best.x.as_ref(), &open);
            let left = some_columns(best.left.as_ref(), &open);
            let (mut x, made) = match sweep {
                Sweep::Factor => (solved(factor, left)?, 1),
                Sweep::ConjugateGradients => self.conjugate_gradients(factor, &chosen, left)?,
            };
            add_scaled_columns(x.as_mut(), &vec![1.0; open.len()], before.as_ref());
            self.project_motion(&mut x);
            let next = self.solution(&chosen, x, 0);
            best.iterations += made;
            let share = next.worst() / best.worst();
            if share < 1.0 {
                best.replace(&open, next);
            }
            open = self.improvable(forces, &best);
            sweep = match sweep {
                _ if open.is_empty() => break,
                Sweep::Factor if share <= FAST => Sweep::Factor,
                // What doesn't become much better any more is as good as rounding allows.
                Sweep::ConjugateGradients if share.is_nan() || share > 0.5 => break,
                _ => Sweep::ConjugateGradients,
            };
        }
        Ok(self.without_kept_modes(forces, best))
    }

    /// What one solution with the factor gives; nothing if that leaves more than there was.
    pub(super) fn first_solution(
        &self,
        factor: &PositiveFactor,
        forces: &ProjectedForces,
    ) -> Result<Solution, Error> {
        let nothing = || zeros(forces.columns.nrows(), forces.columns.ncols());
        if forces.norms.iter().all(|norm| *norm == 0.0) {
            return Ok(self.solution(forces, nothing(), 0));
        }
        let mut x = solved(factor, copied(forces.columns.as_ref()))?;
        self.project_motion(&mut x);
        let first = self.solution(forces, x, 1);
        match first.worst() < 1.0 {
            true => Ok(first),
            false => Ok(self.solution(forces, nothing(), 1)),
        }
    }

    /// Open columns of a refined solution that are worth another sweep: their residuals are above rounding.
    fn improvable(&self, forces: &ProjectedForces, solution: &Solution) -> Vec<usize> {
        let open = solution.open();
        let near: Vec<usize> = (open.iter().copied())
            .filter(|j| solution.residuals[*j] <= RESIDUAL_AT_ROUNDING)
            .collect();
        let norms: Vec<f64> = near.iter().map(|j| forces.norms[*j]).collect();
        let roundings = self.roundings(&some_columns(solution.x.as_ref(), &near), &norms);
        let at_rounding: Vec<usize> = (near.into_iter().zip(roundings))
            .filter(|(j, rounding)| solution.residuals[*j] <= *rounding)
            .map(|(j, _)| j)
            .collect();
        let is_above = |j: &usize| !at_rounding.contains(j);
        open.into_iter().filter(is_above).collect()
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

    /// Takes kept modes out of columns that hold more of them than [`MODE_CONTENT`]. The exact solution has none; but with
    /// modes that rounding leaves a residual, to take them out can cost a column as much of its own.
    pub(super) fn without_kept_modes(
        &self,
        forces: &ProjectedForces,
        mut solution: Solution,
    ) -> Solution {
        let mut amounts = gram(self.kept.mass_shapes, solution.x.as_ref());
        let sizes = self.norms(solution.x.as_ref());
        let contents = relative(&root_sums(&amounts, &self.kept_norms), &sizes);
        if contents.iter().all(|content| *content <= MODE_CONTENT) {
            return solution;
        }
        let added = relative(
            &root_sums(&self.work(&amounts), &self.kept_force_norms),
            &forces.norms,
        );
        let is_taken = |j: &usize| {
            let costs = added[*j] > CLEANED_RESIDUAL.max(solution.residuals[*j]);
            contents[*j] > LARGEST_MODE_CONTENT || contents[*j] > MODE_CONTENT && !costs
        };
        let (taken, left): (Vec<usize>, Vec<usize>) = (0..contents.len()).partition(is_taken);
        if taken.is_empty() {
            return solution;
        }
        for j in left {
            amounts.col_mut(j).fill(0.0);
        }
        add_combination(
            solution.x.as_mut(),
            self.kept.shapes,
            amounts.as_ref(),
            -1.0,
        );
        if contents.iter().any(|of| *of > LARGEST_MODE_CONTENT) {
            return self.solution(forces, solution.x, solution.iterations);
        }
        // K Φ a as M Φ Ω² a: what modes leave of their equation is beyond double precision in so little of them.
        let work = self.work(&amounts);
        for (of, factor) in [(&mut solution.product, -1.0), (&mut solution.left, 1.0)] {
            add_combination(of.as_mut(), self.kept.mass_shapes, work.as_ref(), factor);
        }
        solution.residuals = relative(&self.norms(solution.left.as_ref()), &forces.norms);
        solution
    }

    /// Ω² a.
    fn work(&self, amounts: &Mat<f64>) -> Mat<f64> {
        Mat::from_fn(amounts.nrows(), amounts.ncols(), |k, j| {
            self.kept_eigenvalues[k] * amounts[(k, j)]
        })
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

/// For each column of amounts a of some vectors, the root of the sum of their ‖v a‖².
fn root_sums(amounts: &Mat<f64>, norms: &[f64]) -> Vec<f64> {
    let squares = |column: ColRef<'_, f64>| -> f64 {
        let pairs = column.iter().zip(norms);
        pairs.map(|(amount, norm)| (amount * norm).powi(2)).sum()
    };
    amounts
        .col_iter()
        .map(|column| squares(column).sqrt())
        .collect()
}

/// The largest residual; one that is no number is larger than any other.
fn largest(residuals: &[f64]) -> f64 {
    let largest = residuals.iter().copied().max_by(f64::total_cmp);
    largest.unwrap_or(0.0)
}

/// The solutions of (K + σ M) z = r.
fn solved(factor: &PositiveFactor, mut r: Mat<f64>) -> Result<Mat<f64>, Error> {
    factor.solve_in_place(r.as_mut())?;
    Ok(r)
}
