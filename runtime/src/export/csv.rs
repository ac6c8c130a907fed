//! Histories as a table of comma-separated values: one row a step, every digit kept.

use std::io;
use std::path::Path;

use dcb_formats::output::{Replace, write_stream};
use dcb_formats::results::Results;

use crate::error::Error;
use crate::export::history::{Selection, histories};

/// Writes `time [s],midpoint_deflection [1],…` and a row for every step, or `mode [1],frequency [Hz],…` and a row for every mode. Numbers have as few digits as give the same
/// number back; what isn't a number is `NaN`, `inf` or `-inf`. The table is written whole or not at all.
///
/// # Errors
/// [`Error::File`] if a channel isn't there or can't be read; [`Error::NothingToShow`] if none is selected;
/// [`Error::File`] also for a table that is there and may not be replaced, and on a full disk.
pub fn write_csv(
    results: &Results,
    selection: Selection,
    path: &Path,
    replace: Replace,
) -> Result<(), Error> {
    let listed = histories(results, selection)?;
    let (over, columns) = (&listed.over, &listed.columns);
    if columns.is_empty() {
        return Err(Error::NothingToShow {
            path: path.to_owned(),
            message: "no channel is selected, so the table would be empty".to_owned(),
        });
    }
    Ok(write_stream(path, replace, |out| {
        let mut table = ::csv::Writer::from_writer(out);
        let titles = columns
            .iter()
            .map(|column| format!("{} [{}]", column.name, column.unit));
        let title = format!("{} [{}]", over.name, over.unit);
        table
            .write_record(std::iter::once(title).chain(titles))
            .map_err(refused)?;
        for (step, over) in over.values.iter().enumerate() {
            let values = columns.iter().map(|column| column.values[step]);
            let fields = std::iter::once(*over).chain(values);
            table
                .write_record(fields.map(|value| format!("{value:?}")))
                .map_err(refused)?;
        }
        table.flush()
    })?)
}

/// The system's own answer.
fn refused(error: ::csv::Error) -> io::Error {
    match error.into_kind() {
        ::csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    }
}
