//! Defects of K or M alone: both are positive semi-definite, and M gives the part a mass.

use super::{Input, Places};

/// A matrix that isn't what a part has.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MatrixRefusal {
    /// Diagonal entries below zero.
    #[error(
        "the {matrix} matrix has {count} negative diagonal entries, the first {value:e} at {place}; a {matrix} matrix is positive semi-definite: check the sign convention and the export"
    )]
    NegativeDiagonal {
        /// Which matrix.
        matrix: Matrix,
        /// How many there are.
        count: usize,
        /// The first.
        value: f64,
        /// Where it is.
        place: String,
    },
    /// K + σ M has negative pivots.
    #[error(
        "the stiffness matrix is indefinite: K + {shift:.3e}·M has {pivots} negative pivot(s), at {places}; a stiffness matrix is positive semi-definite: check the element orientation, the material constants and the export{}",
        multipliers(*internal_rows)
    )]
    NegativePivots {
        /// σ, (rad/time)².
        shift: f64,
        /// How many pivots.
        pivots: usize,
        /// Where they are.
        places: Places,
        /// Rows of the part that belong to no node.
        internal_rows: usize,
    },
    /// Rows of K with other entries and nothing on the diagonal, as multipliers of constraints have.
    #[error(
        "the stiffness matrix is indefinite: {count} row(s) have entries beside the diagonal and zero on it, at {places}; such are rows of Lagrange multipliers, with no mass and K indefinite, which are no internal rows: build K and M without them (eliminate the constraints, or use penalties)"
    )]
    Multipliers {
        /// How many.
        count: usize,
        /// Which.
        places: Places,
    },
    /// A mode has a negative eigenvalue.
    #[error(
        "the stiffness matrix is indefinite: an elastic eigenvalue of {eigenvalue:.6e} (rad/time)² is negative beyond rounding; its shape is largest at {place}"
    )]
    NegativeEigenvalue {
        /// ω², (rad/time)².
        eigenvalue: f64,
        /// Where the shape is largest.
        place: String,
    },
    /// M has eigenvalues that are negative beyond what printing with few digits makes.
    #[error(
        "the mass matrix is indefinite: {count} of its eigenvalues are below -{limit:.0e} of the largest (with K's diagonal scaled to one), the lowest is between -{most:.0e} and -{least:.0e}, at {places}; a mass matrix is positive semi-definite, and printed with ten digits it is so to 1e-10: check the lumping, or export more digits"
    )]
    NegativeMass {
        /// How many.
        count: usize,
        /// What would count as zero, of the largest eigenvalue.
        limit: f64,
        /// The lowest one is below this part of the largest,
        least: f64,
        /// and not below this one.
        most: f64,
        /// Where pivots are negative.
        places: Places,
    },
    /// The part has no mass.
    #[error("the mass matrix gives a total mass of {mass:e} {unit}; it should be positive")]
    NoMass {
        /// Total mass.
        mass: f64,
        /// Its unit.
        unit: String,
    },
    /// The part has no inertia against a rigid motion.
    #[error(
        "the mass matrix gives the part no inertia against some rigid motion (all mass on one point or line); add the missing rotary inertia or more nodes"
    )]
    NoInertia,
    /// M has no inertia against rigid motions, and K resists them.
    #[error(
        "the mass matrix gives the part no inertia against some rigid motion, and the stiffness matrix resists rigid motions as a mass does: are the two swapped?"
    )]
    Swapped,
    /// A stress row sees a rigid motion.
    #[error(transparent)]
    Stress(#[from] StressRow),
}

/// A row of a stress matrix that sees a rigid motion of the part as stress.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "component.stresses.{field}: row {} ({component} at place {place}, from 0) of its matrix makes stress of a rigid motion, {defect:.1e} of its entries' sum where only rounding is expected; its columns must be the rows of the stiffness matrix, in the same order and axes",
    row + 1
)]
pub struct StressRow {
    /// Field.
    pub field: String,
    /// Row of the matrix.
    pub row: usize,
    /// Place, from 0.
    pub place: usize,
    /// Component.
    pub component: &'static str,
    /// |s r| over Σ |s_i r_i|.
    pub defect: f64,
}

/// K or M.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Matrix {
    /// K.
    Stiffness,
    /// M.
    Mass,
}

impl std::fmt::Display for Matrix {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Stiffness => "stiffness",
            Self::Mass => "mass",
        })
    }
}

/// Advice for an indefinite K with rows that may be multipliers.
fn multipliers(internal_rows: usize) -> String {
    match internal_rows {
        0 => String::new(),
        count => format!(
            "; are some of the {count} internal rows Lagrange multipliers (no mass, K indefinite)? Such are no internal rows: build K and M without them"
        ),
    }
}

impl MatrixRefusal {
    /// The file that holds the matrix.
    pub(super) fn concerns(&self) -> Input {
        match self {
            Self::NegativeDiagonal {
                matrix: Matrix::Stiffness,
                ..
            }
            | Self::NegativePivots { .. }
            | Self::Multipliers { .. }
            | Self::NegativeEigenvalue { .. } => Input::Stiffness,
            Self::NegativeDiagonal {
                matrix: Matrix::Mass,
                ..
            }
            | Self::NegativeMass { .. }
            | Self::NoMass { .. }
            | Self::NoInertia
            | Self::Swapped => Input::Mass,
            Self::Stress(_) => Input::Description,
        }
    }
}
