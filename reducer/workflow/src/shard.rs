//! A share of the work, for array tasks of a cluster.

use std::path::Path;
use std::str::FromStr;

/// Every `count`th piece of work, beginning with the `index`th.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: usize,
    count: usize,
}

impl Shard {
    /// All of the work.
    pub const WHOLE: Self = Self { index: 1, count: 1 };

    /// Its pieces.
    pub fn of<T>(self, work: impl IntoIterator<Item = T>) -> impl Iterator<Item = T> {
        work.into_iter().skip(self.index - 1).step_by(self.count)
    }

    /// Whether there are no others.
    pub fn is_whole(self) -> bool {
        self.count == 1
    }

    /// Which one it is, from 1.
    pub fn index(self) -> usize {
        self.index
    }

    /// Whether it is the first, which does what is there only once.
    pub fn is_first(self) -> bool {
        self.index == 1
    }
}

/// What a study says whose other shares aren't all there.
pub fn waiting_for_others(made: usize, all: usize, folder: &Path) -> String {
    format!(
        "{}: {made} of {all} rows are there, those of this shard among them; the shard that ends last writes the report, as does the same command without --shard\n",
        folder.display()
    )
}

impl FromStr for Shard {
    type Err = String;

    /// From I/N.
    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = text
            .split_once('/')
            .and_then(|(index, count)| Some((index.parse().ok()?, count.parse().ok()?)));
        match parsed {
            Some((index, count)) if (1..=count).contains(&index) => Ok(Self { index, count }),
            _ => Err("I/N is wanted with I from 1 to N, for example 3/8".into()),
        }
    }
}
