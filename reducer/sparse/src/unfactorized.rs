//! Why a matrix has no factor.

use crate::Error;
use crate::multifrontal::NotPositive;

/// Why there is no factor.
#[derive(Debug)]
pub enum Unfactorized {
    /// The matrix isn't positive definite.
    NotPositive,
    /// No room for the factor, or whoever was to hold it failed.
    Failed(Error),
}

impl From<NotPositive> for Unfactorized {
    fn from(_: NotPositive) -> Self {
        Self::NotPositive
    }
}

impl From<Error> for Unfactorized {
    fn from(error: Error) -> Self {
        Self::Failed(error)
    }
}
