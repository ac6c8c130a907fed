//! Bodies that don't move, and forces of constraints that do nothing.

use super::Condensed;
use crate::error::Error;
use crate::system::System;

impl Condensed {
    /// Which bodies, by index, don't move in the solves after the next factorization: neither as rigid ones nor by deflecting.
    pub fn hold(&mut self, bodies: &[usize]) {
        self.held.fill(false);
        for body in bodies {
            if let Some(held) = self.held.get_mut(*body) {
                *held = true;
            }
        }
    }

    /// One more for the same system, with the same expectations.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn another(&self, system: &System) -> Result<Self, Error> {
        let mut another = Self::of(system)?;
        if self.expected_redundant > 0 {
            another.expect_redundant(self.expected_redundant, self.regularization);
        }
        Ok(another)
    }

    /// Regularizes the joints' system, of which so many rows are redundant.
    pub fn expect_redundant(&mut self, rows: usize, regularization: f64) {
        self.expected_redundant = rows;
        self.regularization = regularization;
        self.joints.expect_redundant(rows);
    }

    /// Whether the present factor leaves the share of λ alone that does nothing.
    pub fn carries_redundant(&self) -> bool {
        self.joints.knows_redundant()
    }

    /// Forgets which share of λ does nothing.
    pub fn forget_redundant(&mut self) {
        self.joints.forget_redundant();
    }

    /// Takes out of a change of λ what does nothing, as far as the present factor knows it.
    pub fn remove_redundant(&mut self, forces: &mut [f64]) {
        self.joints.remove_redundant(forces);
    }

    /// Takes out of λ what does nothing, where the present factor was made: joints share their forces out in the minimum-norm sense.
    /// Overwrites the last solve's `force_step`.
    pub fn share_redundant(&mut self, forces: &mut [f64]) {
        self.joints.share_redundant(forces, &mut self.force_step);
    }

    /// How much the joints' system enlarges what it solves for: large where constraints nearly depend on each other. Overwrites the last solve's
    /// `force_step`.
    pub fn amplification(&mut self) -> f64 {
        self.joints.amplification(&mut self.force_step)
    }

    /// About the largest force that a unit of change in all rows takes with the last factor.
    pub fn largest_force(&mut self) -> f64 {
        self.joints.largest_force(&mut self.force_step)
    }
}
