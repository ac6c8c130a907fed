//! Interfaces that follow their forces within a solve.

use super::Condensed;
use crate::body::Compatibility;
use crate::system::evaluation::Evaluation;
use crate::system::marker::turned_back;
use crate::system::number::Number;
use crate::system::residual::add_product;
use crate::system::{State, System};

impl Condensed {
    /// How far interfaces are from where their forces at the evaluation put them.
    pub(super) fn find_gaps(&mut self, system: &System, state: &State, evaluation: &Evaluation) {
        for (index, body) in system.bodies.iter().enumerate() {
            let rows = body.residual_rows.clone();
            if rows.is_empty() {
                continue;
            }
            let forces = &mut self.force_gaps[rows.clone()];
            forces.copy_from_slice(&evaluation.residual_forces[rows.clone()]);
            let gaps = &mut self.gaps[rows.clone()];
            match body.flexible.compatibility {
                Compatibility::Strong | Compatibility::Static => {
                    for (gap, x) in gaps.iter_mut().zip(&state.residual_displacements[rows]) {
                        *gap = -x;
                    }
                }
                Compatibility::Weak => {
                    let own = &state.coordinates[body.coordinates.clone()];
                    let own = &own[body.flexible.displacement_count()..];
                    for (gap, g) in forces.iter_mut().zip(own) {
                        *gap -= g;
                    }
                    gaps.fill(0.0);
                }
            }
            add_product(self.residual_compliances[index].as_ref(), forces, gaps);
        }
    }
}

impl<T: Number> Condensed<T> {
    /// Interface forces and displacements that follow from the wrenches of the last solve.
    pub(super) fn follow_forces(&mut self, system: &System, evaluation: &Evaluation) {
        for (index, body) in system.bodies.iter().enumerate() {
            let rows = body.residual_rows.clone();
            if rows.is_empty() {
                continue;
            }
            let forces = &mut self.interface_step[rows.clone()];
            forces.fill(T::of(0.0));
            for &marker in body.markers.iter().filter(|m| self.coupled[**m]) {
                let wrench = turned_back(&evaluation.poses[index].axes, &self.wrenches[marker]);
                let place = &evaluation.places[marker];
                system.markers[marker].add_interface_forces(place, &wrench, forces);
            }
            match body.flexible.compatibility {
                Compatibility::Strong | Compatibility::Static => {
                    let step = &mut self.residual_step[rows.clone()];
                    step.copy_from_slice(&self.gaps[rows]);
                    add_product(self.residual_compliances[index].as_ref(), forces, step);
                }
                Compatibility::Weak => {
                    let own = &mut self.step[body.velocities.clone()][6..];
                    let own = &mut own[body.flexible.displacement_count()..];
                    for (step, (change, gap)) in own
                        .iter_mut()
                        .zip(forces.iter().zip(&self.force_gaps[rows]))
                    {
                        *step = *change + *gap;
                    }
                }
            }
        }
    }
}
