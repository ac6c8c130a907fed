//! Dynamics of co-rotated flexible bodies: superelements in large rigid motion.
//!
//! [`FlexibleBody`] is one superelement in dynamic coordinates, read from its `.dcb.h5` file; [`frame`] holds the inertia of its
//! floating frame: the configuration-dependent mass matrix and the velocity-dependent forces. The reducer is not known
//! here: the file is the contract.
//!
//! ```no_run
//! use dcb_runtime::{FlexibleBody, InertiaTerms};
//! use nalgebra::Vector3;
//!
//! let body = FlexibleBody::load("rod.dcb.h5".as_ref())?;
//! let mut terms = InertiaTerms::for_coordinates(body.coordinate_count());
//! let (y, rates) = (vec![0.0; body.coordinate_count()], vec![0.0; body.coordinate_count()]);
//! body.inertia.evaluate(&y, &Vector3::new(0.0, 0.0, -75.0), &rates, &mut terms);
//! println!("spin energy {} ", terms.kinetic_energy(0.0, &Vector3::zeros(), &Vector3::new(0.0, 0.0, -75.0), &rates));
//! # Ok::<(), dcb_runtime::Error>(())
//! ```

pub mod body;
pub mod cli;
mod cli_scene;
pub mod compatibility_window;
pub mod csv;
pub mod driven;
pub mod eigenmodes;
pub mod energy;
pub mod equilibrium;
pub mod error;
pub mod field;
pub mod frame;
pub mod function;
pub mod history;
pub mod initial;
pub mod integrator;
pub mod joint;
mod kernel;
pub mod law;
pub mod measure;
pub mod mechanism;
pub mod model;
pub mod motion;
pub mod picture;
pub mod rotation;
pub mod run;
pub mod scene;
pub mod simulation;
pub mod system;
pub mod validity;
pub mod vtu;

pub use body::{Attachment, Compatibility, FlexibleBody, GeneralizedBody, RigidBody, RigidPoint};
pub use error::Error;
pub use frame::{
    BodyAcceleration, BodyState, FrameInertia, InertiaChange, InertiaForces, InertiaTangent,
    InertiaTerms,
};
pub use function::{Function, TimeFunction};
pub use mechanism::Mechanism;
pub use scene::Scene;
