//! Inertia of a body in its floating frame (`docs/theory.md`, inertia invariants).
//!
//! On mean axes the translation of the frame decouples from everything else, and the rest depends only on the dynamic
//! coordinates y, their rates and the spin ω *in body axes*, not on position or orientation:
//!
//! ```text
//! T     =  ½ m |R'|²  +  ½ ωᵀ J(y) ω  +  ωᵀ L(y) y'  +  ½ |y'|²
//!
//!          | m I    0        0    |
//! M(y)  =  |        J(y)     L(y) |        rows: translation (d), rotation (a), y (n)
//!          | sym             I    |
//! ```
//!
//! All terms of second order in y are kept, so energy and momentum are conserved exactly by the equations. Planar bodies use
//! the same quantities with every entry zero but those of the z axis. The elastic forces are in [`crate::body`]; nothing
//! here allocates once [`InertiaTerms`] exists.

pub mod planar;
pub mod spatial;

use dcb_formats::mesh::Dimension;
use faer::{Mat, MatMut};
use nalgebra::{Matrix3, Vector3};

use crate::error::Error;
pub use planar::PlanarInertia;
pub use spatial::SpatialInertia;

/// Inertia invariants of a body over its dynamic coordinates.
#[derive(Clone, Debug, PartialEq)]
pub enum FrameInertia {
    /// One axis of rotation.
    Planar(PlanarInertia),
    /// Three axes of rotation.
    Spatial(Box<SpatialInertia>),
}

/// What the invariants amount to at one configuration and velocity; made once, overwritten by every evaluation.
#[derive(Clone, Debug, PartialEq)]
pub struct InertiaTerms {
    /// J(y), rotary inertia about the centre of mass, body axes, mass·length² (planar: only (z, z)).
    pub rotary: Matrix3<f64>,
    /// L(y)ᵀ, (n, 3): coupling of each coordinate to each axis, √mass·length (planar: only column z).
    pub coupling: Mat<f64>,
    /// Velocity-dependent moment on the frame, body axes, on the side of the applied forces.
    pub moment: Vector3<f64>,
    /// Velocity-dependent forces on y, (n), on the side of the applied forces.
    pub force: Vec<f64>,
    /// J2 y of every pair of axes, (n, 6): scratch of spatial bodies.
    second_order: Mat<f64>,
}

impl InertiaTerms {
    /// Room for a body of `count` dynamic coordinates.
    pub fn for_coordinates(count: usize) -> Self {
        Self {
            rotary: Matrix3::zeros(),
            coupling: Mat::zeros(count, 3),
            moment: Vector3::zeros(),
            force: vec![0.0; count],
            second_order: Mat::zeros(count, spatial::PAIRS.len()),
        }
    }

    /// `L(y) rates`: angular momentum of the deflection itself, body axes.
    pub fn relative_momentum(&self, rates: &[f64]) -> Vector3<f64> {
        Vector3::from_fn(|axis, _| dot(self.coupling.col_as_slice(axis), rates))
    }

    /// `J(y) ω + L(y) y'`: angular momentum about the centre of mass, body axes.
    pub fn angular_momentum(&self, spin_body: &Vector3<f64>, rates: &[f64]) -> Vector3<f64> {
        self.rotary * spin_body + self.relative_momentum(rates)
    }

    /// Kinetic energy with the centre of mass moving at `velocity` (any axes).
    pub fn kinetic_energy(
        &self,
        mass: f64,
        velocity: &Vector3<f64>,
        spin_body: &Vector3<f64>,
        rates: &[f64],
    ) -> f64 {
        let rotation = 0.5 * spin_body.dot(&(self.rotary * spin_body))
            + spin_body.dot(&self.relative_momentum(rates));
        0.5 * mass * velocity.norm_squared() + rotation + 0.5 * dot(rates, rates)
    }

    /// Accelerations of spin and coordinates under a moment (body axes) and generalised forces, which the velocity-dependent
    /// ones of the last evaluation join. `forces` is replaced by y''; the spin's acceleration is returned.
    ///
    /// ```text
    /// (J - L Lᵀ) ω'  =  r_ω - L r_y          r = applied + velocity-dependent
    /// y''            =  r_y - Lᵀ ω'
    /// ```
    ///
    /// # Errors
    /// [`Error::InertiaNotPositive`] if `J - L Lᵀ` is not positive definite over the body's axes.
    pub fn accelerations(
        &self,
        dimension: Dimension,
        moment_body: &Vector3<f64>,
        forces: &mut [f64],
    ) -> Result<Vector3<f64>, Error> {
        for (force, own) in forces.iter_mut().zip(&self.force) {
            *force += own;
        }
        let mut inertia = Matrix3::from_fn(|a, b| {
            self.rotary[(a, b)] - dot(self.coupling.col_as_slice(a), self.coupling.col_as_slice(b))
        });
        let mut moment = moment_body + self.moment - self.relative_momentum(forces);
        if dimension == Dimension::Planar {
            // The axes that a planar body doesn't turn about.
            inertia[(0, 0)] = 1.0;
            inertia[(1, 1)] = 1.0;
            (moment.x, moment.y) = (0.0, 0.0);
        }
        let factor = inertia.cholesky().ok_or(Error::InertiaNotPositive {
            inertia: inertia.diagonal().min(),
        })?;
        let spin_rate = factor.solve(&moment);
        for axis in 0..3 {
            add_scaled(forces, -spin_rate[axis], self.coupling.col_as_slice(axis));
        }
        Ok(spin_rate)
    }
}

impl FrameInertia {
    /// Planar or spatial.
    pub fn dimension(&self) -> Dimension {
        match self {
            Self::Planar(_) => Dimension::Planar,
            Self::Spatial(_) => Dimension::Spatial,
        }
    }

    /// Total mass.
    pub fn mass(&self) -> f64 {
        match self {
            Self::Planar(inertia) => inertia.mass,
            Self::Spatial(inertia) => inertia.mass,
        }
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
        match self {
            Self::Planar(inertia) => inertia.evaluate(y, spin_body.z, rates, terms),
            Self::Spatial(inertia) => inertia.evaluate(y, spin_body, rates, terms),
        }
    }

    /// Writes M(y) of the last evaluation, (d + a + n, d + a + n): translations in any fixed axes, rotations in body axes.
    pub fn write_mass_matrix(&self, terms: &InertiaTerms, mut matrix: MatMut<'_, f64>) {
        let (d, axes) = match self.dimension() {
            Dimension::Planar => (2, 2..3),
            Dimension::Spatial => (3, 0..3),
        };
        let first = d + axes.len();
        matrix.fill(0.0);
        for i in 0..d {
            matrix[(i, i)] = self.mass();
        }
        for (i, a) in axes.clone().enumerate() {
            for (j, b) in axes.clone().enumerate() {
                matrix[(d + i, d + j)] = terms.rotary[(a, b)];
            }
            for (l, value) in terms.coupling.col_as_slice(a).iter().enumerate() {
                matrix[(d + i, first + l)] = *value;
                matrix[(first + l, d + i)] = *value;
            }
        }
        for l in 0..terms.force.len() {
            matrix[(first + l, first + l)] = 1.0;
        }
    }
}

/// `a · b`
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `y += factor x`
fn add_scaled(y: &mut [f64], factor: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += factor * x;
    }
}
