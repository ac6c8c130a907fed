//! Interfaces as a scene uses them.

use dcb_formats::superelement::Superelement;
use faer::Mat;

use super::LeftOut;
use crate::Error;
use crate::demand::{Demand, InterfaceDemand};
use dcb_superelement::selection::{InterfaceSelection, Normal, Selection};

/// Components of a wrench below this are rounding.
const NOTHING: f64 = 1e-9;

/// How much of the interfaces is left out. Attachments that no force needs are coordinates all the same, and improve the answers to other forces a little.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Economy {
    /// Interfaces that aren't used, and directions in which nothing acts.
    Directions,
    /// Interfaces that aren't used.
    Interfaces,
    /// Nothing.
    None,
}

impl Economy {
    /// The largest first.
    pub const ALL: [Self; 3] = [Self::Directions, Self::Interfaces, Self::None];
}

/// The selection with its interfaces loaded and observed as the demand says, and what of them is left out.
///
/// # Errors
/// Those of [`Selection::with_interface`].
pub(super) fn as_used(
    mut selection: Selection,
    whole: &Superelement,
    demand: &Demand,
    plane: Option<Normal>,
    economy: Economy,
) -> Result<(Selection, Vec<LeftOut>), Error> {
    let mut left_out = Vec::new();
    if economy == Economy::None {
        return Ok((selection, left_out));
    }
    let mut tell = |what: String, why: String| {
        left_out.push(LeftOut {
            what,
            why,
            cost: None,
        });
    };
    for (index, interface) in whole.interfaces.iter().enumerate() {
        let name = &interface.name;
        let before = &selection.interfaces()[index];
        if *before == InterfaceSelection::Dropped {
            continue;
        }
        let Some(asked) = demand.interfaces.iter().find(|asked| asked.name == *name) else {
            tell(
                format!("interface {name:?}"),
                "nothing acts on it or looks at it".to_owned(),
            );
            selection = selection.with_interface(name, InterfaceSelection::Dropped)?;
            continue;
        };
        if *before == InterfaceSelection::Observed {
            continue;
        }
        match forces(whole, index, asked, plane) {
            Forces::All => {}
            Forces::None => {
                tell(
                    format!("attachments of interface {name:?}"),
                    match asked.loaded_by.is_empty() {
                        true => "nothing acts on it".to_owned(),
                        false => "what acts on it doesn't move it in the plane".to_owned(),
                    },
                );
                selection = selection.with_interface(name, InterfaceSelection::Observed)?;
            }
            Forces::Some(_) if economy != Economy::Directions => {}
            Forces::Some(along) => {
                tell(
                    format!(
                        "{} of {} directions of force on interface {name:?}",
                        along.nrows() - along.ncols(),
                        along.nrows()
                    ),
                    format!("{} can't exert them", asked.loaded_by.join(", ")),
                );
                let wanted = InterfaceSelection::LoadedAlong(along);
                selection = selection.with_interface(name, wanted)?;
            }
        }
    }
    Ok((selection, left_out))
}

enum Forces {
    All,
    Some(Mat<f64>),
    None,
}

/// The demanded wrenches over the rows of an interface, those in the plane if there is one.
fn forces(
    whole: &Superelement,
    interface: usize,
    asked: &InterfaceDemand,
    plane: Option<Normal>,
) -> Forces {
    let rows: Vec<usize> = (0..whole.rows.len())
        .filter(|row| whole.rows[*row].interface == interface)
        .collect();
    let slots: Option<Vec<usize>> = rows
        .iter()
        .map(|row| usize::try_from(whole.rows[*row].direction).ok())
        .collect();
    let one_frame = |slots: &Vec<usize>| {
        let mut sorted = slots.clone();
        sorted.sort_unstable();
        sorted.dedup();
        sorted.len() == slots.len()
    };
    // Several nodes or explicit rows take what acts on them row by row.
    let Some(slots) = slots.filter(one_frame) else {
        return match asked.wrenches.is_empty() {
            true => Forces::None,
            false => Forces::All,
        };
    };
    let inside = |slot: usize| plane.is_none_or(|normal| normal.moves(slot));
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for wrench in &asked.wrenches {
        let mut column: Vec<f64> = (slots.iter())
            .map(|slot| if inside(*slot) { wrench[*slot] } else { 0.0 })
            .collect();
        for other in &basis {
            let along: f64 = column.iter().zip(other).map(|(a, b)| a * b).sum();
            for (entry, other) in column.iter_mut().zip(other) {
                *entry -= along * other;
            }
        }
        let size = column.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
        if size > NOTHING {
            basis.push(column.iter().map(|entry| entry / size).collect());
        }
    }
    match basis.len() {
        0 => Forces::None,
        count if count == rows.len() => Forces::All,
        count => Forces::Some(Mat::from_fn(rows.len(), count, |i, j| basis[j][i])),
    }
}
