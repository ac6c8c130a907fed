//! Outputs of a linear system: what a run records, differentiated.

use dcb_formats::linear_system::Variable;
use dcb_formats::results::Channel;

use super::Wanted;
use super::input::Input;
use crate::analysis::independent::{STEP, size};
use crate::analysis::variation::{Variation, derivative};
use crate::error::Error;
use crate::model::{RecordedStep, Recorder};
use crate::system::evaluation::Evaluation;
use crate::system::marker::Marker;
use crate::system::{State, System};

/// Outputs, by their places in the rows of a recorder.
pub(super) struct Outputs {
    channels: Vec<usize>,
    /// Rows of the system whose forces come after the channels.
    rows: Vec<usize>,
    /// Bodies the forces on whose interfaces come after these.
    bodies: Vec<usize>,
}

/// How a mechanism changes by a unit of a state or an input.
pub(super) struct Direction {
    /// x, x', x''.
    pub place: Vec<f64>,
    pub rate: Vec<f64>,
    pub second_rate: Vec<f64>,
    /// Rows of constraints, and how their λ change.
    pub constraints: Vec<(usize, f64)>,
    /// Index of the input that changes, if one does.
    pub input: Option<usize>,
}

impl Outputs {
    /// The outputs that are asked for; the scene's that follow from a state, where no names are given.
    pub(super) fn chosen(
        recorder: &Recorder,
        names: &[String],
        wanted: &Wanted,
    ) -> Result<Self, Error> {
        let mut channels = Vec::new();
        if names.is_empty() {
            let of_scene = recorder.channels().iter().enumerate();
            let of_scene = of_scene
                .filter(|(_, channel)| channel.path.starts_with("outputs/"))
                .map(|(index, _)| index);
            channels.extend(
                of_scene.filter(|index| {
                    recorder.follows_from_state(*index) && recorder.is_smooth(*index)
                }),
            );
            if channels.is_empty() {
                return Err(Error::described(
                    "outputs",
                    "the scene has none that could be an output of a linear system; name something that a run records, for example reactions/JOINT, or give the scene outputs",
                ));
            }
        }
        for name in names {
            let index = recorder.channel(name)?;
            let path = &recorder.channels()[index].path;
            if !recorder.follows_from_state(index) {
                return Err(Error::described(
                    "outputs",
                    format!(
                        "{path} is no output of a linear system: it has the works or the steps of a run, which don't follow from a state; leave it out"
                    ),
                ));
            }
            if !recorder.is_smooth(index) {
                return Err(Error::described(
                    "outputs",
                    format!(
                        "{path} is no output of a linear system: an equivalent stress isn't linear in the components; take these"
                    ),
                ));
            }
            if channels.contains(&index) {
                return Err(Error::described(
                    "outputs",
                    format!("{path} is there twice; name it once"),
                ));
            }
            channels.push(index);
        }
        Ok(Self {
            channels,
            rows: wanted.forces.clone(),
            bodies: wanted.interfaces.clone(),
        })
    }

    /// Of each number whether it is a force or an acceleration.
    pub(super) fn follow_forces(&self, recorder: &Recorder, count: usize) -> Vec<bool> {
        let channels = self.channels.iter().flat_map(|index| {
            let count = recorder.channels()[*index].columns.len();
            std::iter::repeat_n(recorder.follows_forces(*index), count)
        });
        channels
            .chain(std::iter::repeat(true))
            .take(count)
            .collect()
    }

    /// The places on bodies whose displacements are outputs, with the first of these outputs.
    pub(super) fn displaced(&self, recorder: &Recorder) -> Vec<(Marker, usize)> {
        let mut first = 0;
        let mut all = Vec::new();
        for index in &self.channels {
            all.extend((recorder.displaced(*index)).map(|marker| (marker.clone(), first)));
            first += recorder.channels()[*index].columns.len();
        }
        all
    }

    /// Names, units and values; rows have none.
    pub(super) fn variables(&self, recorder: &Recorder, at: &[f64]) -> Vec<Variable> {
        let channels = self
            .channels
            .iter()
            .map(|index| &recorder.channels()[*index]);
        let columns = channels.flat_map(|channel| {
            (channel.columns.iter()).map(|column| (channel.label(column), column.unit.clone()))
        });
        columns
            .zip(at)
            .map(|((name, unit), at)| Variable {
                name,
                unit,
                at: *at,
            })
            .collect()
    }

    /// Values at the state, and their derivatives along directions, one column each.
    pub(super) fn sensitivities(
        &self,
        system: &System,
        state: &State,
        recorder: &mut Recorder,
        inputs: &[Input],
        directions: impl Iterator<Item = Direction>,
    ) -> (Vec<f64>, Vec<Vec<f64>>) {
        // Each input that is a load has a function of its own to be added to.
        let mut system = system.clone();
        let signals: Vec<Option<usize>> = inputs
            .iter()
            .map(|input| input.offset_in(&mut system))
            .collect();
        let mut evaluation = Evaluation::of(&system);
        let columns = self.columns(recorder);
        let mut values = |system: &System, mut state: State| -> Vec<f64> {
            evaluation.place(system, &state);
            evaluation.add_velocities(system, &state);
            evaluation.measure(system, &state);
            for (index, row) in system.rows.iter().enumerate() {
                if !row.is_constraint() {
                    state.forces[index] = evaluation.answers[index];
                }
            }
            let row = recorder.row(&RecordedStep::at(system, &state, &mut evaluation));
            let channels = columns.iter().map(|column| row[*column]);
            let mut values: Vec<f64> = channels
                .chain(self.rows.iter().map(|row| state.forces[*row]))
                .collect();
            for body in &self.bodies {
                let first = values.len();
                values.resize(first + system.bodies[*body].flexible.rows.len(), 0.0);
                evaluation.write_interface_forces(system, *body, &mut values[first..]);
            }
            values
        };
        let at = values(&system, state.clone());
        let slopes = directions
            .map(|direction| {
                let mut forces = vec![0.0; system.rows.len()];
                for (row, force) in &direction.constraints {
                    forces[*row] = *force;
                }
                let signal = direction.input.and_then(|input| signals[input]);
                let variation = Variation {
                    place: &direction.place,
                    rate: &direction.rate,
                    second_rate: &direction.second_rate,
                    forces: &forces,
                };
                derivative(step(&system, state, &variation), |amount| {
                    let before = signal.map(|signal| system.signals[signal].offset);
                    if let (Some(signal), Some(before)) = (signal, before) {
                        system.signals[signal].offset = before + amount;
                    }
                    let found = values(&system, variation.applied(&system, state, amount));
                    if let (Some(signal), Some(before)) = (signal, before) {
                        system.signals[signal].offset = before;
                    }
                    found
                })
            })
            .collect();
        (at, slopes)
    }

    /// Places in a recorder's row.
    fn columns(&self, recorder: &Recorder) -> Vec<usize> {
        let width = |channel: &Channel| channel.columns.len();
        let columns = self.channels.iter().flat_map(|index| {
            let first: usize = recorder.channels()[..*index].iter().map(width).sum();
            first..first + width(&recorder.channels()[*index])
        });
        columns.collect()
    }
}

/// A step for differences: small for places, on which outputs depend in every way; as large as what is there for rates, of which outputs are
/// polynomials of second degree, and for accelerations and forces, in which they are linear.
fn step(system: &System, state: &State, variation: &Variation<'_>) -> f64 {
    let places = size(system, variation.place);
    if places > 0.0 {
        return STEP / places;
    }
    let (speed, acceleration) = (
        size(system, &state.velocities),
        size(system, &state.accelerations),
    );
    let rates = size(system, variation.rate);
    if rates > 0.0 {
        let natural = speed.max(acceleration.sqrt());
        return if natural > 0.0 { natural } else { 1.0 } / rates;
    }
    let largest = |values: &[f64]| values.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let share = |change: f64, there: f64| if there > 0.0 { change / there } else { 0.0 };
    let most = share(size(system, variation.second_rate), acceleration)
        .max(share(largest(variation.forces), largest(&state.forces)));
    if most > 0.0 { 1.0 / most } else { 1.0 }
}
