//! A consistent start: positions that close the joints, velocities and accelerations that keep them closed.
//!
//! Each level solves for the smallest change, in the metric of the mass, that meets the constraints:
//!
//! ```text
//! positions      e(q) - f(t) = 0             Newton, δq = M⁻¹ Bᵀ (B M⁻¹ Bᵀ)⁻¹ (-h); first the bodies as rigid ones
//! velocities     B q' = f'
//! accelerations  M q'' - Bᵀ λ = -(forces),  B q'' + (B)' q' = f''
//! ```
//! Bodies move as rigid ones first; only where that can't close a joint they deflect, by the least strain energy.

use faer::Mat;
use nalgebra::{UnitQuaternion, Vector3};

use crate::error::Error;
use crate::system::body_factor::Elastic;
use crate::system::condensed::{Blend, Condensed};
use crate::system::evaluation::Evaluation;
use crate::system::{Demand, State, System};

/// How far constraints may stay open, relative to the size of the mechanism.
const CLOSED: f64 = 1e-12;
/// How far a misfit may stay open before a scene is refused.
const OPEN: f64 = 1e-8;
/// Largest turn that one iteration of an assembly makes.
const LARGEST_TURN: f64 = 0.5;
/// Iterations of an assembly.
const ITERATIONS: usize = 60;
/// Keeps the joints' system regular where constraints are redundant: a compliance of this part of what a step's inertia gives way.
/// The start iterates it away; steps keep it, so that redundant forces are determined.
pub const REGULARIZATION: f64 = 1e-10;
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
    /// Extent of the mechanism.
    size: f64,
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
            size: system.bodies.iter().map(|b| b.length).sum(),
        })
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
        state.algorithmic.copy_from_slice(&state.accelerations);
        Ok(report)
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
        let mut closed = self.close_with(state, Elastic::Frozen)?;
        if !closed && self.system.coordinate_count() > 0 {
            closed = self.close_with(state, Elastic::Moving)?;
        }
        let (worst, misfit) = self.worst_row();
        if closed || misfit <= OPEN {
            return Ok(());
        }
        let connection = &self.system.connections[self.system.rows[worst].connection];
        Err(Error::CannotAssemble {
            joint: connection.name.clone(),
            misfit: self.evaluation.answers[worst],
            allowed: OPEN * self.size,
        })
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
            self.condensed
                .solve(self.system, &self.evaluation, &self.changes, &forces);
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
                self.condensed
                    .solve(self.system, &self.evaluation, &self.changes, &self.zeros);
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
        let system = self.system;
        state.accelerations.fill(0.0);
        self.evaluation.place(system, state);
        self.evaluation.add_velocities(system, state);
        self.evaluation.measure(system, state);
        for (index, row) in system.rows.iter().enumerate() {
            state.forces[index] = match &row.demand {
                Demand::Answer(_) => self.evaluation.answers[index],
                Demand::Hold(_) | Demand::Follow(_) => 0.0,
            };
        }
        self.evaluation.load(system, state);
        self.evaluation.resist(system, state);
        let blend = Blend {
            mass: 1.0,
            damping: 0.0,
            stiffness: 0.0,
            elastic: Elastic::Moving,
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
        let lambda = self
            .condensed
            .joint_compliance(self.system, &self.evaluation, &constraints);
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
        for body in &self.system.bodies {
            let at = body.velocities.start;
            let change = |i: usize| {
                Vector3::from_fn(|k, _| after.velocities[at + i + k] - before[at + i + k]).norm()
            };
            let size = |i: usize| Vector3::from_fn(|k, _| after.velocities[at + i + k]).norm();
            let (translation, rotation) = (change(0), change(3));
            let speed = size(0) + body.length * size(3);
            if translation + body.length * rotation > 1e-6 * speed {
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

/// Rows of a positive semi-definite matrix that depend on the others: what a Cholesky factorization with diagonal pivoting of the
/// scaled matrix leaves below [`DEPENDENT`].
fn dependent_rows(mut lambda: Mat<f64>) -> Vec<usize> {
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
