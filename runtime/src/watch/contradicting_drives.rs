//! Drives that ask together for what the joints don't allow.
//!
//! Of rigid bodies the rows of joints and drives over the bodies' motions say it: drives are surplus where their rows depend on the others.
//! Flexible bodies give way to such drives, and a run goes on with deflections that mean nothing.

use std::collections::BTreeMap;

use crate::initial::dependent_rows;
use crate::system::evaluation::Evaluation;
use crate::system::marker::halves;
use crate::system::{Demand, State, System};

/// Drives of a system that are surplus where it starts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ContradictingDrives {
    /// Rows of drives of which each depends on the rest.
    rows: Vec<usize>,
}

impl ContradictingDrives {
    /// At a state: drives that depend on joints and other drives, if there are several. At a dead centre a drive can be among them that
    /// isn't elsewhere.
    pub fn at(system: &System, state: &State) -> Self {
        let constraints = system.constraints();
        let is_drive = |row: &usize| matches!(system.rows[*row].demand, Demand::Follow(_));
        let drives: Vec<usize> = constraints.iter().copied().filter(is_drive).collect();
        if drives.len() < 2 {
            return Self::default();
        }
        let mut evaluation = Evaluation::of(system);
        evaluation.place(system, state);
        evaluation.measure(system, state);
        let wrenches = RigidRows::of(system, &evaluation, &constraints);
        let position = |row: usize| constraints.iter().position(|other| *other == row);
        let dependent = |left_out: Option<usize>| wrenches.dependent_count(left_out);
        let all = dependent(None);
        Self {
            rows: match all {
                0 => Vec::new(),
                _ => drives
                    .into_iter()
                    .filter(|row| dependent(position(*row)) < all)
                    .collect(),
            },
        }
    }

    /// Names of those that are surplus in a later state, if some are at the start: large deflections hide constraints that repeat each other.
    pub fn names_at(&self, system: &System, state: &State) -> Vec<String> {
        if self.rows.is_empty() {
            return Vec::new();
        }
        let now = Self::at(system, state);
        let surplus = now.rows.iter();
        surplus
            .map(|row| {
                system.connections[system.rows[*row].connection]
                    .name
                    .clone()
            })
            .collect()
    }
}

/// Forces and moments about the bodies' origins by a unit force of each row; moments by a length. Most entries are zero.
struct RigidRows {
    /// Of each row, by coordinate: 6 a body.
    rows: Vec<BTreeMap<usize, f64>>,
    /// Of each coordinate, by row.
    columns: Vec<Vec<(usize, f64)>>,
}

impl RigidRows {
    fn of(system: &System, evaluation: &Evaluation, constraints: &[usize]) -> Self {
        let length = system.bodies.iter().map(|b| b.length).fold(0.0, f64::max);
        let mut rows = vec![BTreeMap::new(); constraints.len()];
        for (entries, row) in rows.iter_mut().zip(constraints) {
            for index in system.rows[*row].terms.clone() {
                let (term, gradient) = (&system.terms[index], &evaluation.gradients[index]);
                for (marker, side) in [(term.a, &gradient.a), (term.b, &gradient.b)] {
                    let Some(body) = system.markers[marker].body else {
                        continue;
                    };
                    let (force, moment) = halves(side);
                    let arm = evaluation.motions[marker].position - evaluation.poses[body].origin;
                    let moment = (arm.cross(&force) + moment) / length;
                    for (axis, entry) in force.iter().chain(moment.iter()).enumerate() {
                        *entries.entry(6 * body + axis).or_insert(0.0) += entry;
                    }
                }
            }
        }
        let mut columns = vec![Vec::new(); 6 * system.bodies.len()];
        for (row, entries) in rows.iter().enumerate() {
            for (coordinate, entry) in entries {
                columns[*coordinate].push((row, *entry));
            }
        }
        Self { rows, columns }
    }

    /// How many rows depend on the others, with one row left out or none.
    fn dependent_count(&self, left_out: Option<usize>) -> usize {
        let kept: Vec<usize> = (0..self.rows.len())
            .filter(|row| Some(*row) != left_out)
            .collect();
        let index = |row: usize| match left_out {
            Some(gap) if row > gap => row - 1,
            _ => row,
        };
        let diagonal: Vec<f64> = kept
            .iter()
            .map(|row| self.rows[*row].values().map(|entry| entry * entry).sum())
            .collect();
        let dependent = dependent_rows(&diagonal, |chosen, sum| {
            for (coordinate, own) in &self.rows[kept[chosen]] {
                let others = self.columns[*coordinate].iter();
                for (row, entry) in others.filter(|(row, _)| Some(*row) != left_out) {
                    sum.add(index(*row), own * entry);
                }
            }
        });
        dependent.rows.len()
    }
}
