//! The iteration matrix: S of every body, and the joints' system.

use nalgebra::{Matrix3, Vector3};

use super::{Blend, Condensed, Touch, side};
use crate::frame::InertiaTangent;
use crate::kinematics::frame_motion::Six;
use crate::kinematics::rotation_vector::right_jacobian_inverse;
use crate::system::body_factor::BodyMatrix;
use crate::system::evaluation::Evaluation;
use crate::system::marker::turned_back;
use crate::system::{Demand, State, System};

/// A spring without stiffness counts as this many times softer than the bodies that it joins.
const NO_STIFFNESS: f64 = 1e-12;

impl Condensed {
    /// S of one body.
    pub(super) fn blend_body(
        &mut self,
        system: &System,
        state: &State,
        evaluation: &Evaluation,
        index: usize,
        blend: &Blend,
        turn: &Vector3<f64>,
    ) {
        let body = &system.bodies[index];
        let pose = &evaluation.poses[index];
        let (at, acceleration) = system.body_motion(state, pose, index);
        let (tangent, matrix) = (&mut self.tangents[index], &mut self.matrices[index]);
        body.flexible.inertia.evaluate_tangent(
            &at,
            &acceleration,
            &evaluation.inertia[index],
            tangent,
        );
        let force = &evaluation.inertia_forces[index].force_body;
        keep_rows_in_world(tangent, force);
        // Rates follow a turn δφ of the frame as T⁻¹ δφ.
        let follow = right_jacobian_inverse(turn);
        let rigid = tangent.mass.rigid * blend.mass + tangent.damping.rigid * blend.damping;
        matrix.rigid = rigid;
        let turning = rigid.fixed_columns::<3>(3) * follow;
        matrix.rigid.fixed_columns_mut::<3>(3).copy_from(&turning);
        matrix.rigid += tangent.stiffness.rigid * blend.stiffness;
        for (entry, ((m, c), k)) in matrix.rigid_elastic.iter_mut().zip(
            tangent
                .mass
                .rigid_by_elastic
                .iter()
                .zip(&tangent.damping.rigid_by_elastic)
                .zip(&tangent.stiffness.rigid_by_elastic),
        ) {
            *entry = blend.mass * m + blend.damping * c + blend.stiffness * k;
        }
        blend_elastic_rigid(matrix, tangent, blend, &follow);
        for (i, d) in matrix.elastic.iter_mut().enumerate() {
            let stiffness = body.flexible.stiffness[i];
            let damping = body.flexible.damping_coefficient(i);
            *d = blend.mass
                + blend.damping * damping
                + blend.stiffness * (stiffness + tangent.softening[i]);
        }
        for &marker in &body.markers {
            let axes = &pose.axes;
            let place = &evaluation.places[marker];
            let wrench = turned_back(axes, &evaluation.wrenches[marker]);
            let by_slot = system.markers[marker].forces_by_slot(place, &wrench);
            for (slot, stiffening) in &system.markers[marker].stiffening {
                for (i, d) in matrix.elastic.iter_mut().enumerate() {
                    *d += blend.stiffness * by_slot[*slot] * stiffening[(i, i)];
                }
            }
        }
        // Interface forces as coordinates follow the rows' forces alone.
        matrix.elastic[body.flexible.displacement_count()..].fill(f64::INFINITY);
    }

    /// Λ + diag(c), and its factor. Returns whether it is regular.
    pub(super) fn factor_joints(
        &mut self,
        system: &System,
        state: &State,
        evaluation: &Evaluation,
        blend: &Blend,
    ) -> bool {
        self.rates_follow = blend.damping;
        let (values, beyond) = self.joints.values_mut();
        values.fill(0.0);
        beyond.fill(0.0);
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
                for (seen, response) in self.responses[..markers].iter_mut().enumerate() {
                    *response = factor.compliance(seen, loaded.local) * self.gradients[column];
                }
                for (row, touch) in own.iter().enumerate() {
                    values[self.places[place]] +=
                        self.gradients[row].dot(&self.responses[touch.local]);
                    place += 1;
                }
            }
        }
        for (index, row) in system.rows.iter().enumerate() {
            self.compliances[index] = match &row.demand {
                Demand::Hold(_) | Demand::Follow(_) => 0.0,
                Demand::Answer(law) => {
                    let slopes =
                        law.derivatives(evaluation.values[index], evaluation.value_rates[index]);
                    let stiffness = -blend.stiffness * slopes.0 - blend.damping * slopes.1;
                    compliance(stiffness, self.joints.diagonal(index))
                }
                Demand::Actuate(actuator) => {
                    let mobility = self.joints.diagonal(index);
                    self.mobilities[*actuator] = mobility.max(0.0);
                    let slopes = self.met_effort(system, state, evaluation, *actuator).effort;
                    let stiffness =
                        -blend.stiffness * slopes.by_value - blend.damping * slopes.by_rate;
                    compliance(stiffness, mobility)
                }
            };
            self.joints.add_to_diagonal(index, self.compliances[index]);
        }
        self.joints.factor(self.regularization)
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
        let mut add = |entry: f64| {
            values[self.places[*place]] += entry;
            *place += 1;
        };
        for same_row in own.chunk_by(|a, b| a.row == b.row) {
            let mut whole = Six::zeros();
            for touch in same_row {
                let gradient = free_gradient(system, evaluation, index, touch, &matrix.free);
                for entry in gradient.iter() {
                    add(*entry);
                    add(-entry);
                }
                whole += gradient;
            }
            beyond[same_row[0].row] += whole.dot(&(inverse * whole));
        }
        for column in 0..6 {
            for row in 0..6 {
                add(
                    match (matrix.free[row] && matrix.free[column], row == column) {
                        (true, _) => matrix.rigid[(row, column)],
                        (false, true) => 1.0,
                        (false, false) => 0.0,
                    },
                );
            }
        }
    }
}

/// The compliance of a row with this stiffness, where a unit force changes its measure by `mobility`.
fn compliance(stiffness: f64, mobility: f64) -> f64 {
    // A measure that no motion of the system changes: any compliance will do.
    let softest = match mobility.abs() {
        0.0 => 1.0,
        compliance => compliance / NO_STIFFNESS,
    };
    (1.0 / stiffness.max(0.0)).min(softest)
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
fn blend_elastic_rigid(
    matrix: &mut BodyMatrix,
    tangent: &InertiaTangent,
    blend: &Blend,
    follow: &Matrix3<f64>,
) {
    let n = matrix.elastic.len();
    let column = |part: &[f64], k: usize, l: usize| part[k * n + l];
    for l in 0..n {
        let mut row = Six::zeros();
        for k in 0..6 {
            row[k] = blend.mass * column(&tangent.mass.elastic_by_rigid, k, l)
                + blend.damping * column(&tangent.damping.elastic_by_rigid, k, l);
        }
        let turning = follow.tr_mul(&row.fixed_rows::<3>(3));
        for k in 0..6 {
            let following = if k < 3 { row[k] } else { turning[k - 3] };
            matrix.elastic_rigid[k * n + l] =
                following + blend.stiffness * column(&tangent.stiffness.elastic_by_rigid, k, l);
        }
    }
}
