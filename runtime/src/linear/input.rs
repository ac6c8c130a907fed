//! Inputs of a linear system: amplitudes of loads, efforts of actuators, targets of servos, accelerations of drives.

use dcb_formats::description::{listed, suggestion};
use dcb_formats::function::{Function, TimeFunction};
use dcb_formats::linear_system::Variable;
use dcb_formats::mesh::Dimension;
use dcb_formats::scene::{self, Scene};
use nalgebra::Vector3;

use crate::actuator::Source;
use crate::error::Error;
use crate::kinematics::frame_motion::Six;
use crate::model::Quantities;
use crate::system::evaluation::Evaluation;
use crate::system::marker::{Marker, six, turned_back};
use crate::system::{ConnectionKind, Demand, Load, LoadAxes, Signal, State, System};

/// What an input acts on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    /// A component of a load: of the force, 0 to 2, or of the torque, 3 to 5.
    Load { load: usize, slot: usize },
    /// A load on the inside of a body.
    PartLoad { load: usize },
    /// What an actuator follows, by its row: the effort itself, or the target of a servo, of which a unit gives so much effort.
    Actuator {
        row: usize,
        signal: usize,
        effort: f64,
    },
    /// A drive, by its row.
    Drive { row: usize },
}

/// An input.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Input {
    pub variable: Variable,
    pub kind: Kind,
}

/// What could be an input.
struct Candidate {
    /// Name of the load or drive.
    owner: &'static str,
    name: String,
    /// The component as the scene counts it.
    index: usize,
    kind: Kind,
    /// Its function, by index; `None` for a component of a load that is zero.
    signal: Option<usize>,
    /// Its name, as `Mechanism::set_input` has it where it is declared.
    label: String,
}

/// The inputs that are asked for; those that the scene declares, or all, where no names are given.
pub(super) fn chosen(
    system: &System,
    state: &State,
    scene: &Scene,
    names: &[String],
) -> Result<Vec<Input>, Error> {
    let candidates = candidates(system, state, scene);
    let declared = |candidate: &&Candidate| is_declared(system, candidate);
    let mut taken: Vec<&Candidate> = Vec::new();
    if names.is_empty() {
        taken = candidates.iter().filter(declared).collect();
        if taken.is_empty() {
            taken = (candidates.iter())
                .filter(|candidate| candidate.signal.is_some())
                .collect();
        }
        if taken.is_empty() {
            return Err(Error::described(
                "inputs",
                "there is nothing to act with: the scene has no loads, no actuators and no drives; give it a load, which may be zero",
            ));
        }
    }
    for name in names {
        let found = named(&candidates, name);
        if found.is_empty() {
            let known: Vec<&str> = (candidates.iter())
                .filter(|candidate| candidate.signal.is_some())
                .map(|candidate| candidate.label.as_str())
                .collect();
            let hint = match suggestion(name, known.iter().copied()) {
                none if none.is_empty() && known.is_empty() => {
                    "; the scene has no loads, no actuators and no drives".to_owned()
                }
                none if none.is_empty() => format!("; there are: {}", listed(known)),
                nearest => nearest,
            };
            return Err(Error::described(
                "inputs",
                format!("no load, actuator or drive is called {name:?}{hint}"),
            ));
        }
        for candidate in found {
            if taken.iter().any(|other| other.kind == candidate.kind) {
                return Err(Error::described(
                    "inputs",
                    format!("{:?} is there twice; name it once", candidate.label),
                ));
            }
            taken.push(candidate);
        }
    }
    let quantities = Quantities::of(&scene.units);
    let label = |candidate: &Candidate| {
        let is_double =
            |other: &&&Candidate| other.kind != candidate.kind && other.label == candidate.label;
        match taken.iter().find(is_double) {
            Some(_) => format!("{}/{}", candidate.owner, candidate.label),
            None => candidate.label.clone(),
        }
    };
    let inputs = taken.iter().map(|candidate| {
        let function = candidate.signal.map(|signal| system.signal(signal, state));
        Input {
            variable: Variable {
                name: label(candidate),
                unit: unit(system, &quantities, candidate.kind),
                at: match (candidate.kind, function) {
                    (_, None) => 0.0,
                    (Kind::Drive { .. }, Some(function)) => function.second_rate,
                    (_, Some(function)) => function.value,
                },
            },
            kind: candidate.kind,
        }
    });
    Ok(inputs.collect())
}

fn is_declared(system: &System, candidate: &Candidate) -> bool {
    candidate
        .signal
        .is_some_and(|signal| system.signals[signal].input.is_some())
}

fn unit(system: &System, quantities: &Quantities, kind: Kind) -> String {
    match kind {
        Kind::Load { slot: 0..3, .. } => quantities.force.clone(),
        Kind::Load { .. } => quantities.moment.clone(),
        Kind::PartLoad { .. } => "1".to_owned(),
        Kind::Actuator { row, signal, .. } => {
            let is_effort = matches!(system.rows[row].demand, Demand::Actuate(index)
                if system.actuators[index].source == Source::Given(signal));
            match (is_effort, is_length(system, row)) {
                (true, true) => quantities.force.clone(),
                (true, false) => quantities.moment.clone(),
                (false, true) => quantities.length.clone(),
                (false, false) => "rad".to_owned(),
            }
        }
        Kind::Drive { row } => match is_length(system, row) {
            true => quantities.acceleration.clone(),
            false => format!("rad/{}^2", quantities.time),
        },
    }
}

/// Whether a row's coordinate is a length, or an angle.
pub(super) fn is_length(system: &System, row: usize) -> bool {
    system.terms[system.rows[row].terms.start]
        .measure
        .is_length()
}

fn candidates(system: &System, state: &State, scene: &Scene) -> Vec<Candidate> {
    let mut all = Vec::new();
    for (index, load) in system.loads.iter().enumerate() {
        let is_torque = matches!(scene.loads.get(&load.name), Some(scene::Load::Torque(_)));
        let (slots, first) = match (system.dimension, is_torque) {
            (Dimension::Planar, true) => (5..6, 5),
            (Dimension::Planar, false) => (0..2, 0),
            (Dimension::Spatial, true) => (3..6, 3),
            (Dimension::Spatial, false) => (0..3, 0),
        };
        let signal = |slot: usize| match slot {
            0..3 => load.force[slot],
            _ => load.torque[slot - 3],
        };
        let given = slots.clone().filter(|slot| signal(*slot).is_some()).count();
        for slot in slots {
            let declared = signal(slot).and_then(|signal| system.signals[signal].input);
            let label = match declared {
                Some(input) => system.inputs[input].0.clone(),
                None if given == 1 && signal(slot).is_some() => load.name.clone(),
                None => format!("{}/{}", load.name, slot - first),
            };
            all.push(Candidate {
                owner: "loads",
                name: load.name.clone(),
                index: slot - first,
                kind: Kind::Load { load: index, slot },
                signal: signal(slot),
                label,
            });
        }
    }
    for (index, load) in system.part_loads.iter().enumerate() {
        all.push(Candidate {
            owner: "loads",
            name: load.name.clone(),
            index: 0,
            kind: Kind::PartLoad { load: index },
            signal: Some(load.factor),
            label: load.name.clone(),
        });
    }
    all.extend(actuators(system, state));
    for connection in &system.connections {
        if connection.kind != ConnectionKind::Drive {
            continue;
        }
        for row in connection.rows.clone() {
            if let Demand::Follow(signal) = system.rows[row].demand {
                all.push(Candidate {
                    owner: "drives",
                    name: connection.name.clone(),
                    index: 0,
                    kind: Kind::Drive { row },
                    signal: Some(signal),
                    label: connection.name.clone(),
                });
            }
        }
    }
    all
}

/// Efforts that are given, and targets of continuous servos.
fn actuators(system: &System, state: &State) -> Vec<Candidate> {
    let evaluation = Evaluation::at(system, state);
    let connections = system.connections.iter();
    connections
        .flat_map(|connection| connection.rows.clone().map(move |row| (connection, row)))
        .filter_map(|(connection, row)| {
            let Demand::Actuate(index) = system.rows[row].demand else {
                return None;
            };
            let (signal, effort) = match &system.actuators[index].source {
                Source::Given(signal) => (*signal, 1.0),
                Source::Servo(_, target) => (*target, -evaluation.efforts[index].by_value),
                Source::Controlled(_) | Source::Friction(_) | Source::EndStop(_) => return None,
            };
            Some(Candidate {
                owner: "actuators",
                name: connection.name.clone(),
                index: 0,
                kind: Kind::Actuator {
                    row,
                    signal,
                    effort,
                },
                signal: Some(signal),
                label: connection.name.clone(),
            })
        })
        .collect()
}

/// Adds the generalised forces of a wrench on a marker, world axes.
fn add_wrench(
    system: &System,
    evaluation: &Evaluation,
    marker: usize,
    wrench: &Six,
    forces: &mut [f64],
) {
    let of = &system.markers[marker];
    let Some(body) = of.body else { return };
    let wrench = turned_back(&evaluation.poses[body].axes, wrench);
    let mut rigid = Six::zeros();
    let own = &mut forces[system.bodies[body].velocities.clone()];
    let (first, elastic) = own.split_at_mut(6);
    of.add_force(
        &evaluation.places[marker],
        &wrench,
        1.0,
        &mut rigid,
        elastic,
    );
    for (entry, added) in first.iter_mut().zip(rigid.iter()) {
        *entry += added;
    }
}

/// By label, as `NAME/INDEX`, or all components of a load that the scene gives, all of them if it gives none; `loads/`, `actuators/` or `drives/` may come first.
fn named<'a>(candidates: &'a [Candidate], name: &str) -> Vec<&'a Candidate> {
    let (owner, name) = match name.split_once('/') {
        Some((owner @ ("loads" | "actuators" | "drives"), rest)) => (Some(owner), rest),
        _ => (None, name),
    };
    let fits = |candidate: &&Candidate| owner.is_none_or(|owner| candidate.owner == owner);
    let all = || candidates.iter().filter(fits);
    let by_label: Vec<_> = all()
        .filter(|candidate| candidate.label == name)
        .take(1)
        .collect();
    if !by_label.is_empty() {
        return by_label;
    }
    let by_index: Vec<_> = all()
        .filter(|candidate| format!("{}/{}", candidate.name, candidate.index) == name)
        .take(1)
        .collect();
    if !by_index.is_empty() {
        return by_index;
    }
    let by_name = || all().filter(|candidate| candidate.name == name);
    let given: Vec<_> = by_name()
        .filter(|candidate| candidate.signal.is_some())
        .collect();
    match given.is_empty() {
        true => by_name().collect(),
        false => given,
    }
}

/// A mechanism with forces along displacements.
pub(super) struct Pushed {
    pub system: System,
    /// Outputs, and the inputs along them.
    pub along: Vec<(usize, usize)>,
}

/// Forces along the displacements of places, world axes, from an output on for each; they become the last inputs.
pub(super) fn pushed(
    system: &System,
    places: &[(Marker, usize)],
    inputs: &mut Vec<Input>,
) -> Pushed {
    let mut system = system.clone();
    let mut along = Vec::new();
    for (marker, first) in places {
        let Some(body) = marker.body else { continue };
        system.bodies[body].markers.push(system.markers.len());
        let load = Load {
            name: String::new(),
            marker: system.markers.len(),
            axes: LoadAxes::World,
            force: [None; 3],
            torque: [None; 3],
        };
        system.markers.push(marker.clone());
        for slot in 0..system.dimension.coordinate_count() {
            along.push((first + slot, inputs.len()));
            inputs.push(Input {
                variable: Variable {
                    name: String::new(),
                    unit: String::new(),
                    at: 0.0,
                },
                kind: Kind::Load {
                    load: system.loads.len(),
                    slot,
                },
            });
        }
        system.loads.push(load);
    }
    Pushed { system, along }
}

/// Efforts of actuators of their own along rows.
pub(super) fn efforts(system: &System, rows: &[usize]) -> Vec<Input> {
    let given = rows
        .iter()
        .filter_map(|row| match system.rows[*row].demand {
            Demand::Actuate(actuator) => match system.actuators[actuator].source {
                Source::Given(signal) => Some((*row, signal)),
                _ => None,
            },
            _ => None,
        });
    given
        .map(|(row, signal)| Input {
            variable: Variable {
                name: system.connections[system.rows[row].connection].name.clone(),
                unit: String::new(),
                at: 0.0,
            },
            kind: Kind::Actuator {
                row,
                signal,
                effort: 1.0,
            },
        })
        .collect()
}

/// The mechanism without the loads that are inputs.
pub(super) fn without_loads(system: &System, inputs: &[Input]) -> System {
    let mut quiet = system.clone();
    for input in inputs {
        if !matches!(input.kind, Kind::Load { .. } | Kind::PartLoad { .. }) {
            continue;
        }
        let nothing = TimeFunction::new(&Function::Constant(0.0));
        if let (Some(signal), Ok(nothing)) = (input.offset_in(&mut quiet), nothing) {
            quiet.signals[signal].function = nothing;
            quiet.signals[signal].input = None;
        }
    }
    quiet
}

impl Input {
    /// The row of a drive.
    pub(super) fn driven_row(&self) -> Option<usize> {
        match self.kind {
            Kind::Drive { row } => Some(row),
            Kind::Load { .. } | Kind::PartLoad { .. } | Kind::Actuator { .. } => None,
        }
    }

    /// Generalised force of a unit, laid out as velocities, rigid rows in body axes; zero for drives.
    pub(super) fn force(&self, system: &System, state: &State) -> Vec<f64> {
        let mut forces = vec![0.0; system.velocity_count()];
        match self.kind {
            Kind::Drive { .. } => {}
            Kind::PartLoad { load } => {
                let load = &system.part_loads[load];
                let body = &system.bodies[load.body];
                let of_body = &body.flexible.loads[load.load];
                let own = &mut forces[body.velocities.clone()];
                own[..3].copy_from_slice(of_body.force.as_slice());
                own[3..6].copy_from_slice(of_body.moment.as_slice());
                own[6..].copy_from_slice(&of_body.elastic);
            }
            Kind::Actuator { row, effort, .. } => {
                let evaluation = Evaluation::at(system, state);
                let terms = system.rows[row].terms.clone();
                for (term, gradient) in system.terms[terms.clone()]
                    .iter()
                    .zip(&evaluation.gradients[terms])
                {
                    for (marker, wrench) in [(term.a, &gradient.a), (term.b, &gradient.b)] {
                        add_wrench(system, &evaluation, marker, &(wrench * effort), &mut forces);
                    }
                }
            }
            Kind::Load { load, slot } => {
                let load = &system.loads[load];
                let evaluation = Evaluation::at(system, state);
                let unit = |first: usize| {
                    let own = Vector3::from_fn(|i, _| f64::from(u8::from(first + i == slot)));
                    match load.axes {
                        LoadAxes::World => own,
                        LoadAxes::Follower => evaluation.motions[load.marker].axes * own,
                    }
                };
                let wrench = six(&unit(0), &unit(3));
                add_wrench(system, &evaluation, load.marker, &wrench, &mut forces);
            }
        }
        forces
    }

    /// The mechanism with a function of this input's own, whose offset is added to the input; `None` for drives, whose motion is part of the state.
    pub(super) fn offset_in(&self, system: &mut System) -> Option<usize> {
        let slot = match self.kind {
            Kind::Drive { .. } => return None,
            Kind::PartLoad { load } => return Some(system.part_loads[load].factor),
            Kind::Actuator { signal, .. } => return Some(signal),
            Kind::Load { load, slot } => match slot {
                0..3 => &mut system.loads[load].force[slot],
                _ => &mut system.loads[load].torque[slot - 3],
            },
        };
        if slot.is_none() {
            *slot = Some(system.signals.len());
            system.signals.push(Signal {
                function: TimeFunction::new(&Function::Constant(0.0)).ok()?,
                input: None,
                offset: 0.0,
            });
        }
        *slot
    }
}
