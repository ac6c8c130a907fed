//! Results from a file that anybody may have made, finished or not.

use std::fs::File;
use std::path::{Path, PathBuf};

use faer::Mat;

use super::channel::{Channel, Column};
use super::frequency_response::FrequencyResponses;
use super::modes::SystemModes;
use super::{Event, FORMAT, FORMAT_VERSION, Outcome};
use crate::Error;
use crate::component::Units;
use crate::description::{listed, suggestion};
use crate::hdf5_files::FormatVersion;
use crate::hdf5_files::attributes::Value;
use crate::hdf5_files::container::{Container, on_large_stack};
use crate::hdf5_files::element::Element;
use crate::hdf5_files::inventory::{self, Entry, Finding, Hashes, Inventory};
use crate::hdf5_files::version::{FileKind, missing, read_version, text_attribute};

/// The kind of file read here.
const KIND: FileKind = FileKind {
    called: "a results file",
    format: FORMAT,
    version: FORMAT_VERSION,
};
/// Where it comes from.
const WRITTEN_BY: &str = "a results file is what `simulate` writes";

/// An open results file. Opening checks its version and all shapes; histories are read when asked for.
///
/// Of a run that was killed, the steps that every channel has are there.
#[derive(Debug)]
pub struct Results {
    path: PathBuf,
    container: Container,
    inventory: Inventory,
    version: FormatVersion,
    units: Units,
    outcome: Outcome,
    channels: Vec<Channel>,
    step_count: usize,
}

impl Results {
    /// Opens a file and checks everything but the histories.
    ///
    /// # Errors
    /// The file can't be read, isn't a results file, is of a higher major version, or its datasets don't fit each
    /// other; the message names the place.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref().to_owned();
        let io = |source| Error::io(&path, "cannot read", source);
        let unusable = |message: String| Error::File {
            path: path.clone(),
            message,
        };
        let at = |finding: Finding| told(&path, finding);
        let status = std::fs::metadata(&path).map_err(io)?;
        if !status.is_file() {
            return Err(unusable(format!("isn't a file; {WRITTEN_BY}")));
        }
        let file = File::open(&path).map_err(io)?;
        let take = || {
            let container = Container::open(file, status.len(), WRITTEN_BY).map_err(unusable)?;
            container.allow_reading();
            let attributes = inventory::root_attributes(&container).map_err(at)?;
            let version = read_version(&attributes, &KIND).map_err(at)?;
            let inventory = Inventory::take(&container, Hashes::Absent).map_err(at)?;
            Ok((container, version, inventory))
        };
        let (container, version, inventory) = on_large_stack(take).map_err(io)??;
        let units = read_units(&inventory).map_err(at)?;
        let outcome = read_outcome(&inventory).map_err(at)?;
        let channels = read_channels(&inventory).map_err(at)?;
        let step_count = count_steps(&inventory, &channels, &outcome).map_err(at)?;
        Ok(Self {
            path,
            container,
            inventory,
            version,
            units,
            outcome,
            channels,
            step_count,
        })
    }

    /// The version that the file says it is.
    pub fn format_version(&self) -> FormatVersion {
        self.version
    }

    /// Unit system of the scene.
    pub fn units(&self) -> &Units {
        &self.units
    }

    /// How the run ended.
    pub fn outcome(&self) -> &Outcome {
        &self.outcome
    }

    /// n_t, the number of accepted steps.
    pub fn step_count(&self) -> usize {
        self.step_count
    }

    /// All channels, by path.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// The channel with this path, or the only output, or else the only channel, with this name.
    ///
    /// # Errors
    /// [`Error::Location`] with the nearest path if there is no such channel, or with the paths if there are several.
    pub fn channel(&self, wanted: &str) -> Result<&Channel, Error> {
        let wanted = wanted.strip_prefix('/').unwrap_or(wanted);
        let exact = [wanted.to_owned(), format!("outputs/{wanted}")];
        for path in &exact {
            if let Some(channel) = self.channels.iter().find(|channel| channel.path == *path) {
                return Ok(channel);
            }
        }
        let mut named = self.channels.iter().filter(|one| one.name() == wanted);
        let message = match (named.next(), named.next()) {
            (Some(channel), None) => return Ok(channel),
            (Some(first), Some(second)) => format!(
                "is the name of {} and {}; write the whole path",
                first.path, second.path
            ),
            _ => {
                let paths = || self.channels.iter().map(|channel| channel.path.as_str());
                let names = self.channels.iter().map(Channel::name);
                let known = paths().chain(names);
                format!(
                    "isn't a channel{} (channels here: {})",
                    suggestion(wanted, known),
                    listed(paths())
                )
            }
        };
        Err(told(&self.path, Finding::at(wanted, message)))
    }

    /// Times of the accepted steps, (n_t).
    ///
    /// # Errors
    /// [`Error::Location`]: they can't be read.
    pub fn time(&self) -> Result<Vec<f64>, Error> {
        let mut times = Vec::new();
        self.each_row("/time", 1, |_, row| times.extend_from_slice(row))?;
        Ok(times)
    }

    /// The history of a channel, (n_t, k): one row a step, one column for each of the channel's.
    ///
    /// # Errors
    /// As [`Results::channel`], or [`Error::Location`] if it can't be read.
    pub fn history(&self, wanted: &str) -> Result<Mat<f64>, Error> {
        let channel = self.channel(wanted)?;
        let columns = channel.columns.len();
        let mut history = Mat::zeros(self.step_count, columns);
        self.each_row(&format!("/{}", channel.path), columns, |step, row| {
            for (column, value) in row.iter().enumerate() {
                history[(step, column)] = *value;
            }
        })?;
        Ok(history)
    }

    /// Modes of small oscillations, without their shapes; `None` where the run was no modal analysis.
    ///
    /// # Errors
    /// [`Error::Location`] if they can't be read.
    pub fn modes(&self) -> Result<Option<SystemModes>, Error> {
        let read = |path: &str, count: usize| {
            let mut list = Vec::new();
            self.each_row_of(path, [count, 1], |_, row| list.extend_from_slice(row))?;
            Ok(list)
        };
        SystemModes::read(&self.inventory, read).map_err(|finding| told(&self.path, finding))
    }

    /// Frequency responses; `None` where the run was no frequency analysis.
    ///
    /// # Errors
    /// [`Error::Location`] if they can't be read.
    pub fn frequency_responses(&self) -> Result<Option<FrequencyResponses>, Error> {
        let read = |path: &str, shape: [usize; 2]| {
            let mut list = Vec::new();
            self.each_row_of(path, shape, |_, row| list.extend_from_slice(row))?;
            Ok(list)
        };
        FrequencyResponses::read(&self.inventory, read).map_err(|finding| told(&self.path, finding))
    }

    /// One of the JSON attributes of `/provenance`: `scene`, `inputs`, `options`, `warnings`, `summary`; `null` where
    /// the run ended before it was written.
    ///
    /// # Errors
    /// [`Error::Location`] if it isn't JSON.
    pub fn provenance(&self, name: &str) -> Result<serde_json::Value, Error> {
        match self.inventory.attribute("/provenance", name) {
            None => Ok(serde_json::Value::Null),
            Some(_) => text_attribute(&self.inventory, "/provenance", name)
                .and_then(|text| json(text, "/provenance", name))
                .map_err(|finding| told(&self.path, finding)),
        }
    }

    /// Notes of the run, in the order of time.
    ///
    /// # Errors
    /// As [`Results::provenance`].
    pub fn events(&self) -> Result<Vec<Event>, Error> {
        let events: Option<Vec<Event>> = serde_json::from_value(self.provenance("events")?)
            .map_err(|error| {
                let message = format!("attribute events isn't a list of events: {error}");
                told(&self.path, Finding::at("/provenance", message))
            })?;
        Ok(events.unwrap_or_default())
    }

    /// Calls `take` with the number and the values of every step's row.
    fn each_row(
        &self,
        path: &str,
        columns: usize,
        take: impl FnMut(usize, &[f64]),
    ) -> Result<(), Error> {
        self.each_row_of(path, [self.step_count, columns], take)
            .map_err(|finding| told(&self.path, finding))
    }

    /// The same for a dataset with this number of rows and columns.
    fn each_row_of(
        &self,
        path: &str,
        [rows, columns]: [usize; 2],
        mut take: impl FnMut(usize, &[f64]),
    ) -> Result<(), Finding> {
        let at = |message: String| Finding::at(path, message);
        let entry = self.inventory.entries.get(path);
        let entry = entry.ok_or_else(|| missing(path))?;
        let data = entry.storage.data(&self.container).map_err(at)?;
        let window = entry.storage.window_rows(rows, columns);
        for start in (0..rows).step_by(window) {
            let count = window.min(rows - start);
            self.container.allow_reading();
            let values = data
                .read_f64_rows(start as u64, count as u64)
                .map_err(|error| at(format!("can't be read: {error}")))?;
            if values.len() != count * columns {
                let expected = count * columns;
                return Err(at(format!(
                    "has {} values instead of {expected}",
                    values.len()
                )));
            }
            for (row, values) in values.chunks_exact(columns).enumerate() {
                take(start + row, values);
            }
        }
        Ok(())
    }
}

fn told(path: &Path, finding: Finding) -> Error {
    Error::Location {
        path: path.to_owned(),
        location: finding.path,
        message: finding.message,
    }
}

fn json(text: &str, path: &str, name: &str) -> Result<serde_json::Value, Finding> {
    serde_json::from_str(text)
        .map_err(|error| Finding::at(path, format!("attribute {name} isn't JSON: {error}")))
}

fn read_units(inventory: &Inventory) -> Result<Units, Finding> {
    let units = json(text_attribute(inventory, "/", "units")?, "/", "units")?;
    let unit = |name: &str| {
        let unit = units.get(name).and_then(serde_json::Value::as_str);
        let message = || Finding::at("/", format!("attribute units has no {name}"));
        unit.map(str::to_owned).ok_or_else(message)
    };
    Ok(Units {
        length: unit("length")?,
        mass: unit("mass")?,
        time: unit("time")?,
    })
}

fn read_outcome(inventory: &Inventory) -> Result<Outcome, Finding> {
    match inventory.attribute("/", "complete") {
        Some(Value::Integer(1)) => return Ok(Outcome::Complete),
        Some(Value::Integer(0)) => {}
        other => {
            let message = format!("attribute complete is {other:?}; it must be true or false");
            return Err(Finding::at("/", message));
        }
    }
    let stopped = json(text_attribute(inventory, "/", "stopped")?, "/", "stopped")?;
    let reason = stopped.get("reason").and_then(serde_json::Value::as_str);
    Ok(Outcome::Stopped {
        reason: reason.unwrap_or("not told").to_owned(),
        time: stopped.get("time").and_then(serde_json::Value::as_f64),
    })
}

/// Every dataset of two axes is a channel; what later versions may add has another number of axes or another type.
fn read_channels(inventory: &Inventory) -> Result<Vec<Channel>, Finding> {
    let is_channel =
        |entry: &Entry| entry.line.element == Element::Real && entry.line.shape.len() == 2;
    let mut channels = Vec::new();
    for (path, entry) in &inventory.entries {
        if !is_channel(entry) || path.starts_with("/provenance/") {
            continue;
        }
        let count = entry.line.shape[1];
        if count == 0 {
            return Err(Finding::at(path, "has no columns"));
        }
        let units = text_attribute(inventory, path, "units")?;
        let texts = |name: &str| match inventory.attribute(path, name) {
            Some(Value::Texts(texts)) if texts.len() == count => Ok(texts),
            other => Err(Finding::at(
                path,
                format!("attribute {name} is {other:?}; it must be {count} strings"),
            )),
        };
        let names = texts("columns")?;
        let each_unit = match units {
            "mixed" => texts("column_units")?.clone(),
            _ => vec![units.to_owned(); count],
        };
        let columns = names.iter().zip(each_unit).map(|(name, unit)| Column {
            name: name.clone(),
            unit,
        });
        channels.push(Channel {
            path: path.trim_start_matches('/').to_owned(),
            columns: columns.collect(),
            description: text_attribute(inventory, path, "description")?.to_owned(),
        });
    }
    Ok(channels)
}

/// Steps that everything has: all of them in a complete file, and those before the last block in one that was
/// cut off while a block was written.
fn count_steps(
    inventory: &Inventory,
    channels: &[Channel],
    outcome: &Outcome,
) -> Result<usize, Finding> {
    let entry = |path: &str| inventory.entries.get(path).ok_or_else(|| missing(path));
    let time = entry("/time")?;
    let (Element::Real, [steps]) = (time.line.element, &time.line.shape[..]) else {
        return Err(Finding::at("/time", "isn't a list of reals"));
    };
    let mut fewest = *steps;
    for channel in channels {
        let path = format!("/{}", channel.path);
        let rows = entry(&path)?.line.shape[0];
        if rows != *steps && *outcome == Outcome::Complete {
            let message = format!("has {rows} rows, but /time has {steps}");
            return Err(Finding::at(&path, message));
        }
        fewest = fewest.min(rows);
    }
    Ok(fewest)
}
