//! Solutions with the factored iteration matrix.

use nalgebra::Vector3;

use super::touch::side;
use super::{Condensed, Interfaces};
use crate::kinematics::frame_motion::SixOf;
use crate::system::evaluation::Evaluation;
use crate::system::marker::{turned, turned_back};
use crate::system::number::{Number, dot};
use crate::system::{State, System};

impl Condensed {
    /// Adds the last solve to velocities or accelerations, whose linear parts are in world axes.
    pub fn add_step(&self, system: &System, evaluation: &Evaluation, rates: &mut [f64]) {
        for (index, body) in system.bodies.iter().enumerate() {
            let step = &self.step[body.velocities.clone()];
            let linear = evaluation.poses[index].axes * Vector3::from_column_slice(&step[..3]);
            let rates = &mut rates[body.velocities.clone()];
            for (k, rate) in rates.iter_mut().enumerate() {
                *rate += if k < 3 { linear[k] } else { step[k] };
            }
        }
    }

    /// Solves `S δq - Bᵀ δλ = -residual, B δq + c δλ = changes`: `step` and `force_step`. Where interfaces follow their
    /// forces, also `residual_step`, with what the evaluation's interface forces and displacements still differ by.
    pub fn solve(
        &mut self,
        system: &System,
        state: &State,
        evaluation: &Evaluation,
        changes: &[f64],
        residual: &[f64],
    ) {
        if self.interfaces == Interfaces::Following {
            self.find_gaps(system, state, evaluation);
        }
        self.solve_rows(system, evaluation, changes, residual, self.interfaces);
        match self.interfaces {
            Interfaces::Following => self.follow_forces(system, evaluation),
            Interfaces::Held => self.residual_step.fill(0.0),
        }
        if !self.controls.rows.is_empty() {
            self.follow_controls(system, evaluation);
        }
    }
}

impl<T: Number> Condensed<T> {
    /// The response to changes of the rows alone, efforts of controllers taken as given.
    pub(super) fn respond(
        &mut self,
        system: &System,
        evaluation: &Evaluation,
        changes: &[T],
        zeros: &[T],
    ) {
        self.gaps.fill(T::of(0.0));
        self.force_gaps.fill(T::of(0.0));
        self.solve_rows(system, evaluation, changes, zeros, self.interfaces);
        match self.interfaces {
            Interfaces::Following => self.follow_forces(system, evaluation),
            Interfaces::Held => self.residual_step.fill(T::of(0.0)),
        }
    }

    /// The same where interfaces don't move beside the coordinates.
    pub fn solve_held(
        &mut self,
        system: &System,
        evaluation: &Evaluation,
        changes: &[T],
        residual: &[T],
    ) {
        self.solve_rows(system, evaluation, changes, residual, Interfaces::Held);
        if !self.controls.rows.is_empty() {
            self.follow_controls(system, evaluation);
        }
    }

    /// What the rows lack as changes of their measures: that of constraints times `of_position`, by which the measure belongs to what is
    /// lacking, with its sign turned; that of springs, a force, by their compliance.
    pub fn scale_defects(&self, system: &System, defects: &mut [T], of_position: T) {
        for (index, (row, defect)) in system.rows.iter().zip(defects).enumerate() {
            *defect = match row.is_constraint() {
                true => -*defect * of_position,
                false => *defect * self.compliances[index],
            };
        }
    }

    /// The same where δλ are no forces but corrections of the positions: interfaces stay.
    pub fn solve_positions(
        &mut self,
        system: &System,
        evaluation: &Evaluation,
        changes: &[T],
        residual: &[T],
    ) {
        self.solve_rows(system, evaluation, changes, residual, Interfaces::Held);
    }

    fn solve_rows(
        &mut self,
        system: &System,
        evaluation: &Evaluation,
        changes: &[T],
        residual: &[T],
        interfaces: Interfaces,
    ) {
        // t = S⁻¹ r, and how it moves the markers.
        self.step.copy_from_slice(residual);
        for (index, body) in system.bodies.iter().enumerate() {
            let (rigid, elastic) = self.step[body.velocities.clone()].split_at_mut(6);
            let mut six = SixOf::from_column_slice(rigid);
            self.factors[index].solve(&mut six, elastic);
            rigid.copy_from_slice(six.as_slice());
            let gaps = match interfaces {
                Interfaces::Following => body.residual_rows.clone(),
                Interfaces::Held => 0..0,
            };
            for &marker in body.markers.iter().filter(|m| self.coupled[**m]) {
                let place = &evaluation.places[marker];
                let mut twist = system.markers[marker].twist(place, &six, elastic);
                if !gaps.is_empty() {
                    let gaps = &self.gaps[gaps.clone()];
                    twist -= system.markers[marker].interface_twist(place, gaps);
                }
                self.twists[marker] = turned(&evaluation.poses[index].axes, &twist);
            }
        }
        // (Λ + c) δλ = B t + changes
        self.force_step.copy_from_slice(changes);
        for own in &self.touches {
            for touch in own {
                let marker = touch.marker(system);
                self.force_step[touch.row] += dot(side(evaluation, touch), &self.twists[marker]);
            }
        }
        self.joints.solve(&mut self.force_step);
        // δq = S⁻¹ Bᵀ δλ - t
        self.wrenches.fill(SixOf::zeros());
        for own in &self.touches {
            for touch in own {
                let marker = touch.marker(system);
                let force = self.force_step[touch.row];
                self.wrenches[marker] += side(evaluation, touch).map(|entry| force.times(entry));
            }
        }
        for (index, body) in system.bodies.iter().enumerate() {
            let step = &mut self.step[body.velocities.clone()];
            for entry in step.iter_mut() {
                *entry = -*entry;
            }
            let (rigid, elastic) = step.split_at_mut(6);
            let mut six = SixOf::from_column_slice(rigid);
            for (local, marker) in body.markers.iter().enumerate() {
                if self.coupled[*marker] {
                    let wrench =
                        turned_back(&evaluation.poses[index].axes, &self.wrenches[*marker]);
                    self.factors[index].add_response(local, &wrench, &mut six, elastic);
                }
            }
            rigid.copy_from_slice(six.as_slice());
        }
    }
}
