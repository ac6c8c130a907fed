//! Histories of single quantities, as tables and pictures want them: a name, a unit and a number for each step.

use std::collections::BTreeSet;

use dcb_formats::component::Units;
use dcb_formats::results::{Channel, FrequencyResponses, Results, SystemModes, frequency_unit};

use crate::error::Error;

/// Which channels of a results file are meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Selection<'a> {
    /// Everything in `/outputs`.
    Outputs,
    /// Those with these paths or names, or components of them (`tip.z`), in this order; several may stand in one text, with commas between.
    Named(&'a [String]),
}

/// What a history is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// An energy or a work.
    Energy,
    /// What the channel says that it is: a position, a displacement, a velocity.
    Kinematic(&'static str),
    /// Anything else.
    Other,
}

/// Beginnings of descriptions that name a quantity of motion.
const KINEMATIC: [&str; 7] = [
    "position",
    "displacement",
    "elastic displacement",
    "deflection",
    "velocity",
    "acceleration",
    "angular velocity",
];

impl Quantity {
    /// Channels of energies have the kinetic one among their columns.
    fn of(channel: &Channel) -> Self {
        match channel
            .columns
            .iter()
            .any(|column| column.name == "kinetic")
        {
            true => Self::Energy,
            false => Self::of_motion(&channel.description),
        }
    }

    fn of_motion(description: &str) -> Self {
        let starts = |name: &&&str| {
            let rest = description.strip_prefix(**name);
            rest.is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
        };
        match KINEMATIC.iter().find(starts) {
            Some(name) => Self::Kinematic(name),
            None => Self::Other,
        }
    }

    /// Its name, where there is one.
    pub fn name(self) -> Option<&'static str> {
        match self {
            Self::Energy => Some("energy"),
            Self::Kinematic(name) => Some(name),
            Self::Other => None,
        }
    }
}

/// One column of a channel over time.
#[derive(Clone, Debug, PartialEq)]
pub struct History {
    /// Name for people.
    pub name: String,
    /// Unit; `1` where it has none.
    pub unit: String,
    /// What is measured, where the unit doesn't say it: a moment has the unit of an energy.
    pub quantity: Quantity,
    /// One value for each step, (n_t).
    pub values: Vec<f64>,
    /// Largest magnitude of the columns of this unit in its channel.
    pub scale: f64,
}

/// The largest magnitude of a list.
fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| most.max(value.abs()))
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

impl Histories {
    /// The columns with these names, in this order; `None` if one isn't there.
    fn picked(self, names: &[String]) -> Option<Self> {
        let single = names.iter().flat_map(|name| name.split(','));
        let columns: Option<Vec<History>> = single
            .map(|name| {
                let name = name.strip_prefix("modes/").unwrap_or(name);
                let mut columns = self.columns.iter();
                columns.find(|column| column.name == name).cloned()
            })
            .collect();
        columns.map(|columns| Self { columns, ..self })
    }
}

/// The selected columns, channel by channel; a column named twice comes once. Of a modal analysis the modes are listed
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
    if let Some(responses) = results.frequency_responses()? {
        let listed = of_responses(&responses, results.units());
        match selection {
            Selection::Outputs => return Ok(listed),
            Selection::Named(names) => {
                if let Some(picked) = listed.picked(names) {
                    return Ok(picked);
                }
            }
        }
    }
    if let Selection::Named(names) = selection
        && let Some(modes) = results.modes()?
        && let Some(picked) = of_modes(&modes, results.units()).picked(names)
    {
        return Ok(picked);
    }
    let channels = match selection {
        Selection::Outputs => {
            let all = results.channels().iter();
            all.filter(|channel| channel.path.starts_with("outputs/"))
                .map(|channel| (channel, None))
                .collect()
        }
        Selection::Named(names) => {
            let single = names.iter().flat_map(|name| name.split(','));
            let found = single.map(|name| named(results, name));
            found.collect::<Result<Vec<_>, _>>()?
        }
    };
    let mut seen = BTreeSet::new();
    let mut all = Vec::new();
    for (channel, component) in channels {
        let columns = channel.columns.iter().enumerate();
        let wanted: Vec<usize> = columns
            .map(|(index, _)| index)
            .filter(|index| component.is_none_or(|only| only == *index))
            .filter(|index| seen.insert((&channel.path, *index)))
            .collect();
        if wanted.is_empty() {
            continue;
        }
        let values = results.history(&channel.path)?;
        for index in wanted {
            let column = &channel.columns[index];
            all.push(History {
                name: channel.label(column),
                unit: column.unit.clone(),
                quantity: Quantity::of(channel),
                values: values.col_as_slice(index).to_vec(),
                scale: (channel.columns.iter().enumerate())
                    .filter(|(_, other)| other.unit == column.unit)
                    .map(|(other, _)| largest(values.col_as_slice(other)))
                    .fold(0.0, f64::max),
            });
        }
    }
    Ok(Histories {
        over: History {
            name: "time".to_owned(),
            unit: results.units().time.clone(),
            quantity: Quantity::Other,
            values: results.time()?,
            scale: 0.0,
        },
        columns: all,
        is_motion: true,
    })
}

/// A channel, or one of its columns by the name that tables give it.
fn named<'r>(
    results: &'r Results,
    name: &str,
) -> Result<(&'r Channel, Option<usize>), dcb_formats::Error> {
    let unknown = match results.channel(name) {
        Ok(channel) => return Ok((channel, None)),
        Err(unknown) => unknown,
    };
    let Some((channel, component)) = name.rsplit_once('.') else {
        return Err(unknown);
    };
    let Ok(channel) = results.channel(channel) else {
        return Err(unknown);
    };
    let columns = &channel.columns;
    let index = columns.iter().position(|column| column.name == component);
    index.map_or(Err(unknown), |index| Ok((channel, Some(index))))
}

/// Amplitude and phase of each output by each input, and densities under random inputs.
fn of_responses(responses: &FrequencyResponses, units: &Units) -> Histories {
    let history = |name: String, unit: String, values: Vec<f64>| History {
        name,
        unit,
        quantity: Quantity::Other,
        scale: largest(&values),
        values,
    };
    let mut columns = Vec::new();
    for (i, output) in responses.outputs.iter().enumerate() {
        for (j, input) in responses.inputs.iter().enumerate() {
            let values = responses.of(i, j);
            let name = format!("{} by {}", output.name, input.name);
            let amplitude = values.iter().map(|[re, im]| re.hypot(*im)).collect();
            let phase = values
                .iter()
                .map(|[re, im]| im.atan2(*re).to_degrees())
                .collect();
            columns.push(history(name.clone(), responses.unit(i, j), amplitude));
            columns.push(history(format!("phase of {name}"), "deg".to_owned(), phase));
            if let Some(errors) = responses.error_of(i, j) {
                let name = format!("error of {name}");
                columns.push(history(name, responses.unit(i, j), errors));
            }
        }
    }
    for (i, output) in responses.outputs.iter().enumerate() {
        if let Some(density) = responses.density_of(i) {
            let unit = format!("({})^2/{}", output.unit, frequency_unit(units));
            columns.push(history(
                format!("density of {}", output.name),
                unit,
                density,
            ));
        }
    }
    Histories {
        over: History {
            scale: 0.0,
            ..history(
                "frequency".to_owned(),
                frequency_unit(units),
                responses.frequency.clone(),
            )
        },
        columns,
        is_motion: false,
    }
}

fn of_modes(modes: &SystemModes, units: &Units) -> Histories {
    let numbers = 1..=modes.frequency.len();
    let lists = modes.lists(units).into_iter();
    Histories {
        over: History {
            name: "mode".to_owned(),
            unit: "1".to_owned(),
            quantity: Quantity::Other,
            values: numbers.map(|number| number as f64).collect(),
            scale: 0.0,
        },
        columns: lists
            .map(|(name, unit, values)| History {
                name: name.to_owned(),
                unit,
                quantity: Quantity::Other,
                scale: largest(values),
                values: values.to_vec(),
            })
            .collect(),
        is_motion: false,
    }
}
