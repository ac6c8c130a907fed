//! A selection on record: in the superelement for programs, in the provenance for people.

use std::collections::BTreeMap;

use dcb_formats::superelement::{Derivation, Provenance, SelectionRecord, Superelement};
use serde_json::{Value, json};

use super::interface::{InterfaceSelection, rows_of};

/// Key of the provenance's options under which people find selections.
const LISTED: &str = "selections";
/// Key of one selection's interfaces that are loaded along some forces only.
const LOADED_ALONG: &str = "loaded_along";

/// A selection, and what only people ask about it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RecordedSelection {
    pub selection: SelectionRecord,
    /// Interfaces whose attachments went.
    observed: Vec<String>,
    /// Interfaces that went.
    dropped: Vec<String>,
    /// Places of the further columns that stayed.
    further_columns: Vec<usize>,
}

impl RecordedSelection {
    pub(super) fn of(
        whole: &Superelement,
        modes: &[usize],
        wanted: &[InterfaceSelection],
        further: &[usize],
        up_to: Option<f64>,
    ) -> Self {
        let interfaces = || whole.interfaces.iter().map(|frame| &frame.name).zip(wanted);
        let named = |use_of: InterfaceSelection| {
            let those = interfaces().filter(|(_, wanted)| **wanted == use_of);
            those.map(|(name, _)| name.clone()).collect()
        };
        let along = interfaces().filter_map(|(name, wanted)| match wanted {
            InterfaceSelection::LoadedAlong(forces) => {
                let columns = forces.col_iter().map(|force| force.iter().copied());
                Some((name.clone(), columns.map(Iterator::collect).collect()))
            }
            _ => None,
        });
        let omitted = whole.modes.first_omitted_eigenvalue;
        Self {
            selection: SelectionRecord {
                modes: modes.to_vec(),
                of_modes: whole.mode_count(),
                first_omitted_eigenvalue: Some(omitted).filter(|square| square.is_finite()),
                up_to: up_to.filter(|frequency| frequency.is_finite()),
                loaded_along: along.collect(),
            },
            observed: named(InterfaceSelection::Observed),
            dropped: named(InterfaceSelection::Dropped),
            further_columns: further.to_vec(),
        }
    }

    /// How a superelement was made that went through this selection too, which leaves these rows.
    pub(super) fn derivation(&self, whole: &Superelement, rows: &[usize]) -> Derivation {
        let mut derivation = whole.derivation.clone().unwrap_or_default();
        derivation.selections.push(self.selection.clone());
        for record in &mut derivation.selections {
            record.loaded_along = over_rows(whole, &record.loaded_along, rows);
        }
        derivation
    }

    /// The provenance with one more selection; as it is where the options have no keys.
    pub(super) fn provenance(&self, whole: &Superelement, derivation: &Derivation) -> Provenance {
        let mut provenance = whole.provenance.clone();
        if provenance.options.is_null() {
            provenance.options = json!({});
        }
        if let Some(keys) = provenance.options.as_object_mut() {
            let list = keys.entry(LISTED).or_insert(Value::Null);
            if list.is_null() {
                *list = json!([]);
            }
            if let Some(list) = list.as_array_mut() {
                list.push(self.listed());
                for (listed, record) in list.iter_mut().zip(&derivation.selections) {
                    if let Some(keys) = listed.as_object_mut() {
                        keys.insert(LOADED_ALONG.to_owned(), json!(record.loaded_along));
                    }
                }
            }
        }
        provenance
    }

    fn listed(&self) -> Value {
        let mut listed = json!(self.selection);
        listed["observed"] = json!(self.observed);
        listed["dropped"] = json!(self.dropped);
        listed["further_columns"] = json!(self.further_columns);
        listed
    }
}

/// Whether an earlier selection took away directions in which an interface is loaded.
pub(super) fn has_cut_directions(whole: &Superelement) -> bool {
    let records = whole.selections().iter();
    records
        .flat_map(|record| record.loaded_along.keys())
        .any(|name| whole.interfaces.iter().any(|frame| frame.name == *name))
}

/// Forces over the rows that are left, in their order, of the interfaces that are.
fn over_rows(
    whole: &Superelement,
    loaded_along: &BTreeMap<String, Vec<Vec<f64>>>,
    rows: &[usize],
) -> BTreeMap<String, Vec<Vec<f64>>> {
    let mut left = BTreeMap::new();
    for (index, interface) in whole.interfaces.iter().enumerate() {
        let own = rows_of(whole, index);
        let kept: Vec<usize> = rows
            .iter()
            .filter(|row| own.contains(row))
            .copied()
            .collect();
        if let Some(forces) = loaded_along
            .get(&interface.name)
            .filter(|_| !kept.is_empty())
        {
            let over = |force: &Vec<f64>| kept.iter().map(|row| force[row - own.start]).collect();
            left.insert(interface.name.clone(), forces.iter().map(over).collect());
        }
    }
    left
}
