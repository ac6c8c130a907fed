//! What can be wrong with a file. Every variant says where, what was found and what would be right.

use std::path::PathBuf;

/// An input that can't be used, or an output that can't be written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The operating system refused.
    #[error("{}: {action}: {source}", path.display())]
    Io {
        /// File or folder.
        path: PathBuf,
        /// What was being done, for example "cannot read".
        action: &'static str,
        /// The system's answer.
        source: std::io::Error,
    },
    /// A text file has a bad line.
    #[error("{}:{line}: {message}", path.display())]
    Line {
        /// File.
        path: PathBuf,
        /// 1-based line.
        line: u64,
        /// Found and expected.
        message: String,
    },
    /// A file is unusable as a whole.
    #[error("{}: {message}", path.display())]
    File {
        /// File.
        path: PathBuf,
        /// Found and expected.
        message: String,
    },
    /// A place inside a JSON or HDF5 file is wrong.
    #[error("{}: {location}: {message}", path.display())]
    Location {
        /// File.
        path: PathBuf,
        /// JSON path such as `component.interfaces[1].nodes`, or HDF5 path such as `/modes/eigenvalues`.
        location: String,
        /// Found and expected.
        message: String,
    },
    /// The parts of a component don't fit each other.
    #[error("{message}")]
    Mismatch {
        /// Which parts, with both numbers.
        message: String,
    },
    /// The output is there already.
    #[error("{}: exists already; use --force to replace it", path.display())]
    OutputExists {
        /// Output path.
        path: PathBuf,
    },
}
