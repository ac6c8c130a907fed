//! The iteration matrix: S of every body, and the joints' system.

use nalgebra::{Matrix3, Vector3};

use super::{Blend, Condensed, Touch, side};
use crate::actuator::Effort;
use crate::frame::InertiaTangent;
use crate::kinematics::frame_motion::{Six, SixOf};
use crate::kinematics::rotation_vector::right_jacobian_inverse;
use crate::system::body_factor::BodyMatrix;
use crate::system::evaluation::Evaluation;
use crate::system::marker::turned_back;
use crate::system::number::{Number, dot, rotated_back};
use crate::system::{Demand, State, System};

/// A spring without stiffness counts as this many times softer than the bodies that it joins.
const NO_STIFFNESS: f64 = 1e-12;

/// Derivatives of every body's inertia forces, by rows in world axes.
pub(super) fn differentiate(
    system: &System,
    state: &State,
    evaluation: &Evaluation,
    tangents: &mut [InertiaTangent],
) {
    for (index, (body, tangent)) in system.bodies.iter().zip(tangents).enumerate() {
        let (at, acceleration) = system.body_motion(state, &evaluation.poses[index], index);
        let terms = &evaluation.inertia[index];
        let inertia = &body.flexible.inertia;
        inertia.evaluate_tangent(&at, &acceleration, terms, tangent);
        let force = &evaluation.inertia_forces[index].force_body;
        keep_rows_in_world(tangent, force);
    }
}

impl<T: Number> Condensed<T> {
    /// S of one body.
    pub(super) fn blend_body(
        &mut self,
        system: &System,
        evaluation: &Evaluation,
        (index, tangent): (usize, &InertiaTangent),
        blend: &Blend<T>,
        turn: &Vector3<f64>,
    ) {
        let body = &system.bodies[index];
        let pose = &evaluation.poses[index];
        let matrix = &mut self.matrices[index];
        // Rates follow a turn δφ of the frame as T⁻¹ δφ.
        let follow = right_jacobian_inverse(turn);
        let mass = tangent.mass.rigid.map(|m| blend.mass.times(m));
        let rigid = mass + tangent.damping.rigid.map(|c| blend.damping.times(c));
        matrix.rigid = rigid;
        let turning = rigid.fixed_columns::<3>(3) * follow.map(T::of);
        matrix.rigid.fixed_columns_mut::<3>(3).copy_from(&turning);
        let stiffness = tangent.stiffness.rigid * blend.stiffness;
        matrix.rigid += stiffness.map(T::of);
        for (entry, ((m, c), k)) in matrix.rigid_elastic.iter_mut().zip(
            tangent
                .mass
                .rigid_by_elastic
                .iter()
                .zip(&tangent.damping.rigid_by_elastic)
                .zip(&tangent.stiffness.rigid_by_elastic),
        ) {
            *entry = blend.mass.times(*m) + blend.damping.times(*c) + T::of(blend.stiffness * k);
        }
        blend_elastic_rigid(matrix, tangent, blend, &follow);
        for (i, d) in matrix.elastic.iter_mut().enumerate() {
            let stiffness = body.flexible.stiffness[i];
            let damping = body.flexible.damping_coefficient(i);
            *d = blend.mass
                + blend.damping.times(damping)
                + T::of(blend.stiffness * (stiffness + tangent.softening[i]));
        }
        for &marker in &body.markers {
            let axes = &pose.axes;
            let place = &evaluation.places[marker];
            let wrench = turned_back(axes, &evaluation.wrenches[marker]);
            let by_slot = system.markers[marker].forces_by_slot(place, &wrench);
            for (slot, stiffening) in &system.markers[marker].stiffening {
                for (i, d) in matrix.elastic.iter_mut().enumerate() {
                    *d += T::of(blend.stiffness * by_slot[*slot] * stiffening[(i, i)]);
                }
            }
        }
        // Interface forces as coordinates follow the rows' forces alone.
        matrix.elastic[body.flexible.displacement_count()..].fill(T::of(f64::INFINITY));
    }

    /// Λ.
    pub(super) fn assemble_joints(
        &mut self,
        system: &System,
        evaluation: &Evaluation,
        blend: &Blend<T>,
    ) {
        self.rates_follow = blend.damping;
        let (values, beyond) = self.joints.values_mut();
        values.fill(T::of(0.0));
        beyond.fill(T::of(0.0));
        let mut place = 0;
        for index in 0..self.touches.len() {
            if self.motions[index].is_some() {
                self.keep_body(system, evaluation, index, &mut place);
                continue;
            }
            let own = &self.touches[index];
            let (values, _) = self.joints.values_mut();
            let axes = &evaluation.poses[index].axes;
            for (touch, gradient) in own.iter().zip(&mut self.gradients) {
                *gradient = turned_back(axes, side(evaluation, touch));
            }
            let factor = &self.factors[index];
            let markers = system.bodies[index].markers.len();
            for (column, loaded) in own.iter().enumerate() {
                let gradient = self.gradients[column].map(T::of);
                for (seen, response) in self.responses[..markers].iter_mut().enumerate() {
                    *response = factor.compliance(seen, loaded.local) * gradient;
                }
                for (row, touch) in own.iter().enumerate() {
                    values[self.places[place]] +=
                        dot(&self.gradients[row], &self.responses[touch.local]);
                    place += 1;
                }
            }
        }
    }

    /// c by the slopes of springs at the evaluation and of these efforts of the actuators, added to Λ.
    pub(super) fn follow_slopes(
        &mut self,
        system: &System,
        evaluation: &Evaluation,
        efforts: &[Effort],
        blend: &Blend<T>,
    ) {
        for (index, row) in system.rows.iter().enumerate() {
            let slopes = match &row.demand {
                Demand::Hold(_) | Demand::Follow(_) => {
                    self.comply(index, T::of(0.0));
                    continue;
                }
                Demand::Answer(law) => {
                    law.derivatives(evaluation.values[index], evaluation.value_rates[index])
                }
                Demand::Actuate(actuator) => {
                    let effort = &efforts[*actuator];
                    (effort.by_value, effort.by_rate)
                }
            };
            let stiffness = T::of(-blend.stiffness * slopes.0) - blend.damping.times(slopes.1);
            let compliance = compliance(stiffness, self.joints.diagonal(index).modulus());
            self.comply(index, compliance);
        }
    }

    fn comply(&mut self, row: usize, compliance: T) {
        self.compliances[row] = compliance;
        self.joints.add_to_diagonal(row, compliance);
    }

    /// The entries of a body whose motions are unknowns of the joints' system, and what it adds to Λ_ii.
    fn keep_body(
        &mut self,
        system: &System,
        evaluation: &Evaluation,
        index: usize,
        place: &mut usize,
    ) {
        let own = &self.touches[index];
        let matrix = &self.matrices[index];
        let inverse = self.factors[index].rigid_inverse();
        let (values, beyond) = self.joints.values_mut();
        let mut add = |entry: T| {
            values[self.places[*place]] += entry;
            *place += 1;
        };
        for same_row in own.chunk_by(|a, b| a.row == b.row) {
            let mut whole = Six::zeros();
            for touch in same_row {
                let gradient = free_gradient(system, evaluation, index, touch, &matrix.free);
                for entry in gradient.iter() {
                    add(T::of(*entry));
                    add(T::of(-entry));
                }
                whole += gradient;
            }
            beyond[same_row[0].row] += dot(&whole, &(inverse * whole.map(T::of)));
        }
        for column in 0..6 {
            for row in 0..6 {
                add(
                    match (matrix.free[row] && matrix.free[column], row == column) {
                        (true, _) => matrix.rigid[(row, column)],
                        (false, true) => T::of(1.0),
                        (false, false) => T::of(0.0),
                    },
                );
            }
        }
    }
}

impl Condensed {
    /// c of a real factor, added to Λ: efforts that bend by their slope where they are met.
    pub(super) fn meet_efforts(
        &mut self,
        system: &System,
        state: &State,
        evaluation: &Evaluation,
        blend: &Blend,
    ) {
        let mut efforts = std::mem::take(&mut self.efforts);
        for (index, (actuator, effort)) in system.actuators.iter().zip(&mut efforts).enumerate() {
            self.mobilities[index] = self.joints.diagonal(actuator.row).max(0.0);
            *effort = self.met_effort(system, state, evaluation, index).effort;
        }
        self.follow_slopes(system, evaluation, &efforts, blend);
        self.efforts = efforts;
    }
}

/// The compliance of a row with this stiffness, where a unit force changes its measure by `mobility`.
fn compliance<T: Number>(stiffness: T, mobility: f64) -> T {
    // A measure that no motion of the system changes: any compliance will do.
    let softest = match mobility.abs() {
        0.0 => 1.0,
        compliance => compliance / NO_STIFFNESS,
    };
    // What pushes away instead of back is left to the iteration.
    let is_soft = stiffness.real() <= 0.0 || stiffness.modulus() * softest < 1.0;
    match is_soft {
        true => T::of(softest),
        false => T::of(1.0) / stiffness,
    }
}

/// The force on a body's rigid motions by a unit force of a touch, zero for motions that it hasn't.
pub(super) fn free_gradient(
    system: &System,
    evaluation: &Evaluation,
    body: usize,
    touch: &Touch,
    free: &[bool; 6],
) -> Six {
    let marker = touch.marker(system);
    let wrench = turned_back(&evaluation.poses[body].axes, side(evaluation, touch));
    let mut gradient = Six::zeros();
    system.markers[marker].add_force(
        &evaluation.places[marker],
        &wrench,
        1.0,
        &mut gradient,
        &mut [],
    );
    for (entry, _) in gradient.iter_mut().zip(free).filter(|(_, free)| !**free) {
        *entry = 0.0;
    }
    gradient
}

/// Rows of forces stay in world axes while the frame turns: `Aᵀ δF = δ(Aᵀ F) - Aᵀ F × δφ`.
pub(in crate::system) fn keep_rows_in_world(
    tangent: &mut InertiaTangent,
    force_body: &Vector3<f64>,
) {
    let mut block = tangent.stiffness.rigid.fixed_view_mut::<3, 3>(0, 3);
    block -= force_body.cross_matrix();
}

/// S_yr with the rotation's columns following the turn.
fn blend_elastic_rigid<T: Number>(
    matrix: &mut BodyMatrix<T>,
    tangent: &InertiaTangent,
    blend: &Blend<T>,
    follow: &Matrix3<f64>,
) {
    let n = matrix.elastic.len();
    let column = |part: &[f64], k: usize, l: usize| part[k * n + l];
    for l in 0..n {
        let mut row = SixOf::<T>::zeros();
        for k in 0..6 {
            row[k] = blend
                .mass
                .times(column(&tangent.mass.elastic_by_rigid, k, l))
                + blend
                    .damping
                    .times(column(&tangent.damping.elastic_by_rigid, k, l));
        }
        let turning = rotated_back(follow, &row.fixed_rows::<3>(3).into_owned());
        for k in 0..6 {
            let following = if k < 3 { row[k] } else { turning[k - 3] };
            let stiffness = column(&tangent.stiffness.elastic_by_rigid, k, l);
            matrix.elastic_rigid[k * n + l] = following + T::of(blend.stiffness * stiffness);
        }
    }
}
