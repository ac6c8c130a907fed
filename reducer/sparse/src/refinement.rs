//! Solutions with a rounded factor made as good as with an exact one: iterative refinement of `(K + σ M) x = b`.
//!
//! A factor computed in double precision and rounded to u = 6e-8 afterwards is `L + δL`, |δL| ≤ u |L|. Each step
//! `x += (L̃ L̃ᵀ)⁻¹ (b - A x)` leaves about `u √κ` of the error, with κ the condition of the matrix scaled to a unit diagonal: the
//! product `L̃ L̃ᵀ` stays positive definite, and its error on smooth motions is as small as their energy lets it be. Steps end
//! when the residual is that of a solution in double precision.

use faer::{Mat, MatMut, MatRef};

use crate::block_algebra::symmetric_product;
use crate::multifrontal::Matrix;

/// Scaled residual of a solution that needs no further step.
const AIM: f64 = 4.0 * f64::EPSILON;
/// Scaled residual of a solution that counts as one in double precision.
const LIMIT: f64 = 64.0 * f64::EPSILON;
/// Steps after the first solution.
const STEPS: usize = 12;
/// A step that leaves more than this of the residual is the last.
const LEAST_GAIN: f64 = 0.5;

/// Operators that refinement needs beside the rounded factor.
pub struct Refinement<'a> {
    matrix: Matrix<'a>,
    /// √aᵢᵢ: residuals are divided by it and solutions multiplied, so that units don't count.
    scale: Vec<f64>,
}

/// How a refinement ended.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Refined {
    /// Steps made.
    pub steps: usize,
    /// Largest `‖D⁻¹ (b - A x)‖ / ‖D x‖` of a column, D² the diagonal of A.
    pub residual: f64,
}

impl Refined {
    /// Whether the solution is as good as one in double precision.
    pub fn is_accurate(&self) -> bool {
        // Not a number is not accurate.
        self.residual <= LIMIT
    }

    /// The worse of two in each respect.
    pub fn include(&mut self, other: Self) {
        self.steps = self.steps.max(other.steps);
        if other.residual.is_nan() || other.residual > self.residual {
            self.residual = other.residual;
        }
    }
}

impl<'a> Refinement<'a> {
    /// Refinement with a matrix.
    pub fn of(matrix: Matrix<'a>) -> Self {
        let diagonal = |matrix: &dcb_formats::SparseMatrix, i: usize| {
            matrix.as_ref().get(i, i).copied().unwrap_or(0.0)
        };
        let scale = (0..matrix.stiffness.ncols())
            .map(|i| {
                let entry = diagonal(matrix.stiffness, i) + matrix.shift * diagonal(matrix.mass, i);
                if entry > 0.0 { entry.sqrt() } else { 1.0 }
            })
            .collect();
        Self { matrix, scale }
    }

    /// Replaces the columns of `block` by their solutions; `solve` does so with the rounded factor.
    pub fn solve_in_place(
        &self,
        mut block: MatMut<'_, f64>,
        solve: impl Fn(MatMut<'_, f64>),
    ) -> Refined {
        let forces = block.as_ref().to_owned();
        solve(block.as_mut());
        let mut residual = self.residual(&forces, block.as_ref());
        let mut left = self.relative(residual.as_ref(), block.as_ref());
        let mut steps = 0;
        while left > AIM && steps < STEPS {
            solve(residual.as_mut());
            let better = &residual + block.as_ref();
            residual = self.residual(&forces, better.as_ref());
            let now = self.relative(residual.as_ref(), better.as_ref());
            if now.is_nan() || now >= left {
                break;
            }
            block.copy_from(&better);
            steps += 1;
            let gain = now / left;
            left = now;
            if gain > LEAST_GAIN {
                break;
            }
        }
        Refined {
            steps,
            residual: left,
        }
    }

    /// `b - K x - σ M x`
    fn residual(&self, forces: &Mat<f64>, x: MatRef<'_, f64>) -> Mat<f64> {
        let Matrix {
            stiffness,
            mass,
            shift,
        } = self.matrix;
        let mut residual = forces - symmetric_product(stiffness, x);
        residual -= faer::Scale(shift) * symmetric_product(mass, x);
        residual
    }

    fn relative(&self, residual: MatRef<'_, f64>, x: MatRef<'_, f64>) -> f64 {
        let mut largest = 0.0_f64;
        for (residual, x) in residual.col_iter().zip(x.col_iter()) {
            let (mut left, mut whole) = (0.0, 0.0);
            for ((r, x), s) in residual.iter().zip(x.iter()).zip(&self.scale) {
                left += (r / s) * (r / s);
                whole += (x * s) * (x * s);
            }
            let ratio = if left == 0.0 {
                0.0
            } else {
                (left / whole).sqrt()
            };
            // What is not a number is not forgotten.
            if ratio.is_nan() || ratio > largest {
                largest = ratio;
            }
        }
        largest
    }
}
