//! Whether a file's parts fit each other, told from its inventory alone: what must be there,
//! every element type and shape.

use super::contract::{Axis, Counts, Dataset, Presence};
use super::datasets::DATASETS;
use crate::hdf5_files::attributes::Value;
use crate::hdf5_files::element::Element;
use crate::hdf5_files::inventory::{Entry, Finding, Inventory};
use crate::hdf5_files::version::{missing, text_attribute};
use crate::mesh::Dimension;

/// The numbers that all shapes must agree with.
pub(super) fn count(inventory: &Inventory) -> Result<Counts, Finding> {
    let dimension = match inventory.attribute("/", "dimension") {
        Some(Value::Integer(2)) => Dimension::Planar,
        Some(Value::Integer(3)) => Dimension::Spatial,
        other => {
            return Err(Finding::at(
                "/",
                format!("attribute dimension is {other:?}; it must be the integer 2 or 3"),
            ));
        }
    };
    let size = |path: &str, axis: usize| {
        let entry = inventory.entries.get(path).ok_or_else(|| missing(path))?;
        entry
            .line
            .shape
            .get(axis)
            .copied()
            .ok_or_else(|| Finding::at(path, format!("has no axis {axis}")))
    };
    let optional = |path: &str, axis: usize| {
        if inventory.entries.contains_key(path) {
            size(path, axis)
        } else {
            Ok(0)
        }
    };
    // Of two that are the same: where one is missing, that is what is wrong, and not the size of the other.
    let either = |path: &str, axis: usize, other: &str| match optional(path, axis)? {
        0 => optional(other, 0),
        count => Ok(count),
    };
    Ok(Counts {
        dimension,
        interfaces: size("/interfaces/names", 0)?,
        rows: size("/interfaces/dofs", 0)?,
        modes: size("/modes/eigenvalues", 0)?,
        enrichment: optional("/enrichment/interface_shapes", 1)?,
        rank: size("/residual/sigma2", 0)?,
        field_dofs: optional("/fields/dofs", 0)?,
        loads: optional("/loads/names", 0)?,
        rigid: optional("/error/rigid_shapes", 1)?,
        forces: optional("/error/forces", 1)?,
        left_out_columns: optional("/derivation/left_out_columns", 0)?,
        selections: either(
            "/derivation/selection_frequency_limits",
            0,
            "/derivation/selection_first_omitted_eigenvalues",
        )?,
        stress_fields: optional("/stress/names", 0)?,
        stress_points: either("/stress/points", 0, "/stress/point_fields")?,
        stress_rows: either("/stress/rows", 0, "/stress/shapes")?,
        selected_modes: optional("/derivation/selection_modes", 0)?,
        selected_forces: either(
            "/derivation/selection_forces",
            1,
            "/derivation/selection_force_interfaces",
        )?,
    })
}

/// Everything that must be there is there, in type and shape.
pub(super) fn check_shapes(inventory: &Inventory, counts: &Counts) -> Result<(), Finding> {
    for dataset in DATASETS {
        match inventory.entries.get(dataset.path) {
            Some(entry) => check_shape(dataset, entry, counts)?,
            None if is_required(dataset, inventory, counts) => return Err(missing(dataset.path)),
            None => {}
        }
    }
    for path in inventory.entries.keys() {
        text_attribute(inventory, path, "symbol")?;
        text_attribute(inventory, path, "units")?;
        if path.starts_with("/mesh/") {
            check_mesh_shape(inventory, path, counts)?;
        }
    }
    if !inventory.entries.contains_key("/mesh/points")
        && inventory
            .entries
            .keys()
            .any(|path| path.starts_with("/mesh/"))
    {
        return Err(missing("/mesh/points"));
    }
    match inventory.attribute("/residual/transform", "rank") {
        Some(Value::Integer(rank)) if usize::try_from(*rank) == Ok(counts.rank) => Ok(()),
        other => Err(Finding::at(
            "/residual/transform",
            format!(
                "attribute rank is {other:?}; its columns are {}",
                counts.rank
            ),
        )),
    }
}

fn is_required(dataset: &Dataset, inventory: &Inventory, counts: &Counts) -> bool {
    let any = |presence: Presence| {
        DATASETS
            .iter()
            .any(|other| other.presence == presence && inventory.entries.contains_key(other.path))
    };
    match dataset.presence {
        Presence::Required => true,
        Presence::Spatial => counts.dimension == Dimension::Spatial,
        Presence::Optional => false,
        Presence::Fields => any(Presence::Fields),
        Presence::Stressed => any(Presence::Stressed),
        Presence::Estimated => any(Presence::Estimated),
        Presence::Selected => any(Presence::Selected),
        Presence::Derived => {
            let mut paths = inventory.entries.keys();
            paths.any(|path| path.starts_with("/derivation/"))
        }
        Presence::Loaded => inventory.entries.contains_key("/loads/names"),
        Presence::Enriched => inventory
            .entries
            .contains_key("/enrichment/interface_shapes"),
    }
}

fn check_shape(dataset: &Dataset, entry: &Entry, counts: &Counts) -> Result<(), Finding> {
    let shape = counts.shape(dataset);
    if dataset.presence == Presence::Spatial && counts.dimension == Dimension::Planar {
        return Err(Finding::at(
            dataset.path,
            "doesn't belong in a planar superelement".to_owned(),
        ));
    }
    if entry.line.element != dataset.element || entry.line.shape != shape {
        return Err(Finding::at(
            dataset.path,
            format!(
                "is {} of shape {:?}; the other parts need {} of shape {shape:?}",
                entry.line.element.name(),
                entry.line.shape,
                dataset.element.name()
            ),
        ));
    }
    Ok(())
}

fn check_mesh_shape(inventory: &Inventory, path: &str, counts: &Counts) -> Result<(), Finding> {
    let Some(entry) = inventory.entries.get(path) else {
        return Err(missing(path));
    };
    let line = &entry.line;
    let d = counts.length(Axis::Coordinates);
    let right = match path
        .strip_prefix("/mesh/")
        .unwrap_or(path)
        .split('/')
        .collect::<Vec<_>>()[..]
    {
        ["points"] => line.element == Element::Real && line.shape.len() == 2 && line.shape[1] == d,
        ["cells", block, "data"] => {
            let index = block.parse::<usize>();
            let preceded = |index: usize| {
                index == 0
                    || inventory
                        .entries
                        .contains_key(&format!("/mesh/cells/{}/data", index - 1))
            };
            let named = inventory
                .entries
                .contains_key(&format!("/mesh/cells/{block}/type"));
            line.element == Element::Integer
                && line.shape.len() == 2
                && named
                && index.is_ok_and(preceded)
        }
        ["cells", block, "type"] => {
            let has_data = inventory
                .entries
                .contains_key(&format!("/mesh/cells/{block}/data"));
            line.element == Element::Text && line.shape.is_empty() && has_data
        }
        ["point_sets", _] => line.element == Element::Integer && line.shape.len() == 1,
        _ => true,
    };
    if right {
        Ok(())
    } else {
        Err(Finding::at(
            path,
            format!(
                "{} of shape {:?} doesn't fit there",
                line.element.name(),
                line.shape
            ),
        ))
    }
}
