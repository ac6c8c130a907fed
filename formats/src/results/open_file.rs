//! The HDF5 side of a results file being written: groups, datasets, attributes.

use std::path::Path;

use hdf5::Dataset;
use ndarray::{ArrayView2, s};
use serde_json::json;

use super::channel::Channel;
use super::reserve::Reserve;
use super::scales::Scales;
use super::{FORMAT, FORMAT_VERSION, Header, Outcome};
use crate::hdf5_files::attributes::{self, Value, hdf5_text};
use crate::hdf5_files::create::{abandon, create};

/// Rows of a chunk in the file, at most.
const CHUNK_ROWS: usize = 256;
/// Memory of HDF5 beside the data of a block: for its tables, and for each dataset's index of chunks.
const TABLE_BYTES: u64 = 1 << 15;
const INDEX_BYTES: u64 = 1 << 13;

/// Who refused to write the end of the file.
pub(super) enum CloseError {
    Hdf5(hdf5::Error),
    Io(std::io::Error),
}

/// Outcome written at the end, JSON.
pub(super) struct OutcomeTexts {
    pub(super) stopped: String,
    pub(super) events: String,
    pub(super) summary: String,
}

impl OutcomeTexts {
    /// Bytes that they need.
    pub(super) fn needed_space(&self) -> u64 {
        let bytes = self.stopped.len() + self.events.len() + self.summary.len();
        2 * bytes as u64 + TABLE_BYTES
    }
}

/// The HDF5 side: `/time` and the channels, all with the same number of rows.
#[derive(Debug)]
pub(super) struct OpenFile {
    file: hdf5::File,
    time: Dataset,
    channels: Vec<(Dataset, usize)>,
    /// Values of one dataset in a block.
    part: Vec<f64>,
    rows: usize,
    pub(super) last_written: Option<f64>,
    chunk_rows: usize,
    reserve: Reserve,
}

impl OpenFile {
    /// Makes the file with no rows in it.
    pub(super) fn start(
        path: &Path,
        channels: &[Channel],
        header: &Header,
        block_rows: usize,
    ) -> hdf5::Result<Self> {
        let file = create(path)?;
        let started = Self::fill(file.clone(), path, channels, header, block_rows);
        if started.is_err() {
            abandon(path);
        }
        started
    }

    fn fill(
        file: hdf5::File,
        path: &Path,
        channels: &[Channel],
        header: &Header,
        block_rows: usize,
    ) -> hdf5::Result<Self> {
        let reserve =
            Reserve::behind(path).map_err(|error| hdf5::Error::from(error.to_string()))?;
        write_header(&file, header)?;
        let chunk_rows = block_rows.min(CHUNK_ROWS);
        // Blocks are larger than chunks: a cache would only keep what is never touched again.
        let builder = || file.new_dataset::<f64>().chunk_cache(1, 0, 1.0);
        let time = builder().chunk([chunk_rows]).shape(0..).create("time")?;
        let unit = header.units.time.as_str();
        write_text(&time, "units", unit)?;
        write_text(&time, "description", "time of the accepted steps")?;
        let mut scales = Scales::begin(&file, &time, channels)?;
        let mut datasets = Vec::with_capacity(channels.len());
        for channel in channels {
            let columns = channel.columns.len();
            let dataset = builder()
                .chunk([chunk_rows, columns])
                .shape((0.., columns))
                .create(channel.path.as_str())?;
            write_channel(&dataset, channel)?;
            scales.attach(channel)?;
            datasets.push((dataset, columns));
        }
        scales.finish()?;
        file.flush()?;
        let most_columns = datasets.iter().map(|(_, columns)| *columns).max();
        Ok(Self {
            file,
            time,
            channels: datasets,
            part: Vec::with_capacity(block_rows * most_columns.unwrap_or(1)),
            rows: 0,
            last_written: None,
            chunk_rows,
            reserve,
        })
    }

    /// Bytes that so many more rows need.
    pub(super) fn needed_space(&self, rows: usize) -> u64 {
        let chunks = |rows: usize| rows.div_ceil(self.chunk_rows);
        let new_rows = (chunks(self.rows + rows) - chunks(self.rows)) * self.chunk_rows;
        let columns: usize = self.channels.iter().map(|(_, columns)| columns).sum();
        let data = 8 * new_rows as u64 * (1 + columns as u64);
        let indices = INDEX_BYTES * (1 + self.channels.len() as u64);
        data + indices + TABLE_BYTES
    }

    /// Takes disk space behind what is there.
    pub(super) fn take_space(&mut self, bytes: u64) -> std::io::Result<()> {
        self.reserve.take(self.file.size(), bytes)
    }

    /// Adds the rows of a block, each (time, values of all channels).
    pub(super) fn write_rows(&mut self, block: &[f64], row_values: usize) -> hdf5::Result<()> {
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

    /// Bytes that so many more datasets with so many bytes need.
    pub(super) fn needed_space_of(size: u64, datasets: usize) -> u64 {
        size + INDEX_BYTES * datasets as u64 + TABLE_BYTES
    }

    /// Adds datasets that are written once.
    pub(super) fn write_once(
        &mut self,
        write: impl FnOnce(&hdf5::File) -> hdf5::Result<()>,
    ) -> hdf5::Result<()> {
        write(&self.file)?;
        self.file.flush()
    }

    /// Takes back what a failed writing left of its rows, as far as that is possible.
    pub(super) fn withdraw_rows(&self) {
        let _ = self.time.resize(self.rows);
        for (dataset, columns) in &self.channels {
            let _ = dataset.resize((self.rows, *columns));
        }
    }

    /// Says how the run ended, where there is space to say it, and closes the file.
    pub(super) fn close(
        mut self,
        texts: &OutcomeTexts,
        outcome: &Outcome,
    ) -> Result<(), CloseError> {
        let has_space = self.reserve.take(self.file.size(), texts.needed_space());
        let Self {
            file,
            time,
            channels,
            reserve,
            ..
        } = self;
        drop((time, channels));
        let written = match has_space {
            Ok(()) => write_outcome(&file, texts, outcome).map_err(CloseError::Hdf5),
            Err(error) => Err(CloseError::Io(error)),
        };
        let end = file.size();
        let closed = file.close().map_err(CloseError::Hdf5);
        written.and(closed)?;
        reserve
            .give_back(end)
            .and_then(|()| reserve.sync())
            .map_err(CloseError::Io)
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

fn write_outcome(file: &hdf5::File, texts: &OutcomeTexts, outcome: &Outcome) -> hdf5::Result<()> {
    let provenance = file.group("provenance")?;
    write_text(&provenance, "events", &texts.events)?;
    write_text(&provenance, "summary", &texts.summary)?;
    file.attr("stopped")?
        .write_scalar(&hdf5_text(&texts.stopped)?)?;
    file.attr("complete")?
        .write_scalar(&(*outcome == Outcome::Complete))?;
    file.flush()
}

pub(super) fn stopped_text(outcome: &Outcome) -> String {
    match outcome {
        Outcome::Complete => json!(null).to_string(),
        Outcome::Stopped { reason, time } => json!({ "reason": reason, "time": time }).to_string(),
    }
}

fn write_text(object: &hdf5::Location, name: &str, text: &str) -> hdf5::Result<()> {
    attributes::write(object, name, &Value::Text(text.to_owned()))
}
