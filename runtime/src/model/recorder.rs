//! What a run records: channels, and the probes that fill them.

use std::ops::Range;

use dcb_formats::component::Units;
use dcb_formats::description::{listed, suggestion};
use dcb_formats::mesh::Dimension;
use dcb_formats::results::{Channel, Column};
use nalgebra::{Matrix3, Vector3};

use super::library::Library;
use super::places::{Place, find};
use super::probe::{Chord, FrameQuantity, Moment, NodeShapes, Probe, Rate};
use super::{NamedJoint, Names};
use crate::energy::{Energy, Works};
use crate::error::Error;
use crate::integrator::newton::Effort;
use crate::measure::{Angle, Measure};
use crate::scene::{AtPlace, Output, ReactionAxes, Scene};
use crate::simulation::Simulation;
use crate::system::builder::{JointCoordinate, SystemBuilder, Turning, marker_of};
use crate::system::evaluation::Evaluation;
use crate::system::marker::Marker;
use crate::system::{ConnectionKind, State, System};

/// Channels of a results file, and how they are filled.
pub struct Recorder {
    channels: Vec<Channel>,
    probes: Vec<Probe>,
    row: Vec<f64>,
}

/// What a recorded row is computed from.
pub struct RecordedStep<'a> {
    /// The mechanism.
    pub system: &'a System,
    /// The motion.
    pub state: &'a State,
    /// Evaluated at the state, with velocities and accelerations.
    pub evaluation: &'a Evaluation,
    /// Energy at the state.
    pub energy: Energy,
    /// Works since the start.
    pub works: Works,
    /// Defect of the energy balance.
    pub defect: f64,
    /// Size of the last step.
    pub step: f64,
    /// Newton iterations of the last step.
    pub iterations: usize,
}

impl<'a> RecordedStep<'a> {
    /// Where a simulation is, after a step of this size and effort.
    pub fn of(simulation: &'a mut Simulation, step: f64, effort: Effort) -> Self {
        simulation.refresh();
        let (energy, works, defect) = simulation.energy();
        Self {
            system: simulation.system(),
            state: simulation.state(),
            evaluation: simulation.evaluation(),
            energy,
            works,
            defect,
            step,
            iterations: effort.iterations,
        }
    }
}

impl<'a> RecordedStep<'a> {
    /// A state that no simulation led to; nothing has done work.
    pub fn at(system: &'a System, state: &'a State, evaluation: &'a mut Evaluation) -> Self {
        evaluation.refresh(system, state);
        let energy = Energy::at(system, state, evaluation);
        Self {
            system,
            state,
            evaluation,
            energy,
            works: Works::default(),
            defect: 0.0,
            step: 0.0,
            iterations: 0,
        }
    }
}

impl Recorder {
    /// The scene's outputs, and what every run records: reactions, interface forces, drives, springs, energies, drift, steps.
    pub(super) fn for_scene(
        scene: &Scene,
        builder: &mut SystemBuilder,
        names: &Names,
        library: &mut Library,
    ) -> Result<Self, Error> {
        let mut recorder = Self {
            channels: Vec::new(),
            probes: Vec::new(),
            row: Vec::new(),
        };
        let quantities = Quantities::of(&scene.units);
        let mut add = OutputBuilder {
            scene,
            builder,
            names,
            library,
            quantities: &quantities,
        };
        for (name, output) in &scene.outputs {
            let (channel, probe) = add.output(name, output)?;
            recorder.add(channel, probe);
        }
        recorder.add_standard(builder.system(), &quantities);
        Ok(recorder)
    }

    fn add(&mut self, channel: Channel, probe: Probe) {
        self.channels.push(channel);
        self.probes.push(probe);
    }

    /// What every run records.
    fn add_standard(&mut self, system: &System, quantities: &Quantities) {
        for connection in &system.connections {
            let (name, rows) = (&connection.name, connection.rows.clone());
            match connection.kind {
                ConnectionKind::Joint => self.add(
                    quantities.wrench(
                        &format!("reactions/{name}"),
                        system.dimension,
                        "force and moment of the joint on its first body, world axes",
                    ),
                    Probe::Reaction {
                        rows,
                        a: connection.a,
                        b: connection.b,
                        axes: ReactionAxes::World,
                    },
                ),
                ConnectionKind::Drive => {
                    let channel = quantities.effort(&format!("drives/{name}"), system, &rows);
                    self.add(channel, Probe::Forces { rows });
                }
                ConnectionKind::Spring => {
                    let channel = quantities.effort(&format!("springs/{name}"), system, &rows);
                    self.add(channel, Probe::Forces { rows });
                }
            }
        }
        for body in &system.bodies {
            let flexible = &body.flexible;
            if flexible.coordinate_count() == 0 {
                continue;
            }
            for (index, interface) in flexible.interfaces.iter().enumerate() {
                let found = body
                    .markers
                    .iter()
                    .find(|marker| system.markers[**marker].interface == Some(index));
                if let Some(&marker) = found {
                    let path = format!("interface_forces/{}/{}", body.name, interface.name);
                    let description =
                        "force on the interface and what is conjugate to its rotation, body axes";
                    self.add(
                        quantities.wrench(&path, system.dimension, description),
                        Probe::InterfaceForce { marker },
                    );
                }
            }
        }
        self.add(quantities.energy("energy/balance"), Probe::Energy);
        self.add(
            Channel {
                path: "constraints/drift".into(),
                columns: vec![
                    column("position", &quantities.length),
                    column("velocity", &quantities.velocity),
                    column("angle", "rad"),
                    column("angular_velocity", &quantities.angular_velocity),
                ],
                description: "largest violation of the constraints and of their rates".into(),
            },
            Probe::Drift,
        );
        self.add(
            Channel {
                path: "integrator/steps".into(),
                columns: vec![column("step", &quantities.time), column("iterations", "1")],
                description: "size of the last step and its Newton iterations".into(),
            },
            Probe::Steps,
        );
    }

    /// The channels, in the order of a row's values.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Where the values of a channel are in a row: a path, a path in `outputs`, or a last part that only one channel has.
    ///
    /// # Errors
    /// [`Error::UnknownOutput`] with the nearest name.
    pub fn columns(&self, name: &str) -> Result<Range<usize>, Error> {
        let paths = || self.channels.iter().map(|channel| channel.path.as_str());
        let in_outputs = format!("outputs/{name}");
        let exact = paths().position(|path| path == name || path == in_outputs);
        let mut last = self.channels.iter().enumerate();
        let mut last = last.by_ref().filter(|(_, channel)| channel.name() == name);
        let found = exact.or_else(|| match (last.next(), last.next()) {
            (Some((index, _)), None) => Some(index),
            _ => None,
        });
        let Some(index) = found else {
            let short = || paths().map(|path| path.strip_prefix("outputs/").unwrap_or(path));
            let hint = match suggestion(name, short()) {
                none if none.is_empty() => format!("; there are: {}", listed(short())),
                nearest => nearest,
            };
            return Err(Error::UnknownOutput {
                name: name.to_owned(),
                hint,
            });
        };
        let width = |channel: &Channel| channel.columns.len();
        let first = self.channels[..index].iter().map(width).sum();
        Ok(first..first + width(&self.channels[index]))
    }

    /// The values of all channels at a step.
    pub fn row(&mut self, at: &RecordedStep) -> &[f64] {
        let moment = Moment {
            system: at.system,
            state: at.state,
            evaluation: at.evaluation,
            energy: &at.energy,
            works: &at.works,
            defect: at.defect,
            step: (at.step, at.iterations),
        };
        self.row.clear();
        for probe in &mut self.probes {
            probe.write(&moment, &mut self.row);
        }
        &self.row
    }
}

fn column(name: &str, unit: &str) -> Column {
    Column {
        name: name.to_owned(),
        unit: unit.to_owned(),
    }
}

/// Units of what is recorded.
struct Quantities {
    length: String,
    time: String,
    velocity: String,
    acceleration: String,
    angular_velocity: String,
    force: String,
    moment: String,
    energy: String,
    modal: String,
}

impl Quantities {
    fn of(units: &Units) -> Self {
        let (l, m, t) = (&units.length, &units.mass, &units.time);
        Self {
            length: l.clone(),
            time: t.clone(),
            velocity: format!("{l}/{t}"),
            acceleration: format!("{l}/{t}^2"),
            angular_velocity: format!("rad/{t}"),
            force: format!("{m}*{l}/{t}^2"),
            moment: format!("{m}*{l}^2/{t}^2"),
            energy: format!("{m}*{l}^2/{t}^2"),
            modal: format!("sqrt({m})*{l}"),
        }
    }

    fn vector(&self, path: &str, dimension: Dimension, unit: &str, description: &str) -> Channel {
        let names: &[&str] = match dimension {
            Dimension::Planar => &["x", "y"],
            Dimension::Spatial => &["x", "y", "z"],
        };
        Channel::vector(path, names, unit, description)
    }

    fn wrench(&self, path: &str, dimension: Dimension, description: &str) -> Channel {
        let (forces, moments): (&[&str], &[&str]) = match dimension {
            Dimension::Planar => (&["fx", "fy"], &["mz"]),
            Dimension::Spatial => (&["fx", "fy", "fz"], &["mx", "my", "mz"]),
        };
        let columns = forces.iter().map(|name| column(name, &self.force));
        let moments = moments.iter().map(|name| column(name, &self.moment));
        Channel {
            path: path.to_owned(),
            columns: columns.chain(moments).collect(),
            description: description.to_owned(),
        }
    }

    /// λ of rows, a force or a moment each.
    fn effort(&self, path: &str, system: &System, rows: &std::ops::Range<usize>) -> Channel {
        let one = |row: usize| {
            let measure = &system.terms[system.rows[row].terms.start].measure;
            let unit = if measure.is_length() {
                &self.force
            } else {
                &self.moment
            };
            let name = match rows.len() {
                1 => String::new(),
                _ => (row - rows.start + 1).to_string(),
            };
            column(&name, unit)
        };
        Channel {
            path: path.to_owned(),
            columns: rows.clone().map(one).collect(),
            description: "force or moment conjugate to the coordinate, on its second body".into(),
        }
    }

    fn energy(&self, path: &str) -> Channel {
        let names = [
            "kinetic",
            "strain",
            "gravity",
            "springs",
            "drives",
            "loads",
            "dissipated",
            "defect",
        ];
        Channel::vector(
            path,
            &names,
            &self.energy,
            "energy stored, work of drives and loads since the start, heat, and what the balance lacks",
        )
    }
}

/// Makes channels and probes of a scene's outputs.
struct OutputBuilder<'a> {
    scene: &'a Scene,
    builder: &'a mut SystemBuilder,
    names: &'a Names,
    library: &'a mut Library,
    quantities: &'a Quantities,
}

impl OutputBuilder<'_> {
    fn output(&mut self, name: &str, output: &Output) -> Result<(Channel, Probe), Error> {
        let (path, at) = (format!("outputs/{name}"), format!("outputs.{name}"));
        let (q, dimension) = (self.quantities, self.scene.dimension);
        Ok(match output {
            Output::Position(of) => {
                let channel = q.vector(&path, dimension, &q.length, "position, world axes");
                (channel, self.frame(&at, of, FrameQuantity::Position)?)
            }
            Output::Displacement(of) => {
                let channel = q.vector(&path, dimension, &q.length, "displacement, world axes");
                (channel, self.frame(&at, of, FrameQuantity::Displacement)?)
            }
            Output::Velocity(of) => {
                let channel = q.vector(&path, dimension, &q.velocity, "velocity, world axes");
                (channel, self.frame(&at, of, FrameQuantity::Velocity)?)
            }
            Output::Acceleration(of) => {
                let unit = &q.acceleration;
                let channel = q.vector(&path, dimension, unit, "acceleration, world axes");
                (channel, self.frame(&at, of, FrameQuantity::Acceleration)?)
            }
            Output::Orientation(of) => {
                let channel = match dimension {
                    Dimension::Planar => Channel::scalar(&path, "rad", "angle against the world"),
                    Dimension::Spatial => {
                        let names = ["w", "x", "y", "z"];
                        Channel::vector(&path, &names, "1", "quaternion, own axes to world axes")
                    }
                };
                (channel, self.frame(&at, of, FrameQuantity::Orientation)?)
            }
            Output::AngularVelocity(of) => {
                let what = "angular velocity, world axes";
                let channel = match dimension {
                    Dimension::Planar => Channel::scalar(&path, &q.angular_velocity, what),
                    Dimension::Spatial => q.vector(&path, dimension, &q.angular_velocity, what),
                };
                (
                    channel,
                    self.frame(&at, of, FrameQuantity::AngularVelocity)?,
                )
            }
            Output::ChordDeflection(of) => {
                let at = format!("{at}.chord_deflection");
                let what = "deflection from the chord by the chord's length, body axes";
                let channel = match dimension {
                    Dimension::Planar => Channel::scalar(&path, "1", what),
                    Dimension::Spatial => q.vector(&path, dimension, "1", what),
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
                (channel, Probe::Chord { body, chord })
            }
            Output::NodeDisplacement(of) => {
                let node = self.node(&format!("{at}.node_displacement"), &of.body, of.node)?;
                let what = "elastic displacement of the node, body axes";
                let body = self.body(&of.body);
                let channel = q.vector(&path, dimension, &q.length, what);
                (channel, Probe::NodeDisplacement { body, node })
            }
            Output::NodePosition(of) => {
                let node = self.node(&format!("{at}.node_position"), &of.body, of.node)?;
                let body = self.body(&of.body);
                let channel = q.vector(
                    &path,
                    dimension,
                    &q.length,
                    "position of the node, world axes",
                );
                (channel, Probe::NodePosition { body, node })
            }
            Output::JointCoordinate(of) => self.coordinate(&path, &at, &of.joint, Rate::Value)?,
            Output::JointRate(of) => self.coordinate(&path, &at, &of.joint, Rate::Rate)?,
            Output::Reaction(of) => {
                let connection = self.joint(&at, &of.joint)?.connection;
                let connection = &self.builder.system().connections[connection];
                let what = "force and moment of the joint on its first body";
                let probe = Probe::Reaction {
                    rows: connection.rows.clone(),
                    a: connection.a,
                    b: connection.b,
                    axes: of.axes,
                };
                (q.wrench(&path, dimension, what), probe)
            }
            Output::InterfaceForce(of) => {
                let (place, _) = self.marker(&format!("{at}.interface_force.at"), &of.at)?;
                let Place::Body { body, interface } = place else {
                    return Err(Error::described(at, "is on the ground"));
                };
                let system = self.builder.system();
                let marker = system.bodies[body]
                    .markers
                    .iter()
                    .copied()
                    .find(|marker| system.markers[*marker].interface == Some(interface));
                let marker = marker.ok_or_else(|| {
                    Error::described(
                        format!("{at}.interface_force.at"),
                        format!(
                            "nothing takes hold of {:?}: no joint, spring or load is there",
                            of.at
                        ),
                    )
                })?;
                let what =
                    "force on the interface and what is conjugate to its rotation, body axes";
                (
                    q.wrench(&path, dimension, what),
                    Probe::InterfaceForce { marker },
                )
            }
            Output::DriveEffort(of) => {
                self.forces(&path, self.names.drives.get(&of.drive).copied(), &at)?
            }
            Output::SpringForce(of) => {
                self.forces(&path, self.names.springs.get(&of.spring).copied(), &at)?
            }
            Output::Modal(of) => {
                let body = &self.builder.system().bodies[self.body(&of.body)];
                let names: Vec<String> = (1..=body.coordinates.len())
                    .map(|k| k.to_string())
                    .collect();
                let names: Vec<&str> = names.iter().map(String::as_str).collect();
                if names.is_empty() {
                    return Err(Error::described(at, "is of a body without coordinates"));
                }
                let what = "dynamic coordinates: modes, then attachments";
                (
                    Channel::vector(&path, &names, &q.modal, what),
                    Probe::Modal {
                        coordinates: body.coordinates.clone(),
                    },
                )
            }
            Output::Energy => (q.energy(&path), Probe::Energy),
        })
    }

    fn body(&self, name: &str) -> usize {
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

    fn frame(&mut self, at: &str, of: &AtPlace, quantity: FrameQuantity) -> Result<Probe, Error> {
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
        Ok(Probe::Frame {
            marker: Box::new(marker),
            quantity,
            at_start,
            angle,
        })
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

    fn node(&mut self, at: &str, body: &str, node: u32) -> Result<NodeShapes, Error> {
        let fields = self.library.fields(self.scene, body, at)?;
        let flexible = &self.builder.system().bodies[self.body(body)].flexible;
        let (basis, mesh) = (&fields.0, &fields.1);
        NodeShapes::of(flexible, basis, mesh, node).ok_or_else(|| {
            let count = mesh.node_count();
            Error::described(
                format!("{at}.node"),
                format!("is {node}, but the fields of body {body:?} don't have it (mesh of {count} nodes, counted from 0)"),
            )
        })
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
        let probe = Probe::Coordinate {
            a: built.a,
            b: built.b,
            measure,
            angle,
            zero: named.zero(which),
            is_rate,
        };
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
