//! A scene's outputs, to channels and probes.

use dcb_formats::mesh::Dimension;
use dcb_formats::results::Channel;
use nalgebra::{Matrix3, Vector3};

use super::library::Library;
use super::node_shapes::{Chord, NodeShapes};
use super::places::{Place, find};
use super::probe::{CoordinateProbe, FrameProbe, FrameQuantity, NodeQuantity, Probe, Rate};
use super::quantities::Quantities;
use super::{NamedJoint, Names};
use crate::error::Error;
use crate::measure::{Angle, Measure};
use crate::system::builder::{JointCoordinate, SystemBuilder, Turning, marker_of};
use crate::system::marker::Marker;
use dcb_formats::scene::{
    Analysis, AtPlace, ChordDeflection, OfSuperelement, Output, Reaction, Scene,
};

/// Makes channels and probes of a scene's outputs.
pub(super) struct OutputBuilder<'a> {
    pub(super) scene: &'a Scene,
    pub(super) builder: &'a mut SystemBuilder,
    pub(super) names: &'a Names,
    pub(super) library: &'a mut Library,
    pub(super) quantities: &'a Quantities,
}

impl OutputBuilder<'_> {
    pub(super) fn output(
        &mut self,
        name: &str,
        output: &Output,
    ) -> Result<(Channel, Probe), Error> {
        let (path, at) = (format!("outputs/{name}"), format!("outputs.{name}"));
        let kind = format!("{at}.{}", output.kind());
        match output {
            Output::Position(of) => self.frame(&path, &at, of, FrameQuantity::Position),
            Output::Displacement(of) => self.frame(&path, &at, of, FrameQuantity::Displacement),
            Output::Velocity(of) => self.frame(&path, &at, of, FrameQuantity::Velocity),
            Output::Acceleration(of) => self.frame(&path, &at, of, FrameQuantity::Acceleration),
            Output::Orientation(of) => self.frame(&path, &at, of, FrameQuantity::Orientation),
            Output::AngularVelocity(of) => {
                self.frame(&path, &at, of, FrameQuantity::AngularVelocity)
            }
            Output::ChordDeflection(of) => self.chord_deflection(&path, &at, of),
            Output::NodeDisplacement(of) => {
                self.node_motion(&path, &kind, of, NodeQuantity::Displacement)
            }
            Output::NodePosition(of) => self.node_motion(&path, &kind, of, NodeQuantity::Position),
            Output::NodeVelocity(of) => self.node_motion(&path, &kind, of, NodeQuantity::Velocity),
            Output::NodeAcceleration(of) => {
                self.node_motion(&path, &kind, of, NodeQuantity::Acceleration)
            }
            Output::BodyPosition(of) => {
                Ok(self.body_frame(&path, &of.body, FrameQuantity::Position))
            }
            Output::BodyVelocity(of) => {
                Ok(self.body_frame(&path, &of.body, FrameQuantity::Velocity))
            }
            Output::BodyOrientation(of) => {
                Ok(self.body_frame(&path, &of.body, FrameQuantity::Orientation))
            }
            Output::BodyAngularVelocity(of) => {
                Ok(self.body_frame(&path, &of.body, FrameQuantity::AngularVelocity))
            }
            Output::CenterOfMass(of) => Ok(self.center_of_mass(&path, of)),
            Output::Momentum(of) => Ok(self.momentum(&path, of)),
            Output::AngularMomentum(of) => Ok(self.angular_momentum(&path, of)),
            Output::JointCoordinate(of) => self.coordinate(&path, &at, &of.joint, Rate::Value),
            Output::JointRate(of) => self.coordinate(&path, &at, &of.joint, Rate::Rate),
            Output::Reaction(of) => self.reaction(&path, &at, of),
            Output::InterfaceForce(of) => self.interface_force(&path, &at, of),
            Output::DriveEffort(of) => {
                self.forces(&path, self.names.drives.get(&of.drive).copied(), &at)
            }
            Output::SpringForce(of) => {
                self.forces(&path, self.names.springs.get(&of.spring).copied(), &at)
            }
            Output::ActuatorEffort(of) => {
                let connection = self.names.actuators.get(&of.actuator).copied();
                self.forces(&path, connection, &at)
            }
            Output::Modal(of) => self.modal(&path, &at, of),
            Output::Stress(of) => self.stress(&path, &kind, of),
            Output::Energy => Ok(energy(self.quantities, self.scene, &path)),
        }
    }

    fn chord_deflection(
        &mut self,
        path: &str,
        at: &str,
        of: &ChordDeflection,
    ) -> Result<(Channel, Probe), Error> {
        let at = format!("{at}.chord_deflection");
        let what = "deflection from the chord by the chord's length, body axes";
        let dimension = self.scene.dimension;
        let channel = match dimension {
            Dimension::Planar => Channel::scalar(path, "1", what),
            Dimension::Spatial => self.quantities.vector(path, dimension, "1", what),
        };
        let body = self.body(&of.body);
        let node = self.node(&at, &of.body, of.node)?;
        let mut ends = Vec::new();
        for interface in &of.between {
            let reference = format!("{}/{interface}", of.body);
            ends.push(self.marker(&format!("{at}.between"), &reference)?.1);
        }
        let chord = <[Marker; 2]>::try_from(ends).ok();
        let chord = chord.and_then(|ends| Chord::between(node, ends));
        let chord = chord.ok_or_else(|| {
            Error::described(format!("{at}.between"), "names two interfaces at one point")
        })?;
        let chord = Box::new(chord);
        Ok((channel, Probe::Chord { body, chord }))
    }

    fn reaction(&self, path: &str, at: &str, of: &Reaction) -> Result<(Channel, Probe), Error> {
        let connection = self.joint(at, &of.joint)?.connection;
        let connection = &self.builder.system().connections[connection];
        let what = "force and moment of the joint on its first body";
        let probe = Probe::Reaction {
            rows: connection.rows.clone(),
            a: connection.a,
            b: connection.b,
            axes: of.axes,
        };
        let dimension = self.scene.dimension;
        Ok((self.quantities.wrench(path, dimension, what), probe))
    }

    fn interface_force(
        &self,
        path: &str,
        at: &str,
        of: &AtPlace,
    ) -> Result<(Channel, Probe), Error> {
        let (place, _) = self.marker(&format!("{at}.interface_force.at"), &of.at)?;
        let Place::Body { body, interface } = place else {
            return Err(Error::described(at, "is on the ground"));
        };
        let markers = self.builder.system().markers_on(body, interface);
        if markers.is_empty() {
            return Err(Error::described(
                format!("{at}.interface_force.at"),
                format!(
                    "nothing takes hold of {:?}: no joint, spring or load is there",
                    of.at
                ),
            ));
        }
        let what = "force on the interface and what is conjugate to its rotation, body axes";
        let channel = self.quantities.wrench(path, self.scene.dimension, what);
        Ok((channel, Probe::InterfaceForce { markers }))
    }

    fn modal(&self, path: &str, at: &str, of: &OfSuperelement) -> Result<(Channel, Probe), Error> {
        let body = &self.builder.system().bodies[self.body(&of.body)];
        let names: Vec<String> = (1..=body.coordinates.len())
            .map(|k| k.to_string())
            .collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        if names.is_empty() {
            return Err(Error::described(at, "is of a body without coordinates"));
        }
        let what = "dynamic coordinates: modes, then attachments";
        let probe = Probe::Modal {
            coordinates: body.coordinates.clone(),
        };
        let unit = &self.quantities.modal;
        Ok((Channel::vector(path, &names, unit, what), probe))
    }

    /// Channel of a quantity of a frame.
    pub(super) fn frame_channel(&self, path: &str, quantity: FrameQuantity) -> Channel {
        let (q, dimension) = (self.quantities, self.scene.dimension);
        let vector = |unit: &str, what: &str| q.vector(path, dimension, unit, what);
        match (quantity, dimension) {
            (FrameQuantity::Position, _) => vector(&q.length, "position, world axes"),
            (FrameQuantity::Displacement, _) => vector(&q.length, "displacement, world axes"),
            (FrameQuantity::Velocity, _) => vector(&q.velocity, "velocity, world axes"),
            (FrameQuantity::Acceleration, _) => vector(&q.acceleration, "acceleration, world axes"),
            (FrameQuantity::Orientation, Dimension::Planar) => {
                Channel::scalar(path, "rad", "angle against the world")
            }
            (FrameQuantity::Orientation, Dimension::Spatial) => {
                let names = ["w", "x", "y", "z"];
                Channel::vector(path, &names, "1", "quaternion, own axes to world axes")
            }
            (FrameQuantity::AngularVelocity, Dimension::Planar) => {
                Channel::scalar(path, &q.angular_velocity, "angular velocity, world axes")
            }
            (FrameQuantity::AngularVelocity, Dimension::Spatial) => {
                vector(&q.angular_velocity, "angular velocity, world axes")
            }
        }
    }

    pub(super) fn body(&self, name: &str) -> usize {
        self.names.bodies.get(name).copied().unwrap_or_default()
    }

    fn joint(&self, at: &str, name: &str) -> Result<&NamedJoint, Error> {
        let unknown = || Error::described(at, format!("there is no joint {name:?}"));
        self.names.joints.get(name).ok_or_else(unknown)
    }

    /// A frame at a place that follows it without loading it.
    fn marker(&self, at: &str, reference: &str) -> Result<(Place, Marker), Error> {
        let place = find(self.scene, self.builder, self.names, at, reference)?;
        let marker = match &place {
            Place::Ground { position, axes } => Marker::on_ground(*position, *axes),
            Place::Body { body, interface } => {
                let flexible = &self.builder.system().bodies[*body].flexible;
                let attachment = flexible
                    .attachment(*interface)
                    .map_err(|error| Error::described(at, error.to_string()))?;
                marker_of(*body, flexible, *interface, attachment, Turning::Interface)
            }
        };
        Ok((place, marker))
    }

    fn frame(
        &mut self,
        path: &str,
        at: &str,
        of: &AtPlace,
        quantity: FrameQuantity,
    ) -> Result<(Channel, Probe), Error> {
        let channel = self.frame_channel(path, quantity);
        let (place, marker) = self.marker(&format!("{at}.at"), &of.at)?;
        let at_start = match place {
            Place::Ground { position, .. } => position,
            Place::Body { body, interface } => {
                self.builder.interface_frame(body, interface).position
            }
        };
        let turns =
            (quantity, self.scene.dimension) == (FrameQuantity::Orientation, Dimension::Planar);
        let angle = match place {
            Place::Body { body, interface } if turns => Some(self.turns(body, interface)?),
            _ => None,
        };
        let probe = FrameProbe {
            marker,
            quantity,
            at_start,
            angle,
        };
        Ok((channel, Probe::Frame(Box::new(probe))))
    }

    /// Counts the turns of an interface against the world; planar.
    fn turns(&mut self, body: usize, interface: usize) -> Result<usize, Error> {
        let is_rigid = self.builder.system().bodies[body].coordinates.is_empty();
        let turning = if is_rigid {
            Turning::Body
        } else {
            Turning::Interface
        };
        let world = self.builder.ground(Vector3::zeros(), Matrix3::identity());
        let marker = self.builder.marker(body, interface, turning)?;
        Ok(self
            .builder
            .watch(world, marker, Measure::Angle(Angle::in_plane())))
    }

    pub(super) fn node(&mut self, at: &str, body: &str, node: u32) -> Result<NodeShapes, Error> {
        let fields = self.library.fields_of_node(self.scene, body, node, at)?;
        let flexible = &self.builder.system().bodies[self.body(body)].flexible;
        Ok(NodeShapes::of(flexible, &fields))
    }

    fn coordinate(
        &mut self,
        path: &str,
        at: &str,
        joint: &str,
        is_rate: Rate,
    ) -> Result<(Channel, Probe), Error> {
        let named = self.joint(at, joint)?.clone();
        let found = named.built.as_ref().and_then(|built| {
            [JointCoordinate::Rotation, JointCoordinate::Translation]
                .into_iter()
                .find_map(|which| {
                    built
                        .coordinate(which)
                        .map(|measure| (built, which, measure))
                })
        });
        let Some((built, which, measure)) = found else {
            return Err(Error::described(
                at,
                format!("joint {joint:?} has no coordinate"),
            ));
        };
        let angle = matches!(measure, Measure::Angle(_))
            .then(|| self.builder.watch(built.a, built.b, measure));
        let q = self.quantities;
        let unit = match (measure.is_length(), is_rate) {
            (true, Rate::Value) => &q.length,
            (true, Rate::Rate) => &q.velocity,
            (false, Rate::Value) => "rad",
            (false, Rate::Rate) => &q.angular_velocity,
        };
        let probe = Probe::Coordinate(CoordinateProbe {
            a: built.a,
            b: built.b,
            measure,
            angle,
            zero: named.zero(which),
            is_rate,
        });
        Ok((
            Channel::scalar(path, unit, "coordinate of the joint"),
            probe,
        ))
    }

    fn forces(
        &self,
        path: &str,
        connection: Option<usize>,
        at: &str,
    ) -> Result<(Channel, Probe), Error> {
        let unknown = || Error::described(at, "names nothing in the scene");
        let system = self.builder.system();
        let rows = system.connections[connection.ok_or_else(unknown)?]
            .rows
            .clone();
        let channel = self.quantities.effort(path, system, &rows);
        Ok((channel, Probe::Forces { rows }))
    }
}

/// Energies: works and the balance belong to a motion over time.
pub(super) fn energy(quantities: &Quantities, scene: &Scene, path: &str) -> (Channel, Probe) {
    match &scene.analysis {
        Analysis::Transient => (quantities.energy(path), Probe::Energy),
        Analysis::Static
        | Analysis::InertiaRelief
        | Analysis::Kinematic
        | Analysis::Modes(_)
        | Analysis::FrequencyResponse(_) => (quantities.stored_energy(path), Probe::StoredEnergy),
    }
}
