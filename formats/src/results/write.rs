//! Rows of results into a file that can be read whatever happens to the run.
//!
//! Rows are collected in memory and written a block at a time: when the block is full, or when the last writing is
//! [`LONGEST_WAIT`] ago. HDF5 is idle between blocks and has everything on disk, so a killed run leaves a readable
//! file that lacks the unwritten block; only a kill in the milliseconds of the writing itself may damage it.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use hdf5::Dataset;
use ndarray::{ArrayView2, s};
use serde_json::json;

use super::channel::{self, Channel};
use super::{Event, FORMAT, FORMAT_VERSION, Header, Outcome};
use crate::Error;
use crate::dcb::Replace;
use crate::dcb::attributes::{self, Value, hdf5_text};
use crate::dcb::create::{create, told};
use crate::dcb::output::write_whole;

/// Rows of a block, at most.
const BLOCK_ROWS: usize = 1024;
/// Values of a block, at most, unless a single row has more: 4 MiB.
const BLOCK_VALUES: usize = 1 << 19;
/// Rows of a chunk in the file, at most.
const CHUNK_ROWS: usize = 256;
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
        write_whole(target, replace, |partial| {
            let started = OpenFile::start(partial, channels, header, block_rows);
            open = Some(started.map_err(|error| told(target, &error))?);
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
        let result = open.write_rows(&self.block, self.row_values);
        self.last_writing = Instant::now();
        match result {
            Ok(()) => {
                self.block.clear();
                Ok(())
            }
            Err(error) => {
                let failure = told(&self.target, &error);
                let time = open.last_written;
                open.withdraw_rows();
                let reason = failure.to_string();
                // What went wrong first is what the caller must hear.
                let _ = self.close(&Outcome::Stopped { reason, time }, &json!(null));
                Err(failure)
            }
        }
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
        let events = json!(self.events);
        open.close(outcome, summary, &events)
            .map_err(|error| told(&self.target, &error))?;
        std::fs::File::open(&self.target)
            .and_then(|file| file.sync_all())
            .map_err(|source| Error::Io {
                path: self.target.clone(),
                action: "cannot write",
                source,
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
    /// What goes wrong here can't be told; the rows written so far stay readable.
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

/// The HDF5 side: `/time` and the channels, all with the same number of rows.
#[derive(Debug)]
struct OpenFile {
    file: hdf5::File,
    time: Dataset,
    channels: Vec<(Dataset, usize)>,
    /// Values of one dataset's part of a block.
    part: Vec<f64>,
    rows: usize,
    last_written: Option<f64>,
}

impl OpenFile {
    fn start(
        path: &Path,
        channels: &[Channel],
        header: &Header,
        block_rows: usize,
    ) -> hdf5::Result<Self> {
        let file = create(path)?;
        write_header(&file, header)?;
        let chunk_rows = block_rows.min(CHUNK_ROWS);
        // Blocks are larger than chunks: a cache would only keep what is never touched again.
        let builder = || file.new_dataset::<f64>().chunk_cache(1, 0, 1.0);
        let time = builder().chunk([chunk_rows]).shape(0..).create("time")?;
        let unit = header.units.time.as_str();
        write_text(&time, "units", unit)?;
        write_text(&time, "description", "time of the accepted steps")?;
        let mut datasets = Vec::with_capacity(channels.len());
        for channel in channels {
            let columns = channel.columns.len();
            let dataset = builder()
                .chunk([chunk_rows, columns])
                .shape((0.., columns))
                .create(channel.path.as_str())?;
            write_channel(&dataset, channel)?;
            datasets.push((dataset, columns));
        }
        file.flush()?;
        let most_columns = datasets.iter().map(|(_, columns)| *columns).max();
        Ok(Self {
            file,
            time,
            channels: datasets,
            part: Vec::with_capacity(block_rows * most_columns.unwrap_or(1)),
            rows: 0,
            last_written: None,
        })
    }

    fn write_rows(&mut self, block: &[f64], row_values: usize) -> hdf5::Result<()> {
        let count = block.len() / row_values;
        if count == 0 {
            return Ok(());
        }
        let (start, end) = (self.rows, self.rows + count);
        let rows = || block.chunks_exact(row_values);
        let mut first = 1;
        for (dataset, columns) in &self.channels {
            self.part.clear();
            for row in rows() {
                self.part.extend_from_slice(&row[first..first + columns]);
            }
            first += columns;
            dataset.resize((end, *columns))?;
            let part = ArrayView2::from_shape((count, *columns), &self.part)
                .map_err(|error| hdf5::Error::from(error.to_string()))?;
            dataset.write_slice(part, s![start..end, ..])?;
        }
        self.part.clear();
        self.part.extend(rows().map(|row| row[0]));
        self.time.resize(end)?;
        self.time
            .write_slice(self.part.as_slice(), s![start..end])?;
        self.file.flush()?;
        self.rows = end;
        self.last_written = self.part.last().copied();
        Ok(())
    }

    /// Takes back what a failed writing left of its rows, as far as that is possible.
    fn withdraw_rows(&self) {
        let _ = self.time.resize(self.rows);
        for (dataset, columns) in &self.channels {
            let _ = dataset.resize((self.rows, *columns));
        }
    }

    fn close(
        self,
        outcome: &Outcome,
        summary: &serde_json::Value,
        events: &serde_json::Value,
    ) -> hdf5::Result<()> {
        let Self {
            file,
            time,
            channels,
            ..
        } = self;
        drop((time, channels));
        let written = write_outcome(&file, outcome)
            .and_then(|()| {
                let provenance = file.group("provenance")?;
                write_text(&provenance, "events", &events.to_string())?;
                write_text(&provenance, "summary", &summary.to_string())
            })
            .and_then(|()| file.flush());
        let closed = file.close();
        written.and(closed)
    }
}

fn write_header(file: &hdf5::File, header: &Header) -> hdf5::Result<()> {
    let units = &header.units;
    let units = json!({ "length": units.length, "mass": units.mass, "time": units.time });
    let inputs: Vec<_> = header
        .inputs
        .iter()
        .map(|source| json!({ "role": source.role, "file_name": source.file_name, "sha256": source.sha256 }))
        .collect();
    write_text(file, "format", FORMAT)?;
    write_text(file, "format_version", &FORMAT_VERSION.to_string())?;
    write_text(file, "generator", &header.generator)?;
    write_text(file, "units", &units.to_string())?;
    file.new_attr::<bool>()
        .create("complete")?
        .write_scalar(&false)?;
    let unfinished = Outcome::Stopped {
        reason: "the run is going on, or was killed before it could say why it ends".to_owned(),
        time: None,
    };
    write_text(file, "stopped", &stopped_text(&unfinished))?;
    let provenance = file.create_group("provenance")?;
    for (name, value) in [
        ("scene", &header.scene),
        ("inputs", &json!(inputs)),
        ("options", &header.options),
        ("warnings", &json!(header.warnings)),
    ] {
        write_text(&provenance, name, &value.to_string())?;
    }
    write_text(&provenance, "tool_version", &header.generator)
}

fn write_channel(dataset: &Dataset, channel: &Channel) -> hdf5::Result<()> {
    let names = channel.columns.iter().map(|one| one.name.clone());
    attributes::write(dataset, "columns", &Value::Texts(names.collect()))?;
    write_text(dataset, "description", &channel.description)?;
    match channel.common_unit() {
        Some(unit) => write_text(dataset, "units", unit),
        None => {
            let units = channel.columns.iter().map(|one| one.unit.clone());
            attributes::write(dataset, "column_units", &Value::Texts(units.collect()))?;
            write_text(dataset, "units", "mixed")
        }
    }
}

fn write_outcome(file: &hdf5::File, outcome: &Outcome) -> hdf5::Result<()> {
    file.attr("stopped")?
        .write_scalar(&hdf5_text(&stopped_text(outcome))?)?;
    file.attr("complete")?
        .write_scalar(&(*outcome == Outcome::Complete))
}

fn stopped_text(outcome: &Outcome) -> String {
    match outcome {
        Outcome::Complete => json!(null).to_string(),
        Outcome::Stopped { reason, time } => json!({ "reason": reason, "time": time }).to_string(),
    }
}

fn write_text(object: &hdf5::Location, name: &str, text: &str) -> hdf5::Result<()> {
    attributes::write(object, name, &Value::Text(text.to_owned()))
}
