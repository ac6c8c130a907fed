//! Spatial body: three axes of rotation, spin ω in body axes.
//!
//! ```text
//! J(y)     =  I0 + Σ_k y_k J1_k + Σ_kl y_k y_l J2_kl
//! L(y)     =  Σ_k y_k L3[:, k, :]                              (3, n)
//! moment   = -(J' ω + ω × (J ω + L y')),   J' = Σ_k y'_k (J1_k + 2 Σ_l y_l J2_kl)
//! force_k  =  ½ ωᵀ J1_k ω + ωᵀ (Σ_l y_l J2_kl) ω - 2 Σ_a ω_a (L3_aᵀ y')_k
//! ```
//! The part of the moment that would come from L' y' vanishes, because L3 is antisymmetric.

use faer::Mat;
use nalgebra::{Matrix3, Vector3};

use super::{InertiaTerms, add_scaled, dot};

/// Pairs of axes in the order of six-fold quantities: xx, yy, zz, xy, yz, zx.
pub const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];

/// Invariants over the dynamic coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct SpatialInertia {
    /// Total mass.
    pub mass: f64,
    /// I0 about the centre of mass, undeformed, body axes.
    pub tensor: Matrix3<f64>,
    /// J1 by pairs of axes, (n, 6), √mass·length.
    pub first_order: Mat<f64>,
    /// J2 by pairs of axes, six of (n, n), symmetric.
    pub second_order: [Mat<f64>; 6],
    /// L3 by axes, three of (n, n), antisymmetric.
    pub coupling: [Mat<f64>; 3],
}

impl SpatialInertia {
    /// See [`super::FrameInertia::evaluate`].
    pub fn evaluate(
        &self,
        y: &[f64],
        spin_body: &Vector3<f64>,
        rates: &[f64],
        terms: &mut InertiaTerms,
    ) {
        let mut rotary_rate = Matrix3::zeros();
        terms.force.fill(0.0);
        for (pair, (a, b)) in PAIRS.into_iter().enumerate() {
            let first = self.first_order.col_as_slice(pair);
            let second = terms.second_order.col_as_slice_mut(pair);
            second.fill(0.0);
            for (l, y_l) in y.iter().enumerate() {
                add_scaled(second, *y_l, self.second_order[pair].col_as_slice(l));
            }
            let rotary = self.tensor[(a, b)] + dot(first, y) + dot(second, y);
            let rate = dot(first, rates) + 2.0 * dot(second, rates);
            for (i, j) in [(a, b), (b, a)] {
                terms.rotary[(i, j)] = rotary;
                rotary_rate[(i, j)] = rate;
            }
            // A pair of different axes stands for two entries of the tensor.
            let spins = spin_body[a] * spin_body[b] * if a == b { 1.0 } else { 2.0 };
            add_scaled(&mut terms.force, 0.5 * spins, first);
            add_scaled(&mut terms.force, spins, second);
        }
        for (axis, l3) in self.coupling.iter().enumerate() {
            let coupling = terms.coupling.col_as_slice_mut(axis);
            for (l, entry) in coupling.iter_mut().enumerate() {
                let column = l3.col_as_slice(l);
                *entry = dot(y, column);
                terms.force[l] -= 2.0 * spin_body[axis] * dot(column, rates);
            }
        }
        let momentum = terms.angular_momentum(spin_body, rates);
        terms.moment = -(rotary_rate * spin_body + spin_body.cross(&momentum));
    }
}
