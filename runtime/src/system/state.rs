//! The motion at one time.

use nalgebra::{UnitQuaternion, Vector3};

use super::System;
use super::marker::{BodyPose, BodyRates};

/// Positions, velocities, accelerations and forces at one time; everything that the next step starts from.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Time.
    pub time: f64,
    /// Rounding of the summed time: the sum of both is the time.
    pub time_rest: f64,
    /// R of each body: centre of mass at rest, world.
    pub origins: Vec<Vector3<f64>>,
    /// Orientation of each body frame.
    pub orientations: Vec<UnitQuaternion<f64>>,
    /// y of all bodies.
    pub coordinates: Vec<f64>,
    /// V, ω, y' of all bodies.
    pub velocities: Vec<f64>,
    /// V', ω', y'' of all bodies.
    pub accelerations: Vec<f64>,
    /// The algorithmic accelerations of generalized-alpha.
    pub algorithmic: Vec<f64>,
    /// λ of each row.
    pub forces: Vec<f64>,
    /// The accelerations of the step before, for the prediction of the next.
    pub earlier_accelerations: Vec<f64>,
    /// The λ of the step before.
    pub earlier_forces: Vec<f64>,
    /// The size of the last step; zero at the start.
    pub earlier_step: f64,
    /// u_Γ beside the coordinates, by rows: what the residual flexibility of bodies without coordinates for it gives. Rows of
    /// other bodies stay zero.
    pub residual_displacements: Vec<f64>,
    /// Their rates.
    pub residual_rates: Vec<f64>,
    /// Their algorithmic accelerations.
    pub residual_accelerations: Vec<f64>,
    /// Largest deflection of each body so far, a length, where steps follow an accuracy.
    pub deflections: Vec<f64>,
    /// Largest forces that deflect each body so far, there: a norm, by √mass.
    pub body_forces: Vec<f64>,
    /// Angles counted past half a turn.
    pub angles: Vec<f64>,
    /// Values of the inputs.
    pub inputs: Vec<f64>,
    /// Values of the inputs that the accelerations and forces belong to.
    pub felt_inputs: Vec<f64>,
    /// What actuators remember.
    pub memory: Vec<f64>,
}

impl State {
    /// All bodies at the world's origin, at rest.
    pub fn at_rest(system: &System) -> Self {
        let (bodies, n) = (system.bodies.len(), system.velocity_count());
        Self {
            time: 0.0,
            time_rest: 0.0,
            origins: vec![Vector3::zeros(); bodies],
            orientations: vec![UnitQuaternion::identity(); bodies],
            coordinates: vec![0.0; system.coordinate_count()],
            velocities: vec![0.0; n],
            accelerations: vec![0.0; n],
            algorithmic: vec![0.0; n],
            forces: vec![0.0; system.rows.len()],
            earlier_accelerations: vec![0.0; n],
            earlier_forces: vec![0.0; system.rows.len()],
            earlier_step: 0.0,
            residual_displacements: vec![0.0; system.residual_row_count()],
            residual_rates: vec![0.0; system.residual_row_count()],
            residual_accelerations: vec![0.0; system.residual_row_count()],
            deflections: vec![0.0; bodies],
            body_forces: vec![0.0; bodies],
            angles: vec![0.0; system.angle_count],
            inputs: system.inputs.iter().map(|(_, value)| *value).collect(),
            felt_inputs: system.inputs.iter().map(|(_, value)| *value).collect(),
            memory: vec![0.0; system.memory_count],
        }
    }

    /// Overwrites without allocating; both belong to the same system.
    pub fn copy_from(&mut self, other: &Self) {
        (self.time, self.time_rest) = (other.time, other.time_rest);
        self.origins.copy_from_slice(&other.origins);
        self.orientations.copy_from_slice(&other.orientations);
        self.coordinates.copy_from_slice(&other.coordinates);
        self.velocities.copy_from_slice(&other.velocities);
        self.accelerations.copy_from_slice(&other.accelerations);
        self.algorithmic.copy_from_slice(&other.algorithmic);
        self.forces.copy_from_slice(&other.forces);
        self.earlier_accelerations
            .copy_from_slice(&other.earlier_accelerations);
        self.earlier_forces.copy_from_slice(&other.earlier_forces);
        self.earlier_step = other.earlier_step;
        self.residual_displacements
            .copy_from_slice(&other.residual_displacements);
        self.residual_rates.copy_from_slice(&other.residual_rates);
        self.residual_accelerations
            .copy_from_slice(&other.residual_accelerations);
        self.deflections.copy_from_slice(&other.deflections);
        self.body_forces.copy_from_slice(&other.body_forces);
        self.angles.copy_from_slice(&other.angles);
        self.inputs.copy_from_slice(&other.inputs);
        self.felt_inputs.copy_from_slice(&other.felt_inputs);
        self.memory.copy_from_slice(&other.memory);
    }

    /// Lets somebody see every number, in one order.
    pub(crate) fn visit(&mut self, see: &mut dyn FnMut(&mut f64)) {
        let Self {
            time,
            time_rest,
            origins,
            orientations,
            coordinates,
            velocities,
            accelerations,
            algorithmic,
            forces,
            earlier_accelerations,
            earlier_forces,
            earlier_step,
            residual_displacements,
            residual_rates,
            residual_accelerations,
            deflections,
            body_forces,
            angles,
            inputs,
            felt_inputs,
            memory,
        } = self;
        for number in [time, time_rest, earlier_step] {
            see(number);
        }
        for origin in origins {
            origin.iter_mut().for_each(&mut *see);
        }
        for orientation in orientations {
            let quaternion = orientation.as_mut_unchecked();
            quaternion.coords.iter_mut().for_each(&mut *see);
        }
        for numbers in [
            coordinates,
            velocities,
            accelerations,
            algorithmic,
            forces,
            earlier_accelerations,
            earlier_forces,
            residual_displacements,
            residual_rates,
            residual_accelerations,
            deflections,
            body_forces,
            angles,
            inputs,
            felt_inputs,
            memory,
        ] {
            numbers.iter_mut().for_each(&mut *see);
        }
    }

    /// The time after a step, and what rounding takes from it. n steps of h lead to n h but for its own rounding (Knuth's sum without error).
    pub fn time_after(&self, step: f64) -> (f64, f64) {
        let (sum, lost) = exact_sum(self.time, step);
        exact_sum(sum, lost + self.time_rest)
    }

    /// Pose of a body frame.
    pub fn pose(&self, body: usize) -> BodyPose {
        BodyPose {
            origin: self.origins[body],
            axes: self.orientations[body].to_rotation_matrix().into_inner(),
        }
    }

    /// Rigid velocities of a body, and y'.
    pub fn body_rates(&self, system: &System, body: usize) -> (BodyRates, &[f64]) {
        let values = &self.velocities[system.bodies[body].velocities.clone()];
        (rates(values), &values[6..])
    }

    /// Moves the positions by δq, laid out as velocities, rigid parts in body axes.
    pub fn shift(&mut self, system: &System, motion: &[f64]) {
        for (index, body) in system.bodies.iter().enumerate() {
            let own = &motion[body.velocities.clone()];
            let BodyRates { linear, angular } = rates(own);
            let axes = self.pose(index).axes;
            self.origins[index] += axes * linear;
            self.orientations[index] *= UnitQuaternion::new(angular);
            let coordinates = &mut self.coordinates[body.coordinates.clone()];
            for (y, change) in coordinates.iter_mut().zip(&own[6..]) {
                *y += change;
            }
        }
    }

    /// The same positions at rest.
    pub fn without_motion(&self) -> Self {
        let mut still = self.clone();
        still.velocities.fill(0.0);
        still.accelerations.fill(0.0);
        still.residual_rates.fill(0.0);
        still.residual_accelerations.fill(0.0);
        still
    }
}

/// A sum as rounded, and what rounding took from it.
fn exact_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let of_b = sum - a;
    (sum, (a - (sum - of_b)) + (b - of_b))
}

/// The rigid part of a body's velocities or accelerations.
pub fn rates(values: &[f64]) -> BodyRates {
    BodyRates {
        linear: Vector3::new(values[0], values[1], values[2]),
        angular: Vector3::new(values[3], values[4], values[5]),
    }
}
