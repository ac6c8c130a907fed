//! The energy of a mechanism and what went in and out of it.
//!
//! ```text
//! defect = kinetic + strain + gravity + springs - (the same at the start) - drives - loads + dissipated
//! ```
//! Works are summed by the trapezoidal rule over accepted steps, so a defect of second order in the step is the integrator's.

use crate::system::evaluation::Evaluation;
use crate::system::marker::six;
use crate::system::{Demand, State, System};

/// Work done since the start, and the power it goes on with.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Works {
    /// By the drives and actuators.
    pub drives: f64,
    /// By the applied forces and torques, gravity not among them.
    pub loads: f64,
    /// Turned into heat by modal damping and dampers.
    pub dissipated: f64,
    powers: [f64; 3],
}

impl Works {
    /// At the start of a run.
    pub fn at_start(system: &System, state: &State, evaluation: &Evaluation) -> Self {
        Self {
            powers: powers(system, state, evaluation),
            ..Self::default()
        }
    }

    /// Adds the work of a step that ended with `state`.
    pub fn advance(&mut self, system: &System, state: &State, evaluation: &Evaluation, step: f64) {
        let now = powers(system, state, evaluation);
        let works = [&mut self.drives, &mut self.loads, &mut self.dissipated];
        for ((work, before), after) in works.into_iter().zip(self.powers).zip(now) {
            *work += 0.5 * step * (before + after);
        }
        self.powers = now;
    }

    /// Adds the work of the powers at a state over a time.
    pub fn add(&mut self, system: &System, state: &State, evaluation: &Evaluation, time: f64) {
        let works = [&mut self.drives, &mut self.loads, &mut self.dissipated];
        for (work, power) in works.into_iter().zip(powers(system, state, evaluation)) {
            *work += time * power;
        }
    }

    /// Powers that jump at a state go on from there.
    pub fn go_on(&mut self, system: &System, state: &State, evaluation: &Evaluation) {
        self.powers = powers(system, state, evaluation);
    }

    /// Lets somebody see every number, in one order.
    pub(crate) fn visit(&mut self, see: &mut dyn FnMut(&mut f64)) {
        let Self {
            drives,
            loads,
            dissipated,
            powers,
        } = self;
        for number in [drives, loads, dissipated].into_iter().chain(powers) {
            see(number);
        }
    }

    /// The works at a part `x` of a step of this length that led from these to `after`: powers are taken for straight lines, as the
    /// trapezoidal rule takes them.
    pub fn within(&self, after: &Self, x: f64, step: f64) -> Self {
        let mut now = *self;
        let works = [&mut now.drives, &mut now.loads, &mut now.dissipated];
        let powers = self.powers.iter().zip(after.powers);
        for (work, (before, after)) in works.into_iter().zip(powers) {
            *work += x * step * (before + 0.5 * x * (after - before));
        }
        now
    }
}

/// Power of drives, of loads and of dissipation.
fn powers(system: &System, state: &State, evaluation: &Evaluation) -> [f64; 3] {
    let (mut drives, mut loads, mut dissipated) = (0.0, 0.0, 0.0);
    for (index, row) in system.rows.iter().enumerate() {
        match &row.demand {
            Demand::Hold(_) => {}
            Demand::Follow(signal) => {
                drives += state.forces[index] * system.signal(*signal, state).rate;
            }
            Demand::Answer(law) => dissipated += law.dissipation(evaluation.value_rates[index]),
            Demand::Actuate(actuator) => {
                let (value, rate) = (evaluation.values[index], evaluation.value_rates[index]);
                let actuator = &system.actuators[*actuator];
                let [put_in, lost] = system.power_of(actuator, state.forces[index], value, rate);
                drives += put_in;
                dissipated += lost;
            }
        }
    }
    for load in &system.loads {
        let marker = &system.markers[load.marker];
        if let Some(body) = marker.body {
            let mut motion = evaluation.motions[load.marker];
            let (rigid, rates) = state.body_rates(system, body);
            marker.add_velocity(
                &evaluation.places[load.marker],
                &evaluation.poses[body],
                &rigid,
                rates,
                &mut motion,
            );
            let wrench = system.load(load, state, &motion);
            loads += wrench.dot(&six(&motion.velocity, &motion.spin));
        }
    }
    for index in 0..system.bodies.len() {
        let (rigid, rates) = state.body_rates(system, index);
        let velocity = evaluation.poses[index].axes.tr_mul(&rigid.linear);
        for (factor, load) in system.inside(state, index) {
            let elastic: f64 = load.elastic.iter().zip(rates).map(|(f, r)| f * r).sum();
            let power = load.force.dot(&velocity) + load.moment.dot(&rigid.angular) + elastic;
            loads += factor * power;
        }
    }
    for body in &system.bodies {
        let rates = &state.velocities[body.velocities.clone()][6..];
        for (i, rate) in rates.iter().enumerate() {
            dissipated += body.flexible.damping_coefficient(i) * rate * rate;
        }
    }
    [drives, loads, dissipated]
}

/// The energy at one state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Kinetic.
    pub kinetic: f64,
    /// Of the bodies' deflection.
    pub strain: f64,
    /// Of gravity, zero at the world's origin.
    pub gravity: f64,
    /// Of springs and bushings.
    pub springs: f64,
}

impl Energy {
    /// At a state whose evaluation is up to date.
    pub fn at(system: &System, state: &State, evaluation: &mut Evaluation) -> Self {
        let mut energy = Self::default();
        for (index, body) in system.bodies.iter().enumerate() {
            let (rigid, rates) = state.body_rates(system, index);
            let pose = &evaluation.poses[index];
            let y = &state.coordinates[body.coordinates.clone()];
            let terms = &mut evaluation.inertia[index];
            let inertia = &body.flexible.inertia;
            inertia.evaluate(y, &rigid.angular, rates, terms);
            let velocity = pose.axes.tr_mul(&rigid.linear);
            energy.kinetic +=
                terms.kinetic_energy(inertia.mass(), &velocity, &rigid.angular, rates);
            energy.strain += body.flexible.strain_energy(y);
            if !body.residual_rows.is_empty() {
                let forces = &evaluation.residual_forces[body.residual_rows.clone()];
                energy.strain += body.flexible.residual_energy(forces);
            }
            let moment = pose.origin * inertia.mass() + pose.axes * terms.first_moment();
            energy.gravity -= system.gravity.dot(&moment);
        }
        for (index, row) in system.rows.iter().enumerate() {
            let value = evaluation.values[index];
            energy.springs += match &row.demand {
                Demand::Answer(law) => law.potential(value),
                Demand::Actuate(actuator) => system.stored_by(&system.actuators[*actuator], value),
                Demand::Hold(_) | Demand::Follow(_) => 0.0,
            };
        }
        energy
    }

    /// All of it.
    pub fn total(&self) -> f64 {
        self.kinetic + self.strain + self.gravity + self.springs
    }
}
