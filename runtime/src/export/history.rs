//! Histories of single quantities, as tables and pictures want them: a name, a unit and a number for each step.

use std::collections::BTreeSet;

use dcb_formats::component::Units;
use dcb_formats::results::{Results, SystemModes};

use crate::error::Error;

/// Which channels of a results file are meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Selection<'a> {
    /// Everything in `/outputs`.
    Outputs,
    /// Those with these paths or names, in this order.
    Named(&'a [String]),
}

/// One column of a channel over time.
#[derive(Clone, Debug, PartialEq)]
pub struct History {
    /// Name for people.
    pub name: String,
    /// Unit; `1` where it has none.
    pub unit: String,
    /// One value for each step, (n_t).
    pub values: Vec<f64>,
}

/// Histories, or modes, and what they are listed over.
#[derive(Clone, Debug, PartialEq)]
pub struct Histories {
    /// Time, or the numbers of the modes from 1.
    pub over: History,
    /// Entries of the list; may be empty.
    pub columns: Vec<History>,
    /// Whether the values follow each other as a motion does.
    pub is_motion: bool,
}

/// The columns of the selected channels, channel by channel; a channel named twice comes once. Of a modal analysis the modes are listed
/// where no channel is named.
///
/// # Errors
/// [`Error::File`] if a channel isn't there, with the nearest name, or can't be read.
pub fn histories(results: &Results, selection: Selection) -> Result<Histories, Error> {
    if selection == Selection::Outputs
        && let Some(modes) = results.modes()?
    {
        return Ok(of_modes(&modes, results.units()));
    }
    let channels = match selection {
        Selection::Outputs => {
            let all = results.channels().iter();
            all.filter(|channel| channel.path.starts_with("outputs/"))
                .collect()
        }
        Selection::Named(names) => {
            let found = names.iter().map(|name| results.channel(name));
            found.collect::<Result<Vec<_>, _>>()?
        }
    };
    let mut seen = BTreeSet::new();
    let mut all = Vec::new();
    for channel in channels {
        if !seen.insert(&channel.path) {
            continue;
        }
        let values = results.history(&channel.path)?;
        for (index, column) in channel.columns.iter().enumerate() {
            all.push(History {
                name: channel.label(column),
                unit: column.unit.clone(),
                values: values.col_as_slice(index).to_vec(),
            });
        }
    }
    Ok(Histories {
        over: History {
            name: "time".to_owned(),
            unit: results.units().time.clone(),
            values: results.time()?,
        },
        columns: all,
        is_motion: true,
    })
}

fn of_modes(modes: &SystemModes, units: &Units) -> Histories {
    let numbers = 1..=modes.frequency.len();
    let lists = modes.lists(units).into_iter();
    Histories {
        over: History {
            name: "mode".to_owned(),
            unit: "1".to_owned(),
            values: numbers.map(|number| number as f64).collect(),
        },
        columns: lists
            .map(|(name, unit, values)| History {
                name: name.to_owned(),
                unit,
                values: values.to_vec(),
            })
            .collect(),
        is_motion: false,
    }
}
