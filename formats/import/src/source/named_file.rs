//! A file, and one of the matrices in it.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// `FILE` or `FILE#NAME`: a file, and the matrix or table in it that is meant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedFile {
    /// File.
    pub path: PathBuf,
    /// Name of what is meant in it, compared without regard to case, or its number from 1; `None` for the only one.
    pub name: Option<String>,
}

impl NamedFile {
    /// The only matrix of a file.
    pub fn only(path: &Path) -> Self {
        Self {
            path: path.to_path_buf(),
            name: None,
        }
    }

    /// As it is written on the command line. A file that is there by its whole name is meant as a whole, `#` and all.
    pub fn of(argument: &Path) -> Self {
        let whole = Self::only(argument);
        let Some(text) = argument.to_str().filter(|_| !argument.exists()) else {
            return whole;
        };
        match text.rsplit_once('#') {
            Some((path, name)) if !path.is_empty() && !name.is_empty() => Self {
                path: path.into(),
                name: Some(name.to_owned()),
            },
            _ => whole,
        }
    }
}

impl FromStr for NamedFile {
    type Err = std::convert::Infallible;

    fn from_str(argument: &str) -> Result<Self, Self::Err> {
        Ok(Self::of(Path::new(argument)))
    }
}

impl fmt::Display for NamedFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.path.display())?;
        match &self.name {
            Some(name) => write!(f, "#{name}"),
            None => Ok(()),
        }
    }
}
