//! The directions in which a mechanism can move without opening its joints.
//!
//! With lengths as units, `δq = D x`, and the constraints' rows scaled to one, the singular value decomposition
//!
//! ```text
//! R B D = U Σ Vᵀ
//! ```
//! tells all: the columns of V beyond the rank are the free directions, the others carry a misfit or a constraint force of least
//! norm, however often constraints repeat each other. D makes stiff coordinates small, so that frequencies ten powers apart don't
//! drown each other.

use faer::Mat;

use super::System;
use super::linearization::Linearization;
use crate::error::Error;

/// Singular values below this part of the largest belong to constraints that repeat others.
const DEPENDENT: f64 = 1e-9;

/// Free directions of a mechanism at one configuration, N being the length of velocity arrays.
#[derive(Clone, Debug)]
pub struct FreeDirections {
    /// Free directions Z, (N, count): δq of each as a column.
    pub basis: Mat<f64>,
    /// D V₁ Σ⁻¹ Uᵀ R, (N, constraints): the least motion for given changes of the constraints' measures.
    inverse: Mat<f64>,
    /// D, (N).
    pub scale: Vec<f64>,
    /// R, (constraints).
    pub row_scale: Vec<f64>,
}

impl FreeDirections {
    /// At a configuration with constraint Jacobian B, (constraints, N).
    ///
    /// # Errors
    /// [`Error::NoEigenvalues`] if the decomposition fails, on numbers that are not finite.
    pub fn of(system: &System, jacobian: &Mat<f64>) -> Result<Self, Error> {
        let scale = scales(system);
        let columns: Vec<usize> = (0..scale.len()).filter(|i| scale[*i] > 0.0).collect();
        let (rows, n) = (jacobian.nrows(), columns.len());
        let row_scale: Vec<f64> = (0..rows)
            .map(|row| {
                let squares = columns
                    .iter()
                    .map(|i| (jacobian[(row, *i)] * scale[*i]).powi(2));
                let norm = squares.sum::<f64>().sqrt();
                if norm > 0.0 { 1.0 / norm } else { 1.0 }
            })
            .collect();
        let scaled = Mat::from_fn(rows, n, |i, j| {
            row_scale[i] * jacobian[(i, columns[j])] * scale[columns[j]]
        });
        let decomposition = scaled.svd().map_err(|_| Error::NoEigenvalues)?;
        let (u, sigma, v) = (decomposition.U(), decomposition.S(), decomposition.V());
        let sigma = sigma.column_vector();
        let largest = sigma.iter().fold(0.0, |most: f64, s| most.max(*s));
        let rank = sigma.iter().filter(|s| **s > DEPENDENT * largest).count();
        let mut basis = Mat::zeros(scale.len(), n - rank);
        let mut inverse = Mat::zeros(scale.len(), rows);
        for (i, column) in columns.iter().enumerate() {
            for k in rank..n {
                basis[(*column, k - rank)] = scale[*column] * v[(i, k)];
            }
            for (row, row_scale) in row_scale.iter().enumerate() {
                let sum: f64 = (0..rank).map(|k| v[(i, k)] / sigma[k] * u[(row, k)]).sum();
                inverse[(*column, row)] = scale[*column] * sum * row_scale;
            }
        }
        Ok(Self {
            basis,
            inverse,
            scale,
            row_scale,
        })
    }

    /// Number of free directions.
    pub fn count(&self) -> usize {
        self.basis.ncols()
    }

    /// Zᵀ A Z of mass, damping and stiffness.
    pub fn reduced(&self, of: &Linearization) -> [Mat<f64>; 3] {
        [&of.mass, &of.damping, &of.stiffness].map(|matrix| self.reduce(matrix))
    }

    /// Zᵀ A Z of a matrix (N, N).
    pub fn reduce(&self, matrix: &Mat<f64>) -> Mat<f64> {
        self.basis.transpose() * (matrix * &self.basis)
    }

    /// Zᵀ r of generalised forces (N).
    pub fn components(&self, forces: &[f64]) -> Vec<f64> {
        transposed_product(&self.basis, forces)
    }

    /// The least motion, (N), by which the constraints' measures change as given.
    pub fn closing(&self, changes: &[f64]) -> Vec<f64> {
        let mut motion = vec![0.0; self.inverse.nrows()];
        add_product(&self.inverse, changes, &mut motion);
        motion
    }

    /// The constraint forces of least norm that balance generalised forces (N) as far as constraints can: `Bᵀ λ = r`.
    pub fn reactions(&self, forces: &[f64]) -> Vec<f64> {
        transposed_product(&self.inverse, forces)
    }

    /// Adds the motion Z z.
    pub fn add_motion(&self, amounts: &[f64], motion: &mut [f64]) {
        add_product(&self.basis, amounts, motion);
    }
}

/// `into += A x`
fn add_product(matrix: &Mat<f64>, x: &[f64], into: &mut [f64]) {
    for (column, x) in matrix.col_iter().zip(x) {
        for (sum, entry) in into.iter_mut().zip(column.iter()) {
            *sum += x * entry;
        }
    }
}

/// `Aᵀ x`
fn transposed_product(matrix: &Mat<f64>, x: &[f64]) -> Vec<f64> {
    let dot = |column: faer::ColRef<'_, f64>| column.iter().zip(x).map(|(a, b)| a * b).sum();
    matrix.col_iter().map(dot).collect()
}

/// D, zero for motions that the scene hasn't.
fn scales(system: &System) -> Vec<f64> {
    let softest = system
        .bodies
        .iter()
        .flat_map(|body| &body.flexible.stiffness)
        .filter(|stiffness| **stiffness > 0.0)
        .fold(f64::INFINITY, |least, stiffness| least.min(*stiffness));
    let mut scales = Vec::with_capacity(system.velocity_count());
    for body in &system.bodies {
        let units = [
            1.0,
            1.0,
            1.0,
            1.0 / body.length,
            1.0 / body.length,
            1.0 / body.length,
        ];
        scales.extend(
            units
                .iter()
                .zip(body.free)
                .map(|(unit, free)| if free { *unit } else { 0.0 }),
        );
        let unit = body.flexible.inertia.mass().sqrt();
        let stiffness = body.flexible.stiffness.iter();
        scales.extend(stiffness.map(|stiffness| unit / (1.0 + stiffness / softest).sqrt()));
    }
    scales
}
