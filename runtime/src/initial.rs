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

use faer::Mat;
use nalgebra::{UnitQuaternion, Vector3};

use crate::body::Compatibility;
use crate::error::Error;
use crate::simulation::count_turns;
use crate::system::body_factor::Elastic;
use crate::system::condensed::{Blend, Condensed};
use crate::system::evaluation::Evaluation;
use crate::system::residual::{add_product, row_flexibility};
use crate::system::{Body, Demand, State, System};

/// How far constraints may stay open, relative to the size of the mechanism: rounding. What stays open is pulled shut in the first
/// step, with an acceleration of this much over its square.
const CLOSED: f64 = 1e-15;
/// How far a misfit may stay open before a scene is refused.
const OPEN: f64 = 1e-8;
/// Largest turn that one iteration of an assembly makes.
const LARGEST_TURN: f64 = 0.5;
/// Iterations of an assembly.
const ITERATIONS: usize = 60;
/// Keeps the joints' system regular where constraints are redundant: a compliance of this part of what a step's inertia gives way.
/// The start iterates it away; steps keep it, so that redundant forces are determined.
pub const REGULARIZATION: f64 = 1e-10;
/// Rounds of finding the interface forces of a start and making room for the deflection by them.
const SETTLING_ROUNDS: usize = 30;
/// Scaled pivots of the joints' system below this are redundant constraints.
const DEPENDENT: f64 = 1e-9;

/// What it took to make a start consistent.
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

/// What to do about redundant constraints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Redundancy {
    /// Share their forces out in the minimum-norm sense.
    #[default]
    MinimumNorm,
    /// Refuse the scene.
    Refuse,
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
        redundancy: Redundancy,
    ) -> Result<InitialReport, Error> {
        let drawn = state.clone();
        self.start_angles(state);
        self.close(state)?;
        let mut report = InitialReport {
            moved: self.moved(&drawn, state),
            strained: self.strained(state),
            ..InitialReport::default()
        };
        self.find_redundant(state, &mut report)?;
        if redundancy == Redundancy::Refuse && !report.redundant.is_empty() {
            return Err(Error::Redundant {
                joints: report
                    .redundant
                    .iter()
                    .map(|(name, _)| name.clone())
                    .collect(),
            });
        }
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

    /// Interfaces as their forces deflect them.
    fn settle_interfaces(&mut self, state: &mut State) -> Result<(), Error> {
        let mut last = f64::INFINITY;
        for _ in 0..SETTLING_ROUNDS {
            let change = self.follow_forces(state);
            self.close(state)?;
            self.match_velocities(state)?;
            self.accelerate(state)?;
            if change <= CLOSED || (change >= 0.5 * last && change <= OPEN) {
                return Ok(());
            }
            last = change;
        }
        Err(Error::NotConverged {
            time: state.time,
            iterations: SETTLING_ROUNDS,
            residual: last * self.size,
            tolerance: OPEN * self.size,
            worst: self
                .system
                .bodies
                .iter()
                .find(|body| !body.residual_rows.is_empty())
                .map_or_else(String::new, |body| body.name.clone()),
        })
    }

    /// Deflects interfaces beside the coordinates by the forces of the state; the largest change relative to the mechanism
    /// (translations) or in rad.
    fn follow_forces(&mut self, state: &mut State) -> f64 {
        let system = self.system;
        self.evaluation.place(system, state);
        self.evaluation.measure(system, state);
        self.evaluation.load(system, state);
        let mut largest: f64 = 0.0;
        for body in &system.bodies {
            let Some(flexibility) = &body.flexible.residual_flexibility else {
                continue;
            };
            let forces = &self.evaluation.residual_forces[body.residual_rows.clone()];
            let mut change = vec![0.0; forces.len()];
            add_product(flexibility.as_ref(), forces, &mut change);
            let mut before = vec![0.0; forces.len()];
            match body.flexible.compatibility {
                Compatibility::Strong | Compatibility::Static => {
                    let x = &mut state.residual_displacements[body.residual_rows.clone()];
                    before.copy_from_slice(x);
                    x.copy_from_slice(&change);
                }
                Compatibility::Weak => {
                    let own = &mut state.coordinates[body.coordinates.clone()];
                    let g = &mut own[body.flexible.displacement_count()..];
                    add_product(flexibility.as_ref(), g, &mut before);
                    g.copy_from_slice(forces);
                }
            }
            for ((after, before), row) in change.iter().zip(&before).zip(&body.flexible.rows) {
                let unit = if row.direction < 3 { self.size } else { 1.0 };
                largest = largest.max((after - before).abs() / unit);
            }
        }
        largest
    }

    /// Angles start at their principal value, or at the turn where their drive starts.
    fn start_angles(&mut self, state: &mut State) {
        self.evaluation.place(self.system, state);
        for row in &self.system.rows {
            for term in &self.system.terms[row.terms.clone()] {
                if let Some(angle) = term.angle {
                    state.angles[angle] = match &row.demand {
                        Demand::Follow(signal) if term.weight != 0.0 => {
                            self.system.signal(*signal, state).value / term.weight
                        }
                        _ => term.measure.value(
                            &self.evaluation.motions[term.a],
                            &self.evaluation.motions[term.b],
                        ),
                    };
                }
            }
        }
    }

    /// Closes the joints.
    fn close(&mut self, state: &mut State) -> Result<(), Error> {
        self.condensed.hold(&self.held);
        let done = self.close_unheld(state);
        self.condensed.hold(&[]);
        done
    }

    fn close_unheld(&mut self, state: &mut State) -> Result<(), Error> {
        let mut closed = self.close_with(state, Elastic::Frozen)?;
        let deflects = self.system.coordinate_count() + self.system.residual_row_count() > 0;
        if !closed && deflects {
            closed = self.close_strained(state)?;
        }
        if closed || self.worst_row().1 <= OPEN {
            return Ok(());
        }
        Err(self.open())
    }

    /// Which joint stays open.
    fn open(&self) -> Error {
        let (worst, _) = self.worst_row();
        let connection = &self.system.connections[self.system.rows[worst].connection];
        Error::CannotAssemble {
            joint: connection.name.clone(),
            misfit: self.evaluation.answers[worst],
            allowed: OPEN * self.size,
        }
    }

    /// Closes the joints by deflection, interfaces beside the coordinates included.
    fn close_strained(&mut self, state: &mut State) -> Result<bool, Error> {
        for (force, assembly) in state.forces.iter_mut().zip(&self.assembly) {
            *force -= assembly;
        }
        let closed = self.close_with(state, Elastic::Moving)?;
        for (row, assembly) in self.assembly.iter_mut().enumerate() {
            if self.condensed.is_compliant(row) {
                *assembly = self.condensed.force_step[row];
            }
        }
        for (force, assembly) in state.forces.iter_mut().zip(&self.assembly) {
            *force += assembly;
        }
        Ok(closed)
    }

    fn close_with(&mut self, state: &mut State, elastic: Elastic) -> Result<bool, Error> {
        let softest = self
            .system
            .bodies
            .iter()
            .flat_map(|b| b.flexible.stiffness.iter())
            .filter(|s| **s > 0.0)
            .fold(f64::INFINITY, |least, s| least.min(*s));
        let mut last = f64::INFINITY;
        for _ in 0..ITERATIONS {
            self.evaluation.place(self.system, state);
            self.evaluation.measure(self.system, state);
            let (_, misfit) = self.worst_row();
            if misfit <= CLOSED || (misfit >= 0.5 * last && misfit <= OPEN) {
                return Ok(true);
            }
            last = misfit;
            let blend = match elastic {
                Elastic::Frozen => Blend {
                    mass: 1.0,
                    damping: 0.0,
                    stiffness: 0.0,
                    elastic,
                },
                // Deflection costs its strain energy, rigid motion next to nothing.
                Elastic::Moving => Blend {
                    mass: 1e-3 * softest,
                    damping: 0.0,
                    stiffness: 1.0,
                    elastic,
                },
            };
            let still = state.without_motion();
            self.refresh_inertia(&still);
            self.condensed
                .factor(self.system, &still, &self.evaluation, &blend, None)?;
            self.demand_changes(|evaluation, row| Some(-evaluation.answers[row]));
            let mut forces = std::mem::take(&mut self.zeros);
            forces.fill(0.0);
            if elastic == Elastic::Moving {
                for body in &self.system.bodies {
                    let y = &state.coordinates[body.coordinates.clone()];
                    for (k, force) in forces[body.velocities.clone()][6..].iter_mut().enumerate() {
                        *force = body.flexible.stiffness[k] * y[k];
                    }
                }
            }
            if self.system.residual_row_count() > 0 {
                self.evaluation.load(self.system, state);
            }
            let (system, evaluation) = (self.system, &self.evaluation);
            self.condensed
                .solve(system, state, evaluation, &self.changes, &forces);
            forces.fill(0.0);
            self.zeros = forces;
            self.shift(state);
        }
        Ok(false)
    }

    /// Inertia forces and terms, which the tangents start from.
    fn refresh_inertia(&mut self, state: &State) {
        self.evaluation.wrenches.fill(crate::motion::Six::zeros());
        self.evaluation.resist(self.system, state);
    }

    /// What each constraint must change by; springs hold still.
    fn demand_changes(&mut self, change: impl Fn(&Evaluation, usize) -> Option<f64>) {
        for (index, row) in self.system.rows.iter().enumerate() {
            self.changes[index] = match &row.demand {
                Demand::Answer(_) => 0.0,
                Demand::Hold(_) | Demand::Follow(_) => {
                    change(&self.evaluation, index).unwrap_or_default()
                }
            };
        }
    }

    /// Moves the state by the last solve, with turns limited.
    fn shift(&self, state: &mut State) {
        let largest = self
            .system
            .bodies
            .iter()
            .map(|b| {
                Vector3::from_column_slice(&self.condensed.step[b.velocities.clone()][3..6]).norm()
            })
            .fold(0.0, f64::max);
        let factor = if largest > LARGEST_TURN {
            LARGEST_TURN / largest
        } else {
            1.0
        };
        for (index, body) in self.system.bodies.iter().enumerate() {
            let step = &self.condensed.step[body.velocities.clone()];
            let shift = Vector3::from_column_slice(&step[..3]) * factor;
            let turn = Vector3::from_column_slice(&step[3..6]) * factor;
            state.origins[index] += self.evaluation.poses[index].axes * shift;
            state.orientations[index] *= UnitQuaternion::new(turn);
            let rows = body.residual_rows.clone();
            let steps = &self.condensed.residual_step[rows.clone()];
            for (x, change) in state.residual_displacements[rows].iter_mut().zip(steps) {
                *x += factor * change;
            }
            for (y, change) in state.coordinates[body.coordinates.clone()]
                .iter_mut()
                .zip(&step[6..])
            {
                *y += factor * change;
            }
        }
    }

    /// The constraint that is furthest from its demand, and how far relative to the mechanism.
    fn worst_row(&self) -> (usize, f64) {
        let mut worst = (0, 0.0);
        for (index, row) in self.system.rows.iter().enumerate() {
            if matches!(row.demand, Demand::Answer(_)) {
                continue;
            }
            let term = &self.system.terms[row.terms.start];
            let unit = if term.measure.is_length() {
                self.size
            } else {
                1.0
            };
            let misfit = self.evaluation.answers[index].abs() / unit;
            if misfit > worst.1 || misfit.is_nan() {
                worst = (index, misfit);
            }
        }
        worst
    }

    /// Corrects velocities, as rigid bodies first.
    fn match_velocities(&mut self, state: &mut State) -> Result<(), Error> {
        let still = state.without_motion();
        for elastic in [Elastic::Frozen, Elastic::Moving] {
            let blend = Blend {
                mass: 1.0,
                damping: 0.0,
                stiffness: 0.0,
                elastic,
            };
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
                for (index, body) in self.system.bodies.iter().enumerate() {
                    let step = &self.condensed.step[body.velocities.clone()];
                    let shift =
                        self.evaluation.poses[index].axes * Vector3::from_column_slice(&step[..3]);
                    let velocities = &mut state.velocities[body.velocities.clone()];
                    for (k, velocity) in velocities.iter_mut().enumerate() {
                        *velocity += if k < 3 { shift[k] } else { step[k] };
                    }
                }
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
        count_turns(self.system, &self.evaluation, state);
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
            state.forces[index] = match &row.demand {
                Demand::Answer(_) => self.evaluation.answers[index],
                Demand::Hold(_) | Demand::Follow(_) => self.assembly[index],
            };
        }
        self.evaluation.load(system, state);
        self.evaluation.resist(system, state);
        let blend = Blend {
            mass: 1.0,
            damping: 0.0,
            stiffness: 0.0,
            elastic,
        };
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
            for (index, body) in system.bodies.iter().enumerate() {
                let step = &self.condensed.step[body.velocities.clone()];
                let linear =
                    self.evaluation.poses[index].axes * Vector3::from_column_slice(&step[..3]);
                let accelerations = &mut state.accelerations[body.velocities.clone()];
                for (k, acceleration) in accelerations.iter_mut().enumerate() {
                    *acceleration += if k < 3 { linear[k] } else { step[k] };
                }
            }
            for (index, row) in system.rows.iter().enumerate() {
                if !matches!(row.demand, Demand::Answer(_)) {
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

    /// Rank of the constraints in the metric of the mass: pivots of Λ scaled to a unit diagonal.
    fn find_redundant(&mut self, state: &State, report: &mut InitialReport) -> Result<(), Error> {
        let still = state.without_motion();
        self.refresh_inertia(&still);
        let blend = Blend {
            mass: 1.0,
            damping: 0.0,
            stiffness: 0.0,
            elastic: Elastic::Moving,
        };
        self.condensed
            .factor(self.system, &still, &self.evaluation, &blend, None)?;
        let constraints: Vec<usize> = (0..self.system.rows.len())
            .filter(|row| !matches!(self.system.rows[*row].demand, Demand::Answer(_)))
            .collect();
        let mut lambda =
            self.condensed
                .joint_compliance(self.system, &self.evaluation, &constraints);
        if let Some(flexibility) = row_flexibility(self.system, &self.evaluation) {
            // What interfaces give way to is no redundancy. Both matrices are semi-definite: their weights don't matter.
            let trace =
                |entry: &dyn Fn(usize) -> f64| (0..constraints.len()).map(entry).sum::<f64>();
            let own = trace(&|i| flexibility[(constraints[i], constraints[i])]);
            let weight = trace(&|i| lambda[(i, i)]) / own;
            for (i, row) in constraints.iter().enumerate().filter(|_| own > 0.0) {
                for (j, column) in constraints.iter().enumerate() {
                    lambda[(i, j)] += weight * flexibility[(*row, *column)];
                }
            }
        }
        let dependent = dependent_rows(lambda);
        report.independent_constraints = constraints.len() - dependent.len();
        for position in dependent {
            let connection = self.system.rows[constraints[position]].connection;
            let name = &self.system.connections[connection].name;
            match report.redundant.iter_mut().find(|(known, _)| known == name) {
                Some((_, count)) => *count += 1,
                None => report.redundant.push((name.clone(), 1)),
            }
        }
        Ok(())
    }

    fn moved(&self, before: &State, after: &State) -> Vec<MovedBody> {
        let mut moved = Vec::new();
        for (index, body) in self.system.bodies.iter().enumerate() {
            let translation = (after.origins[index] - before.origins[index]).norm();
            let rotation = before.orientations[index].angle_to(&after.orientations[index]);
            if translation > 1e-9 * self.size || rotation > 1e-7 {
                moved.push(MovedBody {
                    body: body.name.clone(),
                    translation,
                    rotation,
                });
            }
        }
        moved
    }

    fn strained(&self, state: &State) -> Vec<(String, f64)> {
        self.system
            .bodies
            .iter()
            .map(|body| {
                let y = &state.coordinates[body.coordinates.clone()];
                (body.name.clone(), body.flexible.strain_energy(y))
            })
            .filter(|(_, energy)| *energy > 0.0)
            .collect()
    }

    fn sped(&self, before: &[f64], after: &State) -> Vec<MovedBody> {
        let mut sped = Vec::new();
        let part = |i: usize| Vector3::from_column_slice(&after.velocities[i..i + 3]).norm();
        let speed = |body: &Body| {
            let at = body.velocities.start;
            part(at) + body.length * part(at + 3)
        };
        let fastest = self.system.bodies.iter().map(speed).fold(0.0, f64::max);
        for body in &self.system.bodies {
            let at = body.velocities.start;
            let change = |i: usize| {
                Vector3::from_fn(|k, _| after.velocities[at + i + k] - before[at + i + k]).norm()
            };
            let (translation, rotation) = (change(0), change(3));
            if translation + body.length * rotation > 1e-6 * fastest {
                sped.push(MovedBody {
                    body: body.name.clone(),
                    translation,
                    rotation,
                });
            }
        }
        sped
    }
}

/// The state after a time in which its accelerations stay.
pub(crate) fn carried(system: &System, state: &State, time: f64) -> State {
    let mut moved = state.clone();
    moved.time += time;
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

/// Rows of a positive semi-definite matrix that depend on the others: what a Cholesky factorization with diagonal pivoting of the
/// scaled matrix leaves below [`DEPENDENT`].
pub(crate) fn dependent_rows(mut lambda: Mat<f64>) -> Vec<usize> {
    let n = lambda.nrows();
    let scale: Vec<f64> = (0..n)
        .map(|i| {
            let entry = lambda[(i, i)].abs();
            if entry > 0.0 { 1.0 / entry.sqrt() } else { 1.0 }
        })
        .collect();
    for j in 0..n {
        for i in 0..n {
            lambda[(i, j)] *= scale[i] * scale[j];
        }
    }
    let mut left: Vec<usize> = (0..n).collect();
    while !left.is_empty() {
        let Some((position, pivot)) = left
            .iter()
            .map(|i| lambda[(*i, *i)])
            .enumerate()
            .max_by(|a, b| a.1.total_cmp(&b.1))
        else {
            break;
        };
        if pivot <= DEPENDENT {
            break;
        }
        let chosen = left.remove(position);
        for &j in &left {
            let factor = lambda[(chosen, j)] / pivot;
            for &i in &left {
                let change = lambda[(i, chosen)] * factor;
                lambda[(i, j)] -= change;
            }
        }
    }
    left.sort_unstable();
    left
}
