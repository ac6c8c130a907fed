//! One linear solve of a Newton iteration: bodies eliminated one by one, then the joints, then back.
//!
//! ```text
//! S δq - Bᵀ δλ = -r          S = β' M + γ' C + κ K, body by body
//! B δq + c δλ  = -h          c = 0 for constraints, 1/k_t for springs
//!
//! t = S⁻¹ r,   (B S⁻¹ Bᵀ + c) δλ = B t - h,   δq = S⁻¹ Bᵀ δλ - t
//! ```
//! Interface forces that deflect a body beside its coordinates add their flexibility to Λ wherever S has stiffness; see
//! [`super::residual`].
//!
//! δq counts `(Aᵀ δR, δφ, δy)` for each body. Two parts of the exact matrix are left to the iteration: the coupling of a body's
//! coordinates with each other by its spin, and the change of the rows' forces with the configuration. Both are of order h² and
//! the exact matrix is in [`super::linearization`].

use faer::Mat;
use nalgebra::{Matrix3, Vector3};

use super::body_factor::{BodyFactor, BodyMatrix, Elastic};
use super::evaluation::Evaluation;
use super::joint_system::JointSystem;
use super::marker::{turned, turned_back};
use super::residual::{add_product, marker_compliance, write_compliance};
use super::{Demand, State, System};
use crate::body::Compatibility;
use crate::error::Error;
use crate::frame::InertiaTangent;
use crate::motion::Six;
use crate::rotation::right_jacobian_inverse;

/// A spring without stiffness counts as this many times softer than the bodies that it joins.
const NO_STIFFNESS: f64 = 1e-12;

/// How much of mass, damping and stiffness is in S.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blend {
    /// β', of the mass.
    pub mass: f64,
    /// γ', of the damping.
    pub damping: f64,
    /// κ, of the stiffness.
    pub stiffness: f64,
    /// Whether y moves.
    pub elastic: Elastic,
}

/// The side of a term on a body.
#[derive(Clone, Copy, Debug)]
struct Touch {
    row: usize,
    term: usize,
    side: Side,
    /// Marker, counted among the body's own.
    local: usize,
}

#[derive(Clone, Copy, Debug)]
enum Side {
    A,
    B,
}

/// The factored iteration matrix of a system.
pub struct Condensed {
    matrices: Vec<BodyMatrix>,
    tangents: Vec<InertiaTangent>,
    factors: Vec<BodyFactor>,
    joints: JointSystem,
    touches: Vec<Vec<Touch>>,
    /// Place of each pair of touches among the joints' values, body by body.
    places: Vec<usize>,
    /// Gradients of a body's touches in body axes, and the body's response to them by markers.
    gradients: Vec<Six>,
    responses: Vec<Six>,
    /// c of each row.
    compliances: Vec<f64>,
    wrenches: Vec<Six>,
    twists: Vec<Six>,
    /// Markers that rows touch.
    coupled: Vec<bool>,
    /// C of each body, over its interface rows; (0, 0) for bodies without.
    residual_compliances: Vec<Mat<f64>>,
    /// Whether interfaces follow their forces in the solves with the present factor.
    interfaces: Interfaces,
    /// Rows that touch a body whose interfaces are deflected by their forces.
    compliant: Vec<bool>,
    /// What interface forces, and interface displacements for the forces that are known, still differ by; by residual rows.
    force_gaps: Vec<f64>,
    gaps: Vec<f64>,
    /// δg of the last solve, by residual rows.
    interface_step: Vec<f64>,
    /// Bodies that don't move.
    held: Vec<bool>,
    /// Added to the unit diagonal of the joints' system where constraints are redundant.
    pub regularization: f64,
    /// δq of the last solve, laid out as velocities, rigid parts in body axes.
    pub step: Vec<f64>,
    /// δλ of the last solve.
    pub force_step: Vec<f64>,
    /// Change of the displacements beside the coordinates in the last solve, by residual rows. Zero for bodies whose interface
    /// forces are coordinates; their change is in `step`.
    pub residual_step: Vec<f64>,
}

/// Whether the displacements of interfaces beside the coordinates follow the forces in a solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Interfaces {
    Following,
    Held,
}

impl Condensed {
    /// Room for a system; the joints' pattern is analysed here.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn of(system: &System) -> Result<Self, Error> {
        let mut touches = vec![Vec::new(); system.bodies.len()];
        let mut coupled = vec![false; system.markers.len()];
        for (row_index, row) in system.rows.iter().enumerate() {
            for term in row.terms.clone() {
                for (marker, side) in [
                    (system.terms[term].a, Side::A),
                    (system.terms[term].b, Side::B),
                ] {
                    let Some(body) = system.markers[marker].body else {
                        continue;
                    };
                    coupled[marker] = true;
                    let local = system.bodies[body]
                        .markers
                        .iter()
                        .position(|m| *m == marker)
                        .unwrap_or_default();
                    touches[body].push(Touch {
                        row: row_index,
                        term,
                        side,
                        local,
                    });
                }
            }
        }
        let pairs: Vec<(usize, usize)> = touches
            .iter()
            .flat_map(|own: &Vec<Touch>| {
                own.iter()
                    .flat_map(move |column| own.iter().map(move |row| (row.row, column.row)))
            })
            .collect();
        let (joints, places) =
            JointSystem::with_pattern(system.rows.len(), &pairs).ok_or(Error::OutOfMemory)?;
        let most_touches = touches.iter().map(Vec::len).max().unwrap_or(0);
        let most_markers = system.bodies.iter().map(|b| b.markers.len()).max();
        let free = system.free_motions();
        let mut compliant = vec![false; system.rows.len()];
        for (body, own) in system.bodies.iter().zip(&touches) {
            for touch in own.iter().filter(|_| !body.residual_rows.is_empty()) {
                compliant[touch.row] = true;
            }
        }
        let residual_rows = system.residual_row_count();
        let counts = || system.bodies.iter().map(|b| b.flexible.coordinate_count());
        Ok(Self {
            matrices: counts()
                .map(|n| BodyMatrix::for_coordinates(n, free))
                .collect(),
            tangents: counts().map(InertiaTangent::for_coordinates).collect(),
            factors: system
                .bodies
                .iter()
                .map(|b| BodyFactor::with_room(b.flexible.coordinate_count(), b.markers.len()))
                .collect(),
            joints,
            touches,
            places,
            gradients: vec![Six::zeros(); most_touches],
            responses: vec![Six::zeros(); most_markers.unwrap_or(0)],
            compliances: vec![0.0; system.rows.len()],
            wrenches: vec![Six::zeros(); system.markers.len()],
            twists: vec![Six::zeros(); system.markers.len()],
            coupled,
            residual_compliances: system
                .bodies
                .iter()
                .map(|body| Mat::zeros(body.residual_rows.len(), body.residual_rows.len()))
                .collect(),
            interfaces: Interfaces::Held,
            compliant,
            force_gaps: vec![0.0; residual_rows],
            gaps: vec![0.0; residual_rows],
            interface_step: vec![0.0; residual_rows],
            residual_step: vec![0.0; residual_rows],
            held: vec![false; system.bodies.len()],
            regularization: 0.0,
            step: vec![0.0; system.velocity_count()],
            force_step: vec![0.0; system.rows.len()],
        })
    }

    /// Which bodies, by index, don't move in the solves after the next factorization: neither as rigid ones nor by deflecting.
    pub fn hold(&mut self, bodies: &[usize]) {
        self.held.fill(false);
        for body in bodies {
            if let Some(held) = self.held.get_mut(*body) {
                *held = true;
            }
        }
    }

    /// How much the joints' system enlarges what it solves for: large where constraints nearly depend on each other. Overwrites the last solve's
    /// `force_step`.
    pub fn amplification(&mut self) -> f64 {
        self.joints.amplification(&mut self.force_step)
    }

    /// Assembles and factors S and the joints' system at the last evaluation. `turns` are the rotation vectors Δφ from the start
    /// of the step, by which velocities follow the positions; `None` for a solve of accelerations or of a first guess.
    ///
    /// # Errors
    /// [`Error::SingularBody`], [`Error::SingularJoints`].
    pub fn factor(
        &mut self,
        system: &System,
        state: &State,
        evaluation: &Evaluation,
        blend: &Blend,
        turns: Option<&[Vector3<f64>]>,
    ) -> Result<(), Error> {
        self.interfaces = match blend.elastic {
            Elastic::Moving if blend.stiffness > 0.0 => Interfaces::Following,
            Elastic::Moving | Elastic::Frozen => Interfaces::Held,
        };
        for (index, body) in system.bodies.iter().enumerate() {
            let turn = turns.map_or_else(Vector3::zeros, |turns| turns[index]);
            self.blend_body(system, state, evaluation, index, blend, &turn);
            let elastic = if self.held[index] {
                Elastic::Frozen
            } else {
                blend.elastic
            };
            self.matrices[index].free = match self.held[index] {
                true => [false; 6],
                false => system.free_motions(),
            };
            if !self.factors[index].factor(&self.matrices[index], elastic) {
                return Err(Error::SingularBody {
                    time: state.time,
                    body: body.name.clone(),
                });
            }
            let markers = &body.markers;
            self.factors[index].respond(
                markers
                    .iter()
                    .map(|m| (&system.markers[*m], &evaluation.places[*m])),
            );
            if self.interfaces == Interfaces::Following && !body.residual_rows.is_empty() {
                write_compliance(
                    body,
                    blend.mass,
                    blend.stiffness,
                    &mut self.residual_compliances[index],
                );
                let compliance = self.residual_compliances[index].as_ref();
                let at = |m: usize| (&system.markers[m].rows, &evaluation.places[m]);
                for (seen, marker) in markers.iter().enumerate() {
                    for (loaded, other) in markers.iter().enumerate() {
                        let more = marker_compliance(compliance, at(*marker), at(*other));
                        self.factors[index].add_compliance(seen, loaded, &more);
                    }
                }
            }
        }
        if self.factor_joints(system, evaluation, blend) {
            Ok(())
        } else {
            Err(Error::SingularJoints { time: state.time })
        }
    }

    /// S of one body.
    fn blend_body(
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
            let damping = 2.0 * body.flexible.damping[i] * stiffness.sqrt();
            *d = blend.mass
                + blend.damping * damping
                + blend.stiffness * (stiffness + tangent.softening[i]);
        }
        // Interface forces as coordinates follow the rows' forces alone.
        matrix.elastic[body.flexible.displacement_count()..].fill(f64::INFINITY);
    }

    /// Λ + diag(c), and its factor. Returns whether it is regular.
    fn factor_joints(&mut self, system: &System, evaluation: &Evaluation, blend: &Blend) -> bool {
        let values = self.joints.values_mut();
        values.fill(0.0);
        let mut place = 0;
        for (index, own) in self.touches.iter().enumerate() {
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
                    let softest = self.joints.diagonal(index).abs() / NO_STIFFNESS;
                    (1.0 / stiffness.max(0.0)).min(softest)
                }
            };
            self.joints.add_to_diagonal(index, self.compliances[index]);
        }
        self.joints.factor(self.regularization)
    }

    /// Λ of the last factorization over some rows, dense.
    pub fn joint_compliance(
        &self,
        system: &System,
        evaluation: &Evaluation,
        rows: &[usize],
    ) -> Mat<f64> {
        let mut position = vec![None; system.rows.len()];
        for (index, row) in rows.iter().enumerate() {
            position[*row] = Some(index);
        }
        let mut lambda = Mat::zeros(rows.len(), rows.len());
        for (index, own) in self.touches.iter().enumerate() {
            let axes = &evaluation.poses[index].axes;
            let in_body = |touch: &Touch| turned_back(axes, side(evaluation, touch));
            for column in own {
                let gradient = in_body(column);
                for row in own {
                    let (Some(i), Some(j)) = (position[row.row], position[column.row]) else {
                        continue;
                    };
                    let compliance = self.factors[index].compliance(row.local, column.local);
                    lambda[(i, j)] += in_body(row).dot(&(compliance * gradient));
                }
            }
        }
        lambda
    }

    /// What each row's measure must change by: to the demand for constraints, and for springs by what the force still differs.
    ///
    /// Where constraints are redundant their regularization is a compliance of the joints, part of the equations and not
    /// of the iteration alone: the share of λ that does nothing is then determined and can't drift from step to step.
    pub fn demand(
        &self,
        system: &System,
        state: &State,
        evaluation: &Evaluation,
        changes: &mut [f64],
    ) {
        for (index, row) in system.rows.iter().enumerate() {
            changes[index] = match &row.demand {
                Demand::Hold(_) | Demand::Follow(_) => {
                    -evaluation.answers[index] - self.yielding(state, index)
                }
                Demand::Answer(_) => {
                    (evaluation.answers[index] - state.forces[index]) * self.compliances[index]
                }
            };
        }
    }

    /// How the rows' measures change with a motion δq, rigid parts in body axes.
    pub fn row_changes(
        &mut self,
        system: &System,
        evaluation: &Evaluation,
        motion: &[f64],
        changes: &mut [f64],
    ) {
        self.twist_markers(system, evaluation, motion);
        changes.fill(0.0);
        for touch in self.touches.iter().flatten() {
            changes[touch.row] += side(evaluation, touch).dot(&self.twists[touch.marker(system)]);
        }
    }

    /// World twists of the markers by a motion δq.
    fn twist_markers(&mut self, system: &System, evaluation: &Evaluation, motion: &[f64]) {
        for (body, pose) in system.bodies.iter().zip(&evaluation.poses) {
            let (rigid, elastic) = motion[body.velocities.clone()].split_at(6);
            let six = Six::from_column_slice(rigid);
            for &marker in body.markers.iter().filter(|m| self.coupled[**m]) {
                let twist = system.markers[marker].twist(&evaluation.places[marker], &six, elastic);
                self.twists[marker] = turned(&pose.axes, &twist);
            }
        }
    }

    /// How far a constraint gives way to its force by the regularization.
    pub fn yielding(&self, state: &State, row: usize) -> f64 {
        self.joints.regularizing_compliance(row) * state.forces[row]
    }

    /// Whether a row touches a body whose interfaces are deflected by their forces: such a row has no velocity constraint of
    /// its own.
    pub fn is_compliant(&self, row: usize) -> bool {
        self.compliant[row]
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
    }

    /// The same where δλ are no forces but corrections of the positions: interfaces stay.
    pub fn solve_positions(
        &mut self,
        system: &System,
        evaluation: &Evaluation,
        changes: &[f64],
        residual: &[f64],
    ) {
        self.solve_rows(system, evaluation, changes, residual, Interfaces::Held);
    }

    /// How far interfaces are from where their forces at the evaluation put them.
    fn find_gaps(&mut self, system: &System, state: &State, evaluation: &Evaluation) {
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

    /// What the wrenches of the last solve make of interface forces and displacements.
    fn follow_forces(&mut self, system: &System, evaluation: &Evaluation) {
        for (index, body) in system.bodies.iter().enumerate() {
            let rows = body.residual_rows.clone();
            if rows.is_empty() {
                continue;
            }
            let forces = &mut self.interface_step[rows.clone()];
            forces.fill(0.0);
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
                        *step = change + gap;
                    }
                }
            }
        }
    }

    fn solve_rows(
        &mut self,
        system: &System,
        evaluation: &Evaluation,
        changes: &[f64],
        residual: &[f64],
        interfaces: Interfaces,
    ) {
        // t = S⁻¹ r, and how it moves the markers.
        self.step.copy_from_slice(residual);
        for (index, body) in system.bodies.iter().enumerate() {
            let (rigid, elastic) = self.step[body.velocities.clone()].split_at_mut(6);
            let mut six = Six::from_column_slice(rigid);
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
                self.force_step[touch.row] += side(evaluation, touch).dot(&self.twists[marker]);
            }
        }
        self.joints.solve(&mut self.force_step);
        // δq = S⁻¹ Bᵀ δλ - t
        self.wrenches.fill(Six::zeros());
        for own in &self.touches {
            for touch in own {
                let marker = touch.marker(system);
                self.wrenches[marker] += side(evaluation, touch) * self.force_step[touch.row];
            }
        }
        for (index, body) in system.bodies.iter().enumerate() {
            let step = &mut self.step[body.velocities.clone()];
            for entry in step.iter_mut() {
                *entry = -*entry;
            }
            let (rigid, elastic) = step.split_at_mut(6);
            let mut six = Six::from_column_slice(rigid);
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

impl Touch {
    fn marker(&self, system: &System) -> usize {
        match self.side {
            Side::A => system.terms[self.term].a,
            Side::B => system.terms[self.term].b,
        }
    }
}

/// The gradient of a touch, world axes.
fn side<'a>(evaluation: &'a Evaluation, touch: &Touch) -> &'a Six {
    match touch.side {
        Side::A => &evaluation.gradients[touch.term].a,
        Side::B => &evaluation.gradients[touch.term].b,
    }
}

/// Rows of forces stay in world axes while the frame turns: `Aᵀ δF = δ(Aᵀ F) - Aᵀ F × δφ`.
pub(super) fn keep_rows_in_world(tangent: &mut InertiaTangent, force_body: &Vector3<f64>) {
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
