//! The motion of a unit, and what is worth telling of it.

use dcb_formats::scene::{Compatibility, Integrator, Scene, Scheme};
use dcb_runtime::mechanism::Mechanism;
use dcb_runtime::model::Model;
use dcb_runtime::run;
use dcb_runtime::run::transient::{adaptive_step, resolution_warning, rounding_warning};
use dcb_runtime::watch::compatibility_window::WeakWindow;
use dcb_runtime::watch::validity::Validity;

use crate::choice::Choice;
use crate::error::Error;
use crate::stepping::Stepping;

/// The motion of a unit.
pub(crate) struct Motion {
    /// What it was made of.
    pub choice: Choice,
    pub mechanism: Mechanism,
    pub stepping: Stepping,
    /// Last communication point.
    pub time: f64,
    validity: Validity,
    /// Where weak compatibility is stable; `None` where that doesn't matter.
    window: Option<WeakWindow>,
    unit_of_time: String,
}

impl Motion {
    /// The start of a scene, made of what was chosen.
    pub fn of(
        scene: &Scene,
        integrator: &Integrator,
        model: Model,
        choice: &Choice,
        warnings: &mut Vec<String>,
    ) -> Result<Self, Error> {
        warnings.extend(model.notes.iter().cloned());
        let mechanism = Mechanism::start_model(scene, integrator, model)?;
        warnings.extend(run::start_notes(mechanism.initial(), scene));
        let simulation = mechanism.simulation();
        let (system, state) = (simulation.system(), simulation.state());
        let stepping = match &integrator.adaptive {
            None if integrator.is_radau() => Stepping::Accurate,
            None => Stepping::equal(integrator.step),
            Some(adaptive) => Stepping::adaptive(adaptive_step(integrator.step, adaptive, system)),
        };
        let is_watched = scene.compatibility == Compatibility::Weak && !scene.allow_unstable_weak;
        let scheme = Scheme::of(integrator.method).filter(|_| is_watched);
        let window = scheme.map(|scheme| WeakWindow::of(system, state, &scheme));
        if let Some(window) = &window {
            let shortest = integrator.adaptive.map(|adaptive| adaptive.minimum_step);
            window.check(shortest.unwrap_or(integrator.step))?;
        }
        Ok(Self {
            choice: choice.clone(),
            validity: Validity::of(system, state),
            stepping,
            time: 0.0,
            window,
            unit_of_time: scene.units.time.clone(),
            mechanism,
        })
    }

    /// Moves to a later communication point.
    pub fn advance(&mut self, target: f64) -> Result<(), Error> {
        let window = self.window.as_ref();
        self.stepping
            .advance(&mut self.mechanism, target, |_, step| match window {
                Some(window) => window.check(step),
                None => Ok(()),
            })?;
        self.time = target;
        Ok(())
    }

    /// Adds what the last communication step has shown.
    pub fn tell(&mut self, warnings: &mut Vec<String>) -> Result<(), Error> {
        let simulation = self.mechanism.simulation();
        let (system, state) = (simulation.system(), simulation.state());
        self.validity
            .check(system, state, |message| warnings.push(message))?;
        Ok(())
    }

    /// Adds what is known at the end only.
    pub fn tell_at_end(&self, warnings: &mut Vec<String>) {
        let simulation = self.mechanism.simulation();
        warnings.extend(resolution_warning(simulation, &self.unit_of_time));
        let (steps, _) = simulation.effort();
        let mean_step = simulation.state().time / steps.max(1) as f64;
        if mean_step > 0.0 {
            warnings.extend(rounding_warning(simulation, mean_step, &self.unit_of_time));
        }
    }
}
