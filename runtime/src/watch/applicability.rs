//! Whether a run stays within what its superelements were made for: the frequencies and the directions of force.
//!
//! Vibrations are watched at every step, forces at the states that are recorded, and both are told when the run is over, with the largest
//! that was met.
//!
//! Of a body's deflection the part above the frequency f is measured by energies, means over time ⟨⟩. The coordinates that are faster than f, by
//! their own frequency or by what they do, vibrate with as much potential energy as kinetic energy:
//!
//! ```text
//! share = Σ_above ⟨y'ₖ²⟩ / Σ ½ (⟨y'ₖ²⟩ + ωₖ² ⟨yₖ²⟩)          above: ωₖ or (⟨y'ₖ²⟩ / ⟨yₖ²⟩)^½ is more than 2π f
//! ```
//! Coordinates that follow slow forces count next to nothing: with the frequency ω they have the kinetic energy (ω/ωₖ)² of their strain energy.
//!
//! An interface that is loaded along the forces B only answers to what g has beyond them with the modes alone. That is
//!
//! ```text
//! g - Q Qᵀ g,     Q an orthonormal basis of B, moments divided by the body's length
//! ```
//! and its largest size counts by the largest size of g in the run.

use std::f64::consts::TAU;
use std::ops::Range;

use dcb_formats::mesh::Direction;
use dcb_formats::results::frequency_unit;
use dcb_formats::units::four_digits;

use crate::body::FlexibleBody;

use crate::system::evaluation::Evaluation;
use crate::system::{Body, State, System};
use dcb_superelement::{FrequencyLimit, LeftOutBy, LoadedDirections};

/// More of a body's elastic energy than this part, above the frequency that it was made for, is told.
const ABOVE: f64 = 0.05;
/// A run of fewer periods of that frequency doesn't tell: what begins to move has no frequency yet.
const PERIODS: f64 = 10.0;
/// Means over fewer states than this don't tell either.
const STATES: usize = 100;
/// A body that deflects by less than this part of its length does nothing that anybody looks at.
const DEFLECTS: f64 = 1e-8;
/// More of an interface's force than this part, in directions that it wasn't made for, is told: the turn of an interface, up to 0.2 rad,
/// brings some of itself.
const ASIDE: f64 = 0.05;
/// Forces below this part of the largest in the scene are rounding, and forces that don't move the body by this part of its length in the
/// time of the run.
const ROUNDING: f64 = 1e-9;
/// A direction depends on others if what they leave of it is below this fraction of its length.
const DEPENDENT: f64 = 1e-6;

/// Observations so far.
#[derive(Clone, Debug)]
pub struct Scope {
    bodies: Vec<Vibration>,
    interfaces: Vec<Loading>,
    /// g of one body.
    forces: Vec<f64>,
    /// Largest force at any marker.
    largest: f64,
    /// Times of the first and the last state.
    times: Option<[f64; 2]>,
    /// States whose motion was looked at.
    states: usize,
}

/// Something beyond what a superelement was made for.
#[derive(Clone, Debug, PartialEq)]
pub struct BeyondScope {
    /// When it was the most.
    pub time: f64,
    /// Finding with its size and the remedy.
    pub message: String,
}

/// Means over time of one body's deflection.
#[derive(Clone, Debug)]
struct Vibration {
    body: usize,
    limit: FrequencyLimit,
    /// ∫ y² dt and ∫ y'² dt of each coordinate.
    integrals: Vec<[f64; 2]>,
}

/// The forces on one interface.
#[derive(Clone, Debug)]
struct Loading {
    body: usize,
    interface: usize,
    rows: Range<usize>,
    by: LeftOutBy,
    /// One, or one over the length for moments, by rows.
    scale: Vec<f64>,
    /// Q, column by column.
    modelled: Vec<Vec<f64>>,
    /// g - Q Qᵀ g.
    aside: Vec<f64>,
    largest: f64,
    /// Largest size beside Q, and when.
    largest_aside: (f64, f64),
}

impl Scope {
    /// Of the bodies of a system.
    pub fn of(system: &System) -> Self {
        let bodies = || system.bodies.iter().enumerate();
        let vibrating = bodies().filter_map(|(index, body)| {
            let limit = body.flexible.made_for.frequency?;
            let count = body.flexible.displacement_count();
            (count > 0).then(|| Vibration {
                body: index,
                limit,
                integrals: vec![[0.0; 2]; count],
            })
        });
        let loaded = bodies().flat_map(|(index, body)| {
            let directions = body.flexible.made_for.directions.iter();
            directions.map(move |along| Loading::of(index, body, along))
        });
        Self {
            bodies: vibrating.collect(),
            interfaces: loaded.collect(),
            forces: Vec::new(),
            largest: 0.0,
            times: None,
            states: 0,
        }
    }

    /// Looks at the vibrations after a step.
    pub fn observe_motion(&mut self, system: &System, state: &State) {
        let [first, last] = self.times.unwrap_or([state.time; 2]);
        self.times = Some([first, state.time]);
        self.states += 1;
        let interval = state.time - last;
        for vibration in &mut self.bodies {
            let body = &system.bodies[vibration.body];
            let y = &state.coordinates[body.coordinates.clone()];
            let rates = &state.velocities[body.velocities.clone()][6..];
            for ([square, of_rate], (y, rate)) in
                vibration.integrals.iter_mut().zip(y.iter().zip(rates))
            {
                *square += interval * y * y;
                *of_rate += interval * rate * rate;
            }
        }
    }

    /// Looks at the forces of a state that was evaluated with them.
    pub fn observe_forces(&mut self, system: &System, state: &State, evaluation: &Evaluation) {
        if self.interfaces.is_empty() {
            return;
        }
        for wrench in &evaluation.wrenches {
            self.largest = self.largest.max(wrench.fixed_rows::<3>(0).norm());
        }
        for loading in &mut self.interfaces {
            let count = system.bodies[loading.body].flexible.rows.len();
            self.forces.resize(count, 0.0);
            evaluation.write_interface_forces(system, loading.body, &mut self.forces);
            loading.look_at(state.time, &self.forces[loading.rows.clone()]);
        }
    }

    /// Findings beyond the purpose of the superelements.
    pub fn found(&self, system: &System) -> Vec<BeyondScope> {
        let [first, last] = self.times.unwrap_or_default();
        let vibrating = self.bodies.iter();
        let vibrating = vibrating.filter_map(|vibration| {
            let body = &system.bodies[vibration.body];
            let share = vibration.share_above(body, last - first, self.states)?;
            (share > ABOVE).then(|| BeyondScope {
                time: last,
                message: vibration.told(body, share),
            })
        });
        let loaded = self.interfaces.iter().filter_map(|loading| {
            let body = &system.bodies[loading.body];
            let still = match last > first {
                true => body.flexible.inertia.mass() * body.length / (last - first).powi(2),
                false => 0.0,
            };
            let (aside, time) = loading.largest_aside;
            let matters = loading.largest > ROUNDING * self.largest.max(still);
            (matters && aside > ASIDE * loading.largest).then(|| BeyondScope {
                time,
                message: loading.told(&body.name, &body.flexible),
            })
        });
        vibrating.chain(loaded).collect()
    }
}

impl Vibration {
    /// The share above the limit; `None` where nothing deflects, or the run is too short to tell.
    fn share_above(&self, body: &Body, duration: f64, states: usize) -> Option<f64> {
        let periods = duration * self.limit.frequency;
        if states < STATES || (self.limit.frequency > 0.0 && periods < PERIODS) {
            return None;
        }
        let limit = (TAU * self.limit.frequency).powi(2);
        let (mut above, mut energy, mut squares) = (0.0, 0.0, 0.0);
        for ([square, of_rate], stiffness) in self.integrals.iter().zip(&body.flexible.stiffness) {
            energy += 0.5 * (of_rate + stiffness * square);
            squares += square;
            if *stiffness > limit || *of_rate > limit * square {
                above += of_rate;
            }
        }
        // Coordinates are displacements by the root of the mass.
        let mean = (squares / (duration * body.flexible.inertia.mass())).sqrt();
        (mean > DEFLECTS * body.length && energy > 0.0).then(|| (above / energy).min(1.0))
    }

    fn told(&self, body: &Body, share: f64) -> String {
        let name = &body.name;
        let unit = frequency_unit(&body.flexible.units);
        let (percent, frequency) = (100.0 * share, self.limit.frequency);
        let (why, remedy) = match self.limit.by {
            LeftOutBy::Reduction => (
                "where its superelement's modes end",
                "reduce the part with more modes, or for this scene (reduce --scene)",
            ),
            LeftOutBy::Selection => (
                "up to which its superelement was made for a scene",
                "reduce the part for this scene (reduce --scene)",
            ),
            LeftOutBy::Run => (
                "up to which the steps follow it or the loads excite it",
                "take shorter steps, or carry everything (--model everything)",
            ),
        };
        format!(
            "{percent:.0} % of the elastic energy of body {name:?} is in motion above {} {unit}, {why}: motion that fast isn't right; {remedy}",
            four_digits(frequency)
        )
    }
}

impl Loading {
    fn of(index: usize, body: &Body, along: &LoadedDirections) -> Self {
        let all = &body.flexible.rows;
        let before = |interface: usize| all.partition_point(|row| row.interface < interface);
        let rows = before(along.interface)..before(along.interface + 1);
        let is_rotation = |direction: i64| {
            let direction = usize::try_from(direction).ok();
            let direction = direction.and_then(Direction::from_index);
            direction.is_some_and(Direction::is_rotation)
        };
        let scale: Vec<f64> = (all[rows.clone()].iter())
            .map(|row| match is_rotation(row.direction) {
                true => body.length.recip(),
                false => 1.0,
            })
            .collect();
        let mut modelled: Vec<Vec<f64>> = Vec::new();
        for force in along.forces.col_iter() {
            let mut left: Vec<f64> = force.iter().zip(&scale).map(|(f, s)| f * s).collect();
            let size = norm(&left);
            // Twice, so that what is left is perpendicular to rounding.
            for _ in 0..2 {
                remove(&modelled, &mut left);
            }
            let rest = norm(&left);
            if rest > DEPENDENT * size {
                modelled.push(left.iter().map(|entry| entry / rest).collect());
            }
        }
        Self {
            body: index,
            interface: along.interface,
            by: along.by,
            modelled,
            aside: vec![0.0; rows.len()],
            rows,
            scale,
            largest: 0.0,
            largest_aside: (0.0, 0.0),
        }
    }

    fn look_at(&mut self, time: f64, forces: &[f64]) {
        for (entry, (force, scale)) in self.aside.iter_mut().zip(forces.iter().zip(&self.scale)) {
            *entry = force * scale;
        }
        self.largest = self.largest.max(norm(&self.aside));
        remove(&self.modelled, &mut self.aside);
        let size = norm(&self.aside);
        if size > self.largest_aside.0 {
            self.largest_aside = (size, time);
        }
    }

    fn told(&self, name: &str, body: &FlexibleBody) -> String {
        let interface = &body.interfaces[self.interface].name;
        let (aside, time) = self.largest_aside;
        let percent = 100.0 * aside / self.largest;
        let remedy = match self.by {
            LeftOutBy::Run => "carry everything (--model everything)",
            LeftOutBy::Reduction | LeftOutBy::Selection => {
                "reduce the part for this scene (reduce --scene)"
            }
        };
        format!(
            "interface {interface:?} of body {name:?} was loaded along directions that its superelement isn't made for: by {percent:.0} % of its largest force \
             (at t = {}); it gives way to them by its modes only; {remedy}",
            four_digits(time)
        )
    }
}

fn norm(vector: &[f64]) -> f64 {
    vector.iter().map(|entry| entry * entry).sum::<f64>().sqrt()
}

/// Takes out of a vector what lies along unit vectors that are perpendicular to each other.
fn remove(units: &[Vec<f64>], vector: &mut [f64]) {
    for unit in units {
        let along: f64 = unit.iter().zip(vector.iter()).map(|(a, b)| a * b).sum();
        for (entry, unit) in vector.iter_mut().zip(unit) {
            *entry -= along * unit;
        }
    }
}
