//! Interfaces that interface forces displace beside the coordinates.
//!
//! With g the forces of rows and loads on the interface rows of a body, the displacement of its interfaces is
//!
//! ```text
//! static   u_Γ = L_b Φ η + x,             x = F g                      (and strong, for directions of F_res without mass)
//! weak     u_Γ = L_b Φ η + F_res g - e_g,   g = B_Γᵀ λ a coordinate, e_g its inertia: M_res g'' and the frame's part
//! ```
//! x is part of the state and follows λ within an iteration. Rates of x come from its history by the formulas of the
//! integrator; those of e_g aren't known and are left out of the markers' velocities.
//!
//! For a change δλ at fixed coordinates, `δu_Γ = C δg` with C = F (static) or F_res - β' M_res (weak): g and u_Γ are gone
//! before the joints' system is made, which has C beside the responses of the bodies.

use faer::{Mat, MatRef};
use nalgebra::Matrix6;

use super::evaluation::Evaluation;
use super::marker::{Marker, MarkerPlace, turned_back};
use super::number::Number;
use super::{Body, State, System};
use crate::body::Compatibility;
use crate::kinematics::frame_motion::Six;

impl Evaluation {
    /// Displacements of a body's markers beside the coordinates.
    pub(super) fn displace_interfaces(&mut self, system: &System, state: &State, index: usize) {
        let body = &system.bodies[index];
        match body.flexible.compatibility {
            Compatibility::Strong | Compatibility::Static => {
                let x = &state.residual_displacements[body.residual_rows.clone()];
                for &marker in &body.markers {
                    self.extras[marker] = system.markers[marker].share(x);
                }
            }
            Compatibility::Weak => {
                let (at, acceleration) = system.body_motion(state, &self.poses[index], index);
                let forces = &mut self.inertia_forces[index];
                let inertia = &body.flexible.inertia;
                inertia.evaluate_forces(&at, &acceleration, &mut self.inertia[index], forces);
                let resisting = &forces.elastic[body.flexible.displacement_count()..];
                for &marker in &body.markers {
                    self.extras[marker] = -system.markers[marker].share(resisting);
                }
            }
        }
    }

    /// Displacement and turn, beside those of the coordinates, of any frame on a body's interfaces, body axes: at the state that was
    /// evaluated last.
    pub fn extra(&self, system: &System, state: &State, marker: &Marker) -> Six {
        let Some(index) = marker.body else {
            return Six::zeros();
        };
        let body = &system.bodies[index];
        if body.residual_rows.is_empty() {
            return Six::zeros();
        }
        match body.flexible.compatibility {
            Compatibility::Strong | Compatibility::Static => {
                marker.share(&state.residual_displacements[body.residual_rows.clone()])
            }
            Compatibility::Weak => {
                let forces = &self.inertia_forces[index].elastic;
                -marker.share(&forces[body.flexible.displacement_count()..])
            }
        }
    }

    /// Rates of the same.
    pub(super) fn carry_interfaces(&mut self, system: &System, state: &State, index: usize) {
        let rows = system.bodies[index].residual_rows.clone();
        for &marker in &system.bodies[index].markers {
            let place = &mut self.places[marker];
            let share = |values: &[f64]| system.markers[marker].share(&values[rows.clone()]);
            place.extra_rate = share(&state.residual_rates);
            place.extra_acceleration = share(&state.residual_accelerations);
        }
    }

    /// g of one body from the wrenches at its markers.
    pub(super) fn gather_interface_forces(&mut self, system: &System, index: usize) {
        let rows = system.bodies[index].residual_rows.clone();
        let mut forces = std::mem::take(&mut self.residual_forces);
        self.write_interface_forces(system, index, &mut forces[rows]);
        self.residual_forces = forces;
    }

    /// g of a body: forces and moments of rows and loads on its interface rows, body axes, acting on the body; one entry for
    /// each row of [`crate::FlexibleBody::rows`]. After [`Evaluation::load`], for any compatibility.
    pub fn write_interface_forces(&self, system: &System, index: usize, forces: &mut [f64]) {
        forces.fill(0.0);
        for &marker in &system.bodies[index].markers {
            let wrench = turned_back(&self.poses[index].axes, &self.wrenches[marker]);
            system.markers[marker].add_interface_forces(&self.places[marker], &wrench, forces);
        }
    }
}

/// `E_k C_kl E_lᵀ` with E = diag(I, J_l): twist at one marker for a wrench at another, beside the coordinates.
pub(super) fn marker_compliance<T: Number>(
    compliance: MatRef<'_, T>,
    (seen, seen_place): (&[Option<usize>; 6], &MarkerPlace),
    (loaded, loaded_place): (&[Option<usize>; 6], &MarkerPlace),
) -> Matrix6<T> {
    let mut block = Matrix6::from_fn(|i, j| match (seen[i], loaded[j]) {
        (Some(row), Some(column)) => compliance[(row, column)],
        _ => T::of(0.0),
    });
    let turning = seen_place.turn_jacobian.map(T::of) * block.fixed_rows::<3>(3);
    block.fixed_rows_mut::<3>(3).copy_from(&turning);
    let turning = block.fixed_columns::<3>(3) * loaded_place.turn_jacobian.transpose().map(T::of);
    block.fixed_columns_mut::<3>(3).copy_from(&turning);
    block
}

/// C of a body whose stiffness counts `stiffness` times and whose mass `mass` times.
pub(super) fn write_compliance<T: Number>(
    body: &Body,
    mass: T,
    stiffness: f64,
    compliance: &mut Mat<T>,
) {
    if let Some(flexibility) = &body.flexible.residual_flexibility {
        for (column, of_body) in compliance.col_iter_mut().zip(flexibility.col_iter()) {
            for (entry, f) in column.iter_mut().zip(of_body.iter()) {
                *entry = T::of(f / stiffness);
            }
        }
    }
    if let Some(of_body) = &body.flexible.residual_mass {
        for (column, of_body) in compliance.col_iter_mut().zip(of_body.col_iter()) {
            for (entry, m) in column.iter_mut().zip(of_body.iter()) {
                *entry -= mass.times(*m);
            }
        }
    }
}

/// `out += matrix x`
pub(crate) fn add_product<T: Number>(matrix: MatRef<'_, T>, x: &[T], out: &mut [T]) {
    for (column, x) in matrix.col_iter().zip(x) {
        for (out, entry) in out.iter_mut().zip(column.iter()) {
            *out += *x * *entry;
        }
    }
}

/// How the rows of the system act on the interface rows of one body: column k is g for a unit λ of row k, (n_b, rows).
pub fn row_forces(system: &System, evaluation: &Evaluation, index: usize) -> Mat<f64> {
    let body = &system.bodies[index];
    let axes = &evaluation.poses[index].axes;
    let count = body.flexible.rows.len();
    let mut of_rows = vec![0.0; count * system.rows.len()];
    for (column, row) in system.rows.iter().enumerate() {
        for term in row.terms.clone() {
            let gradient = &evaluation.gradients[term];
            for (marker, side) in [
                (system.terms[term].a, &gradient.a),
                (system.terms[term].b, &gradient.b),
            ] {
                if system.markers[marker].body == Some(index) {
                    let place = &evaluation.places[marker];
                    let of_row = &mut of_rows[column * count..(column + 1) * count];
                    system.markers[marker].add_interface_forces(
                        place,
                        &turned_back(axes, side),
                        of_row,
                    );
                }
            }
        }
    }
    Mat::from_fn(count, system.rows.len(), |i, j| of_rows[j * count + i])
}

/// `Σ Bᵀ F B` over the bodies that interface forces deflect: what the rows' measures change by unit λ beside the coordinates,
/// (rows, rows); `None` where no body does.
pub fn row_flexibility(system: &System, evaluation: &Evaluation) -> Option<Mat<f64>> {
    let mut sum: Option<Mat<f64>> = None;
    for (index, body) in system.bodies.iter().enumerate() {
        if let Some(flexibility) = &body.flexible.residual_flexibility {
            let forces = row_forces(system, evaluation, index);
            let count = system.rows.len();
            let sum = sum.get_or_insert_with(|| Mat::zeros(count, count));
            *sum += forces.transpose() * (flexibility * &forces);
        }
    }
    sum
}
