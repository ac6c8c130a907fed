//! The state about which a mechanism is linear.

use dcb_formats::scene::{Integrator, Scene};

use crate::analysis::equilibrium::{EquilibriumSettings, find_equilibrium};
use crate::analysis::independent::{IndependentMotion, size};
use crate::error::Error;
use crate::initial::Starter;
use crate::model::{Model, Recorder};
use crate::run::transient::Stepping;
use crate::run::{Observer, check_gaps, rule, start_notes};
use crate::simulation::Simulation;
use crate::system::evaluation::Evaluation;
use crate::system::linearization::Linearization;
use crate::system::{State, System};

/// Bodies that move by less than this part of their size in the time of the fastest pole are at rest.
const STILL: f64 = 1e-12;
/// Gravity that is left, as a part of it, where it is balanced.
const BALANCED: f64 = 1e-10;

/// Where a mechanism is linearized.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum OperatingPoint {
    /// The start, made consistent.
    #[default]
    Initial,
    /// A stable rest near it.
    Static,
    /// A time that the motion from the start has reached, in the scene's unit.
    Time(f64),
}

/// A state of a scene.
pub(super) struct Reached {
    pub system: System,
    pub state: State,
    pub recorder: Recorder,
}

/// Goes there; `None` if the observer stops it.
pub(super) fn reach(
    scene: &Scene,
    at: OperatingPoint,
    observer: &mut dyn Observer,
) -> Result<Option<Reached>, Error> {
    let mut scene = scene.clone();
    if let (OperatingPoint::Time(time), Some(integrator)) = (at, &mut scene.integrator) {
        // Integrals of speeds reach to the end.
        integrator.end = integrator.end.max(time);
    }
    let Model {
        system,
        mut drawn,
        recorder,
        held,
        notes,
        ..
    } = Model::load(&scene)?;
    for note in &notes {
        observer.note(0.0, note);
    }
    let mut tell = |report| {
        check_gaps(&report, &scene)?;
        for note in start_notes(&report, &scene) {
            observer.note(0.0, &note);
        }
        Ok::<(), Error>(())
    };
    match at {
        OperatingPoint::Static => {
            find_equilibrium(&system, &mut drawn, &EquilibriumSettings::default())?;
        }
        OperatingPoint::Time(time) if time > 0.0 && time.is_finite() => {
            let Some(integrator) = scene.integrator else {
                return Err(Error::described(
                    "integrator",
                    "is missing, which leads to the time of the operating point; give it, or linearize at the start or at rest",
                ));
            };
            // What can't be linearized is said before the motion, not after it.
            Linearization::with_rigid_joints(&system, &drawn, &Evaluation::at(&system, &drawn))?;
            let redundancy = scene.redundant_constraints;
            let rule = rule(&integrator);
            let (mut simulation, report) =
                Simulation::start_holding(system, drawn, rule, redundancy, &held)?;
            tell(report)?;
            let integrator = Integrator {
                end: time,
                ..integrator
            };
            let mut stepping = Stepping::of(&integrator, simulation.system());
            while stepping
                .advance(&mut simulation, || observer.is_stopped())?
                .is_some()
            {
                observer.progress(simulation.state().time, time);
            }
            if simulation.state().time < time {
                return Ok(None);
            }
            let state = settled(simulation.system(), simulation.state())?;
            return Ok(Some(Reached {
                system: simulation.system().clone(),
                state,
                recorder,
            }));
        }
        OperatingPoint::Initial | OperatingPoint::Time(0.0) => {
            let mut starter = Starter::of(&system)?.holding(&held);
            tell(starter.start(&mut drawn, scene.redundant_constraints)?)?;
        }
        OperatingPoint::Time(time) => {
            return Err(Error::BadNumber {
                quantity: "the time of the operating point".into(),
                found: time,
                expected: "a time from zero on",
            });
        }
    }
    Ok(Some(Reached {
        system,
        state: drawn,
        recorder,
    }))
}

/// A state of a motion with the accelerations that its positions, velocities and inputs have now, not those of an integrator's step.
pub(crate) fn settled(system: &System, state: &State) -> Result<State, Error> {
    let mut state = state.clone();
    Starter::of(system)?.accelerate(&mut state)?;
    Ok(state)
}

/// Whether nothing moves, and nothing begins to, but for rounding; `fastest` is the size of the fastest pole.
pub(super) fn is_at_rest(system: &System, state: &State, fastest: f64) -> bool {
    let lengths = system.bodies.iter().map(|body| body.length);
    let falling = system.gravity.norm() / lengths.fold(f64::INFINITY, f64::min);
    let (speed, acceleration) = (
        size(system, &state.velocities),
        size(system, &state.accelerations),
    );
    speed <= STILL * fastest && acceleration <= BALANCED * falling + f64::EPSILON * fastest.powi(2)
}

/// A consistent state with the forces of its springs, and those of constraints that are least, however often they repeat each other.
pub(super) fn with_reactions(system: &System, state: &State, motion: &IndependentMotion) -> State {
    let mut state = state.clone();
    let mut evaluation = Evaluation::of(system);
    evaluation.place(system, &state);
    // Differences must not meet the place where an angle that isn't counted yet jumps.
    evaluation.count_turns(system, &mut state);
    evaluation.add_velocities(system, &state);
    evaluation.measure(system, &state);
    for (index, row) in system.rows.iter().enumerate() {
        state.forces[index] = match row.is_constraint() {
            true => 0.0,
            false => evaluation.answers[index],
        };
    }
    evaluation.load(system, &state);
    evaluation.resist(system, &state);
    let reactions = motion.directions.reactions(&evaluation.residual);
    for (row, force) in motion.linearization.constraints.iter().zip(reactions) {
        state.forces[*row] = force;
    }
    state
}
