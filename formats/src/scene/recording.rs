//! When a run records, and the displacement fields that it writes.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::{Checker, finite};
use super::values::positive;
use crate::Error;

/// How often results are recorded; after every step where a scene says nothing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Record {
    /// After every so many steps.
    Every(u32),
    /// At the multiples of this time, wherever steps end, and at the end.
    Interval(f64),
}

/// Displacement fields of a superelement, written as VTU files.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{"required": ["times"]}, {"required": ["every"]}]))]
pub struct FieldRequest {
    /// Name of a superelement's body.
    pub body: String,
    /// Times, not negative and strictly increasing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub times: Option<Vec<f64>>,
    /// Interval of time, in place of times.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub every: Option<f64>,
    /// Folder of the files; a relative path starts at the folder of the scene.
    pub directory: PathBuf,
}

impl Record {
    pub(super) fn check(&self, end: Option<f64>) -> Result<(), Error> {
        match *self {
            Self::Every(0) => Err(Error::described(
                "record.every",
                "is 0, expected a number of steps from 1",
            )),
            Self::Every(_) => Ok(()),
            Self::Interval(interval) => often("record.interval", interval, end),
        }
    }
}

/// Times that a scene may ask for.
const MOST_TIMES: f64 = 1e9;

/// An interval of time, not so short that nobody could wait for its records.
fn often(location: &str, interval: f64, end: Option<f64>) -> Result<(), Error> {
    positive(location, interval)?;
    match end {
        Some(end) if end > MOST_TIMES * interval => Err(Error::described(
            location,
            format!(
                "is {interval:?}: {:.0e} times up to the end at {end}; expected at most {MOST_TIMES:.0e}, an interval of {:.1e} or more",
                end / interval,
                end / MOST_TIMES
            ),
        )),
        _ => Ok(()),
    }
}

impl FieldRequest {
    pub(super) fn check(
        &self,
        location: &str,
        checker: &Checker,
        end: Option<f64>,
    ) -> Result<(), Error> {
        checker.superelement(&format!("{location}.body"), &self.body)?;
        if self.directory.as_os_str().is_empty() {
            return Err(Error::described(
                format!("{location}.directory"),
                "is empty; expected a folder",
            ));
        }
        let times = match (&self.times, self.every) {
            (None, Some(interval)) => return often(&format!("{location}.every"), interval, end),
            (Some(times), None) => times,
            _ => {
                return Err(Error::described(
                    location,
                    "needs exactly one of `times` and `every`",
                ));
            }
        };
        let mut before = None;
        for (index, &time) in times.iter().enumerate() {
            let at = format!("{location}.times[{index}]");
            finite(&at, time)?;
            if time < 0.0 || before.is_some_and(|before| time <= before) {
                return Err(Error::described(
                    at,
                    format!("is {time}; the times must not be negative and must strictly increase"),
                ));
            }
            before = Some(time);
        }
        Ok(())
    }
}
