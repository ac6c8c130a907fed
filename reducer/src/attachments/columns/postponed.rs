//! Columns that one solution doesn't suffice for, until there is a block of them.

use super::ProjectedForces;

/// Columns that have been put off, with their forces.
#[derive(Default)]
pub(super) struct Postponed {
    /// Their rows of L_b; `None` without any.
    pub columns: Option<(Vec<usize>, ProjectedForces)>,
}

impl Postponed {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.columns.as_ref().map_or(0, |(rows, _)| rows.len())
    }

    /// Puts further ones off.
    pub fn extend(&mut self, rows: Vec<usize>, forces: ProjectedForces) {
        match &mut self.columns {
            _ if rows.is_empty() => {}
            Some((all, held)) => {
                all.extend(rows);
                held.extend(forces);
            }
            None => self.columns = Some((rows, forces)),
        }
    }
}
