//! `results.jsonl`: one line of JSON for each part that was made or failed, written by any number of processes.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::io_error;
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
    path: PathBuf,
    file: File,
    rows: BTreeMap<String, (BatchRow, Age)>,
    /// Bytes that were read: whole lines.
    read: u64,
    lines: u64,
}

impl Results {
    /// Opens the results in a folder, or makes them.
    ///
    /// # Errors
    /// They can't be used, or have a line that isn't a row.
    pub fn open(folder: &Path) -> Result<Self, Error> {
        let path = folder.join(RESULTS);
        let file = File::options()
            .read(true)
            .append(true)
            .create(true)
            .open(&path)
            .map_err(|source| io_error(&path, "cannot write", source))?;
        let mut results = Self {
            path,
            file,
            rows: BTreeMap::new(),
            read: 0,
            lines: 0,
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
        let failed = |source| io_error(&self.path, "cannot write", source);
        self.file.lock().map_err(failed)?;
        let added = self.add_alone(row);
        let unlocked = self.file.unlock();
        added?;
        unlocked.map_err(|source| io_error(&self.path, "cannot write", source))
    }

    fn add_alone(&mut self, row: BatchRow) -> Result<(), Error> {
        self.refresh()?;
        let failed = |source| io_error(&self.path, "cannot write", source);
        let line = serde_json::to_string(&row).map_err(|error| failed(error.into()))? + "\n";
        if self.file.metadata().map_err(failed)?.len() > self.read {
            self.file.set_len(self.read).map_err(failed)?;
        }
        self.file
            .write_all(line.as_bytes())
            .and_then(|()| self.file.sync_data())
            .map_err(failed)?;
        self.read += line.len() as u64;
        self.lines += 1;
        self.rows.insert(row.name.clone(), (row, Age::Since));
        Ok(())
    }

    fn read_as(&mut self, age: Age) -> Result<(), Error> {
        let mut text = String::new();
        self.file
            .seek(SeekFrom::Start(self.read))
            .and_then(|_| self.file.read_to_string(&mut text))
            .map_err(|source| io_error(&self.path, "cannot read", source))?;
        for line in text.split_inclusive('\n') {
            // Only what ends in a line break was written completely.
            let Some(whole) = line.strip_suffix('\n') else {
                break;
            };
            let row: BatchRow = serde_json::from_str(whole).map_err(|error| {
                Error::File(dcb_formats::Error::Line {
                    path: self.path.clone(),
                    line: self.lines + 1,
                    message: format!(
                        "is no row of a batch ({error}); remove the line, or name another folder with -o"
                    ),
                })
            })?;
            self.rows.insert(row.name.clone(), (row, age));
            self.read += line.len() as u64;
            self.lines += 1;
        }
        Ok(())
    }
}
