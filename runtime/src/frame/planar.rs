//! Planar body: one axis of rotation, spin θ'.
//!
//! ```text
//! J(y)    =  I_z + 2 I1 y + yᵀ y             (I2 is the reduced mass, which is the identity)
//! L(y)    =  yᵀ L3                           (1, n)
//! moment  = -2 θ' (I1 + yᵀ) y'
//! force   =  θ'² (I1ᵀ + y) - 2 θ' L3ᵀ y'
//! ```
//! Eq. 12 and 14 of the paper with the term yᵀ y of the appendix kept: dropping it alone would leave forces that derive
//! from no energy.

use faer::Mat;

use super::{InertiaTerms, dot};

/// Index of the axis of rotation.
const Z: usize = 2;

/// Invariants over the dynamic coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanarInertia {
    /// Total mass.
    pub mass: f64,
    /// I_z about the centre of mass, undeformed.
    pub moment: f64,
    /// I1, (n), √mass·length: half the first-order change of inertia.
    pub first_order: Vec<f64>,
    /// L3, (n, n), antisymmetric.
    pub coupling: Mat<f64>,
}

impl PlanarInertia {
    /// See [`super::FrameInertia::evaluate`].
    pub fn evaluate(&self, y: &[f64], spin: f64, rates: &[f64], terms: &mut InertiaTerms) {
        terms.rotary[(Z, Z)] = self.moment + 2.0 * dot(&self.first_order, y) + dot(y, y);
        terms.moment[Z] = -2.0 * spin * (dot(&self.first_order, rates) + dot(y, rates));
        let coupling = terms.coupling.col_as_slice_mut(Z);
        for (l, entry) in coupling.iter_mut().enumerate() {
            let column = self.coupling.col_as_slice(l);
            *entry = dot(y, column);
            terms.force[l] =
                spin * spin * (self.first_order[l] + y[l]) - 2.0 * spin * dot(column, rates);
        }
    }
}
