//! A unit: a scene, what an importer has chosen, and its motion.

use std::collections::BTreeMap;
use std::path::Path;

use dcb_demand::SuperelementFiles;
use dcb_formats::scene::{Analysis, Integrator, Scene};
use dcb_runtime::model::Model;

use crate::choice::Choice;
use crate::error::Error;
use crate::mode::Mode;
use crate::motion::Motion;
use crate::parameter::Parameter;
use crate::saved_state::SavedState;
use crate::token::token;
use crate::variable::{Source, Variable, variables};

/// Name of the scene in the folder of a unit.
pub const SCENE: &str = "scene.json";

/// A scene as a unit of a co-simulation.
pub struct CoSimulation {
    scene: Scene,
    open: SuperelementFiles,
    token: String,
    parameters: Vec<Parameter>,
    variables: Vec<Variable>,
    /// Places among the variables, by value references.
    places: BTreeMap<u32, usize>,
    /// What a reset goes back to.
    default: Choice,
    choice: Choice,
    mode: Mode,
    motion: Motion,
    warnings: Vec<String>,
}

impl CoSimulation {
    /// Reads the unit in a folder: `scene.json` and its superelements.
    ///
    /// # Errors
    /// Those of [`Scene::read`], [`Model::load`] and [`dcb_runtime::Mechanism::start`], for a scene that isn't transient, and for names that FMI doesn't allow.
    pub fn load(folder: &Path) -> Result<Self, Error> {
        let path = folder.join(SCENE);
        let scene = Scene::read(&path).map_err(dcb_runtime::Error::from)?;
        let text = std::fs::read_to_string(&path)
            .map_err(|source| dcb_formats::Error::io(&path, "cannot read", source))
            .map_err(dcb_runtime::Error::from)?;
        Self::of(scene, &text).map_err(|error| match error {
            Error::Runtime(error) => Error::Runtime(error.in_file(&path)),
            other => other,
        })
    }

    fn of(scene: Scene, text: &str) -> Result<Self, Error> {
        let integrator = integrator(&scene)?;
        let parameters = Parameter::of(&scene);
        let open = SuperelementFiles::default();
        let model = Model::load_from(&scene, &open)?;
        let token = token(text, &model.files);
        let mut warnings = Vec::new();
        let choice = Choice {
            parameters: parameters.iter().map(|one| one.value(&scene)).collect(),
            inputs: model.inputs.iter().map(|input| input.initial).collect(),
            end: integrator.end,
        };
        let motion = Motion::of(&scene, &integrator, model, &choice, &mut warnings)?;
        let variables = variables(&scene, &motion.mechanism, &parameters)?;
        let places = variables.iter().enumerate();
        let places = places
            .map(|(place, variable)| (variable.reference, place))
            .collect();
        Ok(Self {
            scene,
            open,
            token,
            parameters,
            variables,
            places,
            default: choice.clone(),
            choice,
            mode: Mode::Instantiated,
            motion,
            warnings,
        })
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// What can be read and set.
    pub fn variables(&self) -> &[Variable] {
        &self.variables
    }

    /// What the model description of this unit must have as its instantiation token.
    pub fn token(&self) -> &str {
        &self.token
    }

    /// Where it is in its life.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// The last communication point.
    pub fn time(&self) -> f64 {
        self.motion.time
    }

    /// How far the motion has come: where a step failed, up to the last inner step before.
    pub fn time_reached(&self) -> f64 {
        self.motion.mechanism.time()
    }

    /// What is worth telling since it was asked last.
    pub fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }

    /// The value of a variable.
    ///
    /// # Errors
    /// [`Error::UnknownReference`]; those of the start if a start value has been changed.
    pub fn value(&mut self, reference: u32) -> Result<f64, Error> {
        let place = self.place(reference)?;
        match &self.variables[place].source {
            Source::Time => Ok(self.motion.time),
            Source::Parameter(index) => Ok(self.choice.parameters[*index]),
            Source::Input(index) => Ok(match self.mode {
                Mode::Instantiated | Mode::Initialization => self.choice.inputs[*index],
                Mode::Step | Mode::Terminated => {
                    self.motion.mechanism.simulation().state().inputs[*index]
                }
            }),
            Source::Output { .. } => {
                self.bring_up_to_date()?;
                let Source::Output { channel, column } = &self.variables[place].source else {
                    return Err(Error::UnknownReference(reference));
                };
                Ok(self.motion.mechanism.output(channel)?[*column])
            }
        }
    }

    /// Sets a parameter or an input.
    ///
    /// # Errors
    /// [`Error::UnknownReference`], [`Error::NotFinite`]; [`Error::NotSettable`] for outputs, and for parameters after the start.
    pub fn set(&mut self, reference: u32, value: f64) -> Result<(), Error> {
        let place = self.place(reference)?;
        let variable = &self.variables[place];
        let refused = |why| {
            Err(Error::NotSettable {
                name: variable.name.clone(),
                why,
            })
        };
        if !value.is_finite() {
            let name = variable.name.clone();
            return Err(Error::NotFinite { name, value });
        }
        let is_before = matches!(self.mode, Mode::Instantiated | Mode::Initialization);
        match &variable.source {
            Source::Time => refused("the time follows from the steps"),
            Source::Output { .. } => refused("an output can't be set"),
            _ if self.mode == Mode::Terminated => refused("the simulation is over; reset the unit"),
            Source::Parameter(index) if is_before => {
                self.choice.parameters[*index] = value;
                Ok(())
            }
            Source::Parameter(_) => {
                refused("a parameter can be set before the start only; reset the unit")
            }
            Source::Input(index) if is_before => {
                self.choice.inputs[*index] = value;
                Ok(())
            }
            Source::Input(_) => Ok(self.motion.mechanism.set_input(&variable.name, value)?),
        }
    }

    /// Begins the choice of start values.
    ///
    /// # Errors
    /// [`Error::WrongMode`]; [`Error::Time`] for a start other than zero or a stop that isn't later.
    pub fn enter_initialization(&mut self, start: f64, stop: Option<f64>) -> Result<(), Error> {
        self.expect(
            Mode::Instantiated,
            "fmi3EnterInitializationMode",
            "reset the unit first",
        )?;
        if start != 0.0 {
            return Err(Error::Time {
                quantity: "the start time",
                found: start,
                expected: "but the motion of a scene begins at 0".into(),
            });
        }
        if let Some(stop) = stop {
            if !(stop >= 0.0 && stop.is_finite()) {
                return Err(Error::Time {
                    quantity: "the stop time",
                    found: stop,
                    expected: "expected a time after 0".into(),
                });
            }
            self.choice.end = self.default.end.max(stop);
        }
        self.mode = Mode::Initialization;
        Ok(())
    }

    /// Starts the motion with the values that were chosen.
    ///
    /// # Errors
    /// [`Error::WrongMode`]; what makes the scene with these values unusable, or its start inconsistent.
    pub fn exit_initialization(&mut self) -> Result<(), Error> {
        let call = "fmi3ExitInitializationMode";
        self.expect(
            Mode::Initialization,
            call,
            "call fmi3EnterInitializationMode first",
        )?;
        self.bring_up_to_date()?;
        self.mode = Mode::Step;
        Ok(())
    }

    /// Moves from one communication point to the next.
    ///
    /// # Errors
    /// [`Error::WrongMode`]; [`Error::Time`] where `from` isn't the last communication point or the step isn't positive; whatever stops an inner
    /// step: the motion stays at the one before it.
    pub fn step(&mut self, from: f64, length: f64) -> Result<(), Error> {
        self.expect(Mode::Step, "fmi3DoStep", "initialize the unit first")?;
        let motion = &mut self.motion;
        if !motion.stepping.is_same(from, motion.time) {
            return Err(Error::Time {
                quantity: "the current communication point",
                found: from,
                expected: format!("but the unit is at {:?}", motion.time),
            });
        }
        let target = from + length;
        if !(length > 0.0 && target > motion.mechanism.time() && target.is_finite()) {
            return Err(Error::Time {
                quantity: "the communication step",
                found: length,
                expected: "expected a positive time that changes the sum".into(),
            });
        }
        motion.advance(target)?;
        motion.tell(&mut self.warnings)?;
        Ok(())
    }

    /// Ends the motion.
    ///
    /// # Errors
    /// [`Error::WrongMode`].
    pub fn terminate(&mut self) -> Result<(), Error> {
        self.expect(Mode::Step, "fmi3Terminate", "there is no motion to end")?;
        self.motion.tell_at_end(&mut self.warnings);
        self.mode = Mode::Terminated;
        Ok(())
    }

    /// Back to where [`CoSimulation::load`] left it.
    ///
    /// # Errors
    /// Those of the start: files that are gone meanwhile, for example.
    pub fn reset(&mut self) -> Result<(), Error> {
        self.choice = self.default.clone();
        self.motion = self.moving()?;
        self.mode = Mode::Instantiated;
        Ok(())
    }

    /// All that the continuation depends on: this unit and one that is restored go on alike.
    ///
    /// # Errors
    /// Those of the start if a start value has been changed.
    pub fn save(&mut self) -> Result<SavedState, Error> {
        self.bring_up_to_date()?;
        Ok(SavedState {
            token: self.token.clone(),
            mode: self.mode,
            choice: self.choice.clone(),
            time: self.motion.time,
            progress: self.motion.stepping.progress(),
            motion: self.motion.mechanism.save(),
        })
    }

    /// Goes back, or on, to what was saved of a unit of the same scene.
    ///
    /// # Errors
    /// [`Error::ForeignState`]; those of the start if it was saved with other start values.
    pub fn restore(&mut self, saved: &SavedState) -> Result<(), Error> {
        if saved.token != self.token {
            return Err(Error::ForeignState("it is of another unit"));
        }
        let before = std::mem::replace(&mut self.choice, saved.choice.clone());
        if let Err(error) = self.bring_up_to_date() {
            self.choice = before;
            return Err(error);
        }
        self.motion.mechanism.restore(&saved.motion)?;
        self.motion.stepping.resume(&saved.progress);
        self.motion.time = saved.time;
        self.mode = saved.mode;
        Ok(())
    }

    /// A saved state in bytes: [`SavedState::bytes`] of a unit of the same scene.
    ///
    /// # Errors
    /// [`Error::ForeignState`] for anything else.
    pub fn state_of_bytes(&self, bytes: &[u8]) -> Result<SavedState, Error> {
        let counts = [self.choice.parameters.len(), self.choice.inputs.len()];
        let simulation = self.motion.mechanism.simulation();
        SavedState::of_bytes(bytes, &self.token, counts, simulation)
    }

    fn place(&self, reference: u32) -> Result<usize, Error> {
        let place = self.places.get(&reference).copied();
        place.ok_or(Error::UnknownReference(reference))
    }

    fn expect(&self, mode: Mode, call: &'static str, remedy: &'static str) -> Result<(), Error> {
        match self.mode == mode {
            true => Ok(()),
            false => Err(Error::WrongMode {
                call,
                mode: self.mode,
                remedy,
            }),
        }
    }

    /// Makes the motion anew if it was made of other values.
    fn bring_up_to_date(&mut self) -> Result<(), Error> {
        if self.motion.choice != self.choice {
            self.motion = self.moving()?;
        }
        Ok(())
    }

    /// The motion at its start, with the values that were chosen.
    fn moving(&mut self) -> Result<Motion, Error> {
        let mut scene = self.scene.clone();
        for (parameter, value) in self.parameters.iter().zip(&self.choice.parameters) {
            parameter.set(&mut scene, *value);
        }
        if let Some(integrator) = &mut scene.integrator {
            integrator.end = self.choice.end;
        }
        scene.check().map_err(dcb_runtime::Error::from)?;
        let integrator = integrator(&scene)?;
        let mut model = Model::load_from(&scene, &self.open)?;
        model.start_inputs(&self.choice.inputs)?;
        Motion::of(&scene, &integrator, model, &self.choice, &mut self.warnings)
    }
}

/// The integrator of a scene that moves over time.
fn integrator(scene: &Scene) -> Result<Integrator, Error> {
    if scene.analysis != Analysis::Transient {
        return Err(Error::Runtime(dcb_runtime::Error::described(
            "analysis",
            "is not \"transient\", but a unit of a co-simulation moves over time; leave the key out",
        )));
    }
    let missing = || dcb_runtime::Error::described("integrator", "is missing");
    Ok(scene.integrator.ok_or_else(missing)?)
}
