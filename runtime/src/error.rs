//! Why a body can't be used, or a motion can't be continued.

use std::path::PathBuf;

/// What went wrong, and what would be right.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The superelement's file can't be used.
    #[error(transparent)]
    File(#[from] dcb_formats::Error),
    /// A file can't be written.
    #[error("{}: cannot write: {source}", path.display())]
    CannotWrite {
        /// File or folder.
        path: PathBuf,
        /// The system's answer.
        source: std::io::Error,
    },
    /// Nodal fields, mesh and body don't belong together, or a picture of them isn't possible.
    #[error("body {body:?}: {message}")]
    Field {
        /// Name of the body.
        body: String,
        /// Found and expected.
        message: String,
    },
    /// There is nothing to show.
    #[error("{}: {message}", path.display())]
    NothingToShow {
        /// The file that would have shown it.
        path: PathBuf,
        /// What is missing.
        message: String,
    },
    /// The superelement has something that the dynamics doesn't handle.
    #[error("body {body:?}: {what}; {remedy}")]
    NotHandled {
        /// Name of the body.
        body: String,
        /// What was found.
        what: &'static str,
        /// What to do instead.
        remedy: &'static str,
    },
    /// The frame is called mean-axis, but the basis has momentum in it.
    #[error(
        "body {body:?}: {quantity} of the basis is {found:.1e} of a rigid motion's, but a mean-axis frame allows {limit:.0e}; reduce the component again"
    )]
    NotMeanAxis {
        /// Name of the body.
        body: String,
        /// `L1` or `I3`.
        quantity: &'static str,
        /// The largest cosine between a rigid motion and a column of the basis.
        found: f64,
        /// The largest allowed.
        limit: f64,
    },
    /// The mass matrix is not positive definite at this deflection.
    #[error(
        "the rotary inertia left after eliminating the deflection is not positive ({inertia:.3e}): the deflection is far beyond what linear elasticity describes"
    )]
    InertiaNotPositive {
        /// The smallest diagonal entry of `J - L Lᵀ`.
        inertia: f64,
    },
}
