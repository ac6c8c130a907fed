//! Connections as paths: what their forces are, and the mechanism without them.
//!
//! A mechanism without some connections, on which the forces of these act instead, moves as before. So the forces λ of the rows of the connections are outputs of the
//! mechanism, and inputs of that without them, where each acts along the gradient of its measure, on both sides.

use std::ops::Range;

use dcb_formats::description::{listed, suggestion};
use dcb_formats::function::{Function, TimeFunction};

use crate::actuator::{Actuator, Source};
use crate::error::Error;
use crate::system::{ConnectionKind, Demand, Signal, System};

/// A connection.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Path {
    pub name: String,
    pub rows: Range<usize>,
}

/// The joints, springs and bushings of these names.
///
/// # Errors
/// [`Error::Description`] at `location` for a name that there isn't, or is twice.
pub(crate) fn paths(system: &System, names: &[String], location: &str) -> Result<Vec<Path>, Error> {
    let owner = |kind: ConnectionKind| match kind {
        ConnectionKind::Joint => Some("joints"),
        ConnectionKind::Spring => Some("springs"),
        ConnectionKind::Drive | ConnectionKind::Actuator | ConnectionKind::AssembledModes => None,
    };
    let mut found: Vec<Path> = Vec::with_capacity(names.len());
    for (index, name) in names.iter().enumerate() {
        let at = || format!("{location}[{index}]");
        let mut fits = system.connections.iter().filter(|connection| {
            owner(connection.kind).is_some_and(|owner| {
                connection.name == *name || format!("{owner}/{}", connection.name) == *name
            })
        });
        let Some(connection) = fits.next() else {
            let known = system.connections.iter();
            let known: Vec<&str> = known
                .filter(|connection| owner(connection.kind).is_some())
                .map(|connection| connection.name.as_str())
                .collect();
            let hint = match suggestion(name, known.iter().copied()) {
                none if none.is_empty() => format!("; there are: {}", listed(known)),
                nearest => nearest,
            };
            return Err(Error::described(
                at(),
                format!("there is no joint, spring or bushing {name:?}{hint}"),
            ));
        };
        if fits.next().is_some() {
            return Err(Error::described(
                at(),
                format!("{name:?} is a joint and a spring; write joints/{name} or springs/{name}"),
            ));
        }
        if found.iter().any(|path| path.rows == connection.rows) {
            return Err(Error::described(at(), format!("{name:?} is there twice")));
        }
        found.push(Path {
            name: name.clone(),
            rows: connection.rows.clone(),
        });
    }
    Ok(found)
}

/// The mechanism without the demands of some rows, on which efforts act that are constant: those that the rows have at rest.
pub(crate) fn cut(system: &System, rows: &[usize], efforts: &[f64]) -> Result<System, Error> {
    let mut without = system.clone();
    for (row, effort) in rows.iter().zip(efforts) {
        let signal = Signal {
            function: TimeFunction::new(&Function::Constant(*effort))?,
            input: None,
            offset: 0.0,
        };
        without.rows[*row].demand = Demand::Actuate(without.actuators.len());
        without.actuators.push(Actuator {
            row: *row,
            zero: 0.0,
            source: Source::Given(without.signals.len()),
            memory: without.memory_count,
        });
        without.signals.push(signal);
    }
    Ok(without)
}
