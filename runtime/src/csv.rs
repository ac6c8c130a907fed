//! Histories as a table of comma-separated values: one row a step, every digit kept.

use std::path::Path;

use dcb_formats::results::Results;

use crate::error::Error;
use crate::history::{Selection, histories};

/// Writes `time [s],midpoint_deflection [1],…` and a row for every step. Numbers have as few digits as give the same
/// number back; what isn't a number is `NaN`, `inf` or `-inf`. An existing file is replaced.
///
/// # Errors
/// [`Error::File`] if a channel isn't there or can't be read; [`Error::NothingToShow`] if none is selected;
/// [`Error::CannotWrite`].
pub fn write_csv(results: &Results, selection: Selection, path: &Path) -> Result<(), Error> {
    let columns = histories(results, selection)?;
    if columns.is_empty() {
        return Err(Error::NothingToShow {
            path: path.to_owned(),
            message: "no channel is selected, so the table would be empty".to_owned(),
        });
    }
    let time = results.time()?;
    let told = |error: ::csv::Error| Error::CannotWrite {
        path: path.to_owned(),
        source: error.into(),
    };
    let mut table = ::csv::Writer::from_path(path).map_err(told)?;
    let titles = columns
        .iter()
        .map(|column| format!("{} [{}]", column.name, column.unit));
    let time_title = format!("time [{}]", results.units().time);
    table
        .write_record(std::iter::once(time_title).chain(titles))
        .map_err(told)?;
    for (step, time) in time.iter().enumerate() {
        let values = columns.iter().map(|column| column.values[step]);
        let fields = std::iter::once(*time).chain(values);
        table
            .write_record(fields.map(|value| format!("{value:?}")))
            .map_err(told)?;
    }
    table.flush().map_err(|source| Error::CannotWrite {
        path: path.to_owned(),
        source,
    })
}
