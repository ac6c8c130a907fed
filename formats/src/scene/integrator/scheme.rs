//! The family of generalized-alpha methods.
//!
//! ```text
//! (1 - α_m) a_{n+1} + α_m a_n = (1 - α_f) q''_{n+1} + α_f q''_n
//! Δq        = h q'_n + h² (½ - β) a_n + h² β a_{n+1}
//! q'_{n+1}  = q'_n + h (1 - γ) a_n + h γ a_{n+1}
//! ```
//! The equations of motion hold at n + 1 with the true acceleration q''; Δq is an increment of the Lie group, so turns compose
//! exactly (Brüls and Cardona 2010). All members here are of second order.

use super::Method;

/// Coefficients of one method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scheme {
    /// α_m.
    pub alpha_m: f64,
    /// α_f.
    pub alpha_f: f64,
    /// β.
    pub beta: f64,
    /// γ.
    pub gamma: f64,
}

impl Scheme {
    /// The one that a scene asks for; `None` for other families.
    pub fn of(method: Method) -> Option<Self> {
        match method {
            Method::GeneralizedAlpha { rho_infinity } => {
                Some(Self::generalized_alpha(rho_infinity))
            }
            Method::Hht { alpha } => Some(Self::hht(alpha)),
            Method::Radau { .. } => None,
        }
    }

    /// Chung and Hulbert's method: `spectral_radius` in [0, 1] is what a step leaves of motion far above its resolution.
    pub fn generalized_alpha(spectral_radius: f64) -> Self {
        Self::with(
            (2.0 * spectral_radius - 1.0) / (spectral_radius + 1.0),
            spectral_radius / (spectral_radius + 1.0),
        )
    }

    /// Hilber, Hughes and Taylor's method, `alpha` in [-1/3, 0].
    pub fn hht(alpha: f64) -> Self {
        Self::with(0.0, -alpha)
    }

    /// γ and β that make the method of second order and damp most at high frequency.
    fn with(alpha_m: f64, alpha_f: f64) -> Self {
        let gamma = 0.5 + alpha_f - alpha_m;
        Self {
            alpha_m,
            alpha_f,
            beta: 0.25 * (0.5 + gamma) * (0.5 + gamma),
            gamma,
        }
    }

    /// β' = ∂q''/∂Δq at step h.
    pub fn acceleration_slope(&self, step: f64) -> f64 {
        (1.0 - self.alpha_m) / ((1.0 - self.alpha_f) * self.beta * step * step)
    }

    /// γ' = ∂q'/∂Δq at step h.
    pub fn velocity_slope(&self, step: f64) -> f64 {
        self.gamma / (self.beta * step)
    }

    /// α_m - α_f: a_n is the acceleration at this many steps after t_n, to second order in the step.
    pub fn time_ahead(&self) -> f64 {
        self.alpha_m - self.alpha_f
    }

    /// Error constant: an increment lacks this times h³ q''' of the motion.
    pub fn increment_error(&self) -> f64 {
        1.0 / 6.0 - self.beta - 0.5 * self.time_ahead()
    }

    /// a_{n+1} from the accelerations at both ends and a_n.
    pub fn algorithmic(&self, algorithmic: f64, before: f64, after: f64) -> f64 {
        ((1.0 - self.alpha_f) * after + self.alpha_f * before - self.alpha_m * algorithmic)
            / (1.0 - self.alpha_m)
    }

    /// Δq.
    pub fn increment(&self, step: f64, velocity: f64, before: f64, after: f64) -> f64 {
        step * (velocity + step * ((0.5 - self.beta) * before + self.beta * after))
    }

    /// q'_{n+1}.
    pub fn velocity(&self, step: f64, velocity: f64, before: f64, after: f64) -> f64 {
        velocity + step * ((1.0 - self.gamma) * before + self.gamma * after)
    }

    /// `h σ` above which a growing motion `x'' = σ² x` is damped instead: where the method's root reaches -1,
    /// `z² = 2 (1 - 2 α_m) / ((2 β - γ)(1 - 2 α_f))`. Infinite for a method without numerical damping.
    pub fn growth_limit(&self) -> f64 {
        let squared = 2.0 * (1.0 - 2.0 * self.alpha_m)
            / ((2.0 * self.beta - self.gamma) * (1.0 - 2.0 * self.alpha_f));
        if squared.is_finite() && squared > 0.0 {
            squared.sqrt()
        } else {
            f64::INFINITY
        }
    }

    /// Spectral radius of an infinitely stiff motion.
    pub fn spectral_radius(&self) -> f64 {
        // Roots at infinity: of the acceleration relation, and the double one of β λ² + (½ + γ - 2β) λ + ½ - γ + β with β = ¼ (γ + ½)².
        let of_acceleration = self.alpha_f / (1.0 - self.alpha_f);
        let of_displacement = (1.0 - 2.0 / (self.gamma + 0.5)).abs();
        of_acceleration.max(of_displacement)
    }
}
