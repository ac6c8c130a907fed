//! Static equilibrium: where a mechanism stays at rest, and the forces in its joints there.
//!
//! Newton's method on the exact linearization, kept from running uphill by pseudo-time (Kelley and Keyes 1998). Along the free
//! directions Z of the joints, with the joints' forces λ those of least norm that balance the rest,
//!
//! ```text
//! Zᵀ (K + μ M) Z z = -Zᵀ (r + K δq_h),     δq = δq_h + Z z,     B δq_h = -h
//! ```
//! μ is zero where the rest is near and stable. Where the mechanism's stiffness is negative, as that of a pendulum above its
//! pivot, μ exceeds it twofold, so that every step goes downhill and unstable rests are left behind. Where a step would turn a body
//! far, or makes the imbalance grow, μ rises.

use dcb_dense::symmetric_eigenvalues;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use nalgebra::Vector3;

use crate::error::Error;
use crate::initial::Starter;
use crate::system::evaluation::Evaluation;
use crate::system::free_directions::FreeDirections;
use crate::system::linearization::Linearization;
use crate::system::{State, System};
use dcb_formats::scene::RedundantConstraints;

/// Largest turn of a body in one iteration.
const LARGEST_TURN: f64 = 0.5;
/// A step that makes the imbalance grow by more than this is taken back.
const GROWTH: f64 = 2.0;
/// Stiffness below this part of the largest is rounding.
const ROUNDING: f64 = 1e-13;

/// When a rest is good enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EquilibriumSettings {
    /// The last correction, relative to the size of the mechanism.
    pub tolerance: f64,
    /// Iterations after which the search has failed.
    pub max_iterations: usize,
}

impl Default for EquilibriumSettings {
    fn default() -> Self {
        Self {
            tolerance: 1e-10,
            max_iterations: 200,
        }
    }
}

/// How a rest was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EquilibriumReport {
    /// Iterations made.
    pub iterations: usize,
    /// Size of the last correction, a length.
    pub correction: f64,
    /// The smallest stiffness over mass along the free directions, 1/time²; infinite if nothing is free, zero for a rest that is
    /// indifferent, like that of a body that nothing holds.
    pub least_stiffness: f64,
}

/// Closes the joints and takes all motion away.
///
/// # Errors
/// Those of [`Starter::start`].
pub(super) fn lay_to_rest(system: &System, state: &mut State) -> Result<(), Error> {
    Starter::of(system)?.start(state, RedundantConstraints::MinimumNorm)?;
    for values in [
        &mut state.velocities,
        &mut state.accelerations,
        &mut state.algorithmic,
    ] {
        values.fill(0.0);
    }
    state.earlier_step = 0.0;
    Ok(())
}

/// Moves `state` to a stable rest near it, at the state's time: no velocities, no accelerations, λ in `forces`.
///
/// # Errors
/// [`Error::NoEquilibrium`]; those of [`Starter::start`] if the joints can't be closed; [`Error::NoEigenvalues`].
pub fn find_equilibrium(
    system: &System,
    state: &mut State,
    settings: &EquilibriumSettings,
) -> Result<EquilibriumReport, Error> {
    lay_to_rest(system, state)?;
    let size: f64 = system.bodies.iter().map(|body| body.length).sum();
    let allowed = settings.tolerance * size;
    let mut evaluation = Evaluation::of(system);
    let mut balance = Balance::at(system, state, &mut evaluation)?;
    let mut damping = 0.0;
    let mut last = (f64::INFINITY, String::new());
    let mut made = 0;
    for iterations in 1..=settings.max_iterations {
        made = iterations;
        let (motion, shift) = balance.step(system, &mut damping)?;
        if !shift.0.is_finite() {
            last = shift;
            break;
        }
        let mut next = moved(system, state, &motion);
        let found = Balance::at(system, &mut next, &mut evaluation)?;
        // The imbalance of a rest that is nearly reached is rounding.
        if found.imbalance > GROWTH * balance.imbalance && shift.0 > allowed {
            damping = f64::max(4.0 * damping, balance.least_scale());
            continue;
        }
        state.copy_from(&next);
        evaluation.count_turns(system, state);
        balance = found;
        let undamped = damping <= 0.0;
        damping = if damping > 0.01 * balance.least_scale() {
            0.25 * damping
        } else {
            0.0
        };
        if undamped && shift.0 <= allowed && balance.curvature >= -balance.rounding {
            return Ok(EquilibriumReport {
                iterations,
                correction: shift.0,
                least_stiffness: if balance.curvature.abs() <= balance.rounding {
                    0.0
                } else {
                    balance.curvature
                },
            });
        }
        last = shift;
    }
    Err(Error::NoEquilibrium {
        time: state.time,
        iterations: made,
        residual: last.0,
        tolerance: allowed,
        body: last.1,
        connection: most_loaded(system, state),
    })
}

/// Forces and stiffness at one configuration.
struct Balance {
    directions: FreeDirections,
    linearization: Linearization,
    stiffness: Mat<f64>,
    mass: Mat<f64>,
    /// r, constraint forces included.
    residual: Vec<f64>,
    /// -h of the constraints.
    changes: Vec<f64>,
    /// Size of Zᵀ r in the metric of the mass: an acceleration by √mass.
    imbalance: f64,
    /// Smallest stiffness over mass.
    curvature: f64,
    /// Largest stiffness over mass, that of the imbalance over the size of the bodies included.
    largest: f64,
    rounding: f64,
}

impl Balance {
    fn at(system: &System, state: &mut State, evaluation: &mut Evaluation) -> Result<Self, Error> {
        state.forces.fill(0.0);
        balance_springs(system, state, evaluation);
        let unloaded = Linearization::with_rigid_joints(system, state, evaluation)?;
        let directions = FreeDirections::of(system, &unloaded.jacobian)?;
        let reactions = directions.reactions(&evaluation.residual);
        for (row, force) in unloaded.constraints.iter().zip(reactions) {
            state.forces[*row] = force;
        }
        evaluation.load(system, state);
        evaluation.resist(system, state);
        let linearization = Linearization::with_rigid_joints(system, state, evaluation)?;
        let stiffness = directions.reduce(&linearization.stiffness);
        let mass = directions.reduce(&linearization.mass);
        let components = directions.components(&evaluation.residual);
        let (mut curvature, mut largest, mut imbalance) = (f64::INFINITY, 0.0_f64, 0.0);
        if directions.count() > 0 {
            let root = mass.llt(Side::Lower).map_err(|_| Error::NoEigenvalues)?;
            let lower = root.L();
            let half = |matrix: &Mat<f64>| {
                let mut half = matrix.clone();
                faer::linalg::triangular_solve::solve_lower_triangular_in_place(
                    lower,
                    half.as_mut(),
                    faer::Par::Seq,
                );
                half
            };
            let symmetric = &stiffness + stiffness.transpose();
            let relative = half(&half(&symmetric).transpose().to_owned());
            let values = symmetric_eigenvalues(relative.as_ref()).ok_or(Error::NoEigenvalues)?;
            for value in values {
                curvature = curvature.min(0.5 * value);
                largest = largest.max(0.5 * value.abs());
            }
            let forces = Mat::from_fn(components.len(), 1, |i, _| components[i]);
            imbalance = half(&forces).norm_l2();
        }
        // Where nothing is stiff, as in a pendulum that lies level, forces alone tell a scale.
        let reach = system
            .bodies
            .iter()
            .map(|body| body.length * body.flexible.inertia.mass().sqrt())
            .sum::<f64>();
        if reach > 0.0 {
            largest = largest.max(imbalance / reach);
        }
        let changes = linearization.constraints.iter();
        Ok(Self {
            changes: changes.map(|row| -evaluation.answers[*row]).collect(),
            directions,
            stiffness,
            mass,
            residual: evaluation.residual.clone(),
            imbalance,
            curvature,
            largest,
            rounding: ROUNDING * largest,
            linearization,
        })
    }

    /// A stiffness over mass that is small but not rounding.
    fn least_scale(&self) -> f64 {
        self.curvature
            .abs()
            .clamp(100.0 * self.rounding, self.largest)
    }

    /// The motion of an iteration, its size and the body that it moves most; raises the damping until no body turns far.
    fn step(&self, system: &System, damping: &mut f64) -> Result<(Vec<f64>, (f64, String)), Error> {
        let closing = self.directions.closing(&self.changes);
        let stiffness = &self.linearization.stiffness;
        let mut forces = self.residual.clone();
        for (force, row) in forces.iter_mut().zip(stiffness.row_iter()) {
            *force += row.iter().zip(&closing).map(|(k, q)| k * q).sum::<f64>();
        }
        let components = self.directions.components(&forces);
        let right = Mat::from_fn(components.len(), 1, |i, _| -components[i]);
        let lifted = if self.curvature < -self.rounding {
            -2.0 * self.curvature
        } else if self.curvature < self.rounding {
            2.0 * self.rounding
        } else {
            0.0
        };
        loop {
            let mut motion = closing.clone();
            if self.directions.count() > 0 {
                let lift = lifted + *damping;
                let matrix = Mat::from_fn(right.nrows(), right.nrows(), |i, j| {
                    self.stiffness[(i, j)] + lift * self.mass[(i, j)]
                });
                let amounts = matrix.partial_piv_lu().solve(&right);
                let amounts: Vec<f64> = (0..right.nrows()).map(|i| amounts[(i, 0)]).collect();
                self.directions.add_motion(&amounts, &mut motion);
            }
            let shift = largest_shift(system, &motion);
            let turn = system
                .bodies
                .iter()
                .map(|body| three(&motion, body.velocities.start + 3));
            let turn = turn.fold(0.0, |most: f64, turn| most.max(turn.norm()));
            if turn <= LARGEST_TURN || !shift.0.is_finite() || *damping > 1e6 * self.largest {
                return Ok((motion, shift));
            }
            *damping = f64::max(4.0 * *damping, self.least_scale());
        }
    }
}

/// Everything at a state at rest; springs take their forces from their laws.
pub(super) fn balance_springs(system: &System, state: &mut State, evaluation: &mut Evaluation) {
    evaluation.place(system, state);
    evaluation.add_velocities(system, state);
    evaluation.measure(system, state);
    for (index, row) in system.rows.iter().enumerate() {
        if !row.is_constraint() {
            state.forces[index] = evaluation.answers[index];
        }
    }
    evaluation.load(system, state);
    evaluation.resist(system, state);
}

/// The state with its positions moved by δq.
pub(super) fn moved(system: &System, state: &State, motion: &[f64]) -> State {
    let mut moved = state.clone();
    moved.shift(system, motion);
    moved
}

/// The largest motion of a body as a length, and its name.
pub(super) fn largest_shift(system: &System, motion: &[f64]) -> (f64, String) {
    let mut largest = (0.0, String::new());
    for body in &system.bodies {
        let at = body.velocities.start;
        let deflection = motion[at + 6..body.velocities.end]
            .iter()
            .map(|y| y * y)
            .sum::<f64>();
        let size = three(motion, at).norm()
            + body.length * three(motion, at + 3).norm()
            + (deflection / body.flexible.inertia.mass()).sqrt();
        if size > largest.0 || size.is_nan() {
            largest = (size, body.name.clone());
        }
    }
    largest
}

fn most_loaded(system: &System, state: &State) -> String {
    let force = |row: &usize| state.forces[*row].abs();
    (0..system.rows.len())
        .max_by(|a, b| force(a).total_cmp(&force(b)))
        .map_or_else(String::new, |row| {
            system.connections[system.rows[row].connection].name.clone()
        })
}

fn three(values: &[f64], first: usize) -> Vector3<f64> {
    Vector3::from_column_slice(&values[first..first + 3])
}
