//! Values of the invariants at one configuration and velocity.

use dcb_formats::mesh::Dimension;
use nalgebra::{Matrix3, Vector3};

use super::rotary_inertia::PAIRS;
use crate::error::Error;

/// Values of the invariants at one configuration and velocity; made once, overwritten by every evaluation of the same
/// body.
#[derive(Clone, Debug, PartialEq)]
pub struct InertiaTerms {
    /// J(y), rotary inertia about the frame's origin, body axes, mass·length² (planar: only (z, z)).
    pub rotary: Matrix3<f64>,
    /// Velocity-dependent force on the frame, body axes, on the side of the applied forces; zero on mean axes.
    pub force_body: Vector3<f64>,
    /// Velocity-dependent moment on the frame, body axes, on the side of the applied forces.
    pub moment: Vector3<f64>,
    /// Velocity-dependent forces on y, (n), on the side of the applied forces.
    pub force: Vec<f64>,
    /// dJ/dt.
    pub(super) rotary_rate: Matrix3<f64>,
    /// (I3 + L(y))ᵀ, axis by axis, (n) each.
    pub(super) coupling: Vec<f64>,
    /// L(y')ᵀ, axis by axis, (n) each.
    pub(super) rate_coupling: Vec<f64>,
    /// J'_k = ∂J/∂y_k, pair of axes by pair, (n) each.
    pub(super) gradient: Vec<f64>,
    /// (I3 + L(y)) y'.
    pub(super) relative: Vector3<f64>,
    /// L1 y, first moment of mass about the frame's origin.
    pub(super) first_moment: Vector3<f64>,
    /// L1 y'.
    pub(super) first_moment_rate: Vector3<f64>,
    /// `y'ᵀ M y'` of coordinates that aren't orthonormal.
    pub(super) weighted_square: Option<f64>,
    /// Terms of the body beyond the closed form of [`InertiaTerms::accelerations`].
    pub(super) beyond_closed_form: Option<&'static str>,
}

impl InertiaTerms {
    /// Room for a body of `count` dynamic coordinates.
    pub fn for_coordinates(count: usize) -> Self {
        Self {
            rotary: Matrix3::zeros(),
            force_body: Vector3::zeros(),
            moment: Vector3::zeros(),
            force: vec![0.0; count],
            rotary_rate: Matrix3::zeros(),
            coupling: vec![0.0; 3 * count],
            rate_coupling: vec![0.0; 3 * count],
            gradient: vec![0.0; PAIRS.len() * count],
            relative: Vector3::zeros(),
            first_moment: Vector3::zeros(),
            first_moment_rate: Vector3::zeros(),
            weighted_square: None,
            beyond_closed_form: None,
        }
    }

    /// Row `axis` of I3 + L(y), (n), √mass·length: coupling of each coordinate to a rotation (planar: only z).
    pub fn coupling(&self, axis: usize) -> &[f64] {
        let n = self.force.len();
        &self.coupling[axis * n..(axis + 1) * n]
    }

    /// `L1 y`, first moment of mass about the frame's origin, body axes, mass·length; zero on mean axes.
    pub fn first_moment(&self) -> &Vector3<f64> {
        &self.first_moment
    }

    /// `(I3 + L(y)) rates`: angular momentum of the deflection itself, body axes.
    pub fn relative_momentum(&self, rates: &[f64]) -> Vector3<f64> {
        Vector3::from_fn(|axis, _| dot(self.coupling(axis), rates))
    }

    /// `J(y) ω + (I3 + L(y)) y'`: angular momentum about the frame's origin at rest, body axes. On mean axes a motion of
    /// the origin, the centre of mass, adds nothing; else [`InertiaTerms::momenta`] has it.
    pub fn angular_momentum(&self, spin_body: &Vector3<f64>, rates: &[f64]) -> Vector3<f64> {
        self.rotary * spin_body + self.relative_momentum(rates)
    }

    /// Linear momentum, and angular momentum about the frame's origin, of a body whose origin moves at `velocity_body`,
    /// at the rates and spin of the last evaluation; body axes.
    ///
    /// ```text
    /// P = m V + L1 y' + ω × L1 y          H = J ω + (I3 + L) y' + L1 y × V
    /// ```
    pub fn momenta(
        &self,
        mass: f64,
        velocity_body: &Vector3<f64>,
        spin_body: &Vector3<f64>,
    ) -> (Vector3<f64>, Vector3<f64>) {
        (
            mass * velocity_body + self.first_moment_rate + spin_body.cross(&self.first_moment),
            self.rotary * spin_body + self.relative + self.first_moment.cross(velocity_body),
        )
    }

    /// Kinetic energy at the spin and rates of the last evaluation with the frame's origin moving at `velocity`: in body
    /// axes, or any axes on mean axes.
    ///
    /// ```text
    /// T = ½ m |V|² + V · (L1 y' + ω × L1 y) + ½ ωᵀ J ω + ωᵀ (I3 + L) y' + ½ y'ᵀ M y'
    /// ```
    pub fn kinetic_energy(
        &self,
        mass: f64,
        velocity: &Vector3<f64>,
        spin_body: &Vector3<f64>,
        rates: &[f64],
    ) -> f64 {
        let rotation = 0.5 * spin_body.dot(&(self.rotary * spin_body))
            + spin_body.dot(&self.relative_momentum(rates));
        let deflection = self.first_moment_rate + spin_body.cross(&self.first_moment);
        0.5 * mass * velocity.norm_squared()
            + velocity.dot(&deflection)
            + rotation
            + 0.5 * self.weighted_square.unwrap_or_else(|| dot(rates, rates))
    }

    /// Accelerations of spin and coordinates of a body on mean axes under a moment (body axes) and generalised forces, which
    /// the velocity-dependent ones of the last evaluation join. `forces` is replaced by y''; the spin's acceleration is
    /// returned.
    ///
    /// ```text
    /// (J - L Lᵀ) ω'  =  r_ω - L r_y          r = applied + velocity-dependent
    /// y''            =  r_y - Lᵀ ω'
    /// ```
    ///
    /// # Errors
    /// [`Error::InertiaNotPositive`] if `J - L Lᵀ` is not positive definite over the body's axes;
    /// [`Error::NoClosedForm`] if the frame isn't on mean axes or the coordinates aren't orthonormal.
    pub fn accelerations(
        &self,
        dimension: Dimension,
        moment_body: &Vector3<f64>,
        forces: &mut [f64],
    ) -> Result<Vector3<f64>, Error> {
        if let Some(what) = self.beyond_closed_form {
            return Err(Error::NoClosedForm { what });
        }
        for (force, own) in forces.iter_mut().zip(&self.force) {
            *force += own;
        }
        let mut inertia =
            Matrix3::from_fn(|a, b| self.rotary[(a, b)] - dot(self.coupling(a), self.coupling(b)));
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
            for (force, coupling) in forces.iter_mut().zip(self.coupling(axis)) {
                *force -= spin_rate[axis] * coupling;
            }
        }
        Ok(spin_rate)
    }
}

/// `a · b`
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
