//! Frequency responses of a scene about a placement: `"analysis": {"frequency_response": ...}`.
//!
//! The mechanism is linearised as for a linear system ([`crate::linear`]), gyroscopic terms, static preload and forces of joints included. Inputs are loads of unit
//! amplitude and drives of unit motion; outputs are whatever a run records and follows from a state. `transfer.rs` has the equations.

mod errors;
mod excitation;
mod grid;
mod paths;
mod random;
mod transfer;

use dcb_formats::linear_system::Variable;
use dcb_formats::results::{FrequencyResponses, Signal};
use dcb_formats::scene::{
    BeyondBand, DriveForm, FrequencyResponse, OutputForm, ResponseDamping, Scene,
};
use dcb_superelement::{ErrorBounds, LeftOutBy};
use faer::c64;

use crate::analysis::effective_damping::{
    DampedPart, DampingShare, EffectiveDamping, damping_by_part,
};
use crate::error::Error;
use crate::linear::{Coordinates, Duals, LinearRequest, Wanted, linearized};
use crate::model::Recorder;
use crate::system::{State, System};

use errors::Errors;
use paths::Paths;
pub use random::RandomOutput;
pub use transfer::Solution;
use transfer::{Resonance, Transfer};

/// Peaks of one response that are told.
const PEAKS: usize = 6;
/// Responses below this part of the largest of their unit are rounding, and no peaks.
const NEGLIGIBLE: f64 = 1e-6;
/// Modes whose damping is told by part.
const DAMPED_MODES: usize = 12;
/// A peak is told with a resonance this near, as a part of its frequency.
const NEAR: f64 = 0.05;

/// What a frequency analysis found.
#[derive(Clone, Debug, PartialEq)]
pub struct FrequencyReport {
    /// Responses over the frequencies.
    pub responses: FrequencyResponses,
    /// How they were solved.
    pub solution: Solution,
    /// Coordinates of the linear mechanism.
    pub freedoms: usize,
    /// Largest responses.
    pub peaks: Vec<Peak>,
    /// Outputs under the random inputs.
    pub random: Vec<RandomOutput>,
    /// Damping by part of the lowest undamped modes, up to the highest frequency; empty about a motion.
    pub damping: Vec<EffectiveDamping>,
}

/// A largest response of one output by one input.
#[derive(Clone, Debug, PartialEq)]
pub struct Peak {
    /// Names.
    pub output: String,
    /// Names.
    pub input: String,
    /// Output unit by input unit.
    pub unit: String,
    /// Cycles per time.
    pub frequency: f64,
    /// |H|.
    pub amplitude: f64,
    /// Phase, degrees.
    pub phase: f64,
    /// Ratio to critical of the resonance there; `None` where there is none.
    pub damping: Option<f64>,
    /// Estimate of the relative error by what the superelements' files leave out; `None` where they don't tell, and for outputs that are no displacements.
    pub error: Option<f64>,
    /// Paths that are asked for, and which part of the response comes through each: the real part of a ratio, so that all add up to 1.
    pub paths: Vec<(String, f64)>,
}

/// A mechanism that is shaken.
pub(crate) struct Shaken<'a> {
    pub scene: &'a Scene,
    pub system: &'a System,
    pub state: &'a State,
    /// Of each body, what its superelement leaves out.
    pub bounds: &'a [Option<ErrorBounds>],
}

/// The frequency responses of a mechanism at a state with consistent positions and velocities; `note` is told what a user should know.
///
/// # Errors
/// [`Error::Description`] for a request that can't be met, [`Error::Resonant`] at an undamped resonance.
pub(crate) fn frequency_response(
    of: &Shaken,
    recorder: &mut Recorder,
    asked: &FrequencyResponse,
    note: &mut dyn FnMut(&str),
) -> Result<FrequencyReport, Error> {
    let Shaken {
        scene,
        system,
        state,
        bounds,
    } = *of;
    let request = LinearRequest {
        inputs: asked.inputs.clone(),
        outputs: asked.outputs.clone(),
        order: None,
    };
    // Loads oscillate about nothing: what they would set in motion at the start doesn't count.
    let moves = state.velocities.iter().any(|velocity| *velocity != 0.0);
    let still = state.without_motion();
    let state = if moves { state } else { &still };
    let paths = Paths::of(system, asked)?;
    let mut wanted = Wanted::of(Coordinates::Orthonormal);
    wanted.forces = paths.rows();
    if !moves {
        let told = (0..bounds.len()).filter(|body| bounds[*body].is_some());
        wanted.interfaces = told.collect();
        wanted.duals = Duals::With;
    }
    let linear = linearized(scene, system, state, recorder, &request, &wanted)?;
    let without = paths.without(scene, (system, state), recorder, &request, &linear)?;
    if moves {
        note(
            "the mechanism moves here: responses are those of this instant, to forces and motions in axes that move along",
        );
    }
    let transfer = Transfer::of(&linear, asked)?;
    let without = without.as_ref();
    let without = without
        .map(|linear| Transfer::of(linear, asked))
        .transpose()?;
    let resonances = transfer.resonances();
    let frequency = grid::frequencies(&asked.frequencies, &resonances);
    let time = &scene.units.time;
    // Forces along outputs aren't inputs that were asked for.
    let inputs = linear.system.inputs.len() - linear.duals.iter().flatten().count();
    let is_drive: Vec<bool> = linear.second_order.drives[..inputs]
        .iter()
        .map(Option::is_some)
        .collect();
    let mut responses = FrequencyResponses {
        inputs: (linear.system.inputs.iter().zip(&is_drive))
            .map(|(input, is_drive)| input_signal(input, *is_drive, asked.drive_as, time))
            .collect(),
        outputs: linear
            .system
            .outputs
            .iter()
            .map(|output| output_signal(output, asked.output_as, time))
            .collect(),
        frequency,
        ..FrequencyResponses::default()
    };
    let errors = match moves {
        true => None,
        false => Errors::of(bounds, &linear, asked.loss_factor()),
    };
    let outputs = responses.outputs.len();
    responses.outputs.extend(paths.signals(&responses.outputs));
    for frequency in responses.frequency.clone() {
        let mut found = transfer.at(frequency)?;
        let told =
            (errors.as_ref()).and_then(|errors| errors.at(&found, frequency, [outputs, inputs]));
        if let Some(without) = &without {
            found = paths.split(&found, &without.at(frequency)?, [outputs, inputs]);
        }
        let rate = c64::new(0.0, std::f64::consts::TAU * frequency);
        let made = match asked.output_as {
            OutputForm::Itself => c64::new(1.0, 0.0),
            OutputForm::Rate => rate,
            OutputForm::SecondRate => rate * rate,
        };
        for i in 0..responses.outputs.len() {
            for j in 0..inputs {
                let by = match (is_drive[j], asked.drive_as) {
                    (false, _) | (true, DriveForm::Displacement) => c64::new(1.0, 0.0),
                    (true, DriveForm::Velocity) => rate,
                    (true, DriveForm::Acceleration) => rate * rate,
                };
                let value = found[(i, j)] * made / by;
                responses.real.push(value.re);
                responses.imaginary.push(value.im);
                let error = told.as_ref().filter(|_| i < outputs);
                let error = error.map_or(f64::NAN, |told| told[(i, j)]);
                responses.error.push(error * (made / by).norm());
            }
        }
    }
    if responses.error.iter().all(|error| error.is_nan()) {
        responses.error = Vec::new();
    }
    let mut random = random::random(&mut responses, asked)?;
    random.truncate(outputs);
    excitation::append_cases(&mut responses, asked)?;
    let largest = |unit: &str| {
        let same = random.iter().filter(|output| output.unit == unit);
        same.map(|output| output.rms).fold(0.0, f64::max)
    };
    let told = |output: &&RandomOutput| {
        output.is_coarse() && output.rms > NEGLIGIBLE * largest(&output.unit)
    };
    for output in random.iter().filter(told) {
        note(&format!(
            "the rms of {:?} changes by {:.1} % with every other frequency: take more, or \"spacing\": \"resonances\"",
            output.name,
            100.0 * output.coarseness
        ));
    }
    if let Some(gap) = paths.gap(&responses, outputs) {
        note(&gap);
    }
    let mut peaks = peaks(&responses, outputs, &resonances);
    paths.share(&responses, outputs, &mut peaks);
    Ok(FrequencyReport {
        peaks,
        solution: transfer.solution(),
        freedoms: linear.second_order.units.len(),
        responses,
        random,
        damping: match moves {
            true => Vec::new(),
            false => damping(system, state, asked)?,
        },
    })
}

/// Damping by part, and what the analysis adds or puts in its place.
fn damping(
    system: &System,
    state: &State,
    asked: &FrequencyResponse,
) -> Result<Vec<EffectiveDamping>, Error> {
    let mut all = damping_by_part(system, state, DAMPED_MODES)?;
    all.retain(|mode| mode.frequency <= asked.highest());
    for (k, mode) in all.iter_mut().enumerate() {
        let (part, ratio) = match &asked.damping {
            None => continue,
            Some(ResponseDamping::Structural(loss)) => (DampedPart::LossFactor, 0.5 * loss),
            Some(ResponseDamping::AssembledModal(ratios)) => {
                mode.shares.clear();
                (DampedPart::AssembledModes, ratios.of_mode(k))
            }
        };
        mode.shares.push(DampingShare {
            part,
            name: part.name().to_owned(),
            ratio,
        });
        mode.ratio = mode.shares.iter().map(|share| share.ratio).sum();
    }
    Ok(all)
}

fn input_signal(input: &Variable, is_drive: bool, form: DriveForm, time: &str) -> Signal {
    // The unit of a drive that is an input of a linear system is that of its acceleration.
    let place = input
        .unit
        .trim_end_matches(&format!("/{time}^2"))
        .to_owned();
    let unit = match (is_drive, form) {
        (false, _) | (true, DriveForm::Acceleration) => input.unit.clone(),
        (true, DriveForm::Displacement) => place,
        (true, DriveForm::Velocity) => format!("{place}/{time}"),
    };
    Signal {
        name: input.name.clone(),
        unit,
    }
}

fn output_signal(output: &Variable, form: OutputForm, time: &str) -> Signal {
    let unit = match form {
        OutputForm::Itself => output.unit.clone(),
        OutputForm::Rate => format!("{}/{time}", output.unit),
        OutputForm::SecondRate => format!("{}/{time}^2", output.unit),
    };
    Signal {
        name: output.name.clone(),
        unit,
    }
}

/// What to tell of frequencies that a superelement's file isn't made for.
///
/// # Errors
/// [`Error::Description`] where the analysis refuses them.
pub(crate) fn beyond_band(
    scene: &Scene,
    system: &System,
    asked: &FrequencyResponse,
) -> Result<Vec<String>, Error> {
    let mut notes = Vec::new();
    let highest = asked.highest();
    for body in &system.bodies {
        let Some(limit) = body.flexible.made_for.frequency else {
            continue;
        };
        // What this run leaves out is chosen for these frequencies.
        if highest <= limit.frequency || limit.by == LeftOutBy::Run {
            continue;
        }
        let unit = dcb_formats::results::frequency_unit(&scene.units);
        let message = format!(
            "body {:?}: its superelement is made for motions up to {} {unit}, and the responses go up to {} {unit}; lower `to`, or reduce the part with more modes",
            body.name,
            dcb_formats::units::four_digits(limit.frequency),
            dcb_formats::units::four_digits(highest),
        );
        match asked.beyond_band {
            BeyondBand::Warn => notes.push(message),
            BeyondBand::Refuse => {
                return Err(Error::described(
                    "analysis.frequency_response.frequencies",
                    message,
                ));
            }
        }
    }
    Ok(notes)
}

/// The largest peaks of each output by each input, by rising frequency.
fn peaks(responses: &FrequencyResponses, outputs: usize, resonances: &[Resonance]) -> Vec<Peak> {
    let mut all = Vec::new();
    let largest_of = |i: usize, j: usize| {
        let values = responses.of(i, j).into_iter();
        values.map(|[re, im]| re.hypot(im)).fold(0.0, f64::max)
    };
    let of_scene = &responses.outputs[..outputs];
    for (i, output) in of_scene.iter().enumerate() {
        for (j, input) in responses.inputs.iter().enumerate() {
            let alike =
                (of_scene.iter().enumerate()).filter(|(_, other)| other.unit == output.unit);
            let largest = alike
                .map(|(other, _)| largest_of(other, j))
                .fold(0.0, f64::max);
            if largest_of(i, j) <= NEGLIGIBLE * largest {
                continue;
            }
            let values = responses.of(i, j);
            let errors = responses.error_of(i, j);
            let size = |k: usize| values[k][0].hypot(values[k][1]);
            let last = values.len() - 1;
            let mut found: Vec<usize> = (0..values.len())
                .filter(|k| {
                    *k > 0 && *k < last && size(*k) > size(k - 1) && size(*k) >= size(k + 1)
                })
                .collect();
            found.sort_by(|a, b| size(*b).total_cmp(&size(*a)));
            found.truncate(PEAKS);
            found.sort_unstable();
            all.extend(found.into_iter().map(|k| {
                let frequency = responses.frequency[k];
                let away = |resonance: &&Resonance| (resonance.frequency / frequency - 1.0).abs();
                let nearest = resonances.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
                Peak {
                    output: output.name.clone(),
                    input: input.name.clone(),
                    unit: responses.unit(i, j),
                    frequency,
                    amplitude: size(k),
                    phase: values[k][1].atan2(values[k][0]).to_degrees(),
                    damping: nearest.filter(|of| away(of) < NEAR).map(|of| of.ratio),
                    error: (errors.as_ref())
                        .map(|errors| errors[k] / size(k))
                        .filter(|error| error.is_finite()),
                    paths: Vec::new(),
                }
            }));
        }
    }
    all
}
