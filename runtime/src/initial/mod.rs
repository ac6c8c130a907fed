//! A consistent start: positions that close the joints, velocities and accelerations that keep them closed.
//!
//! Each level solves for the smallest change, in the metric of the mass, that meets the constraints:
//!
//! ```text
//! positions      e(q) - f(t) = 0             Newton, δq = M⁻¹ Bᵀ (B M⁻¹ Bᵀ)⁻¹ (-h); first the bodies as rigid ones
//! velocities     B q' = f'
//! accelerations  M q'' - Bᵀ λ = -(forces),  B q'' + (B)' q' = f''
//! ```
//! Interfaces that their forces deflect beside the coordinates start as if those forces had acted for long: x = F g with the λ of
//! the start, x' = x'' = 0 (static), and g = B_Γᵀ λ, g' = g'' = 0 (weak). The bodies make room for that deflection, as rigid ones
//! where they can; a body that is held so that it must be strained has the forces of the least strain energy. Left alone
//! instead, the interfaces would start unloaded and the mechanism would ring.
//!
//! Bodies move as rigid ones first; only where that can't close a joint they deflect, by the least strain energy.

mod assembly;
mod interfaces;
mod rank;
mod report;

use dcb_formats::scene::RedundantConstraints;
use nalgebra::{UnitQuaternion, Vector3};

use crate::error::Error;
use crate::system::body_factor::Elastic;
use crate::system::condensed::{Blend, Condensed};
use crate::system::evaluation::Evaluation;
use crate::system::{State, System};
pub(crate) use rank::dependent_rows;

/// Keeps the joints' system regular where constraints are redundant: a compliance of this part of what a step's inertia gives way.
/// The start iterates it away; steps keep it, so that redundant forces are determined.
pub const REGULARIZATION: f64 = 1e-10;

/// Effort of making a start consistent.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InitialReport {
    /// Bodies that moved: name, distance of the frame's origin, angle.
    pub moved: Vec<MovedBody>,
    /// Bodies that had to deflect: name, strain energy.
    pub strained: Vec<(String, f64)>,
    /// Bodies whose velocity was corrected: name, change of velocity, change of spin.
    pub sped: Vec<MovedBody>,
    /// Names of the joints and drives with redundant constraints, and how many.
    pub redundant: Vec<(String, usize)>,
    /// Independent constraints.
    pub independent_constraints: usize,
    /// Extent of the mechanism: the mean radii of its bodies together.
    pub size: f64,
}

/// By how much a body moved.
#[derive(Clone, Debug, PartialEq)]
pub struct MovedBody {
    /// Name.
    pub body: String,
    /// Translation.
    pub translation: f64,
    /// Rotation, rad.
    pub rotation: f64,
}

/// Finds consistent positions, velocities and accelerations for a system.
pub struct Starter<'a> {
    system: &'a System,
    evaluation: Evaluation,
    condensed: Condensed,
    zeros: Vec<f64>,
    changes: Vec<f64>,
    /// λ that hold the bodies in the strain by which joints were closed, for rows that interfaces give way to.
    assembly: Vec<f64>,
    /// Extent of the mechanism.
    size: f64,
    /// Bodies that the assembly doesn't move.
    held: Vec<usize>,
}

impl<'a> Starter<'a> {
    /// For a system.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn of(system: &'a System) -> Result<Self, Error> {
        let mut condensed = Condensed::of(system)?;
        condensed.regularization = REGULARIZATION;
        Ok(Self {
            system,
            evaluation: Evaluation::of(system),
            condensed,
            zeros: vec![0.0; system.velocity_count()],
            changes: vec![0.0; system.rows.len()],
            assembly: vec![0.0; system.rows.len()],
            size: system.bodies.iter().map(|b| b.length).sum(),
            held: Vec::new(),
        })
    }

    /// The system that it was made for.
    pub fn system(&self) -> &'a System {
        self.system
    }

    /// Leaves bodies, by index, where they are drawn, undeformed: only the others are moved to close the joints.
    pub fn holding(mut self, bodies: &[usize]) -> Self {
        self.held = bodies.to_vec();
        self
    }

    /// Makes positions, velocities and accelerations consistent, in this order, and tells what changed.
    ///
    /// # Errors
    /// [`Error::CannotAssemble`] with the joint that stays open; [`Error::Redundant`] if redundant constraints are to be
    /// refused; [`Error::SingularBody`].
    pub fn start(
        &mut self,
        state: &mut State,
        redundancy: RedundantConstraints,
    ) -> Result<InitialReport, Error> {
        let drawn = state.clone();
        self.start_angles(state);
        self.close(state)?;
        let mut report = InitialReport {
            moved: self.moved(&drawn, state),
            strained: self.strained(state),
            size: self.size,
            ..InitialReport::default()
        };
        self.find_redundant(state, &mut report)?;
        if redundancy == RedundantConstraints::Refuse && !report.redundant.is_empty() {
            return Err(Error::Redundant {
                joints: report
                    .redundant
                    .iter()
                    .map(|(name, _)| name.clone())
                    .collect(),
            });
        }
        // What rounding makes of forces that do nothing isn't left in them.
        let rows = report.redundant.iter().map(|(_, count)| count).sum();
        self.condensed.expect_redundant(rows, REGULARIZATION);
        let before = state.velocities.clone();
        self.match_velocities(state)?;
        report.sped = self.sped(&before, state);
        self.accelerate(state)?;
        if self.system.residual_row_count() > 0 {
            self.settle_interfaces(state)?;
        }
        state.algorithmic.copy_from_slice(&state.accelerations);
        Ok(report)
    }

    /// Inertia forces and terms, which the tangents start from.
    fn refresh_inertia(&mut self, state: &State) {
        self.evaluation
            .wrenches
            .fill(crate::kinematics::frame_motion::Six::zeros());
        self.evaluation.resist(self.system, state);
    }

    /// Change that each constraint needs; springs hold still.
    fn demand_changes(&mut self, change: impl Fn(&Evaluation, usize) -> Option<f64>) {
        for (index, row) in self.system.rows.iter().enumerate() {
            self.changes[index] = if row.is_constraint() {
                change(&self.evaluation, index).unwrap_or_default()
            } else {
                0.0
            };
        }
    }

    /// Adds the last solve to velocities or accelerations, whose linear parts are in world axes.
    fn add_step(&self, rates: &mut [f64]) {
        self.condensed
            .add_step(self.system, &self.evaluation, rates);
    }

    /// Corrects velocities, as rigid bodies first.
    fn match_velocities(&mut self, state: &mut State) -> Result<(), Error> {
        let still = state.without_motion();
        for elastic in [Elastic::Frozen, Elastic::Moving] {
            let blend = Blend::mass_alone(elastic);
            self.refresh_inertia(&still);
            self.condensed
                .factor(self.system, &still, &self.evaluation, &blend, None)?;
            for _ in 0..3 {
                self.evaluation.add_velocities(self.system, state);
                let system = self.system;
                self.demand_changes(|evaluation, row| {
                    evaluation.velocity_defect(system, state, row).map(|d| -d)
                });
                let (evaluation, zeros) = (&self.evaluation, &self.zeros);
                self.condensed
                    .solve(system, state, evaluation, &self.changes, zeros);
                self.add_step(&mut state.velocities);
            }
        }
        Ok(())
    }

    /// Accelerations and λ at consistent positions and velocities.
    ///
    /// # Errors
    /// [`Error::SingularBody`], [`Error::SingularJoints`].
    pub fn accelerate(&mut self, state: &mut State) -> Result<(), Error> {
        self.accelerate_with(state, Elastic::Moving)
    }

    /// Positions, velocities, accelerations and λ of bodies that stay as deflected as they are, at the state's time; positions near
    /// it must be given.
    ///
    /// # Errors
    /// [`Error::CannotAssemble`], [`Error::SingularBody`], [`Error::SingularJoints`].
    pub fn follow(&mut self, state: &mut State) -> Result<(), Error> {
        if !self.close_with(state, Elastic::Frozen)? {
            return Err(self.open());
        }
        self.evaluation.count_turns(self.system, state);
        self.match_velocities(state)?;
        self.accelerate_with(state, Elastic::Frozen)
    }

    fn accelerate_with(&mut self, state: &mut State, elastic: Elastic) -> Result<(), Error> {
        let system = self.system;
        state.accelerations.fill(0.0);
        self.evaluation.place(system, state);
        self.evaluation.add_velocities(system, state);
        self.evaluation.measure(system, state);
        for (index, row) in system.rows.iter().enumerate() {
            state.forces[index] = if row.is_constraint() {
                self.assembly[index]
            } else {
                self.evaluation.answers[index]
            };
        }
        self.evaluation.load(system, state);
        self.evaluation.resist(system, state);
        let blend = Blend::mass_alone(elastic);
        self.condensed
            .factor(system, state, &self.evaluation, &blend, None)?;
        // With redundant constraints one solve is as exact as their regularization; two are exact.
        for _ in 0..2 {
            self.evaluation.add_accelerations(system, state);
            self.demand_changes(|evaluation, row| {
                evaluation
                    .acceleration_defect(system, state, row)
                    .map(|d| -d)
            });
            self.evaluation.load(system, state);
            self.evaluation.resist(system, state);
            self.condensed.solve(
                system,
                state,
                &self.evaluation,
                &self.changes,
                &self.evaluation.residual,
            );
            self.add_step(&mut state.accelerations);
            for (index, row) in system.rows.iter().enumerate() {
                if row.is_constraint() {
                    state.forces[index] += self.condensed.force_step[index];
                }
            }
        }
        Ok(())
    }

    /// Gives a start the past that its motion would have had: accelerations and forces at `interval` before it, as far as their
    /// first derivatives tell. These come from one-sided differences of consistent accelerations over two intervals after the
    /// start, so that functions of time are never asked for earlier times. Where the motion has no derivative, nothing changed
    /// in the interval.
    ///
    /// # Errors
    /// Those of [`Starter::accelerate`].
    pub fn look_back(&mut self, state: &mut State, interval: f64) -> Result<(), Error> {
        let mut next = carried(self.system, state, interval);
        self.accelerate(&mut next)?;
        let mut second = carried(self.system, state, 2.0 * interval);
        self.accelerate(&mut second)?;
        let change = |now: f64, next: f64, second: f64| 2.0 * next - 1.5 * now - 0.5 * second;
        let before = |now: &[f64], next: &[f64], second: &[f64], earlier: &mut [f64]| {
            for (i, earlier) in earlier.iter_mut().enumerate() {
                let change = change(now[i], next[i], second[i]);
                *earlier = if change.is_finite() {
                    now[i] - change
                } else {
                    now[i]
                };
            }
        };
        before(
            &state.accelerations,
            &next.accelerations,
            &second.accelerations,
            &mut state.earlier_accelerations,
        );
        before(
            &state.forces,
            &next.forces,
            &second.forces,
            &mut state.earlier_forces,
        );
        state.earlier_step = interval;
        Ok(())
    }
}

/// The state after a time in which its accelerations stay.
pub(crate) fn carried(system: &System, state: &State, time: f64) -> State {
    let mut moved = state.clone();
    (moved.time, moved.time_rest) = state.time_after(time);
    for (index, body) in system.bodies.iter().enumerate() {
        let at = body.velocities.start;
        let increment = |i: usize| {
            let (velocity, acceleration) = (state.velocities[at + i], state.accelerations[at + i]);
            time * (velocity + 0.5 * time * acceleration)
        };
        let three = |i: usize| Vector3::new(increment(i), increment(i + 1), increment(i + 2));
        moved.origins[index] += three(0);
        moved.orientations[index] *= UnitQuaternion::new(three(3));
        let coordinates = &mut moved.coordinates[body.coordinates.clone()];
        for (k, y) in coordinates.iter_mut().enumerate() {
            *y += increment(6 + k);
        }
    }
    for (velocity, acceleration) in moved.velocities.iter_mut().zip(&state.accelerations) {
        *velocity += time * acceleration;
    }
    moved
}
