//! Names of a component and in it.

use super::Units;
use super::fault::{ComponentFault, fault};

/// A name that people and other files refer to: not blank, and nothing that can't be printed.
pub(crate) fn check_label(location: &str, label: &str) -> Result<(), ComponentFault> {
    if label.trim().is_empty() {
        return Err(fault(location, "is empty; expected a name"));
    }
    if label.contains(char::is_control) {
        return Err(fault(
            location,
            format!("{label:?} contains a control character; expected printable text"),
        ));
    }
    Ok(())
}

/// Units have names.
pub(crate) fn check_units(units: &Units) -> Result<(), ComponentFault> {
    let Units { length, mass, time } = units;
    [("length", length), ("mass", mass), ("time", time)]
        .into_iter()
        .try_for_each(|(key, unit)| check_label(&format!("component.units.{key}"), unit))
}
