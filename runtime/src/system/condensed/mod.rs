//! One linear solve of a Newton iteration: bodies eliminated one by one, then the joints, then back.
//!
//! ```text
//! S δq - Bᵀ δλ = -r          S = β' M + γ' C + κ K, body by body
//! B δq + c δλ  = -h          c = 0 for constraints, 1/k_t for springs
//!
//! t = S⁻¹ r,   (B S⁻¹ Bᵀ + c) δλ = B t - h,   δq = S⁻¹ Bᵀ δλ - t
//! ```
//! Interface forces that deflect a body beside its coordinates add their flexibility to Λ wherever S has stiffness; see
//! `super::residual`.
//!
//! δq counts `(Aᵀ δR, δφ, δy)` for each body. Two parts of the exact matrix are left to the iteration: the coupling of a body's
//! coordinates with each other by its spin, and the change of the rows' forces with the configuration. Both are of order h² and
//! the exact matrix is in [`super::linearization`].

mod actuated;
mod assemble;
mod changes;
mod columns;
mod controlled;
mod following;
mod redundant;
mod solve;
mod touch;

use faer::Mat;
use nalgebra::Vector3;

use assemble::differentiate;
pub(super) use assemble::keep_rows_in_world;
use controlled::Controls;
use touch::{Side, Touch, body_pairs, side};

use crate::actuator::Effort;
use crate::error::Error;
use crate::frame::InertiaTangent;
use crate::kinematics::frame_motion::{Six, SixOf};
use crate::system::body_factor::{BodyFactor, BodyMatrix, Elastic};
use crate::system::evaluation::Evaluation;
use crate::system::joint_system::JointSystem;
use crate::system::number::Number;
use crate::system::residual::{marker_compliance, write_compliance};
use crate::system::{Demand, State, System};

/// How much of mass, damping and stiffness is in S.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blend<T: Number = f64> {
    /// β', of the mass.
    pub mass: T,
    /// γ', of the damping.
    pub damping: T,
    /// κ, of the stiffness.
    pub stiffness: f64,
    /// Whether y moves.
    pub elastic: Elastic,
    /// Whether interfaces beside y follow their forces.
    pub interfaces: Interfaces,
}

impl Blend {
    /// The mass and nothing else: the metric of a smallest change.
    pub fn mass_alone(elastic: Elastic) -> Self {
        Self {
            mass: 1.0,
            damping: 0.0,
            stiffness: 0.0,
            elastic,
            interfaces: Interfaces::Held,
        }
    }

    /// The mass, and so much of the stiffness: accelerations of which motions that an implicit step doesn't follow have no share.
    pub fn smoothed_mass(stiffness: f64) -> Self {
        Self {
            stiffness,
            ..Self::mass_alone(Elastic::Moving)
        }
    }
}

/// A rigid body with more touches than this stays among the unknowns of the joints' system.
const MANY_TOUCHES: usize = 36;

/// The factored iteration matrix of a system.
pub struct Condensed<T: Number = f64> {
    matrices: Vec<BodyMatrix<T>>,
    /// Of the last real factorization.
    tangents: Vec<InertiaTangent>,
    factors: Vec<BodyFactor<T>>,
    joints: JointSystem<T>,
    touches: Vec<Vec<Touch>>,
    /// Bodies that stay among the unknowns of the joints' system: where their motions are.
    motions: Vec<Option<usize>>,
    /// Place of each pair of touches among the joints' values, body by body; where a body's motions are unknowns, its touches with them.
    places: Vec<usize>,
    /// Rows whose forces do work.
    drives: Vec<usize>,
    /// Gradients of a body's touches in body axes, and the body's response to them by markers.
    gradients: Vec<Six>,
    responses: Vec<SixOf<T>>,
    /// c of each row.
    compliances: Vec<T>,
    /// How much the coordinate of each actuator changes by a unit force, everything else following.
    mobilities: Vec<f64>,
    /// Efforts of the actuators where they are met.
    efforts: Vec<Effort>,
    /// γ' of the present factor: change of rates with positions.
    rates_follow: T,
    /// Efforts that follow coordinates of any joints.
    controls: Controls<T>,
    wrenches: Vec<SixOf<T>>,
    twists: Vec<SixOf<T>>,
    /// Markers that rows touch.
    coupled: Vec<bool>,
    /// C of each body, over its interface rows; (0, 0) for bodies without.
    residual_compliances: Vec<Mat<T>>,
    /// Whether interfaces follow their forces in the solves with the present factor.
    interfaces: Interfaces,
    /// Rows that touch a body whose interfaces are deflected by their forces.
    compliant: Vec<bool>,
    /// Remaining differences of interface forces, and of interface displacements for known forces; by residual rows.
    force_gaps: Vec<T>,
    gaps: Vec<T>,
    /// δg of the last solve, by residual rows.
    interface_step: Vec<T>,
    /// Bodies that don't move.
    held: Vec<bool>,
    /// How many rows are redundant.
    expected_redundant: usize,
    /// Added to the unit diagonal of the joints' system where constraints are redundant.
    pub regularization: f64,
    /// δq of the last solve, laid out as velocities, rigid parts in body axes.
    pub step: Vec<T>,
    /// δλ of the last solve.
    pub force_step: Vec<T>,
    /// Change of the displacements beside the coordinates in the last solve, by residual rows. Zero for bodies whose interface
    /// forces are coordinates; their change is in `step`.
    pub residual_step: Vec<T>,
}

/// Whether the displacements of interfaces beside the coordinates follow the forces in a solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interfaces {
    /// They do.
    Following,
    /// They stay.
    Held,
}

impl<T: Number> Condensed<T> {
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
        let mut unknowns = system.rows.len();
        let motions: Vec<Option<usize>> = touches
            .iter()
            .zip(&system.bodies)
            .map(|(own, body)| {
                let is_rigid =
                    body.flexible.coordinate_count() == 0 && body.residual_rows.is_empty();
                let stays = is_rigid && own.len() > MANY_TOUCHES;
                let first = stays.then_some(unknowns);
                unknowns += if stays { 6 } else { 0 };
                first
            })
            .collect();
        let pairs: Vec<(usize, usize)> = touches
            .iter()
            .zip(&motions)
            .flat_map(|(own, motion)| body_pairs(own, *motion))
            .collect();
        let rows = system.rows.len();
        let (joints, places) =
            JointSystem::with_pattern(rows, unknowns - rows, &pairs).ok_or(Error::OutOfMemory)?;
        let most_touches = touches.iter().map(Vec::len).max().unwrap_or(0);
        let most_markers = system.bodies.iter().map(|b| b.markers.len()).max();
        let mut compliant = vec![false; system.rows.len()];
        for (body, own) in system.bodies.iter().zip(&touches) {
            for touch in own.iter().filter(|_| !body.residual_rows.is_empty()) {
                compliant[touch.row] = true;
            }
        }
        let residual_rows = system.residual_row_count();
        let counts = || system.bodies.iter().map(|b| b.flexible.coordinate_count());
        Ok(Self {
            matrices: system
                .bodies
                .iter()
                .map(|b| BodyMatrix::for_coordinates(b.flexible.coordinate_count(), b.free))
                .collect(),
            tangents: counts().map(InertiaTangent::for_coordinates).collect(),
            factors: system
                .bodies
                .iter()
                .zip(&motions)
                .map(|(body, motion)| match motion {
                    Some(_) => BodyFactor::with_responses_alone(body.markers.len()),
                    None => {
                        BodyFactor::with_room(body.flexible.coordinate_count(), body.markers.len())
                    }
                })
                .collect(),
            joints,
            touches,
            motions,
            places,
            drives: (0..system.rows.len())
                .filter(|row| matches!(system.rows[*row].demand, Demand::Follow(_)))
                .collect(),
            gradients: vec![Six::zeros(); most_touches],
            responses: vec![SixOf::zeros(); most_markers.unwrap_or(0)],
            compliances: vec![T::of(0.0); system.rows.len()],
            mobilities: vec![0.0; system.actuators.len()],
            efforts: vec![Effort::default(); system.actuators.len()],
            rates_follow: T::of(0.0),
            controls: Controls::of(system),
            wrenches: vec![SixOf::zeros(); system.markers.len()],
            twists: vec![SixOf::zeros(); system.markers.len()],
            coupled,
            residual_compliances: system
                .bodies
                .iter()
                .map(|body| Mat::zeros(body.residual_rows.len(), body.residual_rows.len()))
                .collect(),
            interfaces: Interfaces::Held,
            compliant,
            force_gaps: vec![T::of(0.0); residual_rows],
            gaps: vec![T::of(0.0); residual_rows],
            interface_step: vec![T::of(0.0); residual_rows],
            residual_step: vec![T::of(0.0); residual_rows],
            held: vec![false; system.bodies.len()],
            expected_redundant: 0,
            regularization: 0.0,
            step: vec![T::of(0.0); system.velocity_count()],
            force_step: vec![T::of(0.0); system.rows.len()],
        })
    }

    /// S of every body, eliminated, and the Λ that is left; the body that can't be, if there is one.
    fn factor_bodies(
        &mut self,
        system: &System,
        evaluation: &Evaluation,
        tangents: &[InertiaTangent],
        blend: &Blend<T>,
        turns: Option<&[Vector3<f64>]>,
    ) -> Result<(), usize> {
        self.interfaces = blend.interfaces;
        for (index, (body, tangent)) in system.bodies.iter().zip(tangents).enumerate() {
            let turn = turns.map_or_else(Vector3::zeros, |turns| turns[index]);
            self.blend_body(system, evaluation, (index, tangent), blend, &turn);
            let elastic = if self.held[index] {
                Elastic::Frozen
            } else {
                blend.elastic
            };
            self.matrices[index].free = match self.held[index] {
                true => [false; 6],
                false => body.free,
            };
            if !self.factors[index].factor(&self.matrices[index], elastic) {
                return Err(index);
            }
            let markers = &body.markers;
            self.factors[index].respond(
                system.dimension,
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
        self.assemble_joints(system, evaluation, blend);
        Ok(())
    }

    /// Factors the same rows at another shift beside a real factor: with its scales and the directions that do nothing.
    ///
    /// # Errors
    /// [`Error::SingularBody`], [`Error::SingularJoints`].
    pub fn factor_beside(
        &mut self,
        system: &System,
        state: &State,
        evaluation: &Evaluation,
        blend: &Blend<T>,
        real: &Condensed,
    ) -> Result<(), Error> {
        self.factor_bodies(system, evaluation, &real.tangents, blend, None)
            .map_err(|body| singular(system, state, body))?;
        self.follow_slopes(system, evaluation, &evaluation.efforts, blend);
        let is_regular = self.joints.factor_beside(&real.joints)
            && (self.controls.rows.is_empty()
                || self.factor_controls(system, evaluation, blend.stiffness));
        match is_regular {
            true => Ok(()),
            false => Err(Error::SingularJoints { time: state.time }),
        }
    }

    /// `M x` at the last factorization, laid out as velocities, rigid parts in body axes.
    pub fn mass_product(&self, system: &System, x: &[f64], product: &mut [f64]) {
        for (body, tangent) in system.bodies.iter().zip(&self.tangents) {
            let own = body.velocities.clone();
            let (rigid, elastic) = x[own.clone()].split_at(6);
            let (out_rigid, out_elastic) = product[own].split_at_mut(6);
            let mass = &tangent.mass;
            out_elastic.copy_from_slice(elastic);
            f64::add_columns(out_elastic, &mass.elastic_by_rigid, rigid);
            let own = mass.rigid * Six::from_column_slice(rigid);
            out_rigid.copy_from_slice(own.as_slice());
            f64::add_products(out_rigid, &mass.rigid_by_elastic, elastic);
        }
    }

    /// Whether a row touches a body whose interfaces are deflected by their forces: such a row has no velocity constraint of
    /// its own.
    pub fn is_compliant(&self, row: usize) -> bool {
        self.compliant[row]
    }
}

impl Condensed {
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
        self.factor_here(system, state, evaluation, blend, turns)?;
        self.meet_efforts(system, state, evaluation, blend);
        self.factor_rows(system, state, evaluation, blend)
    }

    /// The same with the slopes that efforts have at the evaluation, which factors at other shifts have too.
    ///
    /// # Errors
    /// [`Error::SingularBody`], [`Error::SingularJoints`].
    pub fn factor_straight(
        &mut self,
        system: &System,
        state: &State,
        evaluation: &Evaluation,
        blend: &Blend,
    ) -> Result<(), Error> {
        self.factor_here(system, state, evaluation, blend, None)?;
        self.follow_slopes(system, evaluation, &evaluation.efforts, blend);
        self.factor_rows(system, state, evaluation, blend)
    }

    fn factor_here(
        &mut self,
        system: &System,
        state: &State,
        evaluation: &Evaluation,
        blend: &Blend,
        turns: Option<&[Vector3<f64>]>,
    ) -> Result<(), Error> {
        let mut tangents = std::mem::take(&mut self.tangents);
        differentiate(system, state, evaluation, &mut tangents);
        let factored = self.factor_bodies(system, evaluation, &tangents, blend, turns);
        self.tangents = tangents;
        factored.map_err(|body| singular(system, state, body))
    }

    fn factor_rows(
        &mut self,
        system: &System,
        state: &State,
        evaluation: &Evaluation,
        blend: &Blend,
    ) -> Result<(), Error> {
        if !self.joints.factor(self.regularization) {
            return Err(Error::SingularJoints { time: state.time });
        }
        if self.regularization > 0.0 {
            self.joints.find_redundant(&self.drives);
        }
        if !self.controls.rows.is_empty()
            && !self.factor_controls(system, evaluation, blend.stiffness)
        {
            return Err(Error::SingularJoints { time: state.time });
        }
        Ok(())
    }
}

fn singular(system: &System, state: &State, body: usize) -> Error {
    Error::SingularBody {
        time: state.time,
        body: system.bodies[body].name.clone(),
    }
}
