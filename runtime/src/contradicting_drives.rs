//! Drives that ask together for what the joints don't allow.
//!
//! Of rigid bodies the rows of joints and drives over the bodies' motions say it: drives are surplus where their rows depend on the others.
//! Flexible bodies give way to such drives, and a run goes on with deflections that mean nothing.

use faer::Mat;

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
        let wrenches = rigid_rows(system, &evaluation, &constraints);
        let dependent = |left_out: Option<usize>| {
            let kept: Vec<usize> = (0..constraints.len())
                .filter(|at| Some(constraints[*at]) != left_out)
                .collect();
            let rows = Mat::from_fn(kept.len(), wrenches.ncols(), |i, j| wrenches[(kept[i], j)]);
            dependent_rows(&rows * rows.transpose()).len()
        };
        let all = dependent(None);
        Self {
            rows: match all {
                0 => Vec::new(),
                _ => drives
                    .into_iter()
                    .filter(|row| dependent(Some(*row)) < all)
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

/// Forces and moments about the world's origin on each body by a unit force of each row, (rows, 6 bodies); moments by a length.
fn rigid_rows(system: &System, evaluation: &Evaluation, rows: &[usize]) -> Mat<f64> {
    let length = system.bodies.iter().map(|b| b.length).fold(0.0, f64::max);
    let mut all = Mat::zeros(rows.len(), 6 * system.bodies.len());
    for (at, row) in rows.iter().enumerate() {
        for index in system.rows[*row].terms.clone() {
            let (term, gradient) = (&system.terms[index], &evaluation.gradients[index]);
            for (marker, side) in [(term.a, &gradient.a), (term.b, &gradient.b)] {
                let Some(body) = system.markers[marker].body else {
                    continue;
                };
                let (force, moment) = halves(side);
                let arm = evaluation.motions[marker].position - evaluation.poses[body].origin;
                let moment = (arm.cross(&force) + moment) / length;
                for axis in 0..3 {
                    all[(at, 6 * body + axis)] += force[axis];
                    all[(at, 6 * body + 3 + axis)] += moment[axis];
                }
            }
        }
    }
    all
}
