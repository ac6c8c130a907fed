//! The forces that a selection is made for.

use dcb_formats::superelement::Superelement;
use faer::Mat;

use super::interface::{InterfaceSelection, rows_of};

/// B over all rows of the whole, (n_b, n_p), interface by interface: what a selection says of an interface, and where it is loaded on all its rows what an
/// earlier selection has said.
pub(super) fn loaded_forces(whole: &Superelement, wanted: &[InterfaceSelection]) -> Mat<f64> {
    let earlier = (whole.moments.as_ref()).and_then(|moments| moments.loaded.as_ref());
    let mut columns: Vec<(usize, Vec<f64>)> = Vec::new();
    for (interface, wanted) in wanted.iter().enumerate() {
        let rows = rows_of(whole, interface);
        match (wanted, earlier) {
            (InterfaceSelection::Loaded, Some(earlier)) => {
                for force in earlier.forces.col_iter() {
                    let own: Vec<f64> = rows.clone().map(|row| force[row]).collect();
                    if own.iter().any(|entry| *entry != 0.0) {
                        columns.push((rows.start, own));
                    }
                }
            }
            (InterfaceSelection::Loaded, None) => {
                columns.extend(rows.map(|row| (row, vec![1.0])));
            }
            (InterfaceSelection::LoadedAlong(forces), _) => {
                let own = forces.col_iter();
                columns.extend(own.map(|force| (rows.start, force.iter().copied().collect())));
            }
            (InterfaceSelection::Observed | InterfaceSelection::Dropped, _) => {}
        }
    }
    Mat::from_fn(whole.rows.len(), columns.len(), |row, j| {
        let (first, entries) = &columns[j];
        let entry = row.checked_sub(*first).and_then(|at| entries.get(at));
        entry.copied().unwrap_or(0.0)
    })
}
