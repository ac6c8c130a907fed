//! Everything that the equations need at one state: frames, measures, forces. Made once; every call overwrites.

use nalgebra::Vector3;

use super::marker::{BodyPose, MarkerPlace, six, turned_back};
use super::state::rates;
use super::{Demand, State, System, Term};
use crate::actuator::{Effort, Sense, Source, Timing};
use crate::frame::{InertiaForces, InertiaTerms};
use crate::kinematics::frame_motion::{FrameMotion, Six};
use crate::measure::Gradient;

/// A sensed coordinate.
#[derive(Clone, Copy, Debug)]
pub struct Sensed {
    /// Its value.
    pub value: f64,
    /// Its rate.
    pub rate: f64,
    /// Its gradient.
    pub gradient: Gradient,
}

impl Default for Sensed {
    fn default() -> Self {
        Self {
            value: 0.0,
            rate: 0.0,
            gradient: Gradient::zero(),
        }
    }
}

/// Scratch of one system.
#[derive(Clone, Debug)]
pub struct Evaluation {
    /// Body frames.
    pub poses: Vec<BodyPose>,
    /// Markers on their bodies.
    pub places: Vec<MarkerPlace>,
    /// Markers in the world; velocities and accelerations only where they were asked for.
    pub motions: Vec<FrameMotion>,
    /// Displacement and turn of each marker beside those of the coordinates, body axes.
    pub extras: Vec<Six>,
    /// g of the bodies that interface forces deflect beyond the coordinates, by rows, body axes, acting on the body.
    pub residual_forces: Vec<f64>,
    /// Force and torque at each marker from rows and loads, acting on its body, world axes.
    pub wrenches: Vec<Six>,
    /// Gradient of each term, times its weight.
    pub gradients: Vec<Gradient>,
    /// Measure of each row.
    pub values: Vec<f64>,
    /// Rate of each row's measure, for rows with dampers.
    pub value_rates: Vec<f64>,
    /// Remainder of each row's demand: e - f of a constraint, the spring's force of a spring.
    pub answers: Vec<f64>,
    /// Effort of each actuator, with its derivatives.
    pub efforts: Vec<Effort>,
    /// Coordinates that controllers sense.
    pub sensed: Vec<Sensed>,
    /// Efforts of the continuous controllers; zero for others.
    pub controls: Vec<f64>,
    /// Their derivatives by their arguments, controller by controller.
    pub control_slopes: Vec<f64>,
    arguments: Vec<f64>,
    /// Inertia of each body.
    pub inertia: Vec<InertiaTerms>,
    /// Inertia forces of each body.
    pub inertia_forces: Vec<InertiaForces>,
    /// Inertia + elastic + damping - applied, laid out as velocities; the rigid rows of a body in body axes.
    pub residual: Vec<f64>,
}

impl Evaluation {
    /// At a state, but for what accelerations do: what a linearization needs.
    pub fn at(system: &System, state: &State) -> Self {
        let mut evaluation = Self::of(system);
        evaluation.place(system, state);
        evaluation.add_velocities(system, state);
        evaluation.measure(system, state);
        evaluation.load(system, state);
        evaluation.resist(system, state);
        evaluation
    }

    /// Room for a system.
    pub fn of(system: &System) -> Self {
        let zero = FrameMotion::at_rest(Vector3::zeros(), nalgebra::Matrix3::identity());
        let markers = system.markers.len();
        let mut evaluation = Self {
            poses: vec![
                BodyPose {
                    origin: zero.position,
                    axes: zero.axes
                };
                system.bodies.len()
            ],
            places: system.markers.iter().map(MarkerPlace::of).collect(),
            motions: vec![zero; markers],
            extras: vec![Six::zeros(); markers],
            residual_forces: vec![0.0; system.residual_row_count()],
            wrenches: vec![Six::zeros(); markers],
            gradients: vec![Gradient::zero(); system.terms.len()],
            values: vec![0.0; system.rows.len()],
            value_rates: vec![0.0; system.rows.len()],
            answers: vec![0.0; system.rows.len()],
            efforts: vec![Effort::default(); system.actuators.len()],
            sensed: vec![Sensed::default(); system.sensors.len()],
            controls: vec![0.0; system.controllers.len()],
            control_slopes: vec![0.0; system.slope_count],
            arguments: vec![0.0; system.slope_count],
            inertia: system
                .bodies
                .iter()
                .map(|body| InertiaTerms::for_coordinates(body.flexible.coordinate_count()))
                .collect(),
            inertia_forces: system
                .bodies
                .iter()
                .map(|body| InertiaForces::for_coordinates(body.flexible.coordinate_count()))
                .collect(),
            residual: vec![0.0; system.velocity_count()],
        };
        for (motion, marker) in evaluation.motions.iter_mut().zip(&system.markers) {
            if marker.body.is_none() {
                *motion = FrameMotion::at_rest(marker.position, marker.axes);
            }
        }
        evaluation
    }

    /// Body frames and markers at the state's positions.
    pub fn place(&mut self, system: &System, state: &State) {
        for (index, body) in system.bodies.iter().enumerate() {
            let pose = state.pose(index);
            self.poses[index] = pose;
            let deflects_beyond = !body.residual_rows.is_empty();
            if deflects_beyond {
                self.displace_interfaces(system, state, index);
            }
            let y = &state.coordinates[body.coordinates.clone()];
            for &marker in &body.markers {
                let place = &mut self.places[marker];
                self.motions[marker] =
                    system.markers[marker].place(&pose, y, &self.extras[marker], place);
            }
            if deflects_beyond {
                self.carry_interfaces(system, state, index);
            }
        }
    }

    /// Velocities of the markers, after `place`.
    pub fn add_velocities(&mut self, system: &System, state: &State) {
        for (body, pose) in system.bodies.iter().zip(&self.poses) {
            let values = &state.velocities[body.velocities.clone()];
            for &marker in &body.markers {
                system.markers[marker].add_velocity(
                    &self.places[marker],
                    pose,
                    &rates(values),
                    &values[6..],
                    &mut self.motions[marker],
                );
            }
        }
    }

    /// Accelerations of the markers, after `add_velocities`.
    pub fn add_accelerations(&mut self, system: &System, state: &State) {
        for (body, pose) in system.bodies.iter().zip(&self.poses) {
            let velocities = &state.velocities[body.velocities.clone()];
            let accelerations = &state.accelerations[body.velocities.clone()];
            for &marker in &body.markers {
                system.markers[marker].add_acceleration(
                    &self.places[marker],
                    pose,
                    (&rates(velocities), &velocities[6..]),
                    (&rates(accelerations), &accelerations[6..]),
                    &mut self.motions[marker],
                );
            }
        }
    }

    /// Values, gradients and answers of the rows, after `place`; after `add_velocities` where there are dampers.
    pub fn measure(&mut self, system: &System, state: &State) {
        if !system.sensors.is_empty() {
            self.sense(system, state);
        }
        for (index, row) in system.rows.iter().enumerate() {
            let (mut value, mut rate) = (0.0, 0.0);
            let damped = match &row.demand {
                Demand::Answer(law) => law.is_damped(),
                Demand::Actuate(_) => true,
                Demand::Hold(_) | Demand::Follow(_) => false,
            };
            for (term, gradient) in system.terms[row.terms.clone()]
                .iter()
                .zip(&mut self.gradients[row.terms.clone()])
            {
                let (a, b) = (&self.motions[term.a], &self.motions[term.b]);
                let (found, slope) = (term.measure.value(a, b), term.measure.gradient(a, b));
                value += term.weight * unwound(found, term.angle, &state.angles);
                *gradient = slope.scaled(term.weight);
                if damped {
                    rate += term.weight * term.measure.rate(a, b);
                }
            }
            self.values[index] = value;
            self.value_rates[index] = rate;
            self.answers[index] = match &row.demand {
                Demand::Hold(target) => value - target,
                Demand::Follow(signal) => value - system.signal(*signal, state).value,
                Demand::Answer(law) => law.force(value, rate),
                Demand::Actuate(index) => {
                    let actuator = &system.actuators[*index];
                    let effort = match &actuator.source {
                        Source::Controlled(controller) => Effort {
                            force: system.controlled(*controller, state, &self.controls),
                            ..Effort::default()
                        },
                        _ => system.effort(actuator, state, value, rate),
                    };
                    self.efforts[*index] = effort;
                    effort.force
                }
            };
        }
    }

    /// Sensed coordinates, and what continuous controllers make of them.
    fn sense(&mut self, system: &System, state: &State) {
        for (sensor, found) in system.sensors.iter().zip(&mut self.sensed) {
            let (a, b) = (&self.motions[sensor.a], &self.motions[sensor.b]);
            let value = sensor.measure.value(a, b);
            found.value = unwound(value, sensor.angle, &state.angles) - sensor.zero;
            found.rate = sensor.measure.rate(a, b);
            found.gradient = sensor.measure.gradient(a, b);
        }
        for (index, controller) in system.controllers.iter().enumerate() {
            let Timing::Continuous { senses, first } = &controller.timing else {
                continue;
            };
            let own = *first..first + senses.len();
            for (argument, sense) in self.arguments[own.clone()].iter_mut().zip(senses) {
                *argument = match sense {
                    Sense::Value(sensor) => self.sensed[*sensor].value,
                    Sense::Rate(sensor) => self.sensed[*sensor].rate,
                };
            }
            let arguments = &self.arguments[own.clone()];
            self.controls[index] = controller.formula.evaluate(state.time, arguments);
            for (k, slope) in self.control_slopes[own].iter_mut().enumerate() {
                *slope = controller.formula.slope(state.time, arguments, k);
            }
        }
    }

    /// Counts angles on past half a turn, after `place`.
    pub fn count_turns(&self, system: &System, state: &mut State) {
        for term in &system.terms {
            if let Some(angle) = term.angle {
                let (a, b) = (&self.motions[term.a], &self.motions[term.b]);
                let value = term.measure.value(a, b);
                state.angles[angle] = unwound(value, Some(angle), &state.angles);
            }
        }
    }

    /// Forces at the markers from the rows' λ and from loads, after `measure`.
    pub fn load(&mut self, system: &System, state: &State) {
        self.wrenches.fill(Six::zeros());
        for (row, lambda) in system.rows.iter().zip(&state.forces) {
            for (term, gradient) in system.terms[row.terms.clone()]
                .iter()
                .zip(&self.gradients[row.terms.clone()])
            {
                self.wrenches[term.a] += gradient.a * *lambda;
                self.wrenches[term.b] += gradient.b * *lambda;
            }
        }
        for load in &system.loads {
            let wrench = system.load(load, state, &self.motions[load.marker]);
            self.wrenches[load.marker] += wrench;
        }
        for (index, body) in system.bodies.iter().enumerate() {
            if !body.residual_rows.is_empty() {
                self.gather_interface_forces(system, index);
            }
        }
    }

    /// Residual of the equations of motion, after `load`.
    pub fn resist(&mut self, system: &System, state: &State) {
        for (index, body) in system.bodies.iter().enumerate() {
            let pose = &self.poses[index];
            let (at, acceleration) = system.body_motion(state, pose, index);
            let (terms, forces) = (&mut self.inertia[index], &mut self.inertia_forces[index]);
            body.flexible
                .inertia
                .evaluate_forces(&at, &acceleration, terms, forces);
            let mut rigid = six(&forces.force_body, &forces.moment);
            let residual = &mut self.residual[body.velocities.clone()];
            let (rigid_rows, elastic) = residual.split_at_mut(6);
            body.flexible.internal_forces(at.y, at.rates, elastic);
            for (force, inertia) in elastic.iter_mut().zip(&forces.elastic) {
                *force += inertia;
            }
            for &marker in &body.markers {
                system.markers[marker].add_force(
                    &self.places[marker],
                    &turned_back(&pose.axes, &self.wrenches[marker]),
                    -1.0,
                    &mut rigid,
                    elastic,
                );
            }
            for (factor, load) in system.inside(state, index) {
                rigid -= six(&load.force, &load.moment) * factor;
                for (left, force) in elastic.iter_mut().zip(&load.elastic) {
                    *left -= factor * force;
                }
            }
            rigid_rows.copy_from_slice(rigid.as_slice());
            // Interface forces that are coordinates must be those of the rows and loads.
            let own = body.flexible.displacement_count();
            if own < elastic.len() {
                let found = &self.residual_forces[body.residual_rows.clone()];
                for ((left, g), found) in elastic[own..].iter_mut().zip(&at.y[own..]).zip(found) {
                    *left = g - found;
                }
            }
        }
    }

    /// All of it at a state, velocities and accelerations included.
    pub fn refresh(&mut self, system: &System, state: &State) {
        self.place(system, state);
        self.add_velocities(system, state);
        self.add_accelerations(system, state);
        self.measure(system, state);
        self.load(system, state);
        self.resist(system, state);
    }

    /// e' of a row, after `add_velocities`.
    pub fn rate(&self, system: &System, index: usize) -> f64 {
        let terms = &system.terms[system.rows[index].terms.clone()];
        let rate = |term: &Term| {
            let (a, b) = (&self.motions[term.a], &self.motions[term.b]);
            term.weight * term.measure.rate(a, b)
        };
        terms.iter().map(rate).sum()
    }

    /// e'' of a row, after `add_accelerations`.
    pub fn second_rate(&self, system: &System, index: usize) -> f64 {
        let terms = &system.terms[system.rows[index].terms.clone()];
        let second = |term: &Term| {
            let (a, b) = (&self.motions[term.a], &self.motions[term.b]);
            term.weight * term.measure.second_rate(a, b)
        };
        terms.iter().map(second).sum()
    }

    /// e' - f' of a constraint; `None` for a spring.
    pub fn velocity_defect(&self, system: &System, state: &State, index: usize) -> Option<f64> {
        let target = match &system.rows[index].demand {
            Demand::Hold(_) => 0.0,
            Demand::Follow(signal) => system.signal(*signal, state).rate,
            Demand::Answer(_) | Demand::Actuate(_) => return None,
        };
        Some(self.rate(system, index) - target)
    }

    /// e'' - f'' of a constraint; `None` for a spring.
    pub fn acceleration_defect(&self, system: &System, state: &State, index: usize) -> Option<f64> {
        let target = match &system.rows[index].demand {
            Demand::Hold(_) => 0.0,
            Demand::Follow(signal) => system.signal(*signal, state).second_rate,
            Demand::Answer(_) | Demand::Actuate(_) => return None,
        };
        Some(self.second_rate(system, index) - target)
    }
}

/// An angle counted on from its last value, or any other measure as it is.
pub fn unwound(value: f64, angle: Option<usize>, angles: &[f64]) -> f64 {
    match angle {
        None => value,
        Some(index) => {
            let last = angles[index];
            last + (value - last + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU)
                - std::f64::consts::PI
        }
    }
}
