//! Dynamics of mechanisms made of co-rotated flexible bodies: superelements and rigid bodies in large motion.
//!
//! A [`Scene`] says what moves, how it is held and driven and what is recorded; it is read from a JSON file or filled in by a
//! program. [`Mechanism`] is a scene in motion: stepped, steered by inputs and asked for outputs by name. [`run`] is a whole run to
//! a results file, which is what the program `simulate` does. Superelements come from `.dcb.h5` files; the reducer is not
//! known here.
//!
//! ```
//! use std::path::Path;
//! use dcb_runtime::{Mechanism, Scene};
//!
//! // A pendulum that is let go at the horizontal.
//! let scene = Scene::parse(r#"{
//!     "dimension": 2, "units": {"length": "m", "mass": "kg", "time": "s"}, "gravity": [0, -9.81],
//!     "bodies": {"bob": {"rigid": {"mass": 1, "inertia": 1e-6, "points": {"pivot": [-0.5, 0]}}, "position": [0.5, 0]}},
//!     "joints": {"pivot": {"revolute": {"a": "ground", "b": "bob/pivot"}}},
//!     "outputs": {"angle": {"joint_coordinate": {"joint": "pivot"}}},
//!     "integrator": {"generalized_alpha": {"step": 1e-3, "end": 1}}
//! }"#, Path::new("pendulum.json"))?;
//! let mut mechanism = Mechanism::start(&scene)?;
//! for _ in 0..100 {
//!     mechanism.step(1e-3)?;
//! }
//! // It falls by g/l at first.
//! let angle = mechanism.output("angle")?[0];
//! assert!((angle + 0.5 * 9.81 / 0.5 * 0.01).abs() < 1e-3);
//! let pull = mechanism.output("reactions/pivot")?;
//! assert_eq!(pull.len(), 3);
//! # Ok::<(), dcb_runtime::Error>(())
//! ```
//!
//! [`dcb_formats::scene`] says what stands in a scene, [`model`] how a scene becomes a system of equations. [`FlexibleBody`] is one superelement
//! in dynamic coordinates. The examples `mechanism_in_rust` and `control_loop` are programs to start from.

pub mod body;
pub mod error;
pub mod export;
pub mod frequency;
pub mod linear;
pub mod mechanism;
pub mod model;
pub mod operating_point;
pub mod run;
pub mod whirl;

// No part of the door: for the other crates of this workspace and its tests.
#[doc(hidden)]
pub mod actuator;
#[doc(hidden)]
pub mod analysis;
#[doc(hidden)]
pub mod energy;
#[doc(hidden)]
pub mod force_law;
#[doc(hidden)]
pub mod frame;
#[doc(hidden)]
pub mod initial;
#[doc(hidden)]
pub mod integrator;
#[doc(hidden)]
pub mod joint;
#[doc(hidden)]
pub mod kinematics;
#[doc(hidden)]
pub mod measure;
#[doc(hidden)]
pub mod momentum;
#[doc(hidden)]
pub mod simulation;
#[doc(hidden)]
pub mod system;
#[doc(hidden)]
pub mod watch;

pub use body::{Attachment, Compatibility, FlexibleBody, GeneralizedBody, RigidBody, RigidPoint};
pub use dcb_formats::Scene;
pub use dcb_formats::linear_system::LinearSystem;
pub use dcb_formats::scene::InertiaChange;
pub use error::Error;
pub use frame::{
    BodyAcceleration, BodyState, FrameInertia, InertiaForces, InertiaTangent, InertiaTerms,
};
pub use linear::LinearRequest;
pub use mechanism::Mechanism;
pub use model::Model;
pub use operating_point::{OperatingPoint, linearize};
