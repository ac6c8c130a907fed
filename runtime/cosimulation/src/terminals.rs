//! The `terminalsAndIcons.xml` of FMI 3.0: variables that belong together, for importers that connect them as one.

use std::io;

use indexmap::IndexMap;

use crate::unit::CoSimulation;
use crate::variable::{Source, Variable};
use crate::xml::Document;

/// Variables of a terminal by the names of its members.
type Members<'a> = Vec<(&'a str, &'a Variable)>;

/// The text of `terminalsAndIcons/terminalsAndIcons.xml`: a terminal for each output of several numbers, and for each load of which several components
/// are inputs. `None` where there is none.
///
/// # Errors
/// None but those of writing to memory.
pub fn terminals(unit: &CoSimulation) -> io::Result<Option<String>> {
    let mut found: IndexMap<&str, Members<'_>> = IndexMap::new();
    for separator in ['.', '/'] {
        let own = grouped(unit, separator);
        // An output and a load of one name: the load's components stay by themselves.
        let new: Vec<_> = (own.into_iter())
            .filter(|(name, members)| members.len() > 1 && !found.contains_key(name))
            .collect();
        found.extend(new);
    }
    if found.is_empty() {
        return Ok(None);
    }
    let mut document = Document::new()?;
    document.open("fmiTerminalsAndIcons", &[("fmiVersion", "3.0")])?;
    document.open("Terminals", &[])?;
    for (name, members) in found {
        document.open("Terminal", &[("name", name), ("matchingRule", "bus")])?;
        for (member, variable) in members {
            let attributes = [
                ("variableName", variable.name.as_str()),
                ("memberName", member),
                ("variableKind", "signal"),
            ];
            document.empty("TerminalMemberVariable", &attributes)?;
        }
        document.close("Terminal")?;
    }
    document.close("Terminals")?;
    document.close("fmiTerminalsAndIcons")?;
    document.text().map(Some)
}

/// Outputs `NAME.MEMBER` or inputs `NAME/MEMBER` by their name.
fn grouped(unit: &CoSimulation, separator: char) -> IndexMap<&str, Members<'_>> {
    let mut found: IndexMap<&str, Members<'_>> = IndexMap::new();
    for variable in unit.variables() {
        let is_meant = match (&variable.source, separator) {
            (Source::Output { channel, .. }, '.') => channel.starts_with("outputs/"),
            (Source::Input(_), '/') => true,
            _ => false,
        };
        if let Some((name, member)) = variable.name.rsplit_once(separator).filter(|_| is_meant) {
            found.entry(name).or_default().push((member, variable));
        }
    }
    found
}
