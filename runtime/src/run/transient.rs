//! Motion over time.

use std::time::Instant;

use dcb_formats::results::frequency_unit;
use dcb_formats::units::four_digits;
use serde_json::json;

use super::analyses::described_damping;
use super::{Ending, Observer, Opened, Profiling, Session, Target, rule, tell_start};
use crate::analysis::effective_damping::{EffectiveDamping, effective_damping};
use crate::error::Error;
use crate::initial::InitialReport;
use crate::integrator::adaptive::{AdaptiveStep, StepSize};
use crate::integrator::equal_steps::EqualSteps;
use crate::integrator::resolution::Part;
use crate::integrator::{Effort, Profile};
use crate::model::timetable::{Due, Rows};
use crate::model::{Model, RecordedStep};
use crate::simulation::Simulation;
use crate::system::System;
use crate::watch::compatibility_window::WeakWindow;
use crate::watch::energy_balance::EnergyBalance;
use crate::watch::validity::Validity;
use dcb_formats::scene::{self, Compatibility, Integrator, Record, Scene, Scheme};

/// How a run went.
#[derive(Clone, Debug, PartialEq)]
pub struct RunReport {
    /// Changes that made the start consistent.
    pub initial: InitialReport,
    /// Steps.
    pub steps: usize,
    /// Effort of the steps.
    pub effort: Effort,
    /// Wall time of the integration, s.
    pub seconds: f64,
    /// Time reached.
    pub time: f64,
    /// The energy balance of the recorded steps.
    pub balance: EnergyBalance,
    /// Whether the end was reached.
    pub is_complete: bool,
    /// Where the time of the steps went, if it was asked for.
    pub profile: Option<Profile>,
}

/// Shares of a mode's damping that are told.
const MOST_SHARES: usize = 4;
/// The end of a run that made no step.
const NOT_BEGUN: Ending = Ending {
    is_complete: false,
    time: None,
};

/// Integrates a scene over time and records it.
///
/// # Errors
/// [`Error::File`] where results can't be written; [`Error::Description`] without an integrator; whatever stops the start or a
/// step: the results file then holds every step before it and says so.
pub fn transient(
    scene: &Scene,
    model: Model,
    target: &Target,
    observer: &mut dyn Observer,
) -> Result<RunReport, Error> {
    let integrator = scene
        .integrator
        .ok_or_else(|| Error::described("integrator", "is missing"))?;
    let Opened {
        mut session,
        system,
        drawn,
        held,
        senses,
    } = Session::open(scene, model, target)?;
    let rule = rule(&integrator);
    let started =
        Simulation::start_holding(system, drawn, rule, scene.redundant_constraints, &held);
    let started = started.and_then(|(mut simulation, initial)| {
        if let Some(senses) = senses {
            simulation.control(senses)?;
        }
        Ok((simulation, initial))
    });
    let (mut simulation, initial) = match started {
        Ok(started) => started,
        Err(error) => return session.close(observer, Err(error), &NOT_BEGUN, &json!({})),
    };
    if let Err(error) = tell_start(&initial, scene, observer, &mut session) {
        return session.close(observer, Err(error), &NOT_BEGUN, &json!({}));
    }
    if let Some(Record::Interval(interval)) = scene.record
        && interval > integrator.end
    {
        let unit = &scene.units.time;
        let message = format!(
            "record.interval is {interval} {unit}, longer than the run of {} {unit}: only its start and its end are recorded",
            integrator.end
        );
        session.tell(observer, 0.0, &message);
    }
    let damping = effective_damping(simulation.system(), simulation.state());
    if let Some(message) = damping_note(&damping, scene) {
        session.tell(observer, 0.0, &message);
    }
    if let Err(error) = check_window(scene, &integrator, &simulation, observer, &mut session) {
        return session.close(observer, Err(error), &NOT_BEGUN, &json!({}));
    }
    let mut run = Run {
        integrator,
        record: scene.record.unwrap_or(Record::Every(1)),
        session: &mut session,
        validity: Validity::of(simulation.system(), simulation.state()),
        balance: EnergyBalance::default(),
        met_singular: false,
        unit_of_time: scene.units.time.clone(),
        told_contacts: 0,
        looks_at_forces: scene.looks_at_reactions(),
    };
    if target.profiling == Profiling::Stages {
        simulation.start_profile();
    }
    let clock = Instant::now();
    let result = run.integrate(&mut simulation, observer);
    let seconds = clock.elapsed().as_secs_f64();
    let (balance, validity) = (run.balance, run.validity);
    session.tell_scope(simulation.system(), observer);
    let (steps, effort) = simulation.effort();
    let time = simulation.state().time;
    let summary = json!({
        "steps": steps,
        "elastic_coordinates": simulation.system().coordinate_count(),
        "newton_iterations": effort.iterations,
        "jacobian_updates": effort.factorizations,
        "integration_seconds": seconds,
        "energy_defect": balance.defect,
        "largest_energy": balance.largest,
        "effective_damping": described_damping(&damping),
        "redundant_constraints": initial.redundant.iter().map(|(name, count)| json!({"joint": name, "count": count})).collect::<Vec<_>>(),
    });
    let ending = Ending {
        is_complete: matches!(result, Ok(true)),
        time: Some(time),
    };
    let result = result.map_err(|error| {
        validity.naming_drives(
            error,
            simulation.system(),
            simulation.state(),
            &scene.units.length,
        )
    });
    let is_complete = session.close(observer, result, &ending, &summary)?;
    Ok(RunReport {
        initial,
        steps,
        effort,
        seconds,
        time,
        balance,
        is_complete,
        profile: simulation.profile().copied(),
    })
}

/// Rounding in the joints' forces beyond this part of them is told.
const ROUNDING_TOLD: f64 = 1e-2;
/// Errors of forces beyond this part of the largest are told where nobody held them.
const FORCES_TOLD: f64 = 1e-2;
/// A defect of the energy balance beyond this part of the largest stored energy is told.
const IMBALANCE_TOLD: f64 = 0.05;

/// The loop over steps.
struct Run<'a> {
    integrator: Integrator,
    record: Record,
    session: &'a mut Session,
    validity: Validity,
    balance: EnergyBalance,
    /// Whether a singular configuration has been told.
    met_singular: bool,
    unit_of_time: String,
    /// How many contacts have been told.
    told_contacts: usize,
    /// Whether the scene asks for forces of joints.
    looks_at_forces: bool,
}

impl Run<'_> {
    /// Whether the end was reached.
    fn integrate(
        &mut self,
        simulation: &mut Simulation,
        observer: &mut dyn Observer,
    ) -> Result<bool, Error> {
        let end = self.integrator.end;
        let mut rows = Rows::of(self.record);
        self.write(RecordedStep::of(simulation, 0.0, Effort::default()))?;
        self.session
            .scope
            .observe_motion(simulation.system(), simulation.state());
        self.write_fields(simulation)?;
        let mut stepping = Stepping::of(&self.integrator, simulation.system());
        while let Some((step, effort)) = stepping.advance(simulation, || observer.is_stopped())? {
            if simulation.was_singular() && !self.met_singular {
                self.met_singular = true;
                let time = simulation.state().time;
                let message = "passed a singular configuration (dead centre): constraint forces are not unique there";
                self.session.tell(observer, time, message);
            }
            self.session
                .scope
                .observe_motion(simulation.system(), simulation.state());
            self.tell_contacts(simulation, observer);
            rows.count_step();
            let mut is_recorded = false;
            let now = simulation.state().time;
            let mut is_due = now >= end;
            while let Some(due) = rows.take(now) {
                match due {
                    Due::Now => is_due = true,
                    Due::Within(time) => {
                        let state = simulation.look_within(time);
                        let row = RecordedStep::within(simulation, &state, step, effort);
                        self.write(row)?;
                        is_recorded = true;
                    }
                }
            }
            self.write_fields(simulation)?;
            if is_due {
                self.write(RecordedStep::of(simulation, step, effort))?;
                is_recorded = true;
            }
            if is_recorded {
                observer.progress(now, end);
                let (system, state) = (simulation.system(), simulation.state());
                let session = &mut *self.session;
                self.validity.check(system, state, |message| {
                    session.tell(observer, state.time, &message);
                })?;
            }
        }
        if simulation.state().time < end {
            return Ok(false);
        }
        let time = simulation.state().time;
        // Single steps may be short, for example the last one.
        let (steps, _) = simulation.effort();
        let mean_step = time / steps.max(1) as f64;
        let resolution = resolution_warning(simulation, &self.unit_of_time);
        let forces = (self.integrator.force_tolerance().is_none() && self.looks_at_forces)
            .then(|| forces_warning(simulation))
            .flatten();
        let rounding = rounding_warning(simulation, mean_step, &self.unit_of_time);
        for message in resolution
            .into_iter()
            .chain(rounding)
            .chain(forces)
            .chain(imbalance_warning(&self.balance))
        {
            self.session.tell(observer, time, &message);
        }
        Ok(true)
    }

    /// Writes the fields that are due since the last step.
    fn write_fields(&mut self, simulation: &mut Simulation) -> Result<(), Error> {
        for field in &mut self.session.fields {
            while let Some(due) = field.take(simulation.state().time) {
                match due {
                    Due::Now => {
                        simulation.refresh();
                        let (system, state) = (simulation.system(), simulation.state());
                        field.write(system, state, simulation.evaluation())?;
                    }
                    Due::Within(time) => {
                        let state = simulation.look_within(time);
                        field.write(simulation.system(), &state, simulation.evaluation())?;
                    }
                }
            }
        }
        Ok(())
    }

    fn tell_contacts(&mut self, simulation: &Simulation, observer: &mut dyn Observer) {
        for contact in &simulation.contacts()[self.told_contacts..] {
            let message = contact.message(simulation.system());
            self.session.tell(observer, contact.time, &message);
        }
        self.told_contacts = simulation.contacts().len();
    }

    fn write(&mut self, now: RecordedStep) -> Result<(), Error> {
        self.balance.look_at(&now);
        self.session.record(&now)
    }
}

/// How the next step is found.
pub struct Stepping {
    steps: Steps,
    end: f64,
}

enum Steps {
    /// Equal ones, and how many have been made.
    Equal { steps: EqualSteps, made: u64 },
    /// They follow the error.
    Adaptive(Box<StepSize>),
    /// They follow an accuracy.
    Accurate,
}

impl Stepping {
    /// As the integrator says, up to its end.
    pub fn of(integrator: &Integrator, system: &System) -> Self {
        let Integrator { step, end, .. } = *integrator;
        let steps = match integrator.adaptive {
            _ if integrator.is_radau() => Steps::Accurate,
            None => Steps::Equal {
                steps: EqualSteps::new(step, end),
                made: 0,
            },
            Some(adaptive) => {
                let adaptive = adaptive_step(step, &adaptive, system);
                Steps::Adaptive(Box::new(StepSize::new(adaptive)))
            }
        };
        let end = match &steps {
            Steps::Equal { steps, .. } => steps.time(steps.count()),
            Steps::Adaptive(_) | Steps::Accurate => end,
        };
        Self { steps, end }
    }

    /// Makes the next step: its length and what it took. `None` at the end, or if the run is to stop.
    pub fn advance(
        &mut self,
        simulation: &mut Simulation,
        is_stopped: impl FnOnce() -> bool,
    ) -> Result<Option<(f64, Effort)>, Error> {
        if simulation.state().time >= self.end || is_stopped() {
            return Ok(None);
        }
        match &mut self.steps {
            Steps::Equal { steps, made } => {
                let made_now = simulation.step_equally(steps, *made + 1)?;
                *made += 1;
                Ok(Some(made_now))
            }
            Steps::Adaptive(size) => simulation.step_adaptively(self.end, size).map(Some),
            Steps::Accurate => simulation.step_towards(self.end).map(Some),
        }
    }
}

/// How steps of a scene follow the error, the first of them being `first`.
pub fn adaptive_step(first: f64, adaptive: &scene::AdaptiveStep, system: &System) -> AdaptiveStep {
    let size = system.bodies.iter().map(|body| body.length).sum::<f64>();
    AdaptiveStep {
        tolerance: adaptive.tolerance * size,
        first,
        smallest: adaptive.minimum_step,
        largest: adaptive.maximum_step,
    }
}

/// Weak compatibility is stable above a step only.
fn check_window(
    scene: &Scene,
    integrator: &Integrator,
    simulation: &Simulation,
    observer: &mut dyn Observer,
    session: &mut Session,
) -> Result<(), Error> {
    if scene.compatibility != Compatibility::Weak {
        return Ok(());
    }
    let Some(scheme) = Scheme::of(integrator.method) else {
        return Ok(());
    };
    let window = WeakWindow::of(simulation.system(), simulation.state(), &scheme);
    let unit = &scene.units.time;
    for body in &window.bodies {
        let message = format!(
            "weak compatibility of body {:?}: {} motions grow, the slowest at {:.4e} 1/{unit}; steps above {:.4e} {unit} damp them",
            body.body, body.negative_eigenvalue_count, body.sigma_min, body.smallest_step
        );
        session.tell(observer, 0.0, &message);
    }
    if scene.allow_unstable_weak {
        return Ok(());
    }
    let step = integrator
        .adaptive
        .map_or(integrator.step, |adaptive| adaptive.minimum_step);
    window.check(step)
}

/// Note on steps that are too long for motions of the run up to now: one for all bodies. `time` is the unit of time.
pub fn resolution_warning(simulation: &Simulation, time: &str) -> Option<String> {
    let told = simulation.resolution().told();
    let fastest = told
        .iter()
        .min_by(|one, other| one.advised_step().total_cmp(&other.advised_step()))?;
    let bodies = &simulation.system().bodies;
    let what = match fastest.part {
        Part::Place => "motion",
        Part::Deflection => "deflection",
    };
    let affected = (0..bodies.len()).filter(|body| told.iter().any(|found| found.body == *body));
    let others = match affected.count() - 1 {
        0 => String::new(),
        1 => " (and of 1 other body)".to_owned(),
        count => format!(" (and of {count} other bodies)"),
    };
    Some(format!(
        "the {what} of body {:?}{others} has {:.1} steps of {:.1e} {time} in a period: its frequency and phase are wrong; to follow it take steps below {:.1e} {time}",
        bodies[fastest.body].name,
        fastest.steps_per_period,
        fastest.step,
        fastest.advised_step()
    ))
}

/// Note on forces that miss oscillations of bodies which the accuracy of the motion doesn't ask for.
fn forces_warning(simulation: &Simulation) -> Option<String> {
    let error = simulation.error_of_forces();
    (error.is_finite() && error > FORCES_TOLD).then(|| {
        format!(
            "forces of joints are off by about {error:.0e} of the largest in a step: the motion's tolerance lets stiff bodies ring as they like; `force_tolerance` of radau holds forces, too"
        )
    })
}

/// Note on forces that consist of rounding at steps of this size.
pub fn rounding_warning(simulation: &Simulation, step: f64, time: &str) -> Option<String> {
    let rounding = simulation.rounding_of_forces(step);
    (rounding.is_finite() && rounding > ROUNDING_TOLD).then(|| {
        format!(
            "rounding of positions is {rounding:.0e} of the joints' forces at a step of {step:.1e} {time}: take longer steps, \"formulation\": \"stabilized-index-2\", or a place nearer to the world's origin"
        )
    })
}

/// Note on the damping of the assembled modes.
fn damping_note(modes: &[EffectiveDamping], scene: &Scene) -> Option<String> {
    let unit = frequency_unit(&scene.units);
    let listed = modes.iter().map(|mode| {
        format!(
            "{} at {} {unit}",
            four_digits(mode.ratio),
            four_digits(mode.frequency)
        )
    });
    let listed: Vec<String> = listed.collect();
    (!listed.is_empty()).then(|| {
        format!(
            "damping ratios of the lowest modes of the assembled mechanism: {} ({})",
            listed.join(", "),
            damping_origin(modes, scene)
        )
    })
}

/// Who gives the ratio of the lowest mode, largest share first.
fn damping_origin(modes: &[EffectiveDamping], scene: &Scene) -> String {
    let parts = "the scene and the files give those of the parts by themselves";
    let Some(lowest) = modes.first() else {
        return parts.into();
    };
    let mut shares: Vec<_> = (lowest.shares.iter())
        .filter(|share| share.ratio != 0.0)
        .collect();
    shares.sort_by(|a, b| b.ratio.abs().total_cmp(&a.ratio.abs()));
    match (shares.len(), &scene.damping) {
        (0 | 1, None) => parts.into(),
        (0 | 1, Some(damping)) => format!("by damping.{}", damping.key()),
        _ => {
            let first = shares
                .iter()
                .take(MOST_SHARES)
                .map(|share| format!("{} {}", share.name, four_digits(share.ratio)));
            let first: Vec<String> = first.collect();
            format!("of the lowest one: {}", first.join(", "))
        }
    }
}

/// Note on an energy balance.
pub fn imbalance_warning(balance: &EnergyBalance) -> Option<String> {
    let share = balance.share().filter(|share| *share > IMBALANCE_TOLD)?;
    Some(format!(
        "the energy balance lacks {share:.1e} of the largest energy that was stored or exchanged: the steps are too long for this motion; take shorter ones, or a smaller tolerance of radau"
    ))
}
