//! How exactly places are known.
//!
//! A place has the rounding of its distance from the world's origin, and an angle that is counted on the rounding of an arc of that
//! length. A joint hands it on: what is joined to a body far away, or to a large one, is placed by a point that is only so exact. So bodies
//! that rows connect, whatever lies between them, share the coarsest rounding among them, and what nothing connects to them has its own.

use std::f64::consts::TAU;

use super::ROUNDING;
use crate::system::{State, System};

/// The rounding of the bodies' places.
pub(super) struct Roundings {
    /// Group of connected bodies of each body.
    groups: Vec<usize>,
    /// Group of each counted angle; `None` between frames of the ground.
    of_angles: Vec<Option<usize>>,
    /// How far from the world's origin the ground's points are that rows of a group touch.
    grounded: Vec<f64>,
    /// The longest body of each group.
    longest: Vec<f64>,
    /// How far from the world's origin places of each group are.
    reaches: Vec<f64>,
}

impl Roundings {
    /// For the bodies of a system, nowhere yet.
    pub(super) fn of(system: &System) -> Self {
        let mut groups: Vec<usize> = (0..system.bodies.len()).collect();
        let markers_of = |row: &crate::system::Row| {
            let terms = system.terms[row.terms.clone()].iter();
            terms.flat_map(|term| [term.a, term.b])
        };
        let body_of = |marker: usize| system.markers[marker].body;
        for row in &system.rows {
            let Some(first) = markers_of(row).find_map(body_of) else {
                continue;
            };
            for body in markers_of(row).filter_map(body_of) {
                let (kept, joined) = (groups[first], groups[body]);
                for group in groups.iter_mut().filter(|group| **group == joined) {
                    *group = kept;
                }
            }
        }
        let mut this = Self {
            of_angles: vec![None; system.angle_count],
            grounded: vec![0.0; groups.len()],
            longest: vec![0.0; groups.len()],
            reaches: vec![0.0; groups.len()],
            groups,
        };
        for (body, group) in system.bodies.iter().zip(&this.groups) {
            this.longest[*group] = this.longest[*group].max(body.length);
        }
        for row in &system.rows {
            let Some(body) = markers_of(row).find_map(body_of) else {
                continue;
            };
            let group = this.groups[body];
            for marker in markers_of(row).filter(|marker| body_of(*marker).is_none()) {
                let distance = system.markers[marker].position.amax();
                this.grounded[group] = this.grounded[group].max(distance);
            }
            for term in &system.terms[row.terms.clone()] {
                if let Some(angle) = term.angle {
                    this.of_angles[angle] = Some(group);
                }
            }
        }
        this
    }

    /// Takes the places of a state.
    pub(super) fn update(&mut self, system: &System, state: &State) {
        self.reaches.copy_from_slice(&self.grounded);
        for ((body, origin), group) in system.bodies.iter().zip(&state.origins).zip(&self.groups) {
            let reach = &mut self.reaches[*group];
            *reach = reach.max(origin.amax() + body.length);
        }
        for (angle, group) in state.angles.iter().zip(&self.of_angles) {
            if let Some(group) = group {
                let arc = (angle.abs() - TAU) * self.longest[*group];
                self.reaches[*group] = self.reaches[*group].max(arc);
            }
        }
    }

    /// How exactly a body's place is known: smaller changes are rounding.
    pub(super) fn of_body(&self, body: usize) -> f64 {
        (ROUNDING * self.reaches[self.groups[body]]).max(f64::MIN_POSITIVE)
    }

    /// How exactly the coarsest place is known.
    pub(super) fn coarsest(&self) -> f64 {
        ROUNDING * self.reach()
    }

    /// How far from the world's origin places are.
    pub(super) fn reach(&self) -> f64 {
        self.reaches.iter().copied().fold(0.0, f64::max)
    }
}
