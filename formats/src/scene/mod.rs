//! Scenes: bodies, joints, drives, springs and loads, what is recorded, and how it is integrated.
//!
//! A [`Scene`] is plain data: [`Scene::read`] takes it from a JSON file, and a program can fill it in and call
//! [`Scene::check`]. `docs/scene.md` describes the file, [`scene_schema`] is its JSON schema. What superelements hold
//! (interfaces, nodes, rotation rows) is checked when they are loaded, not here.

mod actuator;
mod attachment;
mod body;
mod check;
mod controller;
mod damping;
mod drive;
mod frequency_response;
mod gear;
mod geometry;
mod integrator;
mod joint;
mod load;
mod observed;
mod output;
mod point_mass;
mod read;
mod recording;
mod samples;
mod settings;
mod spectrum;
mod spring;
mod values;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::component::Units;
use crate::mesh::Dimension;
use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use actuator::{ActuatedCoordinate, Actuator, EndStop, Friction, Saturation, Servo};
pub use attachment::Attachment;
pub use body::{
    Body, BodyKind, GeometricStiffening, InertiaChange, Placement, Point, PointFrame, RigidBody,
    SuperelementBody,
};
pub(crate) use check::name as check_name;
pub use controller::Controller;
pub use damping::{AssembledDamping, DampingOverride, ModalRatios, Rayleigh, RayleighPoints};
pub use drive::{Drive, DriveFunction};
pub use frequency_response::{
    BeyondBand, DriveForm, Frequencies, FrequencyRange, FrequencyResponse, OutputForm,
    ResponseDamping, Spacing,
};
pub use gear::{Gear, Rack};
pub use geometry::{Cylinder, Geometry, GeometryKind, Sphere};
pub use integrator::{AdaptiveStep, Formulation, Integrator, Method, Scheme};
pub use joint::{
    AxisJoint, DistanceJoint, ExertedDirections, FixedJoint, Joint, JointAxis, LineJoint,
    OrientationSource, PointJoint, SecondAxis, Side, UniversalJoint,
};
pub use load::{Load, LoadAxes, LoadFunction, PartLoadFunction};
pub use observed::{
    AngularMomentum, AtPlace, ChordDeflection, MassPoint, MeshNode, MomentPoint, OfActuator,
    OfBody, OfDrive, OfJoint, OfMass, OfSpring, OfSuperelement, Reaction, ReactionAxes,
    StressMeasure, StressOutput,
};
pub use output::Output;
pub(crate) use read::{UnitNames, dimension};
pub use recording::{FieldRequest, Record};
pub use settings::{
    Analysis, Compatibility, Initial, Linearization, ModesAnalysis, RedundantConstraints,
};
pub use spectrum::Correlation;
pub use spring::{Bushing, LineSpring, Spring, TorsionSpring};
pub use values::{AngularVelocity, Characteristic, Orientation, RotaryInertia, in_space};

use crate::Error;
use crate::function::{Function, check_constant};
pub use crate::named::Named;
use crate::named::unique;
use check::{Checker, each, each_of};

/// A scene: a mechanism, what acts on it, and what is to be computed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Where the schema is, for editors; not used.
    #[serde(rename = "$schema", default, skip_serializing_if = "Option::is_none")]
    pub schema: Option<String>,
    /// Folder at which relative paths start; not part of the file.
    #[serde(skip)]
    pub directory: PathBuf,
    /// Planar (2) or spatial (3).
    #[serde(with = "read::dimension")]
    #[schemars(schema_with = "read::dimension::schema")]
    pub dimension: Dimension,
    /// Units of every number; force is mass · length / time². Superelements must have the same.
    #[serde(with = "read::UnitNames")]
    #[schemars(with = "read::UnitNames")]
    pub units: Units,
    /// Acceleration of free fall, world axes: 2 (planar) or 3 components; none where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity: Option<Vec<f64>>,
    /// Points of the world.
    #[serde(default)]
    pub ground: Ground,
    /// Bodies by name, in the order of the results.
    #[serde(deserialize_with = "unique")]
    pub bodies: Named<Body>,
    /// Numbers that formulas may name.
    #[serde(
        default,
        deserialize_with = "unique",
        skip_serializing_if = "Named::is_empty"
    )]
    pub constants: Named<f64>,
    /// Joints by name.
    #[serde(default, deserialize_with = "unique")]
    pub joints: Named<Joint>,
    /// Drives by name.
    #[serde(default, deserialize_with = "unique")]
    pub drives: Named<Drive>,
    /// Springs and dampers by name.
    #[serde(default, deserialize_with = "unique")]
    pub springs: Named<Spring>,
    /// Loads by name.
    #[serde(default, deserialize_with = "unique")]
    pub loads: Named<Load>,
    /// Actuators by name.
    #[serde(
        default,
        deserialize_with = "unique",
        skip_serializing_if = "Named::is_empty"
    )]
    pub actuators: Named<Actuator>,
    /// Controllers by name.
    #[serde(
        default,
        deserialize_with = "unique",
        skip_serializing_if = "Named::is_empty"
    )]
    pub controllers: Named<Controller>,
    /// Recorded quantities by name.
    #[serde(default, deserialize_with = "unique")]
    pub outputs: Named<Output>,
    /// How often results are recorded; after every step where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub record: Option<Record>,
    /// Displacement fields to write.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fields: Vec<FieldRequest>,
    /// How interfaces follow the coordinates of superelements.
    #[serde(default)]
    pub compatibility: Compatibility,
    /// Whether weak compatibility may be used where it is unstable.
    #[serde(default)]
    pub allow_unstable_weak: bool,
    /// Treatment of joints that constrain the same motion twice.
    #[serde(default)]
    pub redundant_constraints: RedundantConstraints,
    /// How the initial placement is made to fit the joints.
    #[serde(default)]
    pub initial: Initial,
    /// Damping of the assembled modes, in place of that of the superelements.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping: Option<AssembledDamping>,
    /// The analysis.
    #[serde(default)]
    pub analysis: Analysis,
    /// How motion is integrated; a transient or kinematic analysis needs it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub integrator: Option<Integrator>,
}

/// The ground: places that don't move.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ground {
    /// Places in world coordinates.
    #[serde(default, deserialize_with = "unique")]
    pub points: Named<Point>,
    /// What the surroundings look like in pictures, world axes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub geometry: Vec<Geometry>,
}

/// The name of a scene that is read from standard input; its paths start at the folder of the process.
pub const STANDARD_INPUT: &str = "-";

impl Scene {
    /// The bodies that are superelements, by their names.
    pub fn superelements(&self) -> impl Iterator<Item = (&str, &SuperelementBody)> {
        let bodies = self.bodies.iter();
        bodies.filter_map(|(name, body)| match &body.kind {
            BodyKind::Superelement(of) => Some((name.as_str(), of)),
            BodyKind::Rigid(_) => None,
        })
    }

    /// Whether forces of joints are among the outputs.
    pub fn looks_at_reactions(&self) -> bool {
        let mut outputs = self.outputs.values();
        outputs.any(|output| matches!(output, Output::Reaction(_)))
    }

    /// An empty scene in SI units without gravity.
    pub fn new(dimension: Dimension) -> Self {
        Self {
            schema: None,
            directory: PathBuf::new(),
            dimension,
            units: Units {
                length: "m".into(),
                mass: "kg".into(),
                time: "s".into(),
            },
            gravity: None,
            ground: Ground::default(),
            bodies: Named::new(),
            constants: Named::new(),
            joints: Named::new(),
            drives: Named::new(),
            springs: Named::new(),
            loads: Named::new(),
            actuators: Named::new(),
            controllers: Named::new(),
            outputs: Named::new(),
            record: None,
            fields: Vec::new(),
            compatibility: Compatibility::default(),
            allow_unstable_weak: false,
            redundant_constraints: RedundantConstraints::default(),
            initial: Initial::default(),
            damping: None,
            analysis: Analysis::default(),
            integrator: None,
        }
    }

    /// Reads and checks a scene file of at most 64 MiB.
    ///
    /// # Errors
    /// [`Error::File`] if it can't be read, with line and column where the JSON or a key is wrong, with a path of keys where
    /// a value doesn't fit the others.
    pub fn read(path: &Path) -> Result<Self, Error> {
        Self::parse(&read::text(path)?, path)
    }

    /// Reads and checks a scene from JSON; `path` names it in errors, and relative paths start at its folder.
    ///
    /// # Errors
    /// As [`Scene::read`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, Error> {
        let mut scene = read::scene(text, path)?;
        scene.directory = path.parent().map(Path::to_path_buf).unwrap_or_default();
        scene.name_constants();
        scene.check().map_err(|error| error.in_file(path))?;
        Ok(scene)
    }

    /// Tells all formulas what the scene's constants are; a scene that is read does so by itself.
    pub fn name_constants(&mut self) {
        let constants = self.constants.iter();
        let constants: Arc<[_]> = constants
            .map(|(name, value)| (name.clone(), *value))
            .collect();
        let drives = self.drives.values_mut().map(Drive::function_mut);
        let loads = self.loads.values_mut().flat_map(Load::functions_mut);
        let actuators = self.actuators.values_mut();
        let actuators = actuators.filter_map(Actuator::function_mut);
        for controller in self.controllers.values_mut() {
            controller.formula.constants = Arc::clone(&constants);
        }
        for function in drives.chain(loads).chain(actuators) {
            if let Function::Formula(formula) = function {
                formula.constants = Arc::clone(&constants);
            }
        }
    }

    /// Checks everything that can be known before superelements are loaded.
    ///
    /// # Errors
    /// [`Error::Description`] with the path of keys, what was found and what would be right.
    pub fn check(&self) -> Result<(), Error> {
        let checker = Checker::new(self);
        for (key, unit) in [
            ("length", &self.units.length),
            ("mass", &self.units.mass),
            ("time", &self.units.time),
        ] {
            check::name(&format!("units.{key}"), unit)?;
        }
        if let Some(gravity) = &self.gravity {
            checker.vector("gravity", gravity)?;
        }
        each("ground.points", &self.ground.points, |at, point| {
            point.check(at, &checker)
        })?;
        each_of("ground.geometry", &self.ground.geometry, |at, solid| {
            solid.check(at, &checker)
        })?;
        if self.bodies.contains_key("ground") {
            return Err(Error::described(
                "bodies.ground",
                "is the name of what doesn't move; call the body otherwise",
            ));
        }
        each("bodies", &self.bodies, |at, body| body.check(at, &checker))?;
        for (name, value) in &self.constants {
            check_constant(name, *value).map_err(|error| error.within("constants"))?;
        }
        each("joints", &self.joints, |at, joint| {
            joint.check(at, &checker)
        })?;
        if let Some(integrator) = &self.integrator {
            integrator.check()?;
        }
        let end = self.integrator.map(|integrator| integrator.end);
        each("drives", &self.drives, |at, drive| {
            drive.check(at, &checker, end.filter(|end| *end > 0.0))
        })?;
        self.check_driven_once()?;
        each("springs", &self.springs, |at, spring| {
            spring.check(at, &checker)
        })?;
        each("loads", &self.loads, |at, load| load.check(at, &checker))?;
        each("actuators", &self.actuators, |at, actuator| {
            actuator.check(at, &checker)
        })?;
        each("controllers", &self.controllers, |at, controller| {
            controller.check(at, &checker)
        })?;
        self.check_samples()?;
        each("outputs", &self.outputs, |at, output| {
            output.check(at, &checker)
        })?;
        if let Some(record) = &self.record {
            record.check(end)?;
        }
        for (index, field) in self.fields.iter().enumerate() {
            field.check(&format!("fields[{index}]"), &checker, end)?;
        }
        for (index, body) in self.initial.hold.iter().enumerate() {
            checker.body(&format!("initial.hold[{index}]"), body)?;
        }
        if let Some(gap) = self.initial.allow_gap {
            values::positive("initial.allow_gap", gap)?;
        }
        self.check_damping()?;
        self.check_analysis()
    }

    /// That a place is there, as far as that can be known before superelements are loaded.
    ///
    /// # Errors
    /// [`Error::Description`] at `location`, with what there is.
    pub fn check_place(&self, location: &str, reference: &str) -> Result<(), Error> {
        Checker::new(self).attachment(location, reference).map(drop)
    }

    /// Gravity in three dimensions, world axes; of a scene that has been checked.
    pub fn gravity_in_space(&self) -> Vector3<f64> {
        in_space(self.gravity.as_deref().unwrap_or_default())
    }

    /// Where a path of this scene leads to: relative ones start at the folder of the scene.
    pub fn resolve(&self, path: &Path) -> PathBuf {
        self.directory.join(path)
    }

    /// Two drives can't move the same coordinate.
    fn check_driven_once(&self) -> Result<(), Error> {
        let mut driven: Vec<(&str, bool, &str)> = Vec::new();
        for (name, drive) in &self.drives {
            let joint = drive.motion().joint.as_str();
            let turns = match drive {
                Drive::Angle(_) => true,
                Drive::Position(_) => false,
                Drive::Speed(_) => self.joints.get(joint).is_some_and(Joint::has_angle),
            };
            let other = driven
                .iter()
                .find(|other| (other.0, other.1) == (joint, turns));
            if let Some((_, _, other)) = other {
                return Err(Error::described(
                    format!("drives.{name}.{}.joint", drive.kind()),
                    format!("joint {joint:?} is driven by {other:?} already"),
                ));
            }
            driven.push((joint, turns, name));
        }
        Ok(())
    }

    /// Assembled modes need interfaces that are coordinates, and take the place of the parts' own damping.
    fn check_damping(&self) -> Result<(), Error> {
        let Some(damping) = &self.damping else {
            return Ok(());
        };
        damping.check("damping")?;
        if self.compatibility != Compatibility::Strong {
            return Err(Error::described(
                format!("damping.{}", damping.key()),
                format!(
                    "needs the modes of the mechanism in displacements, which {} compatibility hasn't; use \"compatibility\": \"strong\"",
                    self.compatibility.name()
                ),
            ));
        }
        let mut own = self.superelements().filter(|(_, of)| of.damping.is_some());
        match own.next() {
            Some((name, _)) => Err(Error::described(
                format!("bodies.{name}.damping"),
                format!(
                    "is given beside damping.{}, which takes its place; leave one of them out",
                    damping.key()
                ),
            )),
            None => Ok(()),
        }
    }

    fn check_analysis(&self) -> Result<(), Error> {
        match (&self.analysis, self.integrator) {
            (Analysis::Transient | Analysis::Kinematic, None) => Err(Error::described(
                "integrator",
                "is missing; add for example \"integrator\": {\"generalized_alpha\": {\"step\": 1e-4, \"end\": 1}}",
            )),
            (Analysis::Modes(ModesAnalysis { count: 0, .. }), _) => Err(Error::described(
                "analysis.modes.count",
                "is 0, expected at least 1",
            )),
            (Analysis::FrequencyResponse(asked), _) => {
                asked.check("analysis.frequency_response")?;
                match self.compatibility {
                    Compatibility::Strong => Ok(()),
                    other => Err(Error::described(
                        "compatibility",
                        format!(
                            "is {}; a frequency response needs strong compatibility",
                            other.name()
                        ),
                    )),
                }
            }
            _ => Ok(()),
        }
    }
}

/// JSON schema of the scene file.
pub fn scene_schema() -> serde_json::Value {
    let mut schema = schemars::schema_for!(Scene);
    schema.insert("title".into(), "Scene".into());
    schema.to_value()
}
