//! Checks of how a file says that it was made.

use std::collections::HashSet;

use super::rules::{Checked, finite, name, wrong};
use crate::superelement::{Derivation, SelectionRecord, Superelement};

/// More modes than this no superelement has had.
const MOST_MODES: usize = 1_000_000;

/// Checks how a superelement was made against what it is.
pub(in crate::dcb) fn derivation(of: &Superelement, derivation: &Derivation) -> Checked {
    if let Some(directions) = derivation.interface_directions
        && directions.kept > directions.available
    {
        return wrong(
            "/derivation/interface_directions",
            format!(
                "keeps {} directions of {}",
                directions.kept, directions.available
            ),
        );
    }
    left_out_columns(of, &derivation.left_out_columns)?;
    let mut earlier = None;
    for (index, record) in derivation.selections.iter().enumerate() {
        selection(of, index, record)?;
        if earlier.is_some_and(|kept| record.of_modes > kept) {
            return wrong(
                "/derivation/selection_modes",
                format!(
                    "selection {index} has {} modes before it; the one before it kept {}",
                    record.of_modes,
                    earlier.unwrap_or(0)
                ),
            );
        }
        earlier = Some(record.modes.len());
    }
    match earlier {
        Some(kept) if kept < of.mode_count() => wrong(
            "/derivation/selection_modes",
            format!(
                "has {kept} modes of the last selection; the superelement has {}",
                of.mode_count()
            ),
        ),
        _ => Ok(()),
    }
}

fn left_out_columns(of: &Superelement, columns: &[String]) -> Checked {
    let path = "/derivation/left_out_columns";
    let there = of.enrichment.as_ref();
    let there = there.map_or(&[][..], |enrichment| enrichment.names.as_slice());
    let mut seen = HashSet::new();
    for (index, text) in columns.iter().enumerate() {
        name(path, &format!("name {index}"), text)?;
        if !seen.insert(text) {
            return wrong(path, format!("{text:?} stands there twice"));
        }
        if there.contains(text) {
            return wrong(path, format!("{text:?} is among /enrichment/names"));
        }
    }
    Ok(())
}

fn selection(of: &Superelement, index: usize, record: &SelectionRecord) -> Checked {
    let path = "/derivation/selection_modes";
    let modes = &record.modes;
    if record.of_modes > MOST_MODES {
        return wrong(
            path,
            format!(
                "selection {index} has {} modes before it; not more than {MOST_MODES} are possible",
                record.of_modes
            ),
        );
    }
    if let Some(pair) = modes.windows(2).find(|pair| pair[1] <= pair[0]) {
        return wrong(
            path,
            format!(
                "selection {index} has mode {} after {}; they must ascend",
                pair[1], pair[0]
            ),
        );
    }
    if let Some(beyond) = modes.last().filter(|last| **last >= record.of_modes) {
        return wrong(
            path,
            format!(
                "selection {index} has mode {beyond} of {}; they count from 0",
                record.of_modes
            ),
        );
    }
    for (path, value) in [
        (
            "/derivation/selection_first_omitted_eigenvalues",
            record.first_omitted_eigenvalue,
        ),
        ("/derivation/selection_frequency_limits", record.up_to),
    ] {
        if let Some(value) = value.filter(|value| !(value.is_finite() && *value >= 0.0)) {
            return wrong(
                path,
                format!("entry {index} is {value}; it must not be negative, and may be infinite"),
            );
        }
    }
    for (name, forces) in &record.loaded_along {
        loaded_along(of, name, forces)?;
    }
    Ok(())
}

fn loaded_along(of: &Superelement, name: &str, forces: &[Vec<f64>]) -> Checked {
    let path = "/derivation/selection_forces";
    let mut interfaces = of.interfaces.iter();
    let Some(index) = interfaces.position(|interface| interface.name == name) else {
        return wrong(
            path,
            format!("{name:?} is no interface of the superelement"),
        );
    };
    let rows = of.rows.iter().filter(|row| row.interface == index).count();
    if forces.is_empty() {
        return wrong(path, format!("interface {name:?} is loaded along no force"));
    }
    for force in forces {
        if force.len() != rows {
            return wrong(
                path,
                format!(
                    "a force on interface {name:?} has {} entries; {rows} are needed",
                    force.len()
                ),
            );
        }
        finite(path, force)?;
    }
    Ok(())
}
