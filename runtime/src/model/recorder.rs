//! Records of a run: channels, and the probes that fill them.

use std::ops::Range;

use dcb_formats::description::{listed, suggestion};
use dcb_formats::mesh::Dimension;
use dcb_formats::results::Channel;

use super::Names;
use super::library::Library;
use super::moment::Moment;
use super::outputs::{OutputBuilder, energy};
use super::probe::{FrameQuantity, NodeQuantity, Probe};
use super::quantities::{Quantities, column};
use crate::body::Compatibility;
use crate::energy::{Energy, Works};
use crate::error::Error;
use crate::integrator::Effort;
use crate::simulation::Simulation;
use crate::system::builder::SystemBuilder;
use crate::system::evaluation::Evaluation;
use crate::system::marker::Marker;
use crate::system::{ConnectionKind, State, System};
use dcb_formats::scene::{ReactionAxes, Scene};
use dcb_formats::superelement::BoundaryRow;

/// Channels of a results file, and how they are filled.
pub struct Recorder {
    channels: Vec<Channel>,
    probes: Vec<Probe>,
    row: Vec<f64>,
}

/// Source of a recorded row.
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
    /// A state within a simulation's last step, as [`Simulation::look_within`] gave it last.
    pub fn within(
        simulation: &'a mut Simulation,
        state: &'a State,
        step: f64,
        effort: Effort,
    ) -> Self {
        let (energy, works, defect) = simulation.energy_within(state);
        Self {
            system: simulation.system(),
            state,
            evaluation: simulation.evaluation(),
            energy,
            works,
            defect,
            step,
            iterations: effort.iterations,
        }
    }

    /// A state that no motion over time led to: it has no works and no balance.
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
        recorder.add_standard(scene, builder.system(), &quantities);
        Ok(recorder)
    }

    fn add(&mut self, channel: Channel, probe: Probe) {
        self.channels.push(channel);
        self.probes.push(probe);
    }

    /// Channels that every run records.
    fn add_standard(&mut self, scene: &Scene, system: &System, quantities: &Quantities) {
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
                ConnectionKind::Actuator => {
                    let channel = quantities.effort(&format!("actuators/{name}"), system, &rows);
                    self.add(channel, Probe::Forces { rows });
                }
                // Seen as dissipation only.
                ConnectionKind::AssembledModes => {}
                ConnectionKind::Spring => {
                    let channel = quantities.effort(&format!("springs/{name}"), system, &rows);
                    self.add(channel, Probe::Forces { rows });
                }
            }
        }
        for (body_index, body) in system.bodies.iter().enumerate() {
            let flexible = &body.flexible;
            if flexible.coordinate_count() == 0 {
                continue;
            }
            for (index, interface) in flexible.interfaces.iter().enumerate() {
                let markers = system.markers_on(body_index, index);
                if markers.is_empty() {
                    continue;
                }
                let path = format!("interface_forces/{}/{}", body.name, interface.name);
                let description =
                    "force on the interface and what is conjugate to its rotation, body axes";
                self.add(
                    quantities.wrench(&path, system.dimension, description),
                    Probe::InterfaceForce { markers },
                );
            }
        }
        self.add_motion(system, quantities);
        let (channel, probe) = energy(quantities, scene, "energy/balance");
        self.add(channel, probe);
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

    /// Where every body is, and how it deflects: what pictures need.
    fn add_motion(&mut self, system: &System, quantities: &Quantities) {
        for (index, body) in system.bodies.iter().enumerate() {
            let columns = match system.dimension {
                Dimension::Planar => vec![
                    column("x", &quantities.length),
                    column("y", &quantities.length),
                    column("angle", "rad"),
                ],
                Dimension::Spatial => ["x", "y", "z"]
                    .map(|name| column(name, &quantities.length))
                    .into_iter()
                    .chain(["qw", "qx", "qy", "qz"].map(|name| column(name, "1")))
                    .collect(),
            };
            let frame = Channel {
                path: format!("motion/{}/frame", body.name),
                columns,
                description: "origin of the body's floating frame and its turn, world axes".into(),
            };
            self.add(frame, Probe::BodyFrame { body: index });
            let count = body.flexible.coordinate_count();
            if count > 0 {
                let channel = Channel {
                    path: format!("motion/{}/coordinates", body.name),
                    columns: (1..=count)
                        .map(|number| column(&number.to_string(), &quantities.modal))
                        .collect(),
                    description: "elastic coordinates of the body".into(),
                };
                let coordinates = body.coordinates.clone();
                self.add(channel, Probe::Modal { coordinates });
            }
            let rows = body.flexible.rows.len();
            if body.flexible.compatibility == Compatibility::Static && rows > 0 {
                let unit = |row: &BoundaryRow| match row.direction {
                    0..=2 => &quantities.force,
                    _ => &quantities.moment,
                };
                let numbered = body.flexible.rows.iter().zip(1..);
                let channel = Channel {
                    path: format!("motion/{}/forces", body.name),
                    columns: numbered
                        .map(|(row, number)| column(&i32::to_string(&number), unit(row)))
                        .collect(),
                    description:
                        "forces on the rows of the interfaces, which deflect the body at once"
                            .into(),
                };
                self.add(channel, Probe::RowForces { body: index, rows });
            }
        }
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
        let index = self.channel(name)?;
        let width = |channel: &Channel| channel.columns.len();
        let first = self.channels[..index].iter().map(width).sum();
        Ok(first..first + width(&self.channels[index]))
    }

    /// The index of a channel, named so.
    ///
    /// # Errors
    /// As [`Recorder::columns`].
    pub(crate) fn channel(&self, name: &str) -> Result<usize, Error> {
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
        Ok(index)
    }

    /// Whether a channel follows from a state, in the order of the channels; histories and reports on steps don't.
    pub(crate) fn follows_from_state(&self, channel: usize) -> bool {
        !matches!(
            self.probes[channel],
            Probe::Energy | Probe::Drift | Probe::Steps
        )
    }

    /// Whether a channel's numbers have derivatives everywhere.
    pub(crate) fn is_smooth(&self, channel: usize) -> bool {
        !matches!(&self.probes[channel], Probe::Stress(stress) if !stress.is_smooth())
    }

    /// The place whose displacement, world axes, a channel is; `None` for others.
    pub(crate) fn displaced(&self, channel: usize) -> Option<&Marker> {
        match &self.probes[channel] {
            Probe::Frame(frame) => match frame.quantity {
                FrameQuantity::Position | FrameQuantity::Displacement => Some(&frame.marker),
                _ => None,
            },
            _ => None,
        }
    }

    /// Whether a channel's numbers are forces or accelerations: what they have of a place they have through the stiffness.
    pub(crate) fn follows_forces(&self, channel: usize) -> bool {
        match &self.probes[channel] {
            Probe::Reaction { .. }
            | Probe::InterfaceForce { .. }
            | Probe::Forces { .. }
            | Probe::RowForces { .. } => true,
            Probe::Frame(frame) => frame.quantity == FrameQuantity::Acceleration,
            Probe::Node { quantity, .. } => *quantity == NodeQuantity::Acceleration,
            _ => false,
        }
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
