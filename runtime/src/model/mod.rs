//! A scene with its superelements loaded: the system, its state as drawn, and where the scene's names are in them.

mod actuators;
mod assembled_modes;
mod bodies;
mod body_outputs;
mod controllers;
mod couplings;
mod field_folder;
mod fields;
mod inputs;
mod library;
mod mass_probe;
mod moment;
mod node_shapes;
mod outputs;
mod places;
mod probe;
mod quantities;
mod recorder;
mod springs;
mod stresses;
pub mod timetable;

use std::sync::Arc;

use indexmap::IndexMap;
use nalgebra::Vector3;

use crate::body::Compatibility;
use crate::error::Error;
use crate::simulation::Senses;
use crate::system::builder::{BuiltJoint, JointCoordinate, SystemBuilder};
use crate::system::{State, System};
use dcb_demand::SuperelementFiles;
use dcb_demand::pruning::{Carrying, NarrowedScene, Pruning};
use dcb_formats::scene::{Analysis, Scene};
use dcb_superelement::ErrorBounds;

use controllers::SensesBuilder;
pub use field_folder::FieldFolders;
pub use fields::{FieldPlan, FieldWriter};
pub use inputs::Input;
pub use library::{Library, LoadedFile};
pub(crate) use quantities::Quantities;
pub use recorder::{RecordedStep, Recorder};

/// A scene ready to be run.
pub struct Model {
    /// The mechanism.
    pub system: System,
    /// Bodies as the scene draws them.
    pub drawn: State,
    /// Recorder of the run.
    pub recorder: Recorder,
    /// Fields that the run writes.
    pub fields: Vec<FieldPlan>,
    /// Bounds of what the superelement of each body leaves out, where an analysis tells the errors of its results.
    pub error_bounds: Vec<Option<ErrorBounds>>,
    /// What sampled controllers see.
    pub senses: Option<Senses>,
    /// Bodies that stay where they are drawn when the others are placed to fit the joints.
    pub held: Vec<usize>,
    /// Files that were read.
    pub files: Vec<LoadedFile>,
    /// What a program can set between steps, in the order of the system's inputs.
    pub inputs: Vec<Input>,
    /// Notes for the user before the run.
    pub notes: Vec<String>,
}

/// Where the names of a scene are in a system being built.
struct Names {
    /// Body by name.
    bodies: IndexMap<String, usize>,
    /// Joint by name; gears and racks have none, but a connection.
    joints: IndexMap<String, NamedJoint>,
    /// Connection of each drive.
    drives: IndexMap<String, usize>,
    /// Connection of each spring.
    springs: IndexMap<String, usize>,
    /// Connection of each actuator.
    actuators: IndexMap<String, usize>,
}

/// A joint and what outputs need of it.
#[derive(Clone, Debug)]
struct NamedJoint {
    connection: usize,
    /// `None` for gears and racks.
    built: Option<BuiltJoint>,
    /// Values of the free coordinates as drawn, which count as zero.
    zero: [f64; 2],
}

impl NamedJoint {
    fn zero(&self, which: JointCoordinate) -> f64 {
        match which {
            JointCoordinate::Rotation => self.zero[0],
            JointCoordinate::Translation => self.zero[1],
        }
    }
}

impl Model {
    /// Loads the superelements of a scene and builds its system.
    ///
    /// # Errors
    /// [`Error::File`] for a superelement that can't be read; [`Error::Description`] with the path of keys where the scene asks
    /// for something that a superelement hasn't, or of other units or dimension.
    pub fn load(scene: &Scene) -> Result<Self, Error> {
        Self::load_from(scene, &SuperelementFiles::default())
    }

    /// The same with files of which some may be open already.
    ///
    /// # Errors
    /// As [`Model::load`].
    pub fn load_from(scene: &Scene, open: &SuperelementFiles) -> Result<Self, Error> {
        Self::carrying(scene, &Carrying::default(), open)
    }

    /// The same with what is carried of the superelements.
    ///
    /// # Errors
    /// As [`Model::load`].
    pub fn load_narrowed(
        narrowed: &NarrowedScene,
        open: &SuperelementFiles,
    ) -> Result<Self, Error> {
        Self::carrying(&narrowed.scene, &narrowed.carrying, open)
    }

    /// Loads what a scene needs of its superelements, within a relative error of their responses; what was left out, too.
    ///
    /// # Errors
    /// As [`Model::load`], of all that the superelements have.
    pub fn load_needed(
        scene: &Scene,
        open: &SuperelementFiles,
        tolerance: f64,
    ) -> Result<(Self, Pruning), Error> {
        // What the scene asks of its superelements is found wrong, or good, with all that they have.
        let whole = Self::load_from(scene, open)?;
        let pruning = Pruning::of(scene, open, tolerance)?;
        let model = match pruning.count() {
            0 => whole,
            _ => Self::load_narrowed(&pruning.applied_to(scene), open)?,
        };
        Ok((model, pruning))
    }

    /// Sets what inputs are at the start, one value for each of [`Model::inputs`].
    ///
    /// # Errors
    /// [`Error::BadNumber`] for a value that isn't finite.
    pub fn start_inputs(&mut self, values: &[f64]) -> Result<(), Error> {
        for (input, value) in self.inputs.iter().zip(values) {
            if !value.is_finite() {
                return Err(Error::BadNumber {
                    quantity: format!("input {:?}", input.name),
                    found: *value,
                    expected: "a finite number",
                });
            }
        }
        let inputs = self.inputs.iter_mut().zip(&mut self.system.inputs);
        for ((input, (_, initial)), value) in inputs.zip(values) {
            (input.initial, *initial) = (*value, *value);
        }
        for (input, value) in self.drawn.inputs.iter_mut().zip(values) {
            *input = *value;
        }
        Ok(())
    }

    fn carrying(
        scene: &Scene,
        carrying: &Carrying,
        open: &SuperelementFiles,
    ) -> Result<Self, Error> {
        let mut library = Library::for_scene(scene, carrying, open);
        let mut builder = SystemBuilder::new(scene.dimension, scene.gravity_in_space());
        let mut names = Names {
            bodies: IndexMap::new(),
            joints: IndexMap::new(),
            drives: IndexMap::new(),
            springs: IndexMap::new(),
            actuators: IndexMap::new(),
        };
        let mut notes = Vec::new();
        for (name, body) in &scene.bodies {
            let mut flexible = library.body(scene, name, body)?;
            if scene.damping.is_some() {
                flexible = Arc::new(bodies::undamped(&flexible));
            }
            if let Some(left_out) = library.out_of_plane(scene, name) {
                notes.push(format!("body {name:?} {left_out}"));
            }
            if flexible.further_transform.nrows() > 0
                && flexible.compatibility != Compatibility::Strong
            {
                notes.push(format!(
                    "body {name:?} has {} further columns, which only strong compatibility uses",
                    flexible.further_transform.nrows()
                ));
            }
            let index = builder.body(name, flexible, &bodies::drawn(body));
            names.bodies.insert(name.clone(), index);
        }
        if let Some(normal) = &carrying.plane {
            builder.stay_in_plane(&Vector3::from(*normal));
        }
        let end = scene.integrator.map_or(0.0, |integrator| integrator.end);
        // Gears and racks come after the joints that they couple, wherever the scene has them.
        let (held, coupled): (Vec<_>, Vec<_>) = scene
            .joints
            .iter()
            .partition(|(_, joint)| joint.attachments().is_some());
        for (name, joint) in held.into_iter().chain(coupled) {
            couplings::add_joint(scene, &mut builder, &mut names, name, joint, &mut notes)?;
        }
        for (name, drive) in &scene.drives {
            couplings::add_drive(&mut builder, &mut names, name, drive, end)?;
        }
        for (name, spring) in &scene.springs {
            springs::add_spring(scene, &mut builder, &mut names, name, spring)?;
        }
        for (name, load) in &scene.loads {
            couplings::add_load(scene, &mut builder, &names, name, load)?;
        }
        for (name, actuator) in &scene.actuators {
            actuators::add_actuator(scene, &mut builder, &mut names, name, actuator)?;
        }
        let mut senses = SensesBuilder::of(scene);
        for (name, controller) in &scene.controllers {
            senses.add(scene, &mut builder, &names, &mut library, name, controller)?;
        }
        let held = scene.initial.hold.iter();
        let held = held.filter_map(|name| names.bodies.get(name).copied());
        let held: Vec<usize> = held.collect();
        if let Some(damping) = &scene.damping {
            assembled_modes::damp(scene, &mut builder, &held, damping)?;
        }
        let recorder = Recorder::for_scene(scene, &mut builder, &names, &mut library)?;
        let mut fields = Vec::new();
        for (index, request) in scene.fields.iter().enumerate() {
            let plan = FieldPlan::of(scene, &builder, &names, &mut library, index, request)?;
            fields.push(plan);
        }
        let error_bounds = match scene.analysis {
            Analysis::FrequencyResponse(_) => (scene.bodies.keys())
                .map(|name| library.error_bounds(scene, name))
                .collect::<Result<_, _>>()?,
            _ => Vec::new(),
        };
        let (system, drawn) = builder.finish();
        let inputs = system.inputs.iter();
        let inputs = inputs.map(|(name, initial)| Input::of(scene, name, *initial));
        Ok(Self {
            inputs: inputs.collect(),
            held,
            senses: senses.finish(),
            system,
            drawn,
            recorder,
            fields,
            error_bounds,
            files: library.into_files(),
            notes,
        })
    }
}
