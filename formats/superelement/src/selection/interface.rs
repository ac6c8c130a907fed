//! Use of an interface by a scene, and the forces that act there.

use dcb_formats::component::Role;
use dcb_formats::mesh::Direction;
use dcb_formats::superelement::Superelement;
use faer::Mat;

/// Use of an interface.
#[derive(Clone, Debug)]
pub enum InterfaceSelection {
    /// Forces act on all its rows.
    Loaded,
    /// Forces act along some directions only, which its attachments then answer to; the displacement of all its rows stays known.
    LoadedAlong(Mat<f64>),
    /// Only its displacement is asked for.
    Observed,
    /// Nothing: its rows go.
    Dropped,
}

/// An interface of the whole.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Place {
    pub name: String,
    role: Role,
    rows: usize,
}

impl Place {
    pub fn all(whole: &Superelement) -> Vec<Self> {
        let interfaces = whole.interfaces.iter().enumerate();
        interfaces
            .map(|(index, interface)| Self {
                name: interface.name.clone(),
                role: interface.role,
                rows: rows_of(whole, index).len(),
            })
            .collect()
    }

    pub fn refuse_misfit(&self, wanted: &InterfaceSelection) -> Result<(), String> {
        let Self { name, role, rows } = self;
        match wanted {
            InterfaceSelection::Loaded | InterfaceSelection::LoadedAlong(_)
                if *role == Role::Output =>
            {
                Err(format!(
                    "interface {name:?} is for output; make it an attachment and reduce again"
                ))
            }
            InterfaceSelection::LoadedAlong(forces)
                if forces.nrows() != *rows
                    || forces.ncols() == 0
                    || !forces.as_ref().is_all_finite()
                    || forces.col_iter().any(|force| force.norm_max() == 0.0) =>
            {
                Err(format!(
                    "forces on interface {name:?} are {} by {}; give finite columns that aren't zero, over its {rows} rows",
                    forces.nrows(),
                    forces.ncols()
                ))
            }
            _ => Ok(()),
        }
    }
}

/// Rows of an interface, which stand together.
pub(super) fn rows_of(whole: &Superelement, interface: usize) -> std::ops::Range<usize> {
    let before = |upto: usize| whole.rows.partition_point(|row| row.interface < upto);
    before(interface)..before(interface + 1)
}

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

impl PartialEq for InterfaceSelection {
    /// Different numbers of forces make a difference here, where matrices of different shapes can't be compared.
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::LoadedAlong(own), Self::LoadedAlong(others)) => {
                own.shape() == others.shape() && own == others
            }
            (Self::Loaded, Self::Loaded)
            | (Self::Observed, Self::Observed)
            | (Self::Dropped, Self::Dropped) => true,
            _ => false,
        }
    }
}

impl InterfaceSelection {
    /// Forces along these directions of an interface; [`Self::Observed`] if it has none of them, [`Self::Loaded`] if it has no others.
    pub fn along(whole: &Superelement, interface: usize, directions: &[Direction]) -> Self {
        let rows = rows_of(whole, interface);
        let along: Vec<usize> = (rows.clone())
            .filter(|row| {
                let direction = usize::try_from(whole.rows[*row].direction).ok();
                directions
                    .iter()
                    .any(|wanted| Some(wanted.index()) == direction)
            })
            .map(|row| row - rows.start)
            .collect();
        match along.len() {
            0 => Self::Observed,
            count if count == rows.len() => Self::Loaded,
            count => Self::LoadedAlong(Mat::from_fn(rows.len(), count, |i, j| {
                f64::from(u8::from(i == along[j]))
            })),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forces_of_different_numbers_are_different() {
        let along = |count: usize| {
            InterfaceSelection::LoadedAlong(Mat::from_fn(6, count, |i, j| {
                f64::from(u8::from(i == j))
            }))
        };
        assert!(along(2) == along(2));
        assert!(along(2) != along(3));
        assert!(along(2) != InterfaceSelection::Loaded);
    }
}
