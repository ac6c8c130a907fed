//! Coordinates of all superelements of a scene in one order: those first that move most by themselves.

use indexmap::IndexMap;

use super::activity::Activity;
use crate::model::Model;
use crate::scene::{BodyKind, Scene};

/// One dynamic coordinate of a superelement file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinate {
    /// A mode, from 0.
    Mode(usize),
    /// An attachment. Which one it is doesn't matter: as many stay as are named, the softest.
    Attachment,
}

/// What the bodies of one file have.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// Bodies made of it, by index in the scene.
    pub bodies: Vec<usize>,
    /// Modes.
    pub modes: usize,
    /// Dynamic attachments.
    pub attachments: usize,
}

/// The coordinates of some parts, the most active first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ranking {
    /// Part, as it is counted in [`parts`], and coordinate.
    pub order: Vec<(usize, Coordinate)>,
}

/// The superelements of a scene by file, in the order of their first bodies.
pub fn parts(scene: &Scene, model: &Model) -> Vec<Part> {
    let mut parts: IndexMap<_, Part> = IndexMap::new();
    for (index, body) in scene.bodies.values().enumerate() {
        let BodyKind::Superelement(of) = &body.kind else {
            continue;
        };
        let flexible = &model.system.bodies[index].flexible;
        let part = parts.entry(scene.resolve(&of.file)).or_default();
        part.bodies.push(index);
        part.modes = flexible.mode_count;
        part.attachments = flexible.displacement_count() - flexible.mode_count;
    }
    parts.into_values().collect()
}

impl Ranking {
    /// By what the coordinates did in a run, the most active body of a part counting.
    pub fn of(parts: &[Part], activity: &Activity) -> Self {
        let mut ranked = Vec::new();
        for (index, part) in parts.iter().enumerate() {
            for coordinate in 0..part.modes + part.attachments {
                let bodies = part.bodies.iter();
                let most = bodies.fold(0.0, |most: f64, body| {
                    let own = activity.of_body(*body).get(coordinate);
                    most.max(own.copied().unwrap_or(0.0))
                });
                let kind = match coordinate < part.modes {
                    true => Coordinate::Mode(coordinate),
                    false => Coordinate::Attachment,
                };
                ranked.push((most, (index, kind)));
            }
        }
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        Self {
            order: ranked.into_iter().map(|(_, entry)| entry).collect(),
        }
    }

    /// The modes of a part among the coordinates, ascending, and how many of its attachments.
    pub fn of_part(&self, part: usize) -> (Vec<usize>, usize) {
        let own = self.order.iter().filter(|(index, _)| *index == part);
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

    /// The first of these coordinates.
    pub fn first(&self, count: usize) -> Self {
        Self {
            order: self.order[..count].to_vec(),
        }
    }

    /// All coordinates but those of a kind, of which the first stay.
    pub fn with_first(&self, count: usize, is_of_kind: impl Fn(Coordinate) -> bool) -> Self {
        let mut left = count;
        let stays = |(_, coordinate): &&(usize, Coordinate)| -> bool {
            if !is_of_kind(*coordinate) {
                return true;
            }
            let stays = left > 0;
            left = left.saturating_sub(1);
            stays
        };
        Self {
            order: self.order.iter().filter(stays).copied().collect(),
        }
    }

    /// How many there are of a kind.
    pub fn count(&self, is_of_kind: impl Fn(Coordinate) -> bool) -> usize {
        let kinds = self.order.iter().map(|(_, coordinate)| *coordinate);
        kinds.filter(|coordinate| is_of_kind(*coordinate)).count()
    }
}
