//! Λ of the last factorization, column by column.

use super::assemble::free_gradient;
use super::{Condensed, side};
use crate::kinematics::frame_motion::Six;
use crate::system::System;
use crate::system::evaluation::Evaluation;
use crate::system::marker::turned_back;

/// Λ by columns: the entries of one are found from the bodies that its row touches.
pub struct ComplianceColumns<'a> {
    condensed: &'a Condensed,
    /// Gradients of the touches in body axes, body by body: on the rigid motions where those are unknowns of the joints' system, else at
    /// the markers.
    gradients: Vec<Vec<Six>>,
    /// Body and touch by rows.
    of_rows: Vec<Vec<(usize, usize)>>,
}

impl Condensed {
    /// Λ of the last factorization, without the compliance of springs.
    pub fn compliance_columns(
        &self,
        system: &System,
        evaluation: &Evaluation,
    ) -> ComplianceColumns<'_> {
        let mut of_rows = vec![Vec::new(); system.rows.len()];
        let mut gradients = Vec::with_capacity(self.touches.len());
        for (body, own) in self.touches.iter().enumerate() {
            let free = &self.matrices[body].free;
            let gradient = |touch| match self.motions[body] {
                Some(_) => free_gradient(system, evaluation, body, touch, free),
                None => turned_back(&evaluation.poses[body].axes, side(evaluation, touch)),
            };
            gradients.push(own.iter().map(gradient).collect());
            for (position, touch) in own.iter().enumerate() {
                of_rows[touch.row].push((body, position));
            }
        }
        ComplianceColumns {
            condensed: self,
            gradients,
            of_rows,
        }
    }
}

impl ComplianceColumns<'_> {
    /// The entry of a row on the diagonal.
    pub fn diagonal(&self, row: usize) -> f64 {
        let mut sum = 0.0;
        for &(body, column) in &self.of_rows[row] {
            let touches = self.of_rows[row].iter().filter(|(other, _)| *other == body);
            for (_, seen) in touches {
                sum += self.entry(body, *seen, column);
            }
        }
        sum
    }

    /// The entries of a column, each with its row; a row may come more than once.
    pub fn for_each(&self, column: usize, mut see: impl FnMut(usize, f64)) {
        for &(body, loaded) in &self.of_rows[column] {
            for (seen, touch) in self.condensed.touches[body].iter().enumerate() {
                see(touch.row, self.entry(body, seen, loaded));
            }
        }
    }

    fn entry(&self, body: usize, seen: usize, loaded: usize) -> f64 {
        let factor = &self.condensed.factors[body];
        let own = &self.condensed.touches[body];
        let compliance = match self.condensed.motions[body] {
            Some(_) => factor.rigid_inverse(),
            None => factor.compliance(own[seen].local, own[loaded].local),
        };
        let gradients = &self.gradients[body];
        gradients[seen].dot(&(compliance * gradients[loaded]))
    }
}
