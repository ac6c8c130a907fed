//! Why a factorization or a basis can't be had.

/// No room.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Memory ran out.
    #[error("out of memory for {what}")]
    OutOfMemory {
        /// Its use.
        what: &'static str,
    },
    /// A file can't hold the factor.
    #[error(transparent)]
    File(#[from] dcb_formats::Error),
}
