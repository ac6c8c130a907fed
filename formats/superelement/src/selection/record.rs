//! Selections in the provenance: what was left out of a superelement after its reduction.

use std::collections::BTreeMap;

use dcb_formats::superelement::Superelement;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::interface::{InterfaceSelection, rows_of};

/// Key of the provenance's options under which selections are listed.
const RECORD: &str = "selections";
/// Key of one selection's interfaces that are loaded along some forces only.
const LOADED_ALONG: &str = "loaded_along";

/// One selection that a superelement went through.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SelectionRecord {
    /// Places of the modes that stayed, ascending.
    pub modes: Vec<usize>,
    /// How many there were.
    pub of_modes: usize,
    /// The lowest ω² that was left out already before; `None` if nothing was.
    #[serde(default)]
    pub first_omitted_eigenvalue: Option<f64>,
    /// The frequency, in cycles per time, up to which the responses were to stay as they are; `None` if nobody said.
    #[serde(default)]
    pub up_to: Option<f64>,
    /// Interfaces that are loaded along some forces only: these, each over the interface's rows.
    pub loaded_along: BTreeMap<String, Vec<Vec<f64>>>,
    /// Interfaces whose attachments went.
    pub observed: Vec<String>,
    /// Interfaces that went.
    pub dropped: Vec<String>,
    /// Places of the further columns that stayed.
    pub further_columns: Vec<usize>,
}

impl SelectionRecord {
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
            modes: modes.to_vec(),
            of_modes: whole.mode_count(),
            first_omitted_eigenvalue: Some(omitted).filter(|square| square.is_finite()),
            up_to,
            loaded_along: along.collect(),
            observed: named(InterfaceSelection::Observed),
            dropped: named(InterfaceSelection::Dropped),
            further_columns: further.to_vec(),
        }
    }

    /// All that a superelement went through, the first one first. Those of other programs, which can't be read, aren't among them.
    pub fn all_of(superelement: &Superelement) -> Vec<Self> {
        let listed = superelement.provenance.options[RECORD].as_array();
        let read = |value: &Value| serde_json::from_value(value.clone()).ok();
        listed.into_iter().flatten().filter_map(read).collect()
    }
}

/// Whether an earlier selection took away directions in which an interface is loaded.
pub(super) fn has_cut_directions(whole: &Superelement) -> bool {
    let selections = whole.provenance.options[RECORD].as_array();
    selections.into_iter().flatten().any(|selection| {
        let along = selection[LOADED_ALONG].as_object();
        along.is_some_and(|along| {
            let names = whole.interfaces.iter().map(|interface| &interface.name);
            names.into_iter().any(|name| along.contains_key(name))
        })
    })
}

/// The options of a superelement with one more selection, which leaves these rows; as they are where they have no keys.
pub(super) fn recorded(whole: &Superelement, record: &SelectionRecord, rows: &[usize]) -> Value {
    let mut options = match &whole.provenance.options {
        Value::Null => json!({}),
        other => other.clone(),
    };
    if let Some(keys) = options.as_object_mut() {
        let list = keys.entry(RECORD).or_insert(Value::Null);
        if list.is_null() {
            *list = json!([]);
        }
        if let Some(list) = list.as_array_mut() {
            for earlier in list.iter_mut() {
                keep_rows(whole, &mut earlier[LOADED_ALONG], rows);
            }
            list.push(json!(record));
        }
    }
    options
}

/// Forces over the rows that are left, in their order.
fn keep_rows(whole: &Superelement, loaded_along: &mut Value, rows: &[usize]) {
    for (index, interface) in whole.interfaces.iter().enumerate() {
        let own = rows_of(whole, index);
        let forces = loaded_along.get_mut(&interface.name);
        let forces = forces.and_then(Value::as_array_mut);
        for force in forces.into_iter().flatten() {
            let kept = rows.iter().filter(|row| own.contains(row));
            *force = kept.map(|row| force[row - own.start].clone()).collect();
        }
    }
}
