//! What a study leaves behind: rows that survive an interruption, tables, charts, and one page that shows them.
//!
//! A study does many runs with different options and asks what each costs and how far it is off. This module has what all
//! studies share and knows nothing of reductions or motions:
//!
//! - [`Ledger`]: rows as lines of JSON, each on disk before the next run starts; a later run goes on where it ended;
//! - [`pareto_front`], [`cheapest_within`]: which rows are worth their cost; [`pareto_chart`] shows it;
//! - [`Chart`], [`svg`], [`small_svg`], [`write_svg`]: line charts, linear or logarithmic;
//! - [`Table`]: for a CSV file and for a page;
//! - [`Page`]: one HTML file that needs no other;
//! - [`write_text`], [`write_json`]: files written whole or not at all.

mod axis;
mod chart;
mod curve;
mod draw;
mod ledger;
mod page;
mod pareto;
mod table;
mod words;

use std::io::Write as _;
use std::path::Path;

use serde::Serialize;

pub use chart::{Axis, Chart, Note, ReferenceSlope, Scale, Series, Style};
pub use draw::{NotDrawn, small_svg, svg, write_svg};
pub use ledger::{Ledger, Start};
pub use page::{Page, escaped};
pub use pareto::{Candidate, Family, cheapest_within, pareto_chart, pareto_front};
pub use table::{Cell, Column, Table};

use crate::dcb::{Replace, write_stream};
use crate::error::Error;

/// Writes a text file, whole or not at all; an existing file is replaced.
///
/// # Errors
/// [`Error::File`] for a place where no file can be; [`Error::NoRoom`] on a full disk; [`Error::Io`] where the system refuses.
pub fn write_text(path: &Path, text: &str) -> Result<(), Error> {
    write_stream(path, Replace::Overwrite, |out| {
        out.write_all(text.as_bytes())
    })
}

/// Writes a value as indented JSON, whole or not at all; an existing file is replaced. Numbers that aren't finite become `null`.
///
/// # Errors
/// As [`write_text`]; [`Error::File`] if the value has no JSON form (a map with keys that aren't text).
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<(), Error> {
    let text = serde_json::to_string_pretty(value).map_err(|error| Error::File {
        path: path.to_owned(),
        message: format!("cannot be written as JSON: {error}"),
    })?;
    write_text(path, &(text + "\n"))
}
