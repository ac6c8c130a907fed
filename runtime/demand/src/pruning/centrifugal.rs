//! How much of a body's response to its own spin stays.
//!
//! ```text
//! f_k = ∂J/∂y_k            the centrifugal force on a coordinate for each product of spins, first order
//! E   = Σ_k |f_k|² / κ_k    twice the strain energy under unit spins, all products together
//! U²  = Σ_k |f_k|² / κ_k²   the square of the displacement, by the mass
//! ```

use dcb_formats::superelement::Superelement;

use crate::Error;
use crate::demand::{DEFLECTION_OF_INTEREST, Spin};
use dcb_formats::scene::Compatibility;
use dcb_superelement::DynamicCoordinates;

/// A body that isn't driven may turn so many times as fast as anything that the scene mentions,
const FASTER: f64 = 3.0;
/// and a body of radius of gyration r that falls with g has a square of its rate below this many g/r.
const FALLING: f64 = 10.0;

/// Static response to unit spins.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Response {
    /// E.
    energy: f64,
    /// U².
    displacement: f64,
}

impl Response {
    /// That of a superelement.
    ///
    /// # Errors
    /// Those of [`DynamicCoordinates::of`].
    pub fn of(of: &Superelement) -> Result<Self, Error> {
        let coordinates = DynamicCoordinates::of(of, Compatibility::Strong)?;
        let columns = coordinates.to_file();
        let mut response = Self::default();
        for (column, stiffness) in columns.col_iter().zip(&coordinates.stiffness) {
            if *stiffness <= 0.0 {
                continue;
            }
            let mut force = [[0.0; 3]; 3];
            for (block, amount) in of.inertia.i1.iter().zip(column.iter()) {
                for (sum, row) in force.iter_mut().zip(block) {
                    for (sum, entry) in sum.iter_mut().zip(row) {
                        *sum += amount * entry;
                    }
                }
            }
            let square: f64 = force.iter().flatten().map(|entry| entry * entry).sum();
            response.energy += square / stiffness;
            response.displacement += square / (stiffness * stiffness);
        }
        Ok(response)
    }
}

/// The response of a body before something is left out of it, and how much its loss counts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Centrifugal {
    whole: Response,
    /// What the displacement under unit spins is multiplied with to be compared with deflections of interest; `None` where nobody knows how fast the body turns.
    weight: Option<f64>,
}

impl Centrifugal {
    /// Of a body with this spin.
    ///
    /// # Errors
    /// Those of [`Response::of`].
    pub fn of(body: &Superelement, spin: &Spin) -> Result<Self, Error> {
        let radius = body.inertia.radius_of_gyration();
        let square = match (spin.known, spin.falls) {
            (true, _) => Some(spin.rate.powi(2)),
            (false, Some(gravity)) => {
                Some((FASTER * spin.rate).powi(2) + FALLING * gravity / radius)
            }
            (false, None) => None,
        };
        Ok(Self {
            whole: Response::of(body)?,
            weight: square.map(|square| {
                square / (body.inertia.mass.sqrt() * DEFLECTION_OF_INTEREST * radius)
            }),
        })
    }

    /// Whether the spin strains the body at all.
    pub fn counts(&self) -> bool {
        self.whole.energy > 0.0 && self.weight != Some(0.0)
    }

    /// What is lost with a smaller superelement of a body whose spin counts: displacement by deflections of interest, or else the root of the share of strain
    /// energy.
    ///
    /// # Errors
    /// Those of [`Response::of`].
    pub fn lost(&self, smaller: &Superelement) -> Result<f64, Error> {
        let (whole, left) = (self.whole, Response::of(smaller)?);
        let share = (1.0 - left.energy / whole.energy).max(0.0);
        Ok(match self.weight {
            None => share.sqrt(),
            Some(weight) => {
                // The lost part is taken as soft as the whole, or as its displacements say.
                let square =
                    (whole.displacement - left.displacement).max(share * whole.displacement);
                weight * square.sqrt()
            }
        })
    }
}
