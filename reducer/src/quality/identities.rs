//! Defects of the identities that the basis of a reduction satisfies.

use dcb_formats::superelement::Inertia;
use dcb_sparse::block_algebra::{gram, symmetric_product};
use faer::{Mat, MatRef};

use super::ORTHOGONALITY_LIMIT;
use crate::attachments::residual::ResidualFlexibility;
use crate::model::condensation::Model;
use crate::model::rigid_body::MassProperties;
use crate::model::shift::AbsoluteForces;
use crate::modes::free_modes::FreeModes;

/// Left sides of Eq. 29–32 minus their right sides, scaled.
pub(super) struct Identities {
    pub(super) stiffness_orthogonality: f64,
    pub(super) mass_orthogonality: f64,
    pub(super) mass_orthonormality: f64,
    pub(super) stiffness_diagonality: f64,
    pub(super) flexibility_identity: f64,
}

fn largest_scaled(matrix: MatRef<'_, f64>, scale: impl Fn(usize, usize) -> f64) -> f64 {
    let mut largest = 0.0_f64;
    for j in 0..matrix.ncols() {
        for i in 0..matrix.nrows() {
            let s = scale(i, j);
            if s > 0.0 {
                largest = largest.max((matrix[(i, j)] / s).abs());
            }
        }
    }
    largest
}

impl Identities {
    pub(super) fn of(model: &Model, modes: &FreeModes, residual: &ResidualFlexibility) -> Self {
        let phi = modes.shapes.as_ref();
        let k_phi = symmetric_product(&model.stiffness, phi);
        let highest = modes
            .eigenvalues
            .last()
            .copied()
            .unwrap_or(0.0)
            .max(f64::MIN_POSITIVE);
        // A motion of a loose piece has no ω² of its own: it is measured against the first elastic one.
        let elastic = modes
            .eigenvalues
            .iter()
            .copied()
            .find(|value| *value > 0.0)
            .unwrap_or(modes.first_omitted);
        let floor = if elastic.is_finite() {
            elastic.max(1e-12 * highest)
        } else {
            1.0
        };
        // What rounding in K makes of a motion without stiffness is within the limit: a light, stiff piece has more of it than a soft one has stiffness.
        let loose = phi.subcols(0, modes.zero_count);
        let energies = AbsoluteForces::of(&model.stiffness, loose).energies;
        let omega_squared = |i: usize| match energies.get(i) {
            Some(energy) => floor.max(f64::EPSILON / ORTHOGONALITY_LIMIT * energy),
            None => modes.eigenvalues[i],
        };
        let f0 = |i: usize| residual.flexibility0[(i, i)].max(0.0);
        let m0 = |i: usize| residual.mass_diagonal0[i];
        let n_k = modes.count();
        let mass = gram(phi, modes.mass_shapes.as_ref());
        let stiffness = gram(phi, k_phi.as_ref());
        let identity = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
        let mass_defect = Mat::from_fn(n_k, n_k, |i, j| mass[(i, j)] - identity(i, j));
        let stiffness_defect = Mat::from_fn(n_k, n_k, |i, j| {
            stiffness[(i, j)] - identity(i, j) * modes.eigenvalues[i]
        });
        let flexibility_defect = &residual.stiffness.columns - &residual.flexibility;
        Self {
            stiffness_orthogonality: largest_scaled(residual.stiffness.modes.as_ref(), |i, j| {
                (omega_squared(i) * f0(j)).sqrt()
            }),
            mass_orthogonality: largest_scaled(
                gram(modes.mass_shapes.as_ref(), residual.shapes.as_ref()).as_ref(),
                |_, j| m0(j).sqrt(),
            ),
            mass_orthonormality: largest_scaled(mass_defect.as_ref(), |_, _| 1.0),
            stiffness_diagonality: largest_scaled(stiffness_defect.as_ref(), |i, j| {
                omega_squared(i).max(omega_squared(j))
            }),
            flexibility_identity: largest_scaled(flexibility_defect.as_ref(), |i, j| {
                (f0(i) * f0(j)).sqrt()
            }),
        }
    }
}

/// M norm of each basis column: 1 for a mode, for the others that with no mode kept (so a vanishing residual stays small).
pub(super) fn basis_norms(
    modes: &FreeModes,
    residual: &ResidualFlexibility,
    further: usize,
) -> Vec<f64> {
    let attachments = residual.mass_diagonal0.iter().map(|m| m.sqrt());
    std::iter::repeat_n(1.0, modes.count())
        .chain(attachments)
        .chain(std::iter::repeat_n(1.0, further))
        .collect()
}

/// Largest |L1 ψ| / (√m ‖ψ‖) and |I3 ψ| / (√I ‖ψ‖): cosines between a rigid motion and a column of the basis.
pub fn mean_axis_defects(
    properties: &MassProperties,
    inertia: &Inertia,
    norms: &[f64],
) -> (f64, f64) {
    let largest_moment = (0..3).map(|a| properties.tensor[a][a]).fold(0.0, f64::max);
    let l1 = largest_scaled(inertia.l1.as_ref(), |_, j| {
        properties.mass.sqrt() * norms[j]
    });
    let i3 = largest_scaled(inertia.i3.as_ref(), |_, j| largest_moment.sqrt() * norms[j]);
    (l1, i3)
}
