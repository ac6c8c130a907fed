//! How a superelement was made, from the datasets of a file of 1.4 or later.

use crate::dcb::names;
use crate::dcb::read::SuperelementFile;
use crate::hdf5_files::inventory::Finding;
use crate::superelement::{
    BoundaryRow, Derivation, InterfaceDirections, InterfaceFrame, SelectionRecord,
};
use crate::terminal::shortened;

/// `None` where the file doesn't say.
pub(super) fn derivation(
    file: &SuperelementFile,
    interfaces: &[InterfaceFrame],
    rows: &[BoundaryRow],
) -> Result<Option<Derivation>, Finding> {
    let path = "/derivation/coupling_source";
    if !file.has(path) {
        return Ok(None);
    }
    let word = file.texts(path)?.pop().unwrap_or_default();
    let coupling_source = names::coupling_source_of(&word).ok_or_else(|| {
        Finding::at(
            path,
            format!(
                "is {:?}; it must be \"integrals\", \"nodal\" or \"unknown\"",
                shortened(&word)
            ),
        )
    })?;
    let left_out = "/derivation/left_out_columns";
    Ok(Some(Derivation {
        coupling_source,
        interface_directions: interface_directions(file)?,
        left_out_columns: match file.has(left_out) {
            true => file.texts(left_out)?,
            false => Vec::new(),
        },
        internal_rows: internal_rows(file)?,
        selections: selections(file, interfaces, rows)?,
    }))
}

fn interface_directions(file: &SuperelementFile) -> Result<Option<InterfaceDirections>, Finding> {
    let path = "/derivation/interface_directions";
    if !file.has(path) {
        return Ok(None);
    }
    match *counts(path, &file.integers(path)?)? {
        [kept, available] => Ok(Some(InterfaceDirections { kept, available })),
        _ => Err(Finding::at(path, "doesn't have two entries")),
    }
}

fn internal_rows(file: &SuperelementFile) -> Result<usize, Finding> {
    let path = "/derivation/internal_rows";
    match file.has(path) {
        true => Ok(counts(path, &file.integers(path)?)?.into_iter().sum()),
        false => Ok(0),
    }
}

fn selections(
    file: &SuperelementFile,
    interfaces: &[InterfaceFrame],
    rows: &[BoundaryRow],
) -> Result<Vec<SelectionRecord>, Finding> {
    let path = "/derivation/selection_modes";
    if !file.has(path) {
        return Ok(Vec::new());
    }
    let omitted = finite_ones(file, "/derivation/selection_first_omitted_eigenvalues")?;
    let limits = finite_ones(file, "/derivation/selection_frequency_limits")?;
    let per_selection = omitted.into_iter().zip(limits);
    let mut records: Vec<SelectionRecord> = per_selection
        .map(|(first_omitted_eigenvalue, up_to)| SelectionRecord {
            first_omitted_eigenvalue,
            up_to,
            ..SelectionRecord::default()
        })
        .collect();
    for [selection, kept] in pairs(path, &file.integers(path)?)? {
        let record = selected(&mut records, path, selection)?;
        match kept {
            0 => {}
            1 => record.modes.push(record.of_modes),
            _ => {
                return Err(Finding::at(
                    path,
                    format!("says {kept} of a mode; it must be 1 if it was kept, or 0"),
                ));
            }
        }
        record.of_modes += 1;
    }
    let path = "/derivation/selection_force_interfaces";
    let (loaded, values) = (
        pairs(path, &file.integers(path)?)?,
        file.reals("/derivation/selection_forces")?,
    );
    for (column, [selection, index]) in loaded.iter().copied().enumerate() {
        let record = selected(&mut records, path, selection)?;
        let interface = interfaces.get(index).ok_or_else(|| {
            Finding::at(
                path,
                format!(
                    "column {column} names interface {index} of {}",
                    interfaces.len()
                ),
            )
        })?;
        let mut force = Vec::new();
        for (place, row) in rows.iter().enumerate() {
            let value = values[place * loaded.len() + column];
            if row.interface == index {
                force.push(value);
            } else if value != 0.0 {
                return Err(Finding::at(
                    "/derivation/selection_forces",
                    format!(
                        "entry ({place}, {column}) is {value}; row {place} isn't one of interface {:?} and must be zero",
                        interface.name
                    ),
                ));
            }
        }
        let name = interface.name.clone();
        record.loaded_along.entry(name).or_default().push(force);
    }
    Ok(records)
}

/// The selection of this index.
fn selected<'r>(
    records: &'r mut [SelectionRecord],
    path: &str,
    index: usize,
) -> Result<&'r mut SelectionRecord, Finding> {
    let count = records.len();
    records.get_mut(index).ok_or_else(|| {
        Finding::at(
            path,
            format!("names selection {index} of {count}; they count from 0"),
        )
    })
}

/// `None` for what is infinite.
fn finite_ones(file: &SuperelementFile, path: &str) -> Result<Vec<Option<f64>>, Finding> {
    let values = file.reals(path)?;
    let finite = |value: f64| Some(value).filter(|value| *value != f64::INFINITY);
    Ok(values.into_iter().map(finite).collect())
}

fn counts(path: &str, values: &[i64]) -> Result<Vec<usize>, Finding> {
    let counted = values.iter().map(|value| {
        usize::try_from(*value)
            .map_err(|_| Finding::at(path, format!("has {value}; none may be negative")))
    });
    counted.collect()
}

fn pairs(path: &str, values: &[i64]) -> Result<Vec<[usize; 2]>, Finding> {
    let counts = counts(path, values)?;
    let (pairs, _) = counts.as_chunks::<2>();
    Ok(pairs.to_vec())
}
