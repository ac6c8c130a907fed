//! Inertia forces with the accelerations in them, for the residual of an implicit integrator.
//!
//! All on the side of the inertia: inertia + internal forces = applied forces. With p = L1 y, Λ = I3 + L(y), and A the
//! acceleration of the frame's origin less gravity, body axes:
//!
//! ```text
//! f_R  =  m A + L1 y'' + ω' × p + 2 ω × p' + ω × (ω × p)
//! f_φ  =  J ω' + Λ y'' + p × A + J' ω + ω × (J ω + Λ y')
//! f_y  =  M y'' + Λᵀ ω' + L1ᵀ A + 2 G(ω) y' - ½ ωᵀ J'_k ω
//! ```

use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};

use super::stacked::{add_scaled, dot};
use super::{BodyState, FrameInertia, InertiaTerms};

/// Accelerations of a body.
#[derive(Clone, Copy, Debug)]
pub struct BodyAcceleration<'a> {
    /// `Aᵀ (R'' - gravity)`: acceleration of the frame's origin less gravity, body axes (planar: z = 0).
    pub origin: Vector3<f64>,
    /// Time derivative of the spin in body axes (planar: only z is not zero).
    pub spin_rate: Vector3<f64>,
    /// y'', (n).
    pub second_rates: &'a [f64],
}

/// Inertia forces on a body, on the side of the inertia; made once, overwritten by every evaluation.
#[derive(Clone, Debug, PartialEq)]
pub struct InertiaForces {
    /// Force on the frame's origin, body axes.
    pub force_body: Vector3<f64>,
    /// Moment about the frame's origin, body axes.
    pub moment: Vector3<f64>,
    /// Forces on y, (n).
    pub elastic: Vec<f64>,
}

impl InertiaForces {
    /// Room for a body of `count` dynamic coordinates.
    pub fn for_coordinates(count: usize) -> Self {
        Self {
            force_body: Vector3::zeros(),
            moment: Vector3::zeros(),
            elastic: vec![0.0; count],
        }
    }
}

impl FrameInertia {
    /// The inertia forces at a state of motion with accelerations; `terms` becomes what
    /// [`FrameInertia::evaluate`] makes of the state.
    pub fn evaluate_forces(
        &self,
        state: &BodyState<'_>,
        acceleration: &BodyAcceleration<'_>,
        terms: &mut InertiaTerms,
        forces: &mut InertiaForces,
    ) {
        Arch::new().dispatch(ForceEvaluation {
            inertia: self,
            state,
            acceleration,
            terms,
            forces,
        });
    }
}

struct ForceEvaluation<'a> {
    inertia: &'a FrameInertia,
    state: &'a BodyState<'a>,
    acceleration: &'a BodyAcceleration<'a>,
    terms: &'a mut InertiaTerms,
    forces: &'a mut InertiaForces,
}

impl WithSimd for ForceEvaluation<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            inertia,
            state,
            acceleration,
            terms,
            forces,
        } = self;
        inertia.evaluate_terms(simd, state, terms);
        let BodyAcceleration {
            origin,
            spin_rate,
            second_rates,
        } = *acceleration;
        forces.force_body = inertia.mass * origin - terms.force_body;
        forces.moment = terms.rotary * spin_rate - terms.moment;
        if second_rates.is_empty() {
            return;
        }
        match &inertia.attachment_mass {
            Some(mass) => {
                forces.elastic.fill(0.0);
                mass.add_product(1.0, second_rates, &mut forces.elastic);
            }
            None => forces.elastic.copy_from_slice(second_rates),
        }
        add_scaled(simd, -1.0, &terms.force, &mut forces.elastic);
        for axis in inertia.rotation.axes() {
            let coupling = terms.coupling(axis);
            forces.moment[axis] += dot(simd, coupling, second_rates);
            add_scaled(simd, spin_rate[axis], coupling, &mut forces.elastic);
        }
        if let Some(momentum) = &inertia.momentum {
            let n = second_rates.len();
            forces.force_body +=
                momentum.linear_of(second_rates) + spin_rate.cross(&terms.first_moment);
            forces.moment += terms.first_moment.cross(&origin);
            for axis in 0..3 {
                let row = &momentum.linear[axis * n..(axis + 1) * n];
                add_scaled(simd, origin[axis], row, &mut forces.elastic);
            }
        }
    }
}
