//! Faults of a file. Every variant says where, what was found and what would be right.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// An input that can't be used, or an output that can't be written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The operating system refused.
    #[error("{}: {action}: {source}", path.display())]
    Io {
        /// File or folder.
        path: PathBuf,
        /// Action that failed, for example "cannot read".
        action: &'static str,
        /// The system's answer.
        source: std::io::Error,
    },
    /// There is no room for an output.
    #[error("{}: {}: needs {}; make room, or name another place ({source})", path.display(), no_room(source), bytes(*needed))]
    NoRoom {
        /// File.
        path: PathBuf,
        /// Bytes that it needs, at least.
        needed: u64,
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
    /// Rows that don't fit the results file that they are for.
    #[error("{message}")]
    Mismatch {
        /// Which row, with both numbers.
        message: String,
    },
    /// The file takes more memory than it may, or than there is.
    #[error(
        "{}: not enough memory: takes {} MB{}", path.display(), needed.div_ceil(1 << 20), of_allowed(*allowed)
    )]
    NotEnoughMemory {
        /// File.
        path: PathBuf,
        /// Needed for what is known of it, bytes.
        needed: u64,
        /// Bytes allowed; `None` where the system refused.
        allowed: Option<u64>,
    },
    /// A scene, or a function of time, says something that can't be used.
    #[error("{location}: {message}")]
    Description {
        /// Where: a path of keys such as `joints.axle.revolute.a`.
        location: String,
        /// Found and expected.
        message: String,
    },
    /// The output is there already.
    #[error("{}: exists already; use --force to replace it", path.display())]
    OutputExists {
        /// Output path.
        path: PathBuf,
    },
}

impl Error {
    /// The system refused an action on a file, for example `cannot read`.
    pub fn io(path: &Path, action: &'static str, source: std::io::Error) -> Self {
        Self::Io {
            path: path.to_owned(),
            action,
            source,
        }
    }

    /// The system refused to write; `needed` are the bytes that there should have been room for, 0 if that isn't known.
    pub fn not_written(path: &Path, needed: u64, source: std::io::Error) -> Self {
        match source.kind() {
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => {
                Self::NoRoom {
                    path: path.to_owned(),
                    needed,
                    source,
                }
            }
            _ => Self::io(path, "cannot write", source),
        }
    }

    /// A fault of a description at a path of keys.
    pub fn described(location: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Description {
            location: location.into(),
            message: message.into(),
        }
    }

    /// The same fault, seen from the object that holds the place under the key `outer`.
    pub fn within(self, outer: &str) -> Self {
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

    /// A fault of a description as one of the file that holds it.
    pub fn in_file(self, path: &Path) -> Self {
        match self {
            Self::Description { location, message } => Self::Location {
                path: path.to_owned(),
                location,
                message,
            },
            other => other,
        }
    }

    /// Whether the input, and not the machine, is at fault.
    pub fn is_unusable_input(&self) -> bool {
        !self.is_out_of_memory()
    }

    /// Whether the system had no memory, so that nothing is wrong with the file.
    pub fn is_out_of_memory(&self) -> bool {
        matches!(self, Self::Io { source, .. } if source.kind() == ErrorKind::OutOfMemory)
    }
}

fn no_room(source: &std::io::Error) -> &'static str {
    match source.kind() {
        ErrorKind::QuotaExceeded => "the quota is used up",
        ErrorKind::FileTooLarge => "larger than a file may be here (ulimit -f)",
        _ => "disk full",
    }
}

/// A number of bytes for people.
fn bytes(count: u64) -> String {
    match count {
        0 => "more than there is".to_owned(),
        1..1_000_000 => format!("{count} bytes"),
        1_000_000..1_000_000_000 => format!("{:.1} MB", count as f64 / 1e6),
        _ => format!("{:.2} GB", count as f64 / 1e9),
    }
}

fn of_allowed(allowed: Option<u64>) -> String {
    match allowed {
        Some(bytes) => format!(
            " or more, and {} MB may be taken; allow more with --memory, if the machine has it",
            bytes >> 20
        ),
        None => {
            ", which the system doesn't give; use a machine with more memory, or a coarser mesh"
                .into()
        }
    }
}
