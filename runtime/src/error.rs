//! Why a body can't be used, or a motion can't be continued.

/// What went wrong, and what would be right.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The superelement's file can't be used.
    #[error(transparent)]
    File(#[from] dcb_formats::Error),
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
    /// Accelerations were asked for in a closed form that the body doesn't have.
    #[error("no closed form for the accelerations of this body: {what}")]
    NoClosedForm {
        /// What the body has beyond it.
        what: &'static str,
    },
    /// A quantity of a body made in memory has to be positive and isn't.
    #[error("body {body:?}: {quantity} has to be {required}, but {found:.3e} was found in it")]
    NotPositive {
        /// Name of the body.
        body: String,
        /// What it is.
        quantity: &'static str,
        /// `positive`, or a weaker demand.
        required: &'static str,
        /// The offending value: an eigenvalue of a matrix.
        found: f64,
    },
    /// Arrays of a body made in memory don't fit each other.
    #[error(
        "body {body:?}: {quantity} has {found:?} rows and columns, but {expected:?} are needed"
    )]
    Shape {
        /// Name of the body.
        body: String,
        /// Which array.
        quantity: &'static str,
        /// Rows and columns found.
        found: (usize, usize),
        /// Rows and columns needed.
        expected: (usize, usize),
    },
    /// An interface doesn't say how a frame moves.
    #[error(
        "body {body:?}: interface {interface:?} is of kind `{kind}` and has no frame that a joint or a load could act on; make it `average` or `rigid`"
    )]
    NoFrame {
        /// Name of the body.
        body: String,
        /// Name of the interface.
        interface: String,
        /// Its kind.
        kind: &'static str,
    },
}
