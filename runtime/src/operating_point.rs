//! The state about which a scene is linear, and its linear system there.

use dcb_formats::linear_system::LinearSystem;
use dcb_formats::scene::{Integrator, Scene};

use crate::analysis::equilibrium::{EquilibriumSettings, find_equilibrium};
use crate::error::Error;
use crate::initial::Starter;
use crate::linear::{LinearRequest, linear_system, settled};
use crate::model::{Model, Recorder};
use crate::run::transient::Stepping;
use crate::run::{Observer, check_gaps, rule, start_notes};
use crate::simulation::Simulation;
use crate::system::evaluation::Evaluation;
use crate::system::linearization::Linearization;
use crate::system::{State, System};

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
struct Reached {
    system: System,
    state: State,
    recorder: Recorder,
}

/// Goes there; `None` if the observer stops it.
fn reach(
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

/// The linear system of a scene at an operating point; `None` if the observer stopped the motion towards it.
///
/// # Errors
/// Those of [`crate::Model::load`], of a start and of [`crate::analysis::equilibrium::find_equilibrium`] or of a motion; [`Error::Description`] at `inputs`,
/// `outputs` or `order` for a request that can't be met; [`Error::NotHandled`] for static and weak compatibility.
pub fn linearize(
    scene: &Scene,
    at: OperatingPoint,
    request: &LinearRequest,
    observer: &mut dyn Observer,
) -> Result<Option<LinearSystem>, Error> {
    let Some(mut reached) = reach(scene, at, observer)? else {
        return Ok(None);
    };
    let recorder = &mut reached.recorder;
    linear_system(scene, &reached.system, &reached.state, recorder, request).map(Some)
}
