//! Why something can't be derived from a superelement.

use crate::NoCoordinates;
use crate::NotFinite;

/// A superelement that isn't what was asked for, or numbers that have no eigenvalues.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// It has something that isn't handled.
    #[error("body {body:?}: {what}; {remedy}")]
    NotHandled {
        /// Name of the superelement.
        body: String,
        /// Found.
        what: &'static str,
        /// Remedy.
        remedy: &'static str,
    },
    /// It has no coordinates beyond its modes.
    #[error("body {body:?}: {why}")]
    NoCoordinates {
        /// Name of the superelement.
        body: String,
        /// Why not.
        why: NoCoordinates,
    },
    /// Something is selected of it that it doesn't have, or that can't be left out.
    #[error("body {body:?}: {message}")]
    Selection {
        /// Name of the superelement.
        body: String,
        /// The request, and what would be right.
        message: String,
    },
    /// A component that isn't symmetric about a plane is to move in it alone.
    #[error(transparent)]
    Asymmetric(#[from] Asymmetry),
    /// Errors are asked for over a band in which they aren't known.
    #[error(
        "the band ends at {end:.6} cycles per unit of time, and errors are known up to {limit:.6}, below the first frequency left out; take a band that ends lower, or keep more modes"
    )]
    BandTooHigh {
        /// End of the band, cycles per time unit.
        end: f64,
        /// Errors are known below this, cycles per time unit.
        limit: f64,
    },
    /// Errors are asked for between rows on which no force acts.
    #[error(
        "no force acts on the rows {rows:?} of {count}: errors are those of rows of attachments"
    )]
    NoForce {
        /// The rows.
        rows: Vec<usize>,
        /// How many rows there are.
        count: usize,
    },
    /// A dense eigenvalue problem of the error bounds failed.
    #[error("the error bounds: numbers overflowed; check the units of the matrices")]
    NotFinite,
    /// An eigenvalue computation did not converge.
    #[error(
        "no eigenvalues: the superelement's matrices are not finite or too badly scaled; check masses, stiffnesses and units"
    )]
    NoEigenvalues,
}

impl Error {
    /// Whether the input, and not the computation, is at fault.
    pub fn is_unusable_input(&self) -> bool {
        !matches!(self, Self::NoEigenvalues | Self::NotFinite)
    }
}

impl From<NotFinite> for Error {
    fn from(_: NotFinite) -> Self {
        Self::NoEigenvalues
    }
}

/// Motions in a plane and out of it that couple more than they may.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "body {body:?} isn't symmetric about the plane across {normal}: {first} and {second} couple by {coupling:.1e} of the most that they could (allowed {tolerance:.0e}); use it in space, or check mesh and interfaces"
)]
pub struct Asymmetry {
    /// Name of the body.
    pub body: String,
    /// Normal of the plane: `x`, `y` or `z`.
    pub normal: &'static str,
    /// The largest coupling, a cosine.
    pub coupling: f64,
    /// The largest allowed.
    pub tolerance: f64,
    /// One of the two.
    pub first: String,
    /// The other.
    pub second: String,
}
