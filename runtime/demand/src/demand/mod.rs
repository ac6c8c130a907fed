//! Demand of a scene on a component: which of its interfaces are loaded and how, which of its motions anybody looks at, how fast
//! they are, and whether it turns or falls.
//!
//! A [`Demand`] is read off a scene without integrating it, and without the part's superelement: names, places and directions of its
//! interfaces are enough. It says what a reduction of the part must be good for, and so what it may leave out. Where the scene
//! doesn't decide a question, the demand is the larger one, and says why.
//!
//! ```
//! use std::path::Path;
//! use dcb_demand::demand::{Demand, PartInterface, Parts};
//! use dcb_formats::Scene;
//! use nalgebra::{Matrix3, Vector3};
//!
//! let scene = Scene::parse(r#"{
//!     "dimension": 3, "units": {"length": "m", "mass": "kg", "time": "s"},
//!     "bodies": {"arm": {"superelement": "arm.dcb.h5"}},
//!     "joints": {"hinge": {"revolute": {"a": "ground", "b": "arm/root", "axis": [0, 0, 1]}}},
//!     "outputs": {"tip": {"position": {"at": "arm/tip"}}},
//!     "integrator": {"generalized_alpha": {"step": 1e-3, "end": 1}}
//! }"#, Path::new("arm.json"))?;
//! let interface = |name: &str, x: f64| PartInterface {
//!     name: name.into(),
//!     position: Vector3::new(x, 0.0, 0.0),
//!     orientation: Matrix3::identity(),
//!     directions: [true; 6],
//! };
//! let arm = vec![interface("root", 0.0), interface("tip", 1.0), interface("spare", 0.5)];
//! let demand = Demand::of(&scene, "arm", &Parts::from_iter([("arm".to_owned(), arm)]))?;
//! // A hinge about z transmits every force, and moments about x and y. Nothing is at "spare".
//! assert_eq!(demand.interfaces[0].wrenches.len(), 5);
//! assert_eq!(demand.interfaces[1].observed_by, ["outputs.tip"]);
//! assert_eq!(demand.interfaces.len(), 2);
//! println!("{demand}");
//! # Ok::<(), dcb_demand::Error>(())
//! ```

mod band;
mod course;
mod excitation;
mod explanation;
mod interface;
mod nodes;
mod part;
mod plane;
mod spin;
mod transmission;
mod union;
mod wrench_space;

use serde::Serialize;

pub use band::Band;
pub use interface::InterfaceDemand;
pub use nodes::NodeDemand;
pub use part::{PartInterface, Parts};
pub use plane::{ALIGNED, PlaneOfMotion, PlanesOfMotion, axis_along};
pub use spin::{DEFLECTION_OF_INTEREST, Spin};

use crate::Error;
use dcb_formats::scene::{Analysis, InertiaChange, Load, Output, Scene};
use interface::{Gathered, Gathering, superelement};

/// Demand of a scene on one of its superelements.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Demand {
    /// Name of the body.
    pub body: String,
    /// The scene's unit of time.
    pub time: String,
    /// Involvement of the body.
    pub involvement: Involvement,
    /// Deflection that is followed.
    pub deflection: Deflection,
    /// Interfaces that the scene uses, in the order of the part; the others are not used.
    pub interfaces: Vec<InterfaceDemand>,
    /// Nodes whose displacement is wanted.
    pub nodes: NodeDemand,
    /// Outputs that show the coordinates of the deflection themselves: paths of keys.
    pub coordinates_shown_by: Vec<String>,
    /// Outputs that show the motion of the body as a whole, its frame or its mass: paths of keys.
    pub whole_shown_by: Vec<String>,
    /// Loads on the inside of the part that act, by their names in its file.
    pub part_loads: Vec<String>,
    /// Whether gravity acts.
    pub gravity: bool,
    /// How far the inertia follows the deflection.
    pub inertia_change: InertiaChange,
    /// How fast the body turns.
    pub spin: Spin,
    /// How fast its deflections are.
    pub band: Band,
    /// Planes that the body's motion stays in if every part is symmetric to its own, component coordinates; and why others are none.
    pub planes: PlanesOfMotion,
}

/// Involvement of a body in a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Involvement {
    /// It moves, or something looks at it.
    Involved,
    /// Each interface in use is fixed to the ground, and nothing else acts on it or looks at it: only reactions and energies show it.
    Locked,
    /// No joint, spring, load or output refers to it.
    Unused,
}

/// Deflection that an analysis follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Deflection {
    /// Nothing: flexible bodies are taken as rigid.
    Rigid,
    /// Equilibria.
    Static,
    /// Motion.
    Dynamic,
}

impl Demand {
    /// Demand of a scene on its body `body`. `parts` has at least that body's interfaces; where a direction depends on another
    /// superelement that isn't in it, the demand is for every direction.
    ///
    /// # Errors
    /// Those of [`Scene::check`]; [`Error::Formats`] for a body that isn't there, is rigid or not in `parts`, and for an interface that
    /// it doesn't have.
    pub fn of(scene: &Scene, body: &str, parts: &Parts) -> Result<Self, Error> {
        scene.check()?;
        let described = superelement(scene, body)?;
        let own = parts.get(body).ok_or_else(|| {
            Error::described(format!("bodies.{body}"), "has no interfaces that are known")
        })?;
        let Gathered {
            interfaces,
            all_grounded,
        } = Gathering::of(scene, parts, body, own)?;
        let nodes = NodeDemand::of(scene, body);
        let coordinates_shown_by = shown_by(scene, |output| match output {
            Output::Modal(of) => of.body == body,
            Output::Stress(of) => of.body == body,
            _ => false,
        });
        let whole_shown_by = shown_by(scene, |output| output.shows_whole(body));
        let part_loads = part_loads(scene, body);
        let is_alone = nodes == NodeDemand::None
            && coordinates_shown_by.is_empty()
            && whole_shown_by.is_empty()
            && part_loads.is_empty();
        let involvement = match (is_alone, interfaces.is_empty(), all_grounded) {
            (true, true, _) => Involvement::Unused,
            (true, false, true) => Involvement::Locked,
            _ => Involvement::Involved,
        };
        let placement = scene.bodies[body].placement();
        let PlanesOfMotion { planes, refused } = PlanesOfMotion::of(scene, parts);
        Ok(Self {
            body: body.to_owned(),
            time: scene.units.time.clone(),
            involvement,
            deflection: match &scene.analysis {
                Analysis::Kinematic => Deflection::Rigid,
                Analysis::Static | Analysis::InertiaRelief => Deflection::Static,
                Analysis::Transient | Analysis::Modes(_) | Analysis::FrequencyResponse(_) => {
                    Deflection::Dynamic
                }
            },
            interfaces,
            nodes,
            coordinates_shown_by,
            whole_shown_by,
            part_loads,
            gravity: scene.gravity_in_space().norm() > 0.0,
            inertia_change: described.inertia_change,
            spin: Spin::of(scene, body)?,
            band: Band::of(scene)?,
            planes: PlanesOfMotion {
                planes: planes
                    .iter()
                    .map(|plane| plane.seen_from(&placement))
                    .collect(),
                refused,
            },
        })
    }
}

fn shown_by(scene: &Scene, shows: impl Fn(&Output) -> bool) -> Vec<String> {
    let outputs = scene.outputs.iter();
    let showing = outputs.filter(|(_, output)| shows(output));
    showing.map(|(name, _)| format!("outputs.{name}")).collect()
}

fn part_loads(scene: &Scene, body: &str) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for load in scene.loads.values() {
        if let Load::PartLoad(part) = load
            && part.body == body
            && !course::is_zero(&part.factor)
            && !names.contains(&part.load)
        {
            names.push(part.load.clone());
        }
    }
    names
}
