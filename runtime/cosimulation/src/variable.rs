//! The variables of a unit, made of a scene: the one list that the model description and the running unit share.
//!
//! Value references are counted within each kind from a number of its own, in the order of the scene. An output that is added behind the others
//! leaves all references as they were.

use std::collections::BTreeMap;

use dcb_formats::scene::Scene;
use dcb_runtime::error::Error;
use dcb_runtime::mechanism::Mechanism;

use crate::parameter::Parameter;

/// First value references of inputs and outputs; that of the time is zero, those of parameters lie between.
const FIRST: [u32; 2] = [100_000, 1_000_000];
/// The channel and column that [`DEFECT`] shows.
const BALANCE: (&str, &str) = ("energy/balance", "defect");
/// Name of the output with the defect of the energy balance.
const DEFECT: &str = "energy_defect";

/// A number that an importer reads or sets.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Unique name.
    pub name: String,
    /// Its number for importers.
    pub reference: u32,
    /// What it is in the unit.
    pub source: Source,
    /// Value at the start, of parameters and inputs.
    pub start: Option<f64>,
    /// Unit, for example `kg*m/s^2`; `1` where it has none.
    pub unit: String,
    /// One sentence for people.
    pub description: String,
}

/// What a variable is in a unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// The time.
    Time,
    /// A parameter, by its index.
    Parameter(usize),
    /// An input, by its index.
    Input(usize),
    /// An output: a column of a recorded channel.
    Output {
        /// Path of the channel.
        channel: String,
        /// Its column.
        column: usize,
    },
}

impl Source {
    /// For people.
    fn kind(&self) -> &'static str {
        match self {
            Self::Time => "the time",
            Self::Parameter(_) => "a parameter",
            Self::Input(_) => "an input",
            Self::Output { .. } => "an output",
        }
    }
}

/// The variables of a scene that moves: time, parameters, inputs, outputs.
///
/// # Errors
/// [`Error::Description`] for a name that FMI doesn't allow, or that two of them have.
pub(crate) fn variables(
    scene: &Scene,
    mechanism: &Mechanism,
    parameters: &[Parameter],
) -> Result<Vec<Variable>, Error> {
    let mut found = vec![Variable {
        name: "time".into(),
        reference: 0,
        source: Source::Time,
        start: None,
        unit: scene.units.time.clone(),
        description: "time of the motion".into(),
    }];
    let [first_input, first_output] = FIRST;
    let references = Parameter::references(parameters);
    for (index, (reference, parameter)) in references.into_iter().zip(parameters).enumerate() {
        found.push(Variable {
            name: parameter.name(),
            reference,
            source: Source::Parameter(index),
            start: Some(parameter.value(scene)),
            unit: parameter.unit(scene),
            description: parameter.description(),
        });
    }
    for (index, (reference, input)) in (first_input..).zip(mechanism.inputs()).enumerate() {
        found.push(Variable {
            name: input.name.clone(),
            reference,
            source: Source::Input(index),
            start: Some(input.initial),
            unit: input.unit.clone(),
            description: input.description.clone(),
        });
    }
    let mut outputs = Vec::new();
    for channel in mechanism.channels() {
        let is_output = channel.path.starts_with("outputs/");
        for (index, column) in channel.columns.iter().enumerate() {
            let name = match (channel.path.as_str(), column.name.as_str()) {
                BALANCE => DEFECT.to_owned(),
                _ if is_output => channel.label(column),
                _ => continue,
            };
            let source = Source::Output {
                channel: channel.path.clone(),
                column: index,
            };
            outputs.push((
                name,
                source,
                column.unit.clone(),
                channel.description.clone(),
            ));
        }
    }
    // The defect is there in any scene: it comes first, whatever is added.
    outputs.sort_by_key(|(name, ..)| name != DEFECT);
    for (reference, (name, source, unit, description)) in (first_output..).zip(outputs) {
        let description = match name.as_str() {
            DEFECT => "what the balance of energies and works lacks since the start".into(),
            _ => description,
        };
        found.push(Variable {
            name,
            reference,
            source,
            start: None,
            unit,
            description,
        });
    }
    check_names(&found)?;
    Ok(found)
}

/// Names are unique, and lines of text.
fn check_names(variables: &[Variable]) -> Result<(), Error> {
    let mut known: BTreeMap<&str, &Variable> = BTreeMap::new();
    for variable in variables {
        let name = variable.name.as_str();
        if let Some(control) = name.chars().find(|c| is_forbidden(*c)) {
            return Err(Error::described(
                place(variable),
                format!(
                    "the name {name:?} has the character {control:?}, which FMI allows in no name of a variable; rename it in the scene"
                ),
            ));
        }
        if let Some(other) = known.insert(name, variable) {
            return Err(Error::described(
                place(variable),
                format!(
                    "{name:?} would be the name of {} and of {}, but FMI wants different names; rename one of them in the scene",
                    other.source.kind(),
                    variable.source.kind()
                ),
            ));
        }
    }
    Ok(())
}

/// Control characters, and what XML 1.0 has no place for.
fn is_forbidden(c: char) -> bool {
    c.is_control() || matches!(c, '\u{2028}' | '\u{2029}' | '\u{fffe}' | '\u{ffff}')
}

/// Where the scene has what a variable is made of.
fn place(variable: &Variable) -> String {
    match &variable.source {
        Source::Time => "time".into(),
        Source::Parameter(_) => variable.name.clone(),
        Source::Input(_) => format!("drives or loads.{:?}", variable.name),
        Source::Output { channel, .. } => match channel.strip_prefix("outputs/") {
            Some(output) => format!("outputs.{output:?}"),
            None => variable.name.clone(),
        },
    }
}
