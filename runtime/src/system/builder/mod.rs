//! A system piece by piece: bodies, frames on them, and what couples the frames.

mod connections;
mod interface_marker;

use std::sync::Arc;

use dcb_formats::mesh::Dimension;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

pub(crate) use interface_marker::marker_of;

use super::marker::Marker;
use super::{Body, Signal, State, System, Term};
use crate::body::FlexibleBody;
use crate::error::Error;
use crate::joint::JointRows;
use crate::kinematics::frame_motion::FrameMotion;
use crate::measure::Measure;
use dcb_demand::demand;

/// Sine of the angle to a plane's normal below which a direction is across the plane. The others of a mechanism that is symmetric to the plane are in it.
const OBLIQUE: f64 = 1e-3;

/// A body's frame and motion as drawn: of the component's frame, in world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drawn {
    /// Origin of the component's frame.
    pub position: Vector3<f64>,
    /// Component axes to world axes.
    pub orientation: UnitQuaternion<f64>,
    /// Velocity of the origin.
    pub velocity: Vector3<f64>,
    /// Angular velocity.
    pub angular_velocity: Vector3<f64>,
}

impl Default for Drawn {
    fn default() -> Self {
        Self {
            position: Vector3::zeros(),
            orientation: UnitQuaternion::identity(),
            velocity: Vector3::zeros(),
            angular_velocity: Vector3::zeros(),
        }
    }
}

/// Whose rotation a marker's axes follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turning {
    /// The interface's own.
    Interface,
    /// The body frame's.
    Body,
}

/// A coordinate that a joint leaves free.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointCoordinate {
    /// Angle.
    Rotation,
    /// Displacement or distance.
    Translation,
}

/// A joint of the system being built.
#[derive(Clone, Debug)]
pub struct BuiltJoint {
    /// Its connection.
    pub connection: usize,
    /// First marker.
    pub a: usize,
    /// Second marker.
    pub b: usize,
    /// Its measures.
    pub rows: JointRows,
}

impl BuiltJoint {
    /// The measure of a free coordinate.
    pub fn coordinate(&self, which: JointCoordinate) -> Option<Measure> {
        match which {
            JointCoordinate::Rotation => self.rows.rotation.map(|rotation| rotation.angle),
            JointCoordinate::Translation => self.rows.translation,
        }
    }
}

/// Collects the pieces of a system; indices count in the order of adding.
#[derive(Clone, Debug)]
pub struct SystemBuilder {
    system: System,
    origins: Vec<Vector3<f64>>,
    orientations: Vec<UnitQuaternion<f64>>,
    velocities: Vec<f64>,
    /// Interface of each marker on a body, and whose rotation it follows.
    interfaces: Vec<Option<(usize, Turning)>>,
    /// Normal of the plane that motion stays in.
    plane: Option<Vector3<f64>>,
}

impl SystemBuilder {
    /// An empty system under gravity (world axes).
    pub fn new(dimension: Dimension, gravity: Vector3<f64>) -> Self {
        Self {
            system: System {
                dimension,
                gravity,
                bodies: Vec::new(),
                markers: Vec::new(),
                terms: Vec::new(),
                rows: Vec::new(),
                connections: Vec::new(),
                loads: Vec::new(),
                part_loads: Vec::new(),
                actuators: Vec::new(),
                controllers: Vec::new(),
                sensors: Vec::new(),
                slope_count: 0,
                argument_count: 0,
                memory_count: 0,
                signals: Vec::new(),
                inputs: Vec::new(),
                angle_count: 0,
                is_damped: false,
            },
            origins: Vec::new(),
            orientations: Vec::new(),
            velocities: Vec::new(),
            interfaces: Vec::new(),
            plane: None,
        }
    }

    /// Leaves out of a spatial system all motion out of a plane with this normal (world axes), and the constraints that hold only such
    /// motion: nothing excites it. Bodies come before, joints after. Whether it was done: not unless the normal is an axis of every
    /// body's frame. It has to be one of the world and of the frames that joints join, too, or rows hold motion in the plane and out of it at once.
    pub fn stay_in_plane(&mut self, normal: &Vector3<f64>) -> bool {
        let axes =
            (self.orientations.iter()).map(|turn| demand::axis_along(&(turn.inverse() * normal)));
        let Some(axes) = axes.collect::<Option<Vec<usize>>>() else {
            return false;
        };
        for (body, axis) in self.system.bodies.iter_mut().zip(axes) {
            let had = body.free;
            body.free =
                std::array::from_fn(|motion| had[motion] && (motion < 3) == (motion % 3 != axis));
            let own = &mut self.velocities[body.velocities.clone()];
            let velocity = Vector3::from_column_slice(&own[..3]);
            own[..3].copy_from_slice((velocity - normal * normal.dot(&velocity)).as_slice());
            for (rate, free) in own[3..6].iter_mut().zip(&body.free[3..]) {
                *rate = if *free { *rate } else { 0.0 };
            }
        }
        let gravity = &mut self.system.gravity;
        *gravity -= normal * normal.dot(gravity);
        self.plane = Some(*normal);
        true
    }

    /// Whether a measure changes only with motion out of the plane that motion stays in.
    fn leads_out_of_plane(&self, a: usize, b: usize, measure: &Measure) -> bool {
        let Some(normal) = &self.plane else {
            return false;
        };
        let gradient = measure.gradient(&self.frame(a), &self.frame(b));
        let lengths = self.system.bodies.iter().map(|body| body.length);
        let arm = demand::ALIGNED * lengths.fold(0.0, f64::max);
        [gradient.a, gradient.b].iter().all(|wrench| {
            let (force, moment) = (wrench.fixed_rows::<3>(0), wrench.fixed_rows::<3>(3));
            let pushed = force - normal * normal.dot(&force);
            pushed.norm() <= OBLIQUE * force.norm()
                && normal.dot(&moment).abs() <= OBLIQUE * moment.norm() + arm * force.norm()
        })
    }

    /// Adds a body as drawn.
    pub fn body(&mut self, name: &str, flexible: Arc<FlexibleBody>, drawn: &Drawn) -> usize {
        let n = flexible.coordinate_count();
        let (first_y, first_v) = (self.system.coordinate_count(), self.system.velocity_count());
        let first_row = self.system.residual_row_count();
        let residual_rows = match &flexible.residual_flexibility {
            Some(_) => flexible.rows.len(),
            None => 0,
        };
        // The frame's origin is the centre of mass.
        let center = drawn.orientation * Vector3::from(flexible.origin);
        self.origins.push(drawn.position + center);
        self.orientations.push(drawn.orientation);
        let velocity = drawn.velocity + drawn.angular_velocity.cross(&center);
        let spin = drawn.orientation.inverse() * drawn.angular_velocity;
        self.velocities.extend(velocity.iter().chain(spin.iter()));
        self.velocities.extend(std::iter::repeat_n(0.0, n));
        let inertia = flexible.inertia.rotation().tensor();
        let gyration = (inertia.diagonal().max() / flexible.inertia.mass()).sqrt();
        self.system.bodies.push(Body {
            name: name.to_owned(),
            coordinates: first_y..first_y + n,
            velocities: first_v..first_v + 6 + n,
            residual_rows: first_row..first_row + residual_rows,
            markers: Vec::new(),
            free: match (self.system.dimension, flexible.is_point_mass()) {
                (Dimension::Planar, true) => [true, true, false, false, false, false],
                (Dimension::Planar, false) => [true, true, false, false, false, true],
                (Dimension::Spatial, true) => [true, true, true, false, false, false],
                (Dimension::Spatial, false) => [true; 6],
            },
            length: gyration,
            flexible,
        });
        self.system.bodies.len() - 1
    }

    /// A frame on a body's interface, the same one if it was asked for before.
    ///
    /// # Errors
    /// [`Error::NoFrame`].
    pub fn marker(
        &mut self,
        body: usize,
        interface: usize,
        turning: Turning,
    ) -> Result<usize, Error> {
        let known = |marker: &usize| self.interfaces[*marker] == Some((interface, turning));
        if let Some(marker) = self.system.bodies[body].markers.iter().copied().find(known) {
            return Ok(marker);
        }
        let flexible = self.system.bodies[body].flexible.clone();
        let attachment = flexible.attachment(interface)?;
        let marker = marker_of(body, &flexible, interface, attachment, turning);
        let owner = &mut self.system.bodies[body];
        owner.length = owner.length.max(marker.position.norm());
        owner.markers.push(self.system.markers.len());
        self.system.markers.push(marker);
        self.interfaces.push(Some((interface, turning)));
        Ok(self.system.markers.len() - 1)
    }

    /// The frame of a body, the same one if it was asked for before.
    pub fn body_frame(&mut self, body: usize) -> usize {
        let owner = &mut self.system.bodies[body];
        let markers = &self.system.markers;
        let known = |marker: &usize| markers[*marker].interface.is_none();
        if let Some(marker) = owner.markers.iter().copied().find(known) {
            return marker;
        }
        owner.markers.push(markers.len());
        self.system.markers.push(Marker::on_body(body));
        self.interfaces.push(None);
        self.system.markers.len() - 1
    }

    /// A frame on the ground.
    pub fn ground(&mut self, position: Vector3<f64>, axes: Matrix3<f64>) -> usize {
        self.system.markers.push(Marker::on_ground(position, axes));
        self.interfaces.push(None);
        self.system.markers.len() - 1
    }

    /// A marker as drawn, at rest.
    pub fn frame(&self, marker: usize) -> FrameMotion {
        let marker = &self.system.markers[marker];
        let Some(body) = marker.body else {
            return FrameMotion::at_rest(marker.position, marker.axes);
        };
        let turn = self.orientations[body];
        let axes = turn.to_rotation_matrix().into_inner() * marker.axes;
        FrameMotion::at_rest(self.origins[body] + turn * marker.position, axes)
    }

    /// An interface as drawn, at rest; of one without a frame, the body's centre of mass.
    pub fn interface_frame(&self, body: usize, interface: usize) -> FrameMotion {
        let turn = self.orientations[body];
        let axes = turn.to_rotation_matrix().into_inner();
        match self.system.bodies[body].flexible.attachment(interface) {
            Ok(attachment) => FrameMotion::at_rest(
                self.origins[body] + turn * attachment.position,
                axes * attachment.axes,
            ),
            Err(_) => FrameMotion::at_rest(self.origins[body], axes),
        }
    }

    /// Counts the turns of an angle between two markers; the index of its value in the state.
    pub fn watch(&mut self, a: usize, b: usize, angle: Measure) -> usize {
        let known = self
            .system
            .terms
            .iter()
            .find(|term| (term.a, term.b, term.measure) == (a, b, angle))
            .and_then(|term| term.angle);
        known.unwrap_or_else(|| {
            self.system.terms.push(Term {
                weight: 1.0,
                a,
                b,
                measure: angle,
                angle: Some(self.system.angle_count),
            });
            self.system.angle_count += 1;
            self.system.angle_count - 1
        })
    }

    /// A function of time.
    pub fn signal(&mut self, signal: Signal) -> usize {
        self.system.signals.push(signal);
        self.system.signals.len() - 1
    }

    /// A value that is set from outside, and what it is at the start.
    pub fn input(&mut self, name: &str, initial: f64) -> usize {
        self.system.inputs.push((name.to_owned(), initial));
        self.system.inputs.len() - 1
    }

    /// The system so far.
    pub fn system(&self) -> &System {
        &self.system
    }

    /// Gives bodies without extent the length over which they move: the distance to what is farthest as drawn.
    fn measure_points(&mut self) {
        let places = (0..self.system.markers.len()).map(|marker| self.frame(marker).position);
        let places: Vec<Vector3<f64>> = places.chain(self.origins.iter().copied()).collect();
        let lengths = self.system.bodies.iter().map(|body| body.length);
        let longest = lengths.fold(0.0, f64::max);
        for (body, origin) in self.system.bodies.iter_mut().zip(&self.origins) {
            if body.length == 0.0 {
                let distances = places.iter().map(|place| (place - origin).norm());
                let reach = distances.fold(longest, f64::max);
                body.length = if reach > 0.0 { reach } else { 1.0 };
            }
        }
    }

    /// The system, and its state as drawn.
    pub fn finish(mut self) -> (System, State) {
        self.measure_points();
        let mut state = State::at_rest(&self.system);
        state.origins.copy_from_slice(&self.origins);
        state.orientations.copy_from_slice(&self.orientations);
        state.velocities.copy_from_slice(&self.velocities);
        (self.system, state)
    }
}
