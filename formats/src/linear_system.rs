//! The linear system of a mechanism about a state, as control engineers use it.
//!
//! ```text
//! x' = A x + B (u - u₀)
//! y  = y₀ + C x + D (u - u₀)
//! ```
//! x is the deviation from the motion at the state, zero there. Numbers are in the units of the scene.

use faer::Mat;

use crate::component::Units;

/// One state, input or output.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Name, for example `motor`, `tip.x` or `rod/3`.
    pub name: String,
    /// Unit, for example `m`; `1` where it has none.
    pub unit: String,
    /// Value at the operating point; zero for states, which are deviations.
    pub at: f64,
}

/// A, B, C and D with names, operating point and poles. n states, n_u inputs, n_y outputs.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearSystem {
    /// Units of the scene.
    pub units: Units,
    /// Time of the operating point.
    pub time: f64,
    /// Whether the mechanism rests there: no velocities, no accelerations.
    pub is_equilibrium: bool,
    /// A, (n, n), 1/time where all states are scaled alike.
    pub a: Mat<f64>,
    /// B, (n, n_u).
    pub b: Mat<f64>,
    /// C, (n_y, n).
    pub c: Mat<f64>,
    /// D, (n_y, n_u).
    pub d: Mat<f64>,
    /// States.
    pub states: Vec<Variable>,
    /// Inputs.
    pub inputs: Vec<Variable>,
    /// Outputs.
    pub outputs: Vec<Variable>,
    /// Eigenvalues of A by increasing magnitude.
    pub poles: Vec<Pole>,
    /// What was left out of a larger system, if anything.
    pub truncation: Option<Truncation>,
}

/// An eigenvalue s of A: motions go with exp(s t).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pole {
    /// Real part, 1/time: negative where motions decay.
    pub growth: f64,
    /// Imaginary part, rad/time.
    pub angular_frequency: f64,
}

/// A real part below this part of the magnitude is rounding.
const ROUNDING: f64 = 1e-8;

impl Pole {
    /// |s|, rad/time.
    pub fn magnitude(&self) -> f64 {
        self.growth.hypot(self.angular_frequency)
    }

    /// Cycles by time, |Im s| / 2π.
    pub fn frequency(&self) -> f64 {
        self.angular_frequency.abs() / std::f64::consts::TAU
    }

    /// -Re(s)/|s|, in [-1, 1]; zero for s = 0.
    pub fn damping_ratio(&self) -> f64 {
        match self.magnitude() {
            0.0 => 0.0,
            // No minus before a zero.
            size => -self.growth / size + 0.0,
        }
    }

    /// Whether motions grow, by more than rounding.
    pub fn is_unstable(&self) -> bool {
        self.growth > ROUNDING * self.magnitude()
    }

    /// Whether motions decay, by more than rounding.
    pub fn is_stable(&self) -> bool {
        self.growth < -ROUNDING * self.magnitude()
    }
}

/// A balanced truncation, and how far it is off at most.
///
/// With G the system before and G_r after, at every frequency `|G - G_r|` of output i by input j is at most `bounds[(i, j)]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Truncation {
    /// States of the system before.
    pub full_order: usize,
    /// Poles that don't decay; they are kept apart, exactly.
    pub kept_apart: usize,
    /// Hankel singular values of the part that decays, falling, as parts of the largest; inputs and outputs are scaled (docs/linear-systems.md).
    pub hankel: Vec<f64>,
    /// 2 Σ of the Hankel singular values left out, without unit.
    pub bound: f64,
    /// The bound of each output by each input, (n_y, n_u), in their units.
    pub bounds: Mat<f64>,
}

impl LinearSystem {
    /// Number of states.
    pub fn order(&self) -> usize {
        self.a.nrows()
    }
}
