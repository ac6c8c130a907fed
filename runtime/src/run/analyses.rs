//! Analyses without integration: a rest, a motion that the drives fix, small oscillations.

use dcb_formats::results::{Column, ModeShapes, SystemModes};
use serde_json::{Value, json};

use super::{Ending, Observer, Opened, Session, Target, tell_start};
use crate::analysis::driven::DrivenMotion;
use crate::analysis::effective_damping::{EffectiveDamping, damping_by_part};
use crate::analysis::eigenmodes::{Eigenmode, Eigenmodes};
use crate::analysis::equilibrium::{EquilibriumReport, EquilibriumSettings, find_equilibrium};
use crate::analysis::inertia_relief::{InertiaReliefReport, find_inertia_relief};
use crate::error::Error;
use crate::frequency::{FrequencyReport, Shaken, Solution, beyond_band, frequency_response};
use crate::initial::{InitialReport, Starter};
use crate::integrator::equal_steps::EqualSteps;
use crate::linear::without_inputs;
use crate::model::timetable::{Due, Rows};
use crate::model::{Model, RecordedStep};
use crate::system::evaluation::Evaluation;
use crate::system::{State, System};
use dcb_formats::scene::{FrequencyResponse, Linearization, ModesAnalysis, Record, Scene};

/// A rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestReport {
    /// How it was found.
    pub equilibrium: EquilibriumReport,
}

/// A motion that the drives fix.
#[derive(Clone, Debug, PartialEq)]
pub struct DrivenReport {
    /// Changes that made the start consistent.
    pub initial: InitialReport,
    /// Times that were computed.
    pub times: u64,
    /// Whether the end was reached.
    pub is_complete: bool,
}

/// Small oscillations.
#[derive(Clone, Debug, PartialEq)]
pub struct ModesReport {
    /// All of them, by increasing frequency.
    pub modes: Eigenmodes,
    /// How many were asked for.
    pub count: usize,
    /// Damping of as many undamped modes, the mechanism taken as at rest, by part.
    pub damping: Vec<EffectiveDamping>,
}

/// Finds a stable rest near the placement and records it.
///
/// # Errors
/// Those of [`find_equilibrium`]; [`Error::File`] where results can't be written.
pub fn rest(
    scene: &Scene,
    model: Model,
    target: &Target,
    observer: &mut dyn Observer,
) -> Result<RestReport, Error> {
    let Opened {
        mut session,
        system,
        mut drawn,
        ..
    } = Session::open(scene, model, target)?;
    let found = find_equilibrium(&system, &mut drawn, &EquilibriumSettings::default());
    let found = found.and_then(|equilibrium| {
        record_state(&mut session, &system, &drawn)?;
        session.tell_scope(&system, observer);
        observer.progress(1.0, 1.0);
        Ok(RestReport { equilibrium })
    });
    let summary = match &found {
        Ok(report) => json!({
            "analysis": "static",
            "iterations": report.equilibrium.iterations,
            "least_stiffness": finite(report.equilibrium.least_stiffness),
        }),
        Err(_) => json!({"analysis": "static"}),
    };
    session.close(observer, found, &at_start(), &summary)
}

/// Finds the rest in the frame that the loads accelerate, and records it.
///
/// # Errors
/// Those of [`find_inertia_relief`]; [`Error::File`] where results can't be written.
pub fn accelerated_rest(
    scene: &Scene,
    model: Model,
    target: &Target,
    observer: &mut dyn Observer,
) -> Result<InertiaReliefReport, Error> {
    let Opened {
        mut session,
        system,
        mut drawn,
        ..
    } = Session::open(scene, model, target)?;
    let found = find_inertia_relief(&system, &mut drawn, &EquilibriumSettings::default());
    let found = found.and_then(|report| {
        record_state(&mut session, &system, &drawn)?;
        session.tell_scope(&system, observer);
        observer.progress(1.0, 1.0);
        Ok(report)
    });
    let summary = match &found {
        Ok(report) => {
            let accelerations: serde_json::Map<String, Value> = (system.bodies.iter())
                .map(|body| {
                    let own = &drawn.accelerations[body.velocities.clone()];
                    let both = json!({"origin_world": own[..3], "angular_body": own[3..6]});
                    (body.name.clone(), both)
                })
                .collect();
            json!({
                "analysis": "inertia_relief",
                "iterations": report.iterations,
                "free_motions": report.free_count,
                "accelerations": accelerations,
            })
        }
        Err(_) => json!({"analysis": "inertia_relief"}),
    };
    session.close(observer, found, &at_start(), &summary)
}

/// Follows the drives from time zero to the end, and records what the scene asks for.
///
/// # Errors
/// Those of [`DrivenMotion`]; [`Error::Description`] without an integrator, whose `step` and `end` are used.
pub fn driven(
    scene: &Scene,
    model: Model,
    target: &Target,
    observer: &mut dyn Observer,
) -> Result<DrivenReport, Error> {
    let integrator = scene
        .integrator
        .ok_or_else(|| Error::described("integrator", "is missing"))?;
    let Opened {
        mut session,
        system,
        drawn,
        ..
    } = Session::open(scene, model, target)?;
    let steps = EqualSteps::new(integrator.step, integrator.end);
    let mut rows = Rows::of(scene.record.unwrap_or(Record::Every(1)));
    let mut times: u64 = 0;
    let mut last = None;
    let mut follow = || {
        let (mut motion, initial) = DrivenMotion::start(&system, drawn.clone())?;
        tell_start(&initial, scene, observer, &mut session)?;
        if system.coordinate_count() > 0 {
            let message = "a kinematic analysis takes flexible bodies as rigid ones";
            session.tell(observer, 0.0, message);
        }
        let mut evaluation = Evaluation::of(&system);
        for index in 0..=steps.count() {
            if observer.is_stopped() {
                break;
            }
            let time = steps.time(index);
            if index > 0 {
                rows.count_step();
            }
            let mut is_due = index == 0 || index == steps.count();
            while let Some(due) = rows.take(time) {
                match due {
                    Due::Now => is_due = true,
                    Due::Within(time) => {
                        let state = motion.at(time)?;
                        session.record(&RecordedStep::at(&system, &state, &mut evaluation))?;
                    }
                }
            }
            for field in &mut session.fields {
                while let Some(due) = field.take(time) {
                    let state = motion.at(match due {
                        Due::Now => time,
                        Due::Within(time) => time,
                    })?;
                    evaluation.refresh(&system, &state);
                    field.write(&system, &state, &evaluation)?;
                }
            }
            if index > 0 {
                motion.advance_to(time)?;
            }
            if is_due {
                let state = motion.state();
                session.record(&RecordedStep::at(&system, state, &mut evaluation))?;
            }
            observer.progress(time, integrator.end);
            times += 1;
            last = Some(time);
        }
        Ok(DrivenReport {
            initial,
            times,
            is_complete: times == steps.count() + 1,
        })
    };
    let found = follow();
    let summary = json!({"analysis": "kinematic", "times": times});
    let ending = Ending {
        is_complete: found.as_ref().is_ok_and(|report| report.is_complete),
        time: last,
    };
    session.close(observer, found, &ending, &summary)
}

/// Frequencies, damping and shapes of small oscillations about the start or a rest.
///
/// # Errors
/// Those of [`Eigenmodes::at`], of the start and of [`find_equilibrium`].
pub fn modes(
    scene: &Scene,
    model: Model,
    target: &Target,
    observer: &mut dyn Observer,
    asked: &ModesAnalysis,
) -> Result<ModesReport, Error> {
    let Opened {
        mut session,
        system,
        mut drawn,
        held,
        ..
    } = Session::open(scene, model, target)?;
    let mut find = || {
        place(
            asked.at,
            scene,
            &system,
            &mut drawn,
            &held,
            &mut session,
            observer,
        )?;
        let report = ModesReport {
            modes: Eigenmodes::at(&system, &drawn)?,
            count: asked.count as usize,
            damping: damping_by_part(&system, &drawn, asked.count as usize)?,
        };
        let modes = listed(&report, scene, &system);
        if !modes.frequency.is_empty() {
            session.writer.write_modes(&modes)?;
        }
        Ok(report)
    };
    let found = find();
    let summary = match &found {
        Ok(report) => {
            let listed = report.modes.modes.iter().take(report.count);
            json!({
                "analysis": "modes",
                "freedoms": report.modes.dof_count,
                "rigid": report.modes.rigid_count,
                "effective_damping": described_damping(&report.damping),
                "modes": listed.map(|mode| described(&system, mode)).collect::<Vec<_>>(),
            })
        }
        Err(_) => json!({"analysis": "modes"}),
    };
    session.close(observer, found, &at_start(), &summary)
}

/// Responses to oscillating inputs about the start or a rest.
///
/// # Errors
/// Those of [`frequency_response`], of the start and of [`find_equilibrium`].
pub fn frequency(
    scene: &Scene,
    mut model: Model,
    target: &Target,
    observer: &mut dyn Observer,
    asked: &FrequencyResponse,
) -> Result<FrequencyReport, Error> {
    let mut notes = beyond_band(scene, &model.system, asked)?;
    let bounds = std::mem::take(&mut model.error_bounds);
    let Opened {
        mut session,
        system,
        mut drawn,
        held,
        ..
    } = Session::open(scene, model, target)?;
    let mut find = || {
        let resting = without_inputs(scene, &system, &drawn, &asked.inputs)?;
        place(
            asked.at,
            scene,
            &resting,
            &mut drawn,
            &held,
            &mut session,
            observer,
        )?;
        let recorder = &mut session.recorder;
        let mut note = |message: &str| notes.push(message.to_owned());
        let scene_of = Shaken {
            scene,
            system: &system,
            state: &drawn,
            bounds: &bounds,
        };
        let report = frequency_response(&scene_of, recorder, asked, &mut note)?;
        for note in notes.drain(..) {
            session.tell(observer, drawn.time, &note);
        }
        session
            .writer
            .write_frequency_responses(&report.responses)?;
        Ok(report)
    };
    let found = find();
    let summary = match &found {
        Ok(report) => json!({
            "analysis": "frequency_response",
            "freedoms": report.freedoms,
            "frequencies": report.responses.frequency.len(),
            "solution": match report.solution {
                Solution::Modes => "modes",
                Solution::ComplexModes => "complex modes",
                Solution::Direct => "direct",
            },
            "effective_damping": described_damping(&report.damping),
            "random": report.random.iter().map(|output| json!({
                "output": output.name,
                "unit": output.unit,
                "rms": output.rms,
                "zero_crossings": output.zero_crossings,
                "error": output.error,
            })).collect::<Vec<_>>(),
        }),
        Err(_) => json!({"analysis": "frequency_response"}),
    };
    session.close(observer, found, &at_start(), &summary)
}

/// The modes that were asked for, for the file.
fn listed(report: &ModesReport, scene: &Scene, system: &System) -> SystemModes {
    let modes = &report.modes.modes[..report.count.min(report.modes.modes.len())];
    let numbers = |of: fn(&Eigenmode) -> f64| modes.iter().map(of).collect();
    let column = |name: String, unit: &str| Column {
        name,
        unit: unit.to_owned(),
    };
    let length = scene.units.length.as_str();
    let modal = format!("sqrt({})*{length}", scene.units.mass);
    let shapes = system.bodies.iter().map(|body| {
        let own = || body.velocities.clone();
        let frame = [("x", length), ("y", length), ("z", length)]
            .into_iter()
            .chain([("rx", "rad"), ("ry", "rad"), ("rz", "rad")])
            .map(|(name, unit)| column(name.to_owned(), unit));
        let elastic = 1..=own().len() - 6;
        let elastic = elastic.map(|number| column(number.to_string(), &modal));
        let motions = modes.iter().flat_map(|mode| {
            let parts = [&mode.shape[own()], &mode.shape_behind[own()]];
            parts.into_iter().flatten().copied()
        });
        ModeShapes {
            body: body.name.clone(),
            columns: frame.chain(elastic).collect(),
            values: motions.collect(),
        }
    });
    SystemModes {
        frequency: numbers(Eigenmode::frequency),
        damping_ratio: numbers(Eigenmode::damping_ratio),
        growth: numbers(|mode| mode.growth),
        shapes: shapes.collect(),
    }
}

/// One mode for the summary: frequency, damping, and the motion of each body.
fn described(system: &System, mode: &Eigenmode) -> Value {
    let bodies: serde_json::Map<String, Value> = system
        .bodies
        .iter()
        .map(|body| {
            let own = body.velocities.clone();
            let motion = json!({
                "in_phase": mode.shape[own.clone()],
                "behind": mode.shape_behind[own],
            });
            (body.name.clone(), motion)
        })
        .collect();
    json!({
        "frequency": mode.frequency(),
        "damping_ratio": mode.damping_ratio(),
        "growth": mode.growth,
        "bodies": bodies,
    })
}

/// Damping of modes for the summary: the ratio, and what each part has of it.
pub(super) fn described_damping(modes: &[EffectiveDamping]) -> Vec<Value> {
    let described = modes.iter().map(|mode| {
        let shares = mode.shares.iter().map(|share| {
            json!({"kind": share.part.name(), "name": share.name, "damping_ratio": share.ratio})
        });
        json!({
            "frequency": mode.frequency,
            "damping_ratio": mode.ratio,
            "shares": shares.collect::<Vec<_>>(),
        })
    });
    described.collect()
}

/// Goes to the placement about which a scene is linearised, and records it.
fn place(
    at: Linearization,
    scene: &Scene,
    system: &System,
    drawn: &mut State,
    held: &[usize],
    session: &mut Session,
    observer: &mut dyn Observer,
) -> Result<(), Error> {
    match at {
        Linearization::Static => {
            find_equilibrium(system, drawn, &EquilibriumSettings::default())?;
        }
        Linearization::Initial => {
            let initial = Starter::of(system)?
                .holding(held)
                .start(drawn, scene.redundant_constraints)?;
            tell_start(&initial, scene, observer, session)?;
        }
    }
    record_state(session, system, drawn)
}

fn record_state(session: &mut Session, system: &System, state: &State) -> Result<(), Error> {
    let mut evaluation = Evaluation::of(system);
    session.record(&RecordedStep::at(system, state, &mut evaluation))
}

fn at_start() -> Ending {
    Ending {
        is_complete: true,
        time: Some(0.0),
    }
}

/// JSON has no infinity.
fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}
