//! A mechanism, ready to move: bodies in floating frames, joined by rows.
//!
//! Every coupling is a *row*: a scalar measure e of two markers that is either held at a value (a constraint, from a joint or a
//! drive) or answered by a force (a spring). A row has one unknown, the force λ conjugate to e, whichever it is:
//!
//! ```text
//! constraint   e(q) - f(t) = 0                 f constant or a drive
//! spring       λ + law(e, e') = 0
//! bodies       inertia + elastic + damping = applied + Bᵀ λ,     B = ∂e/∂q
//! ```
//! so that a stiff spring is as well conditioned as a constraint, and bodies meet in rows only. [`System`] never changes
//! during a run; [`State`] is the motion; [`evaluation::Evaluation`] is scratch.

mod actuation;
pub mod body_factor;
pub mod builder;
pub mod condensed;
pub mod evaluation;
pub(crate) mod free_directions;
pub(crate) mod joint_system;
pub mod linearization;
pub(crate) mod marker;
pub(crate) mod number;
mod redundancy;
pub(crate) mod residual;
pub(crate) mod state;

use std::ops::Range;
use std::sync::Arc;

use dcb_formats::mesh::Dimension;
use nalgebra::Vector3;

use crate::actuator::{Actuator, Controller};
use crate::body::{BodyLoad, FlexibleBody};
use crate::force_law::Law;
use crate::frame::{BodyAcceleration, BodyState};
use crate::kinematics::frame_motion::{FrameMotion, Six};
use crate::measure::Measure;
use dcb_formats::function::{FunctionValue, TimeFunction};
use marker::{BodyPose, Marker, six};
pub use state::State;
use state::rates;

/// One body of a mechanism.
#[derive(Clone, Debug)]
pub struct Body {
    /// Name in the scene.
    pub name: String,
    /// Its description; shared by the bodies made of the same superelement.
    pub flexible: Arc<FlexibleBody>,
    /// Its coordinates among those of all bodies.
    pub coordinates: Range<usize>,
    /// Its velocities among those of all bodies: V (world axes), ω (body axes), y'.
    pub velocities: Range<usize>,
    /// Its interface rows among those of all bodies that interface forces deflect beyond the coordinates; empty for others.
    pub residual_rows: Range<usize>,
    /// Its markers.
    pub markers: Vec<usize>,
    /// Which of its rigid motions there are: three translations, three rotations, body axes.
    pub free: [bool; 6],
    /// A length that turns rotations into displacements: the largest radius of gyration, or the reach of its markers.
    pub length: f64,
}

/// A measure of two markers, weighted; a row adds up its terms.
#[derive(Clone, Debug)]
pub struct Term {
    /// Weight.
    pub weight: f64,
    /// First marker.
    pub a: usize,
    /// Second marker.
    pub b: usize,
    /// Measure.
    pub measure: Measure,
    /// Where an angle's last value is kept, so that it goes on past half a turn.
    pub angle: Option<usize>,
}

/// A coordinate that is sensed without being loaded.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    /// First marker.
    pub a: usize,
    /// Second marker.
    pub b: usize,
    /// Measure.
    pub measure: Measure,
    /// Where an angle's last value is kept.
    pub angle: Option<usize>,
    /// Value of the measure at which the coordinate is zero.
    pub zero: f64,
}

/// Demand on a row's measure.
#[derive(Clone, Debug)]
pub enum Demand {
    /// Stay at a value.
    Hold(f64),
    /// Follow a function of time, by its index.
    Follow(usize),
    /// Be answered by a force.
    Answer(Law),
    /// Be answered by an actuator, by its index.
    Actuate(usize),
}

/// One scalar coupling.
#[derive(Clone, Debug)]
pub struct Row {
    /// The connection that it belongs to.
    pub connection: usize,
    /// Measured terms: one, or two for a gear.
    pub terms: Range<usize>,
    /// Demand.
    pub demand: Demand,
}

impl Row {
    /// Whether the measure is fixed, by a joint or a drive, and not answered by a force.
    pub fn is_constraint(&self) -> bool {
        match self.demand {
            Demand::Hold(_) | Demand::Follow(_) => true,
            Demand::Answer(_) | Demand::Actuate(_) => false,
        }
    }
}

/// Kind of a connection, for reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConnectionKind {
    /// A joint.
    Joint,
    /// A drive.
    Drive,
    /// A spring, torsion spring or bushing.
    Spring,
    /// An actuator.
    Actuator,
    /// Damping of assembled modes: each row measures the amplitude of one.
    AssembledModes,
}

/// Rows under one name.
#[derive(Clone, Debug)]
pub struct Connection {
    /// Name in the scene.
    pub name: String,
    /// Kind.
    pub kind: ConnectionKind,
    /// First marker.
    pub a: usize,
    /// Second marker.
    pub b: usize,
    /// Its rows.
    pub rows: Range<usize>,
}

/// In which axes the components of a load are given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoadAxes {
    /// World.
    World,
    /// The marker's own, turning with it.
    Follower,
}

/// A force and a torque on a marker.
#[derive(Clone, Debug)]
pub struct Load {
    /// Name in the scene.
    pub name: String,
    /// Where.
    pub marker: usize,
    /// In which axes.
    pub axes: LoadAxes,
    /// Functions of time of the three components of the force, by index; `None` is zero.
    pub force: [Option<usize>; 3],
    /// The same of the torque.
    pub torque: [Option<usize>; 3],
}

/// A load on the inside of a body, of those that the body brings along.
#[derive(Clone, Debug)]
pub struct PartLoad {
    /// Name in the scene.
    pub name: String,
    /// The body.
    pub body: usize,
    /// Index among its [`crate::FlexibleBody::loads`].
    pub load: usize,
    /// Factor: index of a function of time.
    pub factor: usize,
}

/// A function of time, and the input it listens to if it does.
#[derive(Clone, Debug)]
pub struct Signal {
    /// The function.
    pub function: TimeFunction,
    /// Index among the inputs, for functions that are set from outside.
    pub input: Option<usize>,
    /// Added to the value: where the coordinate that follows it counts from.
    pub offset: f64,
}

/// A mechanism. Never changes during a run.
#[derive(Clone, Debug)]
pub struct System {
    /// Planar or spatial.
    pub dimension: Dimension,
    /// Acceleration of free fall, world axes.
    pub gravity: Vector3<f64>,
    /// Bodies.
    pub bodies: Vec<Body>,
    /// Frames on bodies and on the ground.
    pub markers: Vec<Marker>,
    /// Terms of the rows.
    pub terms: Vec<Term>,
    /// Rows, connection by connection.
    pub rows: Vec<Row>,
    /// Joints, drives and springs.
    pub connections: Vec<Connection>,
    /// Loads.
    pub loads: Vec<Load>,
    /// Loads on the inside of bodies.
    pub part_loads: Vec<PartLoad>,
    /// Actuators.
    pub actuators: Vec<Actuator>,
    /// Controllers.
    pub controllers: Vec<Controller>,
    /// Coordinates that continuous controllers sense.
    pub sensors: Vec<Sensor>,
    /// How many derivatives continuous controllers have.
    pub slope_count: usize,
    /// How many outputs sampled controllers use.
    pub argument_count: usize,
    /// How many numbers actuators remember.
    pub memory_count: usize,
    /// Functions of time.
    pub signals: Vec<Signal>,
    /// Names of the inputs and their values at the start.
    pub inputs: Vec<(String, f64)>,
    /// Number of angles whose turns are counted.
    pub angle_count: usize,
    /// Whether any row's force depends on velocities.
    pub is_damped: bool,
}

impl System {
    /// Number of y of all bodies.
    pub fn coordinate_count(&self) -> usize {
        self.bodies.last().map_or(0, |body| body.coordinates.end)
    }

    /// Length of velocity arrays: six and the number of coordinates for each body.
    pub fn velocity_count(&self) -> usize {
        self.bodies.last().map_or(0, |body| body.velocities.end)
    }

    /// Number of interface rows of the bodies that interface forces deflect beyond the coordinates.
    pub fn residual_row_count(&self) -> usize {
        self.bodies.last().map_or(0, |body| body.residual_rows.end)
    }

    /// Indices of the rows that are constraints.
    pub fn constraints(&self) -> Vec<usize> {
        (0..self.rows.len())
            .filter(|row| self.rows[*row].is_constraint())
            .collect()
    }

    /// Number of degrees of freedom before constraints: 3 + n or 6 + n for each body.
    pub fn dof_count(&self) -> usize {
        let rigid = self.bodies.iter().flat_map(|body| body.free);
        rigid.filter(|free| *free).count() + self.coordinate_count()
    }

    /// The markers on an interface of a body: one, or two where some couplings follow its rotation and others the body's.
    pub fn markers_on(&self, body: usize, interface: usize) -> Vec<usize> {
        let markers = self.bodies[body].markers.iter().copied();
        markers
            .filter(|marker| self.markers[*marker].interface == Some(interface))
            .collect()
    }

    /// Whether a force follows an input at once: a load or an actuator. What only moves driven coordinates makes none jump.
    pub fn is_effort(&self, input: usize) -> bool {
        let loads = self.loads.iter().flat_map(|load| [load.force, load.torque]);
        let of_loads = loads.flatten().flatten();
        let of_parts = self.part_loads.iter().map(|load| load.factor);
        let of_actuators = self.actuators.iter().filter_map(|one| one.source.signal());
        let mut signals = of_loads.chain(of_parts).chain(of_actuators);
        signals.any(|signal| self.signals[signal].input == Some(input))
    }

    /// The value of a signal at the state's time.
    pub fn signal(&self, index: usize, state: &State) -> FunctionValue {
        let signal = &self.signals[index];
        let input = signal.input.map_or(0.0, |input| state.inputs[input]);
        let mut value = signal.function.evaluate(state.time, input);
        value.value += signal.offset;
        value
    }

    /// Force and torque of a load in world axes.
    pub fn load(&self, load: &Load, state: &State, motion: &FrameMotion) -> Six {
        let part = |components: &[Option<usize>; 3]| {
            let own = Vector3::from_fn(|i, _| {
                components[i].map_or(0.0, |signal| self.signal(signal, state).value)
            });
            match load.axes {
                LoadAxes::World => own,
                LoadAxes::Follower => motion.axes * own,
            }
        };
        six(&part(&load.force), &part(&load.torque))
    }

    /// Loads on the inside of body `index` with their factors.
    pub fn inside<'a>(
        &'a self,
        state: &'a State,
        index: usize,
    ) -> impl Iterator<Item = (f64, &'a BodyLoad)> {
        let own = self
            .part_loads
            .iter()
            .filter(move |load| load.body == index);
        own.map(move |load| {
            let factor = self.signal(load.factor, state).value;
            (factor, &self.bodies[index].flexible.loads[load.load])
        })
    }

    /// State that a body's inertia forces depend on, in its own axes.
    pub fn body_motion<'a>(
        &self,
        state: &'a State,
        pose: &BodyPose,
        index: usize,
    ) -> (BodyState<'a>, BodyAcceleration<'a>) {
        let body = &self.bodies[index];
        let velocities = &state.velocities[body.velocities.clone()];
        let accelerations = &state.accelerations[body.velocities.clone()];
        let at = BodyState {
            y: &state.coordinates[body.coordinates.clone()],
            rates: &velocities[6..],
            spin: rates(velocities).angular,
        };
        let changing = rates(accelerations);
        let acceleration = BodyAcceleration {
            origin: pose.axes.tr_mul(&(changing.linear - self.gravity)),
            spin_rate: changing.angular,
            second_rates: &accelerations[6..],
        };
        (at, acceleration)
    }
}
