//! A selection on record: in the superelement for programs, in the provenance for people.

use std::collections::BTreeMap;

use dcb_formats::superelement::{Derivation, Provenance, SelectionRecord, Superelement};
use serde_json::{Value, json};

use super::Selection;
use super::interface::{InterfaceSelection, rows_of};

/// Key of the provenance's options under which people find selections.
const LISTED: &str = "selections";
/// Key of one selection's interfaces that are loaded along some forces only.
const LOADED_ALONG: &str = "loaded_along";

impl Selection {
    /// How a superelement was made that went through this selection too, which leaves these rows, and its provenance with one more selection.
    pub(super) fn recorded(
        &self,
        whole: &Superelement,
        rows: &[usize],
    ) -> (Option<Derivation>, Provenance) {
        let mut derivation = whole.derivation.clone().unwrap_or_default();
        derivation.selections.push(self.record(whole));
        for record in &mut derivation.selections {
            record.loaded_along = over_rows(whole, &record.loaded_along, rows);
        }
        let provenance = self.provenance(whole, &derivation.selections);
        (Some(derivation), provenance)
    }

    fn record(&self, whole: &Superelement) -> SelectionRecord {
        let along = whole.interfaces.iter().zip(&self.interfaces);
        let along = along.filter_map(|(frame, wanted)| match wanted {
            InterfaceSelection::LoadedAlong(forces) => {
                let columns = forces.col_iter().map(|force| force.iter().copied());
                Some((frame.name.clone(), columns.map(Iterator::collect).collect()))
            }
            _ => None,
        });
        let omitted = whole.modes.first_omitted_eigenvalue;
        SelectionRecord {
            modes: self.modes.clone(),
            of_modes: whole.mode_count(),
            first_omitted_eigenvalue: Some(omitted).filter(|square| square.is_finite()),
            up_to: self.up_to.filter(|frequency| frequency.is_finite()),
            loaded_along: along.collect(),
        }
    }

    /// The provenance with this selection, the last on record; as it is where the options have no keys.
    fn provenance(&self, whole: &Superelement, records: &[SelectionRecord]) -> Provenance {
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
                list.push(self.listed(whole, records));
                for (listed, record) in list.iter_mut().zip(records) {
                    if let Some(keys) = listed.as_object_mut() {
                        keys.insert(LOADED_ALONG.to_owned(), json!(record.loaded_along));
                    }
                }
            }
        }
        provenance
    }

    /// The last on record, and the facts that only people ask about.
    fn listed(&self, whole: &Superelement, records: &[SelectionRecord]) -> Value {
        let named = |use_of: InterfaceSelection| -> Vec<&str> {
            let interfaces = whole.interfaces.iter().zip(&self.interfaces);
            let those = interfaces.filter(|(_, wanted)| **wanted == use_of);
            those.map(|(frame, _)| frame.name.as_str()).collect()
        };
        let mut listed = json!(records.last());
        listed["observed"] = json!(named(InterfaceSelection::Observed));
        listed["dropped"] = json!(named(InterfaceSelection::Dropped));
        listed["further_columns"] = json!(self.enrichment);
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
