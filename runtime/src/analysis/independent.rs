//! Small motions of a mechanism beside its own, in independent coordinates.
//!
//! With x the variation in body axes that move along (`variation.rs`), the constraints leave
//!
//! ```text
//! x = T ζ          B T = [0, e of the driven rows]
//! x' = T ζ' + T' ζ        B T' = - B' T
//! x'' = T ζ'' + 2 T' ζ' + T'' ζ        B T'' = - 2 B' T' - B'' T
//! ```
//! ζ are amounts of the free directions Z, then the coordinates of driven rows that are let vary. T' and T'' are the least that keep the
//! joints closed; they vanish where body axes see the joints stand still, as at rest and in steady spin. The equations of motion become
//!
//! ```text
//! Zᵀ M T ζ'' + Zᵀ (C T + 2 M T') ζ' + Zᵀ (K T + C T' + M T'') ζ  =  Zᵀ f
//! ```
//! M, C and K are the exact linearization at the state, forces in the joints included. All is that of an instant: about a motion the matrices
//! change with time, unless body axes see the motion stand still.

use faer::Mat;
use faer::linalg::solvers::DenseSolveCore;
use nalgebra::RowVector3;

use super::variation::{Variation, derivative};
use crate::error::Error;
use crate::system::evaluation::Evaluation;
use crate::system::free_directions::FreeDirections;
use crate::system::linearization::Linearization;
use crate::system::state::rates;
use crate::system::{State, System};

/// What differences find in constraints that don't change, as a part of what changing ones would have.
const DIFFERENCES: f64 = 1e-9;
/// The step of differences, as a part of a body's length or in radians.
pub(crate) const STEP: f64 = 3e-4;
/// A driven row that moves by less than this for one asked for is held by others.
const HELD: f64 = 1e-6;

/// A mechanism at a state in independent coordinates, N being the length of velocity arrays, k the number of coordinates.
pub struct IndependentMotion {
    /// Free directions Z, and forces of constraints.
    pub directions: FreeDirections,
    /// M, C, K over x, x', x'', (N, N), and the constraints.
    pub linearization: Linearization,
    /// T, (N, k): the free directions, then the driven rows.
    pub places: Mat<f64>,
    /// T', (N, k).
    pub rates: Mat<f64>,
    /// T'', (N, k).
    pub second_rates: Mat<f64>,
    /// Amounts of the free directions that are about as large as each other.
    pub(crate) units: Vec<f64>,
}

impl IndependentMotion {
    /// At a consistent state. `driven` are the constraints that may vary, by row of the system: those of drives.
    ///
    /// # Errors
    /// Those of [`Linearization::with_rigid_joints`]; [`Error::NoEigenvalues`]; [`Error::Description`] for a drive that can't vary by itself.
    pub fn at(system: &System, state: &State, driven: &[usize]) -> Result<Self, Error> {
        let evaluation = Evaluation::at(system, state);
        let mut linearization = Linearization::with_rigid_joints(system, state, &evaluation)?;
        let directions = FreeDirections::of(system, &linearization.jacobian)?;
        turn_with_bodies(system, state, &mut linearization);
        let (n, free) = (system.velocity_count(), directions.count());
        let mut places = Mat::zeros(n, free + driven.len());
        places
            .as_mut()
            .subcols_mut(0, free)
            .copy_from(&directions.basis);
        for (index, row) in driven.iter().enumerate() {
            let place = linearization.constraints.iter().position(|own| own == row);
            let mut change = vec![0.0; linearization.constraints.len()];
            if let Some(place) = place {
                change[place] = 1.0;
            }
            let motion = directions.closing(&change);
            for (i, entry) in motion.iter().enumerate() {
                places[(i, free + index)] = *entry;
            }
            let found = &linearization.jacobian * places.col(free + index);
            let misfit = (0..change.len())
                .map(|i| directions.row_scale[i] * (found[i] - change[i]).abs())
                .fold(0.0, f64::max);
            if misfit > HELD * place.map_or(0.0, |place| directions.row_scale[place]) {
                let name = &system.connections[system.rows[*row].connection].name;
                return Err(Error::described(
                    format!("drives.{name}"),
                    "can't be an input: the joints and the other drives hold what it drives; leave it out of the inputs, or leave a drive out of the scene",
                ));
            }
        }
        let (rates, second_rates) = carried(system, state, &directions, &linearization, &places);
        Ok(Self {
            directions,
            linearization,
            places,
            rates,
            second_rates,
            units: vec![1.0; free],
        })
    }

    /// Number of free directions.
    pub fn free_count(&self) -> usize {
        self.directions.count()
    }

    /// Zᵀ M T, Zᵀ (C T + 2 M T') and Zᵀ (K T + C T' + M T''), (free, k) each.
    pub fn reduced(&self) -> [Mat<f64>; 3] {
        let Linearization {
            mass,
            damping,
            stiffness,
            ..
        } = &self.linearization;
        let z = self.places.as_ref().subcols(0, self.free_count());
        let inertia = mass * &self.places;
        let rate = damping * &self.places + faer::Scale(2.0) * (mass * &self.rates);
        let place = stiffness * &self.places + damping * &self.rates + mass * &self.second_rates;
        [inertia, rate, place].map(|matrix| z.transpose() * matrix)
    }

    /// Makes chosen coordinates of the bodies the amounts of the free directions, at all times: `x_I = z`, as many as there are free directions,
    /// by their places in velocity arrays. Driven rows don't move them.
    ///
    /// # Errors
    /// [`Error::NoEigenvalues`] for coordinates that don't determine the motion.
    pub fn follow(&mut self, chosen: &[usize]) -> Result<(), Error> {
        let (free, k) = (self.free_count(), self.places.ncols());
        let own = |matrix: &Mat<f64>, below: f64| {
            Mat::from_fn(k, k, |i, j| match chosen.get(i) {
                Some(row) => matrix[(*row, j)],
                None => below * f64::from(u8::from(i == j)),
            })
        };
        // ζ = G z: G₀ first, then what it changes by.
        let by = own(&self.places, 1.0).partial_piv_lu().inverse();
        if by
            .col_iter()
            .any(|column| column.iter().any(|x| !x.is_finite()))
        {
            return Err(Error::NoEigenvalues);
        }
        for matrix in [&mut self.places, &mut self.rates, &mut self.second_rates] {
            *matrix = &*matrix * &by;
        }
        let (first, second) = (own(&self.rates, 0.0), own(&self.second_rates, 0.0));
        let curved = faer::Scale(2.0) * (&first * &first) - second;
        self.second_rates =
            &self.second_rates - faer::Scale(2.0) * (&self.rates * &first) + &self.places * curved;
        self.rates = &self.rates - &self.places * &first;
        self.directions.basis = self.places.as_ref().subcols(0, free).to_owned();
        self.units = (chosen.iter())
            .map(|row| self.directions.scale[*row])
            .collect();
        Ok(())
    }
}

/// T' and T''.
fn carried(
    system: &System,
    state: &State,
    directions: &FreeDirections,
    linearization: &Linearization,
    places: &Mat<f64>,
) -> (Mat<f64>, Mat<f64>) {
    let zero = Mat::zeros(places.nrows(), places.ncols());
    let (rate, second_rate) = (
        size(system, &state.velocities),
        size(system, &state.accelerations),
    );
    if rate == 0.0 && second_rate == 0.0 {
        return (zero.clone(), zero);
    }
    let rows = &linearization.constraints;
    let mut evaluation = Evaluation::of(system);
    let mut of_rows = |varied: &State, second: bool| -> Vec<f64> {
        evaluation.place(system, varied);
        evaluation.add_velocities(system, varied);
        evaluation.add_accelerations(system, varied);
        let value = |row: &usize| match second {
            false => evaluation.rate(system, *row),
            true => evaluation.second_rate(system, *row),
        };
        rows.iter().map(value).collect()
    };
    let (mut first, mut second) = (zero.clone(), zero);
    let columns =
        |matrix: &Mat<f64>, k: usize| -> Vec<f64> { matrix.col(k).iter().copied().collect() };
    for k in 0..places.ncols() {
        let place = columns(places, k);
        let step = STEP / size(system, &place);
        let length = scaled_size(directions, &place);
        if !step.is_finite() {
            continue;
        }
        let mut closing = |is_second: bool, rates: &[f64], natural: f64| -> Vec<f64> {
            let variation = Variation {
                place: &place,
                rate: rates,
                second_rate: &[],
                forces: &[],
            };
            let change = derivative(step, |amount| {
                of_rows(&variation.applied(system, state, amount), is_second)
            });
            let limit = DIFFERENCES * natural * length;
            let change: Vec<f64> = change
                .iter()
                .zip(&directions.row_scale)
                .map(|(change, scale)| match (scale * change).abs() > limit {
                    true => -change,
                    false => 0.0,
                })
                .collect();
            directions.closing(&change)
        };
        let rates = closing(false, &[], rate);
        let seconds = closing(true, &rates, rate * rate + second_rate);
        for i in 0..places.nrows() {
            first[(i, k)] = rates[i];
            second[(i, k)] = seconds[i];
        }
    }
    (first, second)
}

/// |D⁻¹ x| at most, a length.
fn scaled_size(directions: &FreeDirections, x: &[f64]) -> f64 {
    let scaled = x.iter().zip(&directions.scale);
    scaled
        .map(|(x, scale)| if *scale > 0.0 { x.abs() / scale } else { 0.0 })
        .fold(0.0, f64::max)
}

/// The largest motion of a body, or its rate: translations and deflections as parts of its length, rotations in radians.
pub(crate) fn size(system: &System, motion: &[f64]) -> f64 {
    let mut largest = 0.0_f64;
    for body in &system.bodies {
        let mass = body.flexible.inertia.mass().sqrt();
        for (k, value) in motion[body.velocities.clone()].iter().enumerate() {
            let unit = match k {
                0..3 => body.length,
                3..6 => 1.0,
                _ => mass * body.length,
            };
            largest = largest.max(value.abs() / unit);
        }
    }
    largest
}

/// Adds to C and K that velocities follow the positions' variations in turning axes: with x the variation in body axes and W the
/// spin's cross product,
///
/// ```text
/// translations   Aᵀ δV = x' + W x,   Aᵀ δV' = x'' + 2 W x' + (W² + W') x
/// rotations         δω = x' + W x,      δω' = x'' + W x' + W' x
/// ```
fn turn_with_bodies(system: &System, state: &State, linearization: &mut Linearization) {
    for body in &system.bodies {
        let spin = rates(&state.velocities[body.velocities.clone()])
            .angular
            .cross_matrix();
        let spin_rate = rates(&state.accelerations[body.velocities.clone()])
            .angular
            .cross_matrix();
        for (first, velocity, place) in [
            (0, spin * 2.0, spin * spin + spin_rate),
            (3, spin, spin_rate),
        ] {
            let first = body.velocities.start + first;
            for row in 0..system.velocity_count() {
                let part = |matrix: &Mat<f64>| RowVector3::from_fn(|_, k| matrix[(row, first + k)]);
                let (mass, damping) = (part(&linearization.mass), part(&linearization.damping));
                let of_rate = mass * velocity;
                let of_place = mass * place + damping * spin;
                for k in 0..3 {
                    linearization.damping[(row, first + k)] += of_rate[k];
                    linearization.stiffness[(row, first + k)] += of_place[k];
                }
            }
        }
    }
}
