//! Why a factorization or a basis can't be had.

/// No factor.
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
    /// A program that should start other processes can't be started.
    #[error("cannot start {program}: {source}; docs/ranks.md says what is needed")]
    CannotStart {
        /// The program.
        program: String,
        /// The system's answer.
        source: std::io::Error,
    },
    /// The processes that hold the factor failed.
    #[error("ranks: {0}")]
    Ranks(String),
}
