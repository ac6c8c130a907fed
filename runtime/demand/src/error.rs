//! Why it can't be said what a scene needs.

/// A scene or a superelement that can't be used.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file, or what a scene says.
    #[error(transparent)]
    Formats(#[from] dcb_formats::Error),
    /// Properties that follow from a superelement.
    #[error(transparent)]
    Superelement(#[from] dcb_superelement::Error),
}

impl Error {
    /// Whether the input, and not the computation, is at fault.
    pub fn is_unusable_input(&self) -> bool {
        match self {
            Self::Formats(error) => error.is_unusable_input(),
            Self::Superelement(error) => error.is_unusable_input(),
        }
    }

    /// A fault of a scene at a path of keys.
    pub(crate) fn described(location: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Formats(dcb_formats::Error::described(location, message))
    }
}
