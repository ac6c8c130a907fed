//! A scene in motion under the control of a program: steps, inputs, and outputs by name.

use crate::error::Error;
use crate::initial::InitialReport;
use crate::integrator::Effort;
use crate::integrator::adaptive::StepSize;
use crate::linear::{LinearRequest, linear_system, settled};
use crate::model::{Input, Model, RecordedStep, Recorder};
use crate::run;
use crate::simulation::{Simulation, Snapshot};
use dcb_formats::linear_system::LinearSystem;
use dcb_formats::results::Channel;
use dcb_formats::scene::{Integrator, Scene};

/// A scene in motion, advanced step by step.
///
/// Where a whole run is to go to a results file, [`run::run`] does that.
pub struct Mechanism {
    scene: Scene,
    simulation: Simulation,
    recorder: Recorder,
    inputs: Vec<Input>,
    initial: InitialReport,
    last_step: (f64, Effort),
    /// The recorder's values, and whether they are those of the present state.
    values: Vec<f64>,
    is_current: bool,
}

impl Mechanism {
    /// Checks a scene, loads its superelements and makes its start consistent. The scene's `integrator` says how steps are made;
    /// its `step`, `end` and `record` are those of a whole run and don't matter here, but for the integral of a speed, which
    /// reaches to `end`.
    ///
    /// # Errors
    /// Those of [`Scene::check`], [`Model::load`] and [`Simulation::start`].
    pub fn start(scene: &Scene) -> Result<Self, Error> {
        scene.check()?;
        let integrator = scene
            .integrator
            .ok_or_else(|| Error::described("integrator", "is missing"))?;
        Self::start_model(scene, &integrator, Model::load(scene)?)
    }

    /// The same of a scene that is checked and loaded already.
    ///
    /// # Errors
    /// Those of [`Simulation::start`].
    pub fn start_model(
        scene: &Scene,
        integrator: &Integrator,
        model: Model,
    ) -> Result<Self, Error> {
        let Model {
            system,
            drawn,
            recorder,
            held,
            senses,
            inputs,
            ..
        } = model;
        let rule = run::rule(integrator);
        let redundancy = scene.redundant_constraints;
        let (mut simulation, initial) =
            Simulation::start_holding(system, drawn, rule, redundancy, &held)?;
        run::check_gaps(&initial, scene)?;
        if let Some(senses) = senses {
            simulation.control(senses)?;
        }
        let columns = recorder.channels().iter();
        let width = columns.map(|channel| channel.columns.len()).sum();
        Ok(Self {
            scene: scene.clone(),
            simulation,
            recorder,
            inputs,
            initial,
            last_step: (0.0, Effort::default()),
            values: Vec::with_capacity(width),
            is_current: false,
        })
    }

    /// Changes that made the start consistent.
    pub fn initial(&self) -> &InitialReport {
        &self.initial
    }

    /// Time reached.
    pub fn time(&self) -> f64 {
        self.simulation.state().time
    }

    /// One step of this length.
    ///
    /// # Errors
    /// Those of [`Simulation::step`]; the motion stays where it was.
    pub fn step(&mut self, step: f64) -> Result<Effort, Error> {
        let effort = self.simulation.step(step)?;
        self.last_step = (step, effort);
        self.is_current = false;
        Ok(effort)
    }

    /// One step towards `end`, as large as the tolerance of `size` allows; its size, and what it took.
    ///
    /// # Errors
    /// Those of [`Simulation::step_adaptively`]; the motion stays where it was.
    pub fn step_adaptively(
        &mut self,
        end: f64,
        size: &mut StepSize,
    ) -> Result<(f64, Effort), Error> {
        let made = self.simulation.step_adaptively(end, size)?;
        self.last_step = made;
        self.is_current = false;
        Ok(made)
    }

    /// One step towards `end`, as long as the accuracy of the scene's integrator allows; its length, and what it took.
    ///
    /// # Errors
    /// Those of [`Simulation::step_towards`]; the motion stays where it was.
    pub fn step_towards(&mut self, end: f64) -> Result<(f64, Effort), Error> {
        let made = self.simulation.step_towards(end)?;
        self.last_step = made;
        self.is_current = false;
        Ok(made)
    }

    /// What can be set between steps, with names, units and values at the start.
    pub fn inputs(&self) -> &[Input] {
        &self.inputs
    }

    /// What can be asked for, with names and units of the numbers of each; the scene's outputs come first, in its order.
    pub fn channels(&self) -> &[Channel] {
        self.recorder.channels()
    }

    /// Sets an input from now on: that of a drive or load by its name; `NAME/INDEX` where several components of a load have one.
    ///
    /// # Errors
    /// Those of [`Simulation::set_input`].
    pub fn set_input(&mut self, name: &str, value: f64) -> Result<(), Error> {
        self.is_current = false;
        self.simulation.set_input(name, value)
    }

    /// The values of an output of the scene, or of anything else that a run records (`reactions/JOINT`, `energy/balance` and so on;
    /// `docs/results.md`), at the present time. Forces, accelerations and reactions are those of the last step.
    ///
    /// # Errors
    /// [`Error::UnknownOutput`].
    pub fn output(&mut self, name: &str) -> Result<&[f64], Error> {
        let columns = self.recorder.columns(name)?;
        if !self.is_current {
            let (step, effort) = self.last_step;
            let row = self
                .recorder
                .row(&RecordedStep::of(&mut self.simulation, step, effort));
            self.values.clear();
            self.values.extend_from_slice(row);
            self.is_current = true;
        }
        Ok(&self.values[columns])
    }

    /// The linear system about the present state, with the inputs as they are now.
    ///
    /// # Errors
    /// Those of [`crate::linearize`].
    pub fn linearize(&mut self, request: &LinearRequest) -> Result<LinearSystem, Error> {
        // The recorder's last values are of other states then.
        self.is_current = false;
        let system = self.simulation.system();
        let state = settled(system, self.simulation.state())?;
        linear_system(&self.scene, system, &state, &mut self.recorder, request)
    }

    /// The motion with all that its continuation depends on: this one and one that is restored go on alike to the last bit.
    pub fn save(&mut self) -> Snapshot {
        self.simulation.save()
    }

    /// Goes back, or on, to what was saved of this scene.
    ///
    /// # Errors
    /// [`Error::ForeignSnapshot`].
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), Error> {
        self.is_current = false;
        self.simulation.restore(snapshot)
    }

    /// The simulation itself: state, system, energies.
    pub fn simulation(&self) -> &Simulation {
        &self.simulation
    }
}
