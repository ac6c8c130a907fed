//! The `simulate show` command: what a results file holds, or the values of what is named.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use dcb_formats::component::Units;
use dcb_formats::results::{Channel, Outcome as RunOutcome, Results, SystemModes};
use dcb_formats::terminal::one_line;
use dcb_runtime::error::Error;
use dcb_runtime::export::history::{History, Selection, histories};

use crate::outcome::Outcome;
use crate::simulate::opened;

/// Columns of a channel that are numbered, like modal coordinates, are listed one by one up to this many.
const NUMBERED: usize = 8;

/// Results, and what is looked at.
#[derive(Debug, Args)]
pub(crate) struct ShowArguments {
    /// Results.
    results: PathBuf,
    /// Names of outputs or channels, or of components, whose last, smallest and largest values are shown: tip tip.z.
    names: Vec<String>,
}

pub(crate) fn run(arguments: &ShowArguments) -> Result<Outcome, Error> {
    let results = opened(&arguments.results)?;
    if !arguments.names.is_empty() {
        return values(&results, &arguments.names);
    }
    let mut text = format!(
        "{}: {} rows, ",
        arguments.results.display(),
        results.step_count()
    );
    // Writing to a string doesn't fail.
    let _ = match results.outcome() {
        RunOutcome::Complete => writeln!(text, "complete"),
        RunOutcome::Stopped {
            reason,
            time: Some(time),
        } => writeln!(text, "stopped at t = {time}: {}", one_line(reason)),
        RunOutcome::Stopped { reason, time: None } => {
            writeln!(text, "stopped: {}", one_line(reason))
        }
    };
    for channel in results.channels() {
        let _ = writeln!(text, "  {}", one_line(&described(channel)));
    }
    if let Some(modes) = results.modes()? {
        text += &modes_table(&modes, results.units());
    }
    for event in results.events()? {
        let _ = writeln!(text, "  t = {}: {}", event.time, one_line(&event.message));
    }
    Ok(Outcome::done(text))
}

/// `tip: x y z [m]  (position of …)`: the columns of one unit together.
fn described(channel: &Channel) -> String {
    let name = channel
        .path
        .strip_prefix("outputs/")
        .unwrap_or(&channel.path);
    let mut groups: Vec<(&str, Vec<&str>)> = Vec::new();
    for column in &channel.columns {
        match groups.last_mut() {
            Some((unit, names)) if *unit == column.unit => names.push(&column.name),
            _ => groups.push((&column.unit, vec![&column.name])),
        }
    }
    let groups: Vec<String> = (groups.iter())
        .map(|(unit, names)| {
            let are_numbers = names.iter().all(|name| name.parse::<usize>().is_ok());
            let names = match names.as_slice() {
                [first, .., last] if are_numbers && names.len() > NUMBERED => {
                    format!("{first} to {last}")
                }
                names => names.join(" "),
            };
            format!("{names} [{unit}]").trim_start().to_owned()
        })
        .collect();
    let colon = match channel.columns.as_slice() {
        [only] if only.name.is_empty() => "",
        _ => ":",
    };
    format!(
        "{name}{colon} {}  ({})",
        groups.join(", "),
        channel.description
    )
}

/// Frequencies, in both units, and damping.
fn modes_table(modes: &SystemModes, units: &Units) -> String {
    let lists = modes.lists(units);
    let titles = lists
        .iter()
        .map(|(name, unit, _)| format!("{name} [{unit}]"));
    let titles: Vec<String> = titles.collect();
    let mut text = format!(
        "  {} modes: {}, angular frequency [rad/{}]\n",
        modes.frequency.len(),
        titles.join(", "),
        units.time
    );
    for number in 0..modes.frequency.len() {
        let angular = std::f64::consts::TAU * modes.frequency[number];
        let values = lists.iter().map(|(.., values)| values[number]);
        let values = values.chain([angular]);
        // No minus before a zero.
        let values: Vec<String> = values
            .map(|value| format!("{:>14.6e}", value + 0.0))
            .collect();
        let _ = writeln!(text, "  {:>5} {}", number + 1, values.join(" "));
    }
    text
}

/// Last, smallest and largest values of what is named.
fn values(results: &Results, names: &[String]) -> Result<Outcome, Error> {
    let listed = histories(results, Selection::Named(names))?;
    let mut text = String::new();
    if let (true, Some(end)) = (listed.is_motion, listed.over.values.last()) {
        let rows = listed.over.values.len();
        text = format!("{rows} rows to t = {end} {}\n", listed.over.unit);
    }
    let width = listed
        .columns
        .iter()
        .map(|column| title(column).chars().count());
    let width = width.fold(0, usize::max);
    let _ = writeln!(
        text,
        "{:<width$} {:>14} {:>14} {:>14}",
        "", "last", "smallest", "largest"
    );
    for column in &listed.columns {
        let finite = || column.values.iter().copied();
        let last = column.values.last().copied().unwrap_or(f64::NAN);
        let least = finite().fold(f64::INFINITY, f64::min);
        let most = finite().fold(f64::NEG_INFINITY, f64::max);
        let _ = writeln!(
            text,
            "{:<width$} {last:>14.6e} {least:>14.6e} {most:>14.6e}",
            title(column)
        );
    }
    Ok(Outcome::done(text))
}

/// `tip.z [m]`.
fn title(history: &History) -> String {
    one_line(&format!("{} [{}]", history.name, history.unit)).into_owned()
}

/// The outputs at a rest, a line each.
///
/// # Errors
/// Those of reading the results.
pub(super) fn last_values(results: &Results) -> Result<String, Error> {
    let listed = histories(results, Selection::Outputs)?;
    let width = listed
        .columns
        .iter()
        .map(|column| title(column).chars().count());
    let width = width.fold(0, usize::max);
    let mut text = String::new();
    for column in &listed.columns {
        let last = column.values.last().copied().unwrap_or(f64::NAN);
        let _ = writeln!(text, "  {:<width$} {last:>14.6e}", title(column));
    }
    Ok(text)
}
