//! Selections in the provenance: what was left out of a superelement after its reduction.

use dcb_formats::superelement::Superelement;
use serde_json::{Value, json};

use super::interface::InterfaceSelection;

/// Key of the provenance's options under which selections are listed.
const RECORD: &str = "selections";
/// Key of one selection's interfaces that are loaded along some forces only.
const LOADED_ALONG: &str = "loaded_along";

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

/// What was selected, in words.
pub(super) fn record(
    whole: &Superelement,
    modes: &[usize],
    wanted: &[InterfaceSelection],
    further: &[usize],
) -> Value {
    let named = |is: fn(&InterfaceSelection) -> bool| -> Vec<&str> {
        let interfaces = whole.interfaces.iter().zip(wanted);
        let those = interfaces.filter(|(_, wanted)| is(wanted));
        those
            .map(|(interface, _)| interface.name.as_str())
            .collect()
    };
    let along: serde_json::Map<String, Value> = (whole.interfaces.iter().zip(wanted))
        .filter_map(|(interface, wanted)| match wanted {
            InterfaceSelection::LoadedAlong(forces) => {
                Some((interface.name.clone(), json!(forces.ncols())))
            }
            _ => None,
        })
        .collect();
    json!({
        "modes": modes,
        "of_modes": whole.mode_count(),
        LOADED_ALONG: along,
        "observed": named(|wanted| *wanted == InterfaceSelection::Observed),
        "dropped": named(|wanted| *wanted == InterfaceSelection::Dropped),
        "further_columns": further,
    })
}

/// Options with one more selection; as they are where they have no keys.
pub(super) fn recorded(options: &Value, record: &Value) -> Value {
    let mut options = match options {
        Value::Null => json!({}),
        other => other.clone(),
    };
    if let Some(keys) = options.as_object_mut() {
        let list = keys.entry(RECORD).or_insert_with(|| json!([]));
        if let Some(list) = list.as_array_mut() {
            list.push(record.clone());
        }
    }
    options
}
