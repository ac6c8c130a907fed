//! How many elastic modes are kept: as it is asked for, and as it is resolved in the part's units.

use clap::Args;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::{CommandRefusal, Error};
use dcb_formats::units::si_factor;

/// Modes kept where nothing is said.
pub const DEFAULT_MODES: usize = 20;

/// Which modes to keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ModeSelection {
    /// This many lowest elastic modes (a multiple root is never cut, so it may be more).
    Lowest(usize),
    /// Every elastic mode below this ω², (rad/time)².
    Below {
        /// The limit.
        eigenvalue: f64,
    },
    /// The same, but no more than so many, the lowest (or more where that would cut a multiple root).
    BelowAtMost {
        /// The limit.
        eigenvalue: f64,
        /// How many.
        count: usize,
    },
}

impl Default for ModeSelection {
    fn default() -> Self {
        Self::Lowest(DEFAULT_MODES)
    }
}

/// The modes that are asked for, by any part in any units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ModeRequest {
    /// This many.
    Lowest(usize),
    /// All below this frequency, Hz.
    BelowHertz(f64),
}

/// The options, and keys of a manifest, that ask for modes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Args, Serialize, Deserialize, JsonSchema)]
pub struct ModeOptions {
    /// Number of elastic modes, equal ones kept together; for a scene the most [default: 20].
    #[arg(long, value_name = "N", conflicts_with = "max_frequency", allow_negative_numbers = true, value_parser = count)]
    pub modes: Option<usize>,
    /// Keep every elastic mode below this frequency, Hz.
    #[arg(long, value_name = "HZ", allow_hyphen_values = true, value_parser = frequency)]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub max_frequency: Option<f64>,
}

impl ModeOptions {
    /// Request.
    pub fn request(&self) -> ModeRequest {
        match self.max_frequency {
            Some(hertz) => ModeRequest::BelowHertz(hertz),
            None => ModeRequest::Lowest(self.modes.unwrap_or(DEFAULT_MODES)),
        }
    }
}

impl ModeRequest {
    /// For a part with this unit of time.
    ///
    /// # Errors
    /// [`Error::Command`] for a frequency in a time unit that is not known.
    pub fn selection(self, time_unit: &str) -> Result<ModeSelection, Error> {
        let hertz = match self {
            Self::Lowest(count) => return Ok(ModeSelection::Lowest(count)),
            Self::BelowHertz(hertz) => hertz,
        };
        let second = si_factor(time_unit).ok_or_else(|| CommandRefusal::UnknownTimeUnit {
            option: "--max-frequency",
            unit: time_unit.to_owned(),
            remedy: "use --modes",
        })?;
        Ok(ModeSelection::Below {
            eigenvalue: (2.0 * std::f64::consts::PI * hertz * second).powi(2),
        })
    }
}

fn count(text: &str) -> Result<usize, String> {
    text.parse()
        .map_err(|_| "a number of modes is wanted, 0 or more".into())
}

fn frequency(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(hertz) if hertz.is_finite() && hertz > 0.0 => Ok(hertz),
        _ => Err("a positive number of Hz is wanted".into()),
    }
}
