//! Results of a simulation: histories of named channels in an HDF5 file, as `docs/results.md` publishes it.
//!
//! [`ResultsWriter`] takes one row for every accepted step and needs the same memory however long the run is.
//! Unlike a superelement, which is written whole or not at all, a results file has its own name from the first
//! moment on and says `complete` = false until the run has reached its end: whatever stops a run, the steps so far
//! can be read. [`Results`] reads such files and believes nothing it hasn't checked. As for superelements, libhdf5
//! writes and `hdf5-pure`, which is memory-safe, reads.

mod channel;
mod frequency_response;
mod modes;
mod open_file;
mod read;
mod reserve;
mod scales;
mod write;

pub use channel::{Channel, Column};
pub use frequency_response::{FrequencyResponses, Signal};
pub use modes::{ModeShapes, SystemModes, frequency_unit};
pub use read::Results;
pub use write::ResultsWriter;

use crate::component::{Source, Units};
use crate::hdf5_files::FormatVersion;

/// Value of the attribute `format` of every results file.
pub const FORMAT: &str = "dcb-results";

/// The version this program writes; it reads every minor version of the same major version.
pub const FORMAT_VERSION: FormatVersion = FormatVersion { major: 1, minor: 1 };

/// Facts of a run that are known before its first step.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// Unit system of the scene.
    pub units: Units,
    /// Program and version that writes the results.
    pub generator: String,
    /// The scene as it was simulated, JSON.
    pub scene: serde_json::Value,
    /// Files that the scene was made from.
    pub inputs: Vec<Source>,
    /// Options of the run that override the scene, JSON.
    pub options: serde_json::Value,
    /// Notes about the scene, for the reader.
    pub warnings: Vec<String>,
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// It reached the end that the scene asks for.
    Complete,
    /// It ended before.
    Stopped {
        /// Why.
        reason: String,
        /// Time of the last accepted step, in the scene's unit; `None` if there was none or the run was killed.
        time: Option<f64>,
    },
}

/// Something worth telling that happened during a run.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Event {
    /// When, in the scene's unit.
    pub time: f64,
    /// Its text.
    pub message: String,
}
