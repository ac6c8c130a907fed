//! Z = G_σ M X, the response to the inertia of the static shapes X, by one solution with the factor for each column; of it only the
//! moments are kept.
//!
//! With c = L φ of an omitted mode φ, ω² = μ: X is Σ φ cᵀ/μ and Z is Σ φ cᵀ/(μ (μ + σ)), exactly. No refinement is needed to
//! make that G M X, because the estimate takes σ into account.

use dcb_dense::symmetrized;
use dcb_sparse::block_algebra::{copy, gram, symmetric_product, zeros};
use dcb_sparse::column_products::{BLOCK, enter_symmetric};
use dcb_sparse::factorization::PositiveFactor;
use faer::{Mat, MatRef};

use crate::attachments::columns::Complement;
use crate::attachments::enrichment::Reducing;
use crate::error::Error;
use crate::model::shift::EnergyBound;
use crate::observer::Observer;

/// Moments of the static shapes X and their second responses Z.
pub(super) struct SecondResponses {
    /// M_2 = Xᵀ M X, (n, n).
    pub second: Mat<f64>,
    /// M_3 = Xᵀ M Z, symmetric.
    pub third: Mat<f64>,
    /// M_4 = Zᵀ M Z.
    pub fourth: Mat<f64>,
    /// Largest deviation of M_3 from symmetry, in each column by its diagonal entries: rounding in the solutions.
    pub asymmetry: Vec<f64>,
    /// Bounds of |z|ᵀ |K| |z|.
    pub energies: Vec<f64>,
}

impl SecondResponses {
    /// Of static shapes X, (n_c, n).
    ///
    /// # Errors
    /// [`Error::Interrupted`], and those of solving.
    pub(super) fn of(
        of: &Reducing<'_>,
        shapes: MatRef<'_, f64>,
        factor: &PositiveFactor,
        bound: &EnergyBound,
        observer: &mut dyn Observer,
    ) -> Result<Self, Error> {
        let n = shapes.ncols();
        let mass = &of.model.mass;
        let complements = [
            Complement::of_rigid(of.rigid),
            Complement::of_modes(of.modes),
        ];
        let mut second = Mat::zeros(n, n);
        let mut raw = Mat::zeros(n, n);
        let mut fourth = Mat::zeros(n, n);
        let mut next = zeros(shapes.nrows(), n);
        let mut energies = Vec::with_capacity(n);
        for first in (0..n).step_by(BLOCK) {
            observer.advance(first as f64 / n as f64)?;
            let count = BLOCK.min(n - first);
            let mut block = symmetric_product(mass, shapes.subcols(first, count));
            let known = shapes.subcols(0, first + count);
            enter_symmetric(&mut second, first, &gram(known, block.as_ref()));
            // Of these motions M X has what rounding leaves, which the factor enlarges: taken out afterwards, as much of it is left as if before too.
            factor.solve_in_place(block.as_mut())?;
            for complement in &complements {
                complement.project_motion(&mut block);
            }
            energies.extend(bound.energies(block.as_ref()));
            let inertia = symmetric_product(mass, block.as_ref());
            copy(block.as_ref(), next.as_mut().subcols_mut(first, count));
            let mut third = raw.as_mut().subcols_mut(first, count);
            third.copy_from(gram(shapes, inertia.as_ref()));
            let known = next.as_ref().subcols(0, first + count);
            enter_symmetric(&mut fourth, first, &gram(known, inertia.as_ref()));
        }
        Ok(Self {
            asymmetry: asymmetry(&raw),
            second,
            third: symmetrized(raw.as_ref()),
            fourth,
            energies,
        })
    }
}

fn asymmetry(raw: &Mat<f64>) -> Vec<f64> {
    let n = raw.ncols();
    let size = |i: usize, j: usize| (raw[(i, i)] * raw[(j, j)]).sqrt();
    let apart = |i: usize, j: usize| match size(i, j) {
        size if size > 0.0 => (raw[(i, j)] - raw[(j, i)]).abs() / size,
        _ => 0.0,
    };
    (0..n)
        .map(|j| (0..n).map(|i| apart(i, j)).fold(0.0, f64::max))
        .collect()
}
