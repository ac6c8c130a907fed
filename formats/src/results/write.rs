//! Rows of results into a file that can be read whatever happens to the run.
//!
//! Rows are collected in memory and written a block at a time: when the block is full, or when the last writing is
//! [`LONGEST_WAIT`] ago. HDF5 is idle between blocks and has everything on disk, so a killed run leaves a readable
//! file that lacks the unwritten block; only a kill in the milliseconds of the writing itself may damage it. The disk
//! space of a block is taken before HDF5 begins, so a full disk ends the file before that block.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde_json::json;

use super::channel::{self, Channel};
use super::frequency_response::FrequencyResponses;
use super::modes::SystemModes;
use super::open_file::{CloseError, OpenFile, OutcomeTexts, stopped_text};
use super::{Event, Header, Outcome};
use crate::Error;
use crate::component::Units;
use crate::hdf5_files::create::told;
use crate::output::Replace;
use crate::output::write_whole;

/// Rows of a block, at most.
const BLOCK_ROWS: usize = 1024;
/// Values of a block, at most, unless a single row has more: 4 MiB.
const BLOCK_VALUES: usize = 1 << 19;
/// A row is on disk no later than the first row that comes this much after the last writing.
const LONGEST_WAIT: Duration = Duration::from_secs(5);
/// Events that are kept, at most; further ones are counted.
const MOST_EVENTS: usize = 1000;

/// A results file being written.
///
/// The file has its final name from [`ResultsWriter::create`] on. Dropped without [`ResultsWriter::finish`], for
/// example by an error's `?`, it writes what it has and says that the run was abandoned.
#[derive(Debug)]
pub struct ResultsWriter {
    target: PathBuf,
    open: Option<OpenFile>,
    /// Rows of (time, values of all channels).
    block: Vec<f64>,
    block_rows: usize,
    row_values: usize,
    last_time: Option<f64>,
    last_writing: Instant,
    events: Vec<Event>,
    further_events: usize,
    units: Units,
}

impl ResultsWriter {
    /// Makes the file with no rows in it; the channels' values follow each other in this order in every row.
    /// A file that is replaced is gone from this moment on.
    ///
    /// # Errors
    /// [`Error::OutputExists`]; [`Error::Location`] for channels that can't be in one file; [`Error::Io`] where the
    /// system refuses.
    pub fn create(
        target: &Path,
        channels: &[Channel],
        header: &Header,
        replace: Replace,
    ) -> Result<Self, Error> {
        channel::check(channels).map_err(|(location, message)| Error::Location {
            path: target.to_owned(),
            location,
            message,
        })?;
        let row_values = 1 + channels.iter().map(|one| one.columns.len()).sum::<usize>();
        let block_rows = (BLOCK_VALUES / row_values).clamp(1, BLOCK_ROWS);
        let mut open = None;
        write_whole(target, replace, |partial, file| {
            let started = OpenFile::start(partial, channels, header, block_rows);
            open = Some(started.map_err(|error| {
                let length = file.metadata().map_or(0, |data| data.len());
                told(target, length, &error)
            })?);
            Ok(())
        })?;
        Ok(Self {
            target: target.to_owned(),
            open,
            block: Vec::with_capacity(block_rows * row_values),
            block_rows,
            row_values,
            last_time: None,
            last_writing: Instant::now(),
            events: Vec::new(),
            further_events: 0,
            units: header.units.clone(),
        })
    }

    /// Number of values of a row, without the time.
    pub fn value_count(&self) -> usize {
        self.row_values - 1
    }

    /// Adds the row of an accepted step. Allocates nothing but when a block is written.
    ///
    /// # Errors
    /// [`Error::Mismatch`] if there are not [`ResultsWriter::value_count`] values or the time isn't after that of the
    /// row before; [`Error::Io`] where the system refuses: the file then ends before the failed block, and no more
    /// rows are taken.
    pub fn append(&mut self, time: f64, values: &[f64]) -> Result<(), Error> {
        if values.len() != self.value_count() {
            return Err(Error::Mismatch {
                message: format!(
                    "a row of results has {} values, but the channels have {} columns",
                    values.len(),
                    self.value_count()
                ),
            });
        }
        if !time.is_finite() || self.last_time.is_some_and(|last| time <= last) {
            return Err(Error::Mismatch {
                message: format!(
                    "a row of results is at time {time}, but the one before is at {:?}; time must be finite and increase",
                    self.last_time
                ),
            });
        }
        if self.open.is_none() {
            return Err(self.closed());
        }
        self.block.push(time);
        self.block.extend_from_slice(values);
        self.last_time = Some(time);
        let is_full = self.block.len() >= self.block_rows * self.row_values;
        if is_full || self.last_writing.elapsed() >= LONGEST_WAIT {
            self.write_block()?;
        }
        Ok(())
    }

    /// Writes the modes of small oscillations; once in a file.
    ///
    /// # Errors
    /// [`Error::Io`] where the system refuses.
    pub fn write_modes(&mut self, modes: &SystemModes) -> Result<(), Error> {
        self.write_once(modes.size(), modes.dataset_count(), |file, units| {
            modes.write(file, units)
        })
    }

    /// Writes frequency responses; once in a file.
    ///
    /// # Errors
    /// [`Error::Io`] where the system refuses.
    pub fn write_frequency_responses(
        &mut self,
        responses: &FrequencyResponses,
    ) -> Result<(), Error> {
        self.write_once(
            responses.size(),
            responses.dataset_count(),
            |file, units| responses.write(file, units),
        )
    }

    /// Adds so many datasets with so many bytes.
    fn write_once(
        &mut self,
        size: u64,
        datasets: usize,
        write: impl FnOnce(&hdf5::File, &Units) -> hdf5::Result<()>,
    ) -> Result<(), Error> {
        let Some(open) = &mut self.open else {
            return Err(self.closed());
        };
        let needed = OpenFile::needed_space_of(size, datasets);
        open.take_space(needed)
            .map_err(|source| Error::not_written(&self.target, needed, source))?;
        open.write_once(|file| write(file, &self.units))
            .map_err(|error| told(&self.target, needed, &error))
    }

    /// Keeps something worth telling; it is written when the file is closed.
    pub fn note(&mut self, time: f64, message: &str) {
        if self.events.len() < MOST_EVENTS {
            self.events.push(Event {
                time,
                message: message.to_owned(),
            });
        } else {
            self.further_events += 1;
        }
    }

    /// Writes the rest, says how the run ended, and closes the file. `summary` is the run's statistics, JSON.
    ///
    /// # Errors
    /// [`Error::Io`] where the system refuses, also if a block failed before: the file then says that the run
    /// stopped there.
    pub fn finish(mut self, outcome: &Outcome, summary: &serde_json::Value) -> Result<(), Error> {
        if self.open.is_none() {
            return Err(self.closed());
        }
        self.write_block()?;
        self.close(outcome, summary)
    }

    fn write_block(&mut self) -> Result<(), Error> {
        let Some(open) = &mut self.open else {
            return Ok(());
        };
        let needed = open.needed_space(self.block.len() / self.row_values);
        let written = open
            .take_space(needed)
            .map_err(|source| Error::not_written(&self.target, needed, source))
            .and_then(|()| {
                open.write_rows(&self.block, self.row_values)
                    .map_err(|error| told(&self.target, needed, &error))
            });
        self.last_writing = Instant::now();
        if let Err(error) = written {
            let outcome = Outcome::Stopped {
                reason: error.to_string(),
                time: open.last_written,
            };
            open.withdraw_rows();
            // What went wrong first is what the caller must hear.
            let _ = self.close(&outcome, &json!(null));
            return Err(error);
        }
        self.block.clear();
        Ok(())
    }

    fn close(&mut self, outcome: &Outcome, summary: &serde_json::Value) -> Result<(), Error> {
        let Some(open) = self.open.take() else {
            return Ok(());
        };
        if self.further_events > 0 {
            self.events.push(Event {
                time: self.last_time.unwrap_or_default(),
                message: format!("and {} more", self.further_events),
            });
        }
        let texts = OutcomeTexts {
            stopped: stopped_text(outcome),
            events: json!(self.events).to_string(),
            summary: summary.to_string(),
        };
        let needed = texts.needed_space();
        open.close(&texts, outcome).map_err(|error| match error {
            CloseError::Hdf5(error) => told(&self.target, needed, &error),
            CloseError::Io(source) => Error::not_written(&self.target, needed, source),
        })
    }

    fn closed(&self) -> Error {
        Error::File {
            path: self.target.clone(),
            message: "was closed after an error; start the run again where it can be written"
                .to_owned(),
        }
    }
}

impl Drop for ResultsWriter {
    /// An error here can't be told; the rows written so far stay readable.
    fn drop(&mut self) {
        if self.open.is_some() && self.write_block().is_ok() {
            let outcome = Outcome::Stopped {
                reason: "the run was abandoned".to_owned(),
                time: self.last_time,
            };
            let _ = self.close(&outcome, &json!(null));
        }
    }
}
