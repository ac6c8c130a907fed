//! `results.jsonl`: one line of JSON for each part that was made or failed, written by any number of processes.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use dcb_report::SharedLines;
use serde::{Deserialize, Serialize};

use crate::cache::Key;
use dcb_reducer::error::Error;

/// Name of the file.
pub const RESULTS: &str = "results.jsonl";

/// How a part ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// Its superelement is complete.
    Done,
    /// There is none.
    Failed,
}

/// One line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BatchRow {
    /// Name of the superelement.
    pub name: String,
    /// Stiffness matrix.
    pub part: PathBuf,
    /// How it ended.
    pub status: Status,
    /// Why it failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// Exit status of the reduction: 1 numerical failure, 2 unusable input; absent where a signal ended it.
    pub exit_status: Option<i32>,
    /// Digest of the part's files and options; absent where a file can't be read.
    pub key: Option<Key>,
    /// The superelement.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub superelement: Option<BatchSuperelement>,
    /// Wall time of the process, s.
    pub seconds: f64,
    /// Its largest resident memory, MB, where the system tells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub peak_megabytes: Option<f64>,
    /// Warnings.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// When it ended, seconds since 1970.
    pub ended: u64,
}

/// Outcome of a component.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BatchSuperelement {
    /// Name of its file, in the folder of the results.
    pub file: PathBuf,
    /// Digest.
    pub digest: String,
    /// Modes.
    pub modes: usize,
    /// Rows of the interfaces.
    pub rows: usize,
    /// Independent attachments.
    pub rank: usize,
    /// Whether it was in the cache.
    pub from_cache: bool,
}

/// Whether a row was there when this process began.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Age {
    /// It was.
    Before,
    /// It came since, from this process or another.
    Since,
}

/// The file, and what is known of it.
#[derive(Debug)]
pub struct Results {
    lines: SharedLines,
    rows: BTreeMap<String, (BatchRow, Age)>,
}

impl Results {
    /// Opens the results in a folder, or makes them.
    ///
    /// # Errors
    /// They can't be used, or have a line that isn't a row.
    pub fn open(folder: &Path) -> Result<Self, Error> {
        let mut results = Self {
            lines: SharedLines::open(&folder.join(RESULTS))?,
            rows: BTreeMap::new(),
        };
        results.read_as(Age::Before)?;
        Ok(results)
    }

    /// Reads what was added by others.
    ///
    /// # Errors
    /// As [`Results::open`].
    pub fn refresh(&mut self) -> Result<(), Error> {
        self.read_as(Age::Since)
    }

    /// The last row of a name.
    pub fn row(&self, name: &str) -> Option<&(BatchRow, Age)> {
        self.rows.get(name)
    }

    /// Adds a row and waits until the disk has it. Half a line that a killed process left is removed.
    ///
    /// # Errors
    /// A full disk, for example.
    pub fn add(&mut self, row: BatchRow) -> Result<(), Error> {
        let line = serde_json::to_string(&row).map_err(|error| {
            dcb_formats::Error::io(self.lines.path(), "cannot write", error.into())
        })?;
        let _alone = self.lines.alone()?;
        self.refresh()?;
        self.lines.append(&line)?;
        self.rows.insert(row.name.clone(), (row, Age::Since));
        Ok(())
    }

    fn read_as(&mut self, age: Age) -> Result<(), Error> {
        let (path, rows) = (self.lines.path().to_owned(), &mut self.rows);
        self.lines.read(|number, line| {
            let row: BatchRow = serde_json::from_str(line).map_err(|error| dcb_formats::Error::Line {
                path: path.clone(),
                line: number,
                message: format!(
                    "is no row of a batch ({error}); remove the line, or name another folder with -o"
                ),
            })?;
            rows.insert(row.name.clone(), (row, age));
            Ok(())
        })
    }
}
