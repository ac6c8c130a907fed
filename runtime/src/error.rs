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
    /// A scene, or a function of time, says something that can't be used.
    #[error("{location}: {message}")]
    Description {
        /// Where: a path of keys such as `joints.axle.revolute.a`.
        location: String,
        /// What was found, and what would be right.
        message: String,
    },
}

impl Error {
    /// A fault of a description at a path of keys.
    pub(crate) fn described(location: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Description {
            location: location.into(),
            message: message.into(),
        }
    }

    /// The same fault, seen from the object that holds the place under the key `outer`.
    pub(crate) fn within(self, outer: &str) -> Self {
        match self {
            Self::Description { location, message } if location.starts_with('[') => {
                Self::described(format!("{outer}{location}"), message)
            }
            Self::Description { location, message } => {
                Self::described(format!("{outer}.{location}"), message)
            }
            other => other,
        }
    }
}
