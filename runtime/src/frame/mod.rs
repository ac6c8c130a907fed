//! Inertia of a body in its floating frame (`docs/theory.md`, inertia invariants).
//!
//! The inertia depends on the dynamic coordinates y, their rates, and the velocity V and spin ω of the frame *in body axes*, not
//! on position or orientation:
//!
//! ```text
//! T     =  ½ m |V|² + V · (L1 y' + ω × L1 y)  +  ½ ωᵀ J(y) ω  +  ωᵀ (I3 + L(y)) y'  +  ½ y'ᵀ M y'
//!
//!          | m I   -skew(L1 y)   L1        |
//! M(y)  =  |        J(y)         I3 + L(y) |        rows: translation (d), rotation (a), y (n)
//!          | sym                 M         |
//! ```
//!
//! On mean axes L1 and I3 vanish and the translation decouples from everything else; coordinates are orthonormal, M = I,
//! unless attachments are measured by their forces ([`AttachmentMass`]). [`InertiaChange`] says how far J follows y; forces
//! and energy always belong together, so energy and momentum are conserved exactly by the equations. Planar bodies use the
//! same quantities with every entry zero but those of the plane and of the z axis. The elastic forces are in [`crate::body`];
//! nothing here allocates once the terms, forces and tangents exist.

mod forces;
mod given;
mod rotary_inertia;
pub(crate) mod stacked;
pub(crate) mod tall_products;
mod tangent;
mod terms;

use dcb_formats::mesh::Dimension;
use dcb_formats::scene::InertiaChange;
use dcb_formats::superelement::Inertia;
use faer::{Mat, MatMut, MatRef};
use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};

pub use forces::{BodyAcceleration, InertiaForces};
pub use given::{AttachmentMass, FrameMomentum};
pub use rotary_inertia::RotaryInertia;
pub use tangent::{InertiaTangent, TangentBlock};
pub use terms::InertiaTerms;

/// Inertia invariants of a body over its dynamic coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameInertia {
    mass: f64,
    rotation: RotaryInertia,
    momentum: Option<FrameMomentum>,
    attachment_mass: Option<AttachmentMass>,
}

/// Deflection and velocities of a body, body axes. Slices have the body's number of coordinates.
#[derive(Clone, Copy, Debug)]
pub struct BodyState<'a> {
    /// Dynamic coordinates.
    pub y: &'a [f64],
    /// Their rates.
    pub rates: &'a [f64],
    /// Spin in body axes (planar: only z is used).
    pub spin: Vector3<f64>,
}

impl FrameInertia {
    /// The invariants of a body on mean axes over the orthonormal coordinates that the `columns` combine from those of
    /// `inertia`: `columnsᵀ · columns`.
    pub fn over(inertia: &Inertia, dimension: Dimension, columns: MatRef<'_, f64>) -> Self {
        Self {
            mass: inertia.mass,
            rotation: RotaryInertia::over(inertia, dimension, columns),
            momentum: None,
            attachment_mass: None,
        }
    }

    /// The same with the momentum that coordinates have in a frame of kind `given`.
    pub fn with_momentum(mut self, momentum: Option<FrameMomentum>) -> Self {
        self.momentum = momentum;
        self
    }

    /// The same with last coordinates that aren't orthonormal.
    pub fn with_attachment_mass(mut self, mass: AttachmentMass) -> Self {
        self.attachment_mass = Some(mass);
        self
    }

    /// The same with geometric stiffening by products of spins, over the coordinates that the columns combine.
    pub fn with_stiffening(mut self, centrifugal: &[Mat<f64>], columns: MatRef<'_, f64>) -> Self {
        self.rotation = self.rotation.with_stiffening(centrifugal, columns);
        self
    }

    /// Whether spins stiffen the body.
    pub fn is_stiffened(&self) -> bool {
        self.rotation.is_stiffened()
    }

    /// The same with the change of the rotary inertia followed no further than `change`.
    pub fn with_change(mut self, change: InertiaChange) -> Self {
        self.rotation = self.rotation.with_change(change);
        self
    }

    /// Planar or spatial.
    pub fn dimension(&self) -> Dimension {
        self.rotation.dimension()
    }

    /// Total mass.
    pub fn mass(&self) -> f64 {
        self.mass
    }

    /// Rotary inertia of the undeformed body, and how it changes.
    pub fn rotation(&self) -> &RotaryInertia {
        &self.rotation
    }

    /// L1 and I3; `None` on mean axes.
    pub fn momentum(&self) -> Option<&FrameMomentum> {
        self.momentum.as_ref()
    }

    /// J, L and the velocity-dependent forces at the coordinates `y`, their `rates` and the spin in body axes
    /// (planar: only its z entry is used). All slices have the body's number of coordinates.
    pub fn evaluate(
        &self,
        y: &[f64],
        spin_body: &Vector3<f64>,
        rates: &[f64],
        terms: &mut InertiaTerms,
    ) {
        let spin = match self.dimension() {
            Dimension::Planar => Vector3::new(0.0, 0.0, spin_body.z),
            Dimension::Spatial => *spin_body,
        };
        let state = BodyState { y, rates, spin };
        Arch::new().dispatch(Evaluation {
            inertia: self,
            state,
            terms,
        });
    }

    /// Writes M(y) of the last evaluation, (d + a + n, d + a + n): translations in body axes (any fixed axes will do on
    /// mean axes), rotations in body axes.
    pub fn write_mass_matrix(&self, terms: &InertiaTerms, mut matrix: MatMut<'_, f64>) {
        let d = self.dimension().coordinate_count();
        let axes = self.rotation.axes();
        let first = d + axes.len();
        matrix.fill(0.0);
        let turned = terms.first_moment.cross_matrix();
        for i in 0..d {
            matrix[(i, i)] = self.mass;
            for (j, b) in axes.clone().enumerate() {
                matrix[(i, d + j)] = -turned[(i, b)];
                matrix[(d + j, i)] = -turned[(i, b)];
            }
        }
        for (i, a) in axes.clone().enumerate() {
            for (j, b) in axes.clone().enumerate() {
                matrix[(d + i, d + j)] = terms.rotary[(a, b)];
            }
            for (l, value) in terms.coupling(a).iter().enumerate() {
                matrix[(d + i, first + l)] = *value;
                matrix[(first + l, d + i)] = *value;
            }
        }
        let n = terms.force.len();
        let mut elastic = matrix.as_mut().submatrix_mut(first, first, n, n);
        match &self.attachment_mass {
            Some(mass) => mass.add_matrix(1.0, elastic),
            None => (0..n).for_each(|l| elastic[(l, l)] = 1.0),
        }
        if let Some(momentum) = &self.momentum {
            for l in 0..n {
                let column = momentum.linear_column(l);
                for i in 0..d {
                    matrix[(i, first + l)] = column[i];
                    matrix[(first + l, i)] = column[i];
                }
            }
        }
    }

    #[inline(always)]
    fn evaluate_terms<S: Simd>(&self, simd: S, state: &BodyState<'_>, terms: &mut InertiaTerms) {
        match &self.momentum {
            Some(momentum) => {
                terms.coupling.copy_from_slice(&momentum.angular);
                let (p, dp) = (momentum.linear_of(state.y), momentum.linear_of(state.rates));
                let spin = &state.spin;
                terms.force_body = -(2.0 * spin.cross(&dp) + spin.cross(&spin.cross(&p)));
                (terms.first_moment, terms.first_moment_rate) = (p, dp);
            }
            None => {
                terms.coupling.fill(0.0);
                terms.force_body = Vector3::zeros();
                terms.first_moment = Vector3::zeros();
                terms.first_moment_rate = Vector3::zeros();
            }
        }
        let mass = self.attachment_mass.as_ref();
        terms.weighted_square = mass.map(|mass| mass.square(state.rates));
        terms.beyond_closed_form = match (&self.momentum, mass) {
            (Some(_), _) => Some("its frame is not on mean axes"),
            (None, Some(_)) => Some("its coordinates are not orthonormal"),
            (None, None) => None,
        };
        self.rotation.evaluate(simd, state, mass, terms);
    }
}

struct Evaluation<'a> {
    inertia: &'a FrameInertia,
    state: BodyState<'a>,
    terms: &'a mut InertiaTerms,
}

impl WithSimd for Evaluation<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.inertia.evaluate_terms(simd, &self.state, self.terms);
    }
}
