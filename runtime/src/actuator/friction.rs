//! Dry friction that is regularized at rest, with Stribeck's fall, and viscous friction.
//!
//! ```text
//! σ(v) = -[Fc + (Fs - Fc) exp(-(v/vs)²)] tanh(v/v0) - c v
//! ```
//! Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 30 (1994), with the sign of v as tanh(v/v0).

use super::Effort;

/// Friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// Fc.
    pub coulomb: f64,
    /// Fs.
    pub at_rest: f64,
    /// vs; infinite where friction doesn't fall.
    pub stribeck_rate: f64,
    /// c.
    pub viscous: f64,
    /// v0; infinite without dry friction.
    pub regularization: f64,
}

impl Friction {
    /// σ and its derivatives.
    pub fn effort(&self, rate: f64) -> Effort {
        let x = rate / self.stribeck_rate;
        let fall = (self.at_rest - self.coulomb) * (-x * x).exp();
        let size = self.coulomb + fall;
        let size_slope = -2.0 * x / self.stribeck_rate * fall;
        let sign = (rate / self.regularization).tanh();
        let sign_slope = (1.0 - sign * sign) / self.regularization;
        Effort {
            force: -size * sign - self.viscous * rate,
            by_value: 0.0,
            by_rate: -(size_slope * sign + size * sign_slope) - self.viscous,
        }
    }

    /// Power that becomes heat; never negative.
    pub fn dissipation(&self, rate: f64) -> f64 {
        -self.effort(rate).force * rate
    }
}
