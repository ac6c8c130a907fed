//! Where something is: the first few names of a list that may be long, and how many more there are.

use std::fmt;

/// Longest list in a message.
pub(crate) const LISTED: usize = 6;

/// The first names of a list.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Places {
    /// At most six, for example `node 3 ux`.
    pub first: Vec<String>,
    /// How many follow them.
    pub more: usize,
}

impl Places {
    /// The first of these names.
    pub(crate) fn of(mut names: impl Iterator<Item = String>) -> Self {
        Self {
            first: names.by_ref().take(LISTED).collect(),
            more: names.count(),
        }
    }
}

impl fmt::Display for Places {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The processes of --ranks count pivots and don't say where they are.
        if self.first.is_empty() && self.more == 0 {
            return f.write_str("places that a reduction without --ranks tells");
        }
        f.write_str(&self.first.join(", "))?;
        match self.more {
            0 => Ok(()),
            more => write!(f, " and {more} more"),
        }
    }
}
