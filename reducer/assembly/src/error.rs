//! Why parts can't be put together.

/// Parts that don't go together, or numbers that have no modes.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file can't be read, or isn't what it should be.
    #[error(transparent)]
    File(#[from] dcb_formats::Error),
    /// Something can't be derived from a superelement.
    #[error(transparent)]
    Superelement(#[from] dcb_superelement::Error),
    /// A body isn't what the assembly takes it for.
    #[error("bodies.{body}: {message}")]
    Body {
        /// Its name.
        body: String,
        /// What was found, and what was expected.
        message: String,
    },
    /// A joint, spring or interface isn't at places that fit.
    #[error("{location}: {message}")]
    Place {
        /// Its path of keys.
        location: String,
        /// What was found, and what was expected.
        message: String,
    },
    /// The whole isn't one free or held body.
    #[error("{0}")]
    Whole(String),
    /// A dense computation failed, which only numbers that aren't finite cause.
    #[error(
        "{what}: numbers overflowed; check the units of the superelements and stiffnesses of the assembly"
    )]
    NotFinite {
        /// What was computed.
        what: &'static str,
    },
}

impl Error {
    /// Whether the input, and not the computation, is at fault.
    pub fn is_unusable_input(&self) -> bool {
        match self {
            Self::NotFinite { .. } => false,
            Self::Superelement(error) => error.is_unusable_input(),
            Self::File(error) => !error.is_out_of_memory(),
            Self::Body { .. } | Self::Place { .. } | Self::Whole(_) => true,
        }
    }

    pub(crate) fn body(name: &str, message: impl Into<String>) -> Self {
        Self::Body {
            body: name.to_owned(),
            message: message.into(),
        }
    }

    pub(crate) fn place(location: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Place {
            location: location.into(),
            message: message.into(),
        }
    }
}
