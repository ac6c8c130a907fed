//! A mechanism that isn't held, at rest in the frame that its loads accelerate: inertia relief.
//!
//! Of the motions Z that joints leave, R meet no stiffness of bodies and springs, and E, mass-orthogonal to R, do. Loads are balanced by
//! the inertia of accelerations R α; deflections are those along E:
//!
//! ```text
//! Zᵀ (r + M R α)  =  0,        r: elastic - applied forces, the joints' forces balanced
//! ```
//! Frames stay where they were in the mean that masses weight. Nothing moves yet: the accelerations are those of a release from rest, and
//! the deflections those after vibrations died out, before the mechanism has gone anywhere.

use faer::Mat;
use faer::linalg::solvers::Solve;
use nalgebra::Vector3;

use super::eigenmodes::undamped;
use super::equilibrium::{EquilibriumSettings, balance_springs, largest_shift, lay_to_rest, moved};
use crate::error::Error;
use crate::system::evaluation::Evaluation;
use crate::system::free_directions::FreeDirections;
use crate::system::linearization::Linearization;
use crate::system::{Demand, State, System};

/// How an accelerated rest was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InertiaReliefReport {
    /// Iterations made.
    pub iterations: usize,
    /// Size of the last correction, a length.
    pub correction: f64,
    /// Motions without stiffness, which the loads accelerate.
    pub free_count: usize,
}

/// Moves `state` to the accelerated rest near it: no velocities, the accelerations of frames, λ in `forces`.
///
/// # Errors
/// [`Error::NoEquilibrium`]; [`Error::Description`] where every motion meets stiffness; those of a start if the joints
/// can't be closed; [`Error::NoEigenvalues`].
pub fn find_inertia_relief(
    system: &System,
    state: &mut State,
    settings: &EquilibriumSettings,
) -> Result<InertiaReliefReport, Error> {
    lay_to_rest(system, state)?;
    let size: f64 = system.bodies.iter().map(|body| body.length).sum();
    let allowed = settings.tolerance * size;
    let mut evaluation = Evaluation::of(system);
    // Not by amounts of R: its columns may change places from one iteration to the next.
    let mut acceleration = vec![0.0; system.velocity_count()];
    let mut last = (f64::INFINITY, String::new());
    for iterations in 1..=settings.max_iterations {
        let motions = Motions::at(system, state)?;
        let free_count = motions.free.ncols();
        if free_count == 0 {
            return Err(Error::described(
                "analysis",
                "is \"inertia_relief\", but every motion of the mechanism meets stiffness; use \"static\"",
            ));
        }
        accelerate(system, state, &acceleration);
        let linear = balance(system, state, &mut evaluation, &motions.directions)?;
        let (shift, change) = step(&motions, &linear, &evaluation);
        last = largest_shift(system, &shift);
        if !last.0.is_finite() {
            break;
        }
        for (entry, added) in (acceleration.iter_mut()).zip(times(&motions.free, &change)) {
            *entry += added;
        }
        *state = moved(system, state, &shift);
        evaluation.count_turns(system, state);
        if last.0 <= allowed {
            let motions = Motions::at(system, state)?;
            accelerate(system, state, &acceleration);
            balance(system, state, &mut evaluation, &motions.directions)?;
            return Ok(InertiaReliefReport {
                iterations,
                correction: last.0,
                free_count,
            });
        }
    }
    Err(Error::NoEquilibrium {
        time: state.time,
        iterations: settings.max_iterations,
        residual: last.0,
        tolerance: allowed,
        body: last.1,
        connection: String::new(),
    })
}

/// Motions that the joints leave.
struct Motions {
    directions: FreeDirections,
    /// R, (N, free): no stiffness of bodies and springs.
    free: Mat<f64>,
    /// E, (N, others).
    stiff: Mat<f64>,
}

impl Motions {
    fn at(system: &System, state: &State) -> Result<Self, Error> {
        let still = state.without_motion();
        let mut evaluation = Evaluation::at(system, &still);
        let linear = Linearization::with_rigid_joints(system, &still, &evaluation)?;
        let directions = FreeDirections::of(system, &linear.jacobian)?;
        let count = directions.count();
        if count == 0 {
            return Ok(Self {
                directions,
                free: Mat::zeros(system.velocity_count(), 0),
                stiff: Mat::zeros(system.velocity_count(), 0),
            });
        }
        // Elongations of everything stiff along each direction, each by the root of its stiffness.
        let mut columns = Vec::new();
        let mut moving = still.clone();
        for direction in 0..count {
            let mut unit = vec![0.0; count];
            unit[direction] = 1.0;
            let mut motion = vec![0.0; system.velocity_count()];
            directions.add_motion(&unit, &mut motion);
            moving
                .velocities
                .copy_from_slice(&in_world(system, &still, &motion));
            evaluation.add_velocities(system, &moving);
            let mut elongations = Vec::new();
            for body in &system.bodies {
                let y = &motion[body.velocities.clone()][6..];
                let stiffness = body.flexible.stiffness.iter();
                elongations.extend(stiffness.zip(y).map(|(k, y)| k.sqrt() * y));
            }
            for (index, row) in system.rows.iter().enumerate() {
                if let Demand::Answer(law) = &row.demand {
                    let slope = law.derivatives(evaluation.values[index], 0.0).0.abs();
                    elongations.push(slope.sqrt() * evaluation.rate(system, index));
                }
            }
            columns.push(elongations);
        }
        let elongations = Mat::from_fn(columns[0].len(), count, |i, j| columns[j][i]);
        let stiffness = elongations.transpose() * &elongations;
        let modes = undamped(&directions.reduce(&linear.mass), &stiffness)?;
        let (free, stiff): (Vec<_>, Vec<_>) =
            (modes.into_iter()).partition(|mode| mode.angular_frequency == 0.0);
        let motions = |modes: Vec<super::eigenmodes::Eigenmode>| {
            let mut all = Mat::zeros(system.velocity_count(), modes.len());
            for (column, mode) in all.col_iter_mut().zip(modes) {
                let mut motion = vec![0.0; system.velocity_count()];
                directions.add_motion(&mode.shape, &mut motion);
                for (entry, motion) in column.iter_mut().zip(motion) {
                    *entry = motion;
                }
            }
            all
        };
        let (free, stiff) = (motions(free), motions(stiff));
        Ok(Self {
            directions,
            free,
            stiff,
        })
    }
}

/// Deflection and change of α of one iteration.
fn step(
    motions: &Motions,
    linear: &Linearization,
    evaluation: &Evaluation,
) -> (Vec<f64>, Vec<f64>) {
    let directions = &motions.directions;
    let constraints = linear.constraints.iter();
    let changes: Vec<f64> = constraints.map(|row| -evaluation.answers[*row]).collect();
    let mut shift = directions.closing(&changes);
    let mut forces = evaluation.residual.clone();
    for (force, row) in forces.iter_mut().zip(linear.stiffness.row_iter()) {
        *force += row.iter().zip(&shift).map(|(k, q)| k * q).sum::<f64>();
    }
    let right = directions.components(&forces);
    let (stiff, free) = (motions.stiff.ncols(), motions.free.ncols());
    let by_column = [
        &linear.stiffness * &motions.stiff,
        &linear.mass * &motions.free,
    ];
    let mut matrix = Mat::zeros(right.len(), stiff + free);
    let columns = by_column.iter().flat_map(|block| block.col_iter());
    for (into, column) in matrix.col_iter_mut().zip(columns) {
        let column: Vec<f64> = column.iter().copied().collect();
        let components = directions.components(&column);
        into.iter_mut()
            .zip(components)
            .for_each(|(into, found)| *into = found);
    }
    let right = Mat::from_fn(right.len(), 1, |i, _| -right[i]);
    let found = matrix.partial_piv_lu().solve(&right);
    let found: Vec<f64> = found.col(0).iter().copied().collect();
    for (entry, added) in shift.iter_mut().zip(times(&motions.stiff, &found[..stiff])) {
        *entry += added;
    }
    (shift, found[stiff..].to_vec())
}

/// Residual with the joints' forces that balance it, and the linearization there.
fn balance(
    system: &System,
    state: &mut State,
    evaluation: &mut Evaluation,
    directions: &FreeDirections,
) -> Result<Linearization, Error> {
    state.forces.fill(0.0);
    balance_springs(system, state, evaluation);
    let reactions = directions.reactions(&evaluation.residual);
    for (row, force) in system.constraints().iter().zip(reactions) {
        state.forces[*row] = force;
    }
    evaluation.load(system, state);
    evaluation.resist(system, state);
    Linearization::with_rigid_joints(system, state, evaluation)
}

/// Sets accelerations, given with translations in body axes.
fn accelerate(system: &System, state: &mut State, motion: &[f64]) {
    let world = in_world(system, state, motion);
    state.accelerations.copy_from_slice(&world);
    state.algorithmic.copy_from_slice(&world);
}

/// A motion with its translations in world axes.
fn in_world(system: &System, state: &State, motion: &[f64]) -> Vec<f64> {
    let mut turned = motion.to_vec();
    for (index, body) in system.bodies.iter().enumerate() {
        let own = &mut turned[body.velocities.clone()];
        let world = state.pose(index).axes * Vector3::from_column_slice(&own[..3]);
        own[..3].copy_from_slice(world.as_slice());
    }
    turned
}

/// `A x`
fn times(matrix: &Mat<f64>, x: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; matrix.nrows()];
    for (column, x) in matrix.col_iter().zip(x) {
        for (sum, entry) in product.iter_mut().zip(column.iter()) {
            *sum += x * entry;
        }
    }
    product
}
