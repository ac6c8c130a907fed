//! How a superelement was made, from the provenance of a file before 1.4: later files say so in datasets.
//!
//! The digest doesn't cover the provenance, so nothing here is refused: what can't be read is as if nobody had said it.

use serde::Deserialize;
use serde_json::Value;

use crate::superelement::{
    BoundaryRow, CouplingSource, Derivation, InterfaceDirections, InterfaceFrame, Provenance,
    SelectionRecord,
};

/// `None` where the provenance says nothing.
pub(super) fn derivation(
    provenance: &Provenance,
    interfaces: &[InterfaceFrame],
    rows: &[BoundaryRow],
) -> Option<Derivation> {
    let Provenance {
        quality, options, ..
    } = provenance;
    let selections: Vec<SelectionRecord> = listed(&options["selections"])
        .map(|value| selection(value, interfaces, rows))
        .collect();
    if quality.is_null() && selections.is_empty() {
        return None;
    }
    let reduction = &quality["interface_reduction"];
    let count = |name: &str| reduction[name].as_u64().unwrap_or(0) as usize;
    Some(Derivation {
        coupling_source: CouplingSource::deserialize(&quality["couplings"]).unwrap_or_default(),
        interface_directions: (!reduction.is_null()).then(|| InterfaceDirections {
            kept: count("kept"),
            available: count("available"),
        }),
        left_out_columns: listed(&quality["enrichment"]["left_out"])
            .map(|name| {
                name.as_str()
                    .map_or_else(|| name.to_string(), str::to_owned)
            })
            .collect(),
        internal_rows: 0,
        selections,
    })
}

fn listed(list: &Value) -> impl Iterator<Item = &Value> {
    list.as_array().into_iter().flatten()
}

/// Forces count on interfaces that are still there. Where they aren't over the rows of theirs, all that is known is that there were some.
fn selection(
    value: &Value,
    interfaces: &[InterfaceFrame],
    rows: &[BoundaryRow],
) -> SelectionRecord {
    let mut record = SelectionRecord::deserialize(value).unwrap_or_default();
    record.loaded_along.retain(|name, forces| {
        let index = interfaces.iter().position(|frame| frame.name == *name);
        let own = rows.iter().filter(|row| Some(row.interface) == index);
        let count = own.count();
        if forces.iter().any(|force| force.len() != count) {
            forces.clear();
        }
        index.is_some()
    });
    record
}
