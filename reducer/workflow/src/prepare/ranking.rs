//! Coordinates of all superelements of a scene in one order: attachments, which stand for all modes that are left out, and then the modes that move
//! most by themselves.

use super::activity::Activity;

/// Kind of a coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinate {
    /// A mode, by its place among those of the body.
    Mode(usize),
    /// An attachment. Which one it is doesn't matter: as many stay as are named, the softest.
    Attachment,
}

/// A body that deflects.
#[derive(Clone, Debug, PartialEq)]
pub struct Flexible {
    /// Its name.
    pub name: String,
    /// Its index in the scene.
    pub index: usize,
    /// Modes.
    pub modes: usize,
    /// Dynamic attachments.
    pub attachments: usize,
    /// Whether all modes have to stay.
    pub has_bound_modes: bool,
    /// Whether it has geometric stiffening, which is part of an inertia of second order.
    pub is_stiffened: bool,
}

/// Coordinates of some bodies, attachments first, and of either kind the most active first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ranking {
    /// Body, by its place among those that deflect, and coordinate.
    pub order: Vec<(usize, Coordinate)>,
}

impl Ranking {
    /// By what the coordinates did in a run.
    pub fn of(bodies: &[Flexible], activity: &Activity) -> Self {
        let mut ranked = Vec::new();
        for (place, body) in bodies.iter().enumerate() {
            let first = if body.has_bound_modes { body.modes } else { 0 };
            let moved = activity.of_body(body.index).iter().enumerate();
            for (coordinate, moved) in moved.skip(first) {
                let kind = match coordinate < body.modes {
                    true => Coordinate::Mode(coordinate),
                    false => Coordinate::Attachment,
                };
                ranked.push((*moved, (place, kind)));
            }
        }
        // Beside all modes an attachment hardly moves; what it is worth shows when modes are gone.
        let is_mode = |(_, kind): &(usize, Coordinate)| *kind != Coordinate::Attachment;
        ranked.sort_by(|a, b| {
            let kinds = is_mode(&a.1).cmp(&is_mode(&b.1));
            kinds.then(b.0.total_cmp(&a.0))
        });
        Self {
            order: ranked.into_iter().map(|(_, entry)| entry).collect(),
        }
    }

    /// The modes of a body among the coordinates, ascending, and how many of its attachments.
    pub fn of_body(&self, place: usize) -> (Vec<usize>, usize) {
        let own = self.order.iter().filter(|(body, _)| *body == place);
        let (mut modes, mut attachments) = (Vec::new(), 0);
        for (_, coordinate) in own {
            match coordinate {
                Coordinate::Mode(mode) => modes.push(*mode),
                Coordinate::Attachment => attachments += 1,
            }
        }
        modes.sort_unstable();
        (modes, attachments)
    }

    /// All coordinates but those of a kind, of which the first stay.
    pub fn with_first(&self, count: usize, is_of_kind: impl Fn(Coordinate) -> bool) -> Self {
        let mut order = self.order.clone();
        let mut left = count;
        order.retain(|(_, coordinate)| {
            let stays = !is_of_kind(*coordinate) || left > 0;
            if is_of_kind(*coordinate) {
                left = left.saturating_sub(1);
            }
            stays
        });
        Self { order }
    }

    /// How many there are of a kind.
    pub fn count(&self, is_of_kind: impl Fn(Coordinate) -> bool) -> usize {
        let kinds = self.order.iter().map(|(_, coordinate)| *coordinate);
        kinds.filter(|coordinate| is_of_kind(*coordinate)).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_a_kind_stay_and_all_of_the_others() {
        let mode = Coordinate::Mode;
        let all = Ranking {
            order: vec![
                (0, mode(2)),
                (1, Coordinate::Attachment),
                (0, mode(0)),
                (1, mode(1)),
                (0, Coordinate::Attachment),
            ],
        };
        let is_mode = |coordinate: Coordinate| coordinate != Coordinate::Attachment;
        assert_eq!(all.count(is_mode), 3);
        let fewer = all.with_first(2, is_mode);
        assert_eq!(fewer.of_body(0), (vec![0, 2], 1));
        assert_eq!(fewer.of_body(1), (vec![], 1));
        assert_eq!(all.with_first(1, |_| true).order, [(0, mode(2))]);
    }
}
