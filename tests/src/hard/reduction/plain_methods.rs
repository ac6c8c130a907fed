//! What one writes first: the plain methods that run beside this project's own in the hard cases.

use dcb_samples::PseudoRandom;
use faer::linalg::solvers::Solve;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Mat, MatRef, Par, Side};

use crate::dense::{eigen, identity, symmetric};

/// A Ritz vector whose residual is below this fraction of its eigenvalue has converged.
const CONVERGED: f64 = 1e-8;
/// A new direction shorter than this after orthogonalisation is a breakdown.
const BREAKDOWN: f64 = 1e-10;

/// Ascending ω² and Φ of K φ = ω² M φ: M = L Lᵀ, and a dense symmetric solver on L⁻¹ K L⁻ᵀ without any shift. `None` where M
/// has no Cholesky factor.
pub fn eigenpairs(stiffness: &Mat<f64>, mass: &Mat<f64>) -> Option<(Vec<f64>, Mat<f64>)> {
    let lower = mass.llt(Side::Lower).ok()?.L().to_owned();
    let mut half = stiffness.clone();
    solve_lower_triangular_in_place(lower.as_ref(), half.as_mut(), Par::Seq);
    let mut matrix = half.transpose().to_owned();
    solve_lower_triangular_in_place(lower.as_ref(), matrix.as_mut(), Par::Seq);
    let (values, mut shapes) = eigen(&symmetric(&matrix));
    solve_upper_triangular_in_place(lower.as_ref().transpose(), shapes.as_mut(), Par::Seq);
    Some((values, shapes))
}

/// Σ (L_b φ)(L_b φ)ᵀ / ω² over the given modes.
pub fn modal_flexibility(
    rows: &Mat<f64>,
    shapes: MatRef<'_, f64>,
    eigenvalues: &[f64],
) -> Mat<f64> {
    let seen = rows * shapes;
    Mat::from_fn(rows.nrows(), rows.nrows(), |i, j| {
        (0..eigenvalues.len())
            .map(|k| seen[(i, k)] * seen[(j, k)] / eigenvalues[k])
            .sum()
    })
}

/// Number of eigenvalues above this fraction of the matrix's own largest.
pub fn rank_by_own_largest(matrix: &Mat<f64>, tolerance: f64) -> usize {
    let (values, _) = eigen(&symmetric(matrix));
    let largest = values.last().copied().unwrap_or(0.0);
    values
        .iter()
        .filter(|value| **value > tolerance * largest)
        .count()
}

/// How far the columns of T = L⁻ᵀ, with A = L Lᵀ by Cholesky, are from Tᵀ A T = I; infinite where there is no factor.
pub fn cholesky_defect(matrix: &Mat<f64>) -> f64 {
    let Ok(factor) = matrix.llt(Side::Lower) else {
        return f64::INFINITY;
    };
    let n = matrix.nrows();
    let mut transform = identity(n);
    solve_upper_triangular_in_place(factor.L().transpose(), transform.as_mut(), Par::Seq);
    let defect = transform.transpose() * matrix * &transform - identity(n);
    let entries = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
    // NaN, from a pivot that is zero, counts as infinite.
    entries.fold(0.0, |worst, at| {
        let entry = defect[at].abs();
        if entry.is_finite() {
            f64::max(worst, entry)
        } else {
            f64::INFINITY
        }
    })
}

/// Block Lanczos on (K + σM)⁻¹ M without restarts and without an eigenvalue count: starts from pseudo-random vectors free of the
/// `rigid` motions, orthogonalises fully, and stops as soon as the `wanted` lowest Ritz vectors have converged or the space runs dry. Gives
/// their ω².
pub fn block_lanczos(
    stiffness: &Mat<f64>,
    mass: &Mat<f64>,
    rigid: &Mat<f64>,
    shift: f64,
    (block, wanted): (usize, usize),
) -> Vec<f64> {
    let n = stiffness.nrows();
    let factor = (stiffness + mass * faer::Scale(shift))
        .llt(Side::Lower)
        .expect("a positive matrix");
    let mut basis = Basis::new(mass);
    basis.add(rigid);
    let locked = basis.vectors.len();
    let mut random = PseudoRandom::new(11);
    let mut next = Mat::from_fn(n, block, |_, _| random.number());
    let mut images = Vec::new();
    loop {
        let first = basis.vectors.len();
        basis.add(&next);
        let added = basis.vectors.len() - first;
        if added == 0 {
            return converged(&basis, locked, &images, shift, wanted);
        }
        let newest = Mat::from_fn(n, added, |i, j| basis.vectors[first + j][(i, 0)]);
        let image = factor.solve(&(mass * &newest));
        images.extend((0..added).map(|j| image.as_ref().subcols(j, 1).to_owned()));
        let found = converged(&basis, locked, &images, shift, wanted);
        if found.len() >= wanted {
            return found;
        }
        next = image;
    }
}

/// ω² of the lowest Ritz vectors as far as they have converged, `wanted` at most; `images` are those of the vectors after the locked
/// ones.
fn converged(
    basis: &Basis<'_>,
    locked: usize,
    images: &[Mat<f64>],
    shift: f64,
    wanted: usize,
) -> Vec<f64> {
    let (vectors, mass_vectors) = (&basis.vectors[locked..], &basis.mass_vectors[locked..]);
    let projected = Mat::from_fn(images.len(), images.len(), |i, j| {
        (mass_vectors[i].transpose() * &images[j])[(0, 0)]
    });
    let (values, amounts) = eigen(&symmetric(&projected));
    let n = basis.mass.nrows();
    let mut found = Vec::new();
    for k in (0..values.len()).rev() {
        // S x - θ x for the Ritz vector x = V s.
        let mut left = Mat::<f64>::zeros(n, 1);
        for (j, image) in images.iter().enumerate() {
            for i in 0..n {
                left[(i, 0)] += amounts[(j, k)] * (image[(i, 0)] - values[k] * vectors[j][(i, 0)]);
            }
        }
        if found.len() == wanted || basis.norm(&left) > CONVERGED * values[k] {
            break;
        }
        found.push(1.0 / values[k] - shift);
    }
    found
}

/// M-orthonormal vectors, and M times them.
struct Basis<'a> {
    mass: &'a Mat<f64>,
    vectors: Vec<Mat<f64>>,
    mass_vectors: Vec<Mat<f64>>,
}

impl<'a> Basis<'a> {
    fn new(mass: &'a Mat<f64>) -> Self {
        Self {
            mass,
            vectors: Vec::new(),
            mass_vectors: Vec::new(),
        }
    }

    fn norm(&self, x: &Mat<f64>) -> f64 {
        (x.transpose() * self.mass * x)[(0, 0)].max(0.0).sqrt()
    }

    /// Gram and Schmidt twice, column by column; what was in the space already is left out.
    fn add(&mut self, x: &Mat<f64>) {
        for j in 0..x.ncols() {
            let mut column = x.as_ref().subcols(j, 1).to_owned();
            let before = self.norm(&column);
            for _ in 0..2 {
                for (vector, mass_vector) in self.vectors.iter().zip(&self.mass_vectors) {
                    let amount = (mass_vector.transpose() * &column)[(0, 0)];
                    column -= vector * faer::Scale(amount);
                }
            }
            let after = self.norm(&column);
            if after > BREAKDOWN * before {
                let unit = &column * faer::Scale(1.0 / after);
                self.mass_vectors.push(self.mass * &unit);
                self.vectors.push(unit);
            }
        }
    }
}
