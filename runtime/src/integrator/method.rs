//! How steps are made, and what they take.

use super::radau::Accuracy;
use dcb_formats::scene::Scheme;

/// At which level constraints are met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Formulation {
    /// Positions only.
    #[default]
    Index3,
    /// Positions and velocities: Gear, Gupta and Leimkuhler's stabilized index 2. Velocities meet the constraints by λ, positions by a
    /// second set of multipliers that vanishes with the step.
    StabilizedIndex2,
}

/// When an iteration is good enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Error of the accelerations that a step may leave, relative to their size in the run.
    pub relative: f64,
    /// Iterations after which a step has failed.
    pub max_iterations: usize,
}

/// How steps are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Method {
    /// The member of the family.
    pub scheme: Scheme,
    /// The level of the constraints.
    pub formulation: Formulation,
    /// When a step is good enough.
    pub tolerance: Tolerance,
}

/// How the motion is integrated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    /// Generalized alpha and its relatives.
    GeneralizedAlpha(Method),
    /// Radau IIA, by the accuracy that is wanted.
    Radau(Accuracy),
}

impl From<Method> for Rule {
    fn from(method: Method) -> Self {
        Self::GeneralizedAlpha(method)
    }
}

impl From<Accuracy> for Rule {
    fn from(accuracy: Accuracy) -> Self {
        Self::Radau(accuracy)
    }
}

/// Effort of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Newton iterations.
    pub iterations: usize,
    /// Factorizations of the iteration matrix.
    pub factorizations: usize,
}
