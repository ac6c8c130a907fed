//! Whether M is positive semi-definite, as far as the digits that it was printed with can tell.
//!
//! Masses integrated at few points, massless rotations and internal rows make M singular; printed with ten digits it is then slightly
//! indefinite. Sizes are those of M with the diagonal of K scaled to one, which has no unit: eigenvalues 1/ω² as single rows have
//! them. With θ the largest, M + τ diag(K) is positive if no eigenvalue is below −τ; τ = 1e-9 θ counts as zero.

use dcb_formats::SparseMatrix;
use dcb_formats::component::Component;
use dcb_formats::mesh::Direction;
use dcb_sparse::factorization::SymmetricFactor;
use faer::sparse::SymbolicSparseColMat;
use rayon::prelude::*;

use crate::error::{Error, MatrixRefusal, Places};
use crate::model::condensation::Model;
use crate::model::couplings::Solid;

/// Negative eigenvalues of M down to this part of the largest count as zero.
const ZERO_MASS: f64 = 1e-9;
/// Part of uᵀ diag(M) u that is looked for as mass of every motion u first: elements with a full mass matrix keep more.
const MASS_PART: f64 = 1e-4;
/// The lowest eigenvalue is found between powers of this.
const STEP: f64 = 10.0;

/// Diagonal of a square matrix.
pub(crate) fn diagonal(matrix: &SparseMatrix) -> Vec<f64> {
    let entry = |i: usize| matrix.as_ref().get(i, i).copied().unwrap_or(0.0);
    (0..matrix.ncols()).into_par_iter().map(entry).collect()
}

/// Negative eigenvalues of M that count as zero.
pub(crate) struct NegativeEigenvalues {
    /// τ, time².
    counted_as_zero: f64,
}

impl NegativeEigenvalues {
    /// From the diagonals of K and M alone.
    pub fn of_diagonals(stiffness: &[f64], mass: &[f64]) -> Self {
        let ratios = mass.iter().zip(stiffness).filter(|(_, k)| **k > 0.0);
        let largest = ratios.map(|(m, k)| m / k).fold(0.0, f64::max);
        Self {
            counted_as_zero: ZERO_MASS * largest,
        }
    }

    /// The most negative diagonal entry of M that counts as zero, as an amount, beside K's entry.
    pub fn at(&self, stiffness: f64) -> f64 {
        self.counted_as_zero * stiffness.max(0.0)
    }
}

/// Refuses a mass matrix with negative eigenvalues beyond rounding; `factor` is the analysis of K and M. Returns the part of uᵀ diag(M) u that is at least mass of
/// every motion u, where that is known: M - part · diag(M) is positive semi-definite.
///
/// # Errors
/// [`MatrixRefusal::NegativeMass`] with how many and how large.
pub(crate) fn refuse_indefinite_mass(
    component: &Component,
    model: &Model,
    factor: &SymmetricFactor,
) -> Result<Option<f64>, Error> {
    let all: Vec<u32> = (0..model.len() as u32).collect();
    let one_direction = one_direction(component, model);
    let (dofs, mass) = match &one_direction {
        Some(of) => (&of.dofs, &of.mass),
        None => (&all, &*model.mass),
    };
    let own = diagonal(mass);
    let inertia = factor.inertia_of(dofs, mass, &diagonal_matrix(&own), MASS_PART)?;
    // A row without mass is a pivot of zero; any other says nothing of those after it.
    let without_mass = own.iter().filter(|mass| **mass == 0.0).count();
    if (inertia.negative, inertia.zero) == (0, without_mass) {
        return Ok(Some(MASS_PART));
    }
    let stiffness = diagonal(&model.stiffness);
    let to_one = |k: &f64| if *k > 0.0 { 1.0 / k.sqrt() } else { 0.0 };
    let scale: Vec<f64> = stiffness.iter().map(to_one).collect();
    let largest = largest_scaled_row_sum(&model.mass, &scale);
    // M + τ diag(K) has the signs of diag(K) + M / τ.
    let shift = |part: f64| -1.0 / (part * largest);
    if let Some(of) = one_direction {
        let lift = diagonal_matrix(&of.least(component, &stiffness));
        let inertia = factor.inertia_of(&of.dofs, &lift, &of.mass, shift(ZERO_MASS))?;
        if inertia.negative == 0 {
            return Ok(None);
        }
    }
    let lift = diagonal_matrix(&stiffness);
    let count = |part: f64| factor.inertia_of(&all, &lift, &model.mass, shift(part));
    let first = count(ZERO_MASS)?;
    if first.negative == 0 {
        return Ok(None);
    }
    let mut least = ZERO_MASS;
    while least < 1.0 && count(STEP * least)?.negative > 0 {
        least *= STEP;
    }
    let places = first.negative_dofs.iter();
    Err(MatrixRefusal::NegativeMass {
        count: first.negative,
        limit: ZERO_MASS,
        least,
        most: STEP * least,
        places: Places::of(places.map(|dof| model.dof_name(*dof))),
    }
    .into())
}

/// M of a solid along x.
struct OneDirection {
    /// The dof of each row, ascending.
    dofs: Vec<u32>,
    mass: SparseMatrix,
}

impl OneDirection {
    /// The least diagonal of K at the node of each row: if it makes M along x positive, so do all directions.
    fn least(&self, component: &Component, stiffness: &[f64]) -> Vec<f64> {
        let least = |row: &u32| {
            let node = component.dofs.dof(*row as usize).map(|dof| dof.node);
            let all = Direction::ALL.into_iter();
            let rows = all.filter_map(|direction| component.dofs.row(node?, direction));
            rows.map(|row| stiffness[row]).fold(f64::INFINITY, f64::min)
        };
        self.dofs.iter().map(least).collect()
    }
}

/// The part of M that belongs to ux, of a solid, whose M is the same in every direction. `None` for other parts.
fn one_direction(component: &Component, model: &Model) -> Option<OneDirection> {
    if !model.frames.is_empty() {
        return None;
    }
    let mut dofs: Vec<u32> = Solid::of(component)?.rows_along_x().collect();
    dofs.sort_unstable();
    let mut place = vec![u32::MAX; model.len()];
    for (new, dof) in dofs.iter().enumerate() {
        place[*dof as usize] = new as u32;
    }
    let entries = |dof: &u32| {
        let rows = model.mass.row_idx_of_col_raw(*dof as usize).iter();
        let all = rows.zip(model.mass.val_of_col(*dof as usize));
        let along = all.map(|(row, value)| (place[*row as usize], *value));
        along.filter(|(row, value)| *row != u32::MAX && *value != 0.0)
    };
    let count = |dof: &u32| entries(dof).count() as u32;
    let mut starts = vec![0];
    starts.par_extend(dofs.par_iter().map(count));
    for row in 0..dofs.len() {
        starts[row + 1] += starts[row];
    }
    let (rows, values) = dofs.par_iter().flat_map_iter(entries).unzip();
    let pattern = SymbolicSparseColMat::new_checked(dofs.len(), dofs.len(), starts, None, rows);
    Some(OneDirection {
        mass: SparseMatrix::new(pattern, values),
        dofs,
    })
}

/// Largest sum of |a_ij| s_i s_j of a row; with s that make a diagonal one, the largest eigenvalue of the scaled matrix is not above it, and hardly
/// below.
pub(crate) fn largest_scaled_row_sum(matrix: &SparseMatrix, scale: &[f64]) -> f64 {
    let sum = |column: usize| {
        let rows = matrix.row_idx_of_col_raw(column).iter();
        let entries = rows.zip(matrix.val_of_col(column));
        let sum: f64 = entries
            .map(|(row, value)| value.abs() * scale[*row as usize])
            .sum();
        sum * scale[column]
    };
    (0..matrix.ncols())
        .into_par_iter()
        .map(sum)
        .reduce(|| 0.0, f64::max)
}

fn diagonal_matrix(entries: &[f64]) -> SparseMatrix {
    let n = entries.len();
    let (starts, rows) = ((0..=n as u32).collect(), (0..n as u32).collect());
    let pattern = SymbolicSparseColMat::new_checked(n, n, starts, None, rows);
    SparseMatrix::new(pattern, entries.to_vec())
}
