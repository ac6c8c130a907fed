//! A scene as a unit of a co-simulation: variables with value references, communication steps, states that can be saved.
//!
//! A folder with `scene.json` and its superelements is all that a unit is made of. [`CoSimulation::load`] reads it, says which
//! [`Variable`]s there are and moves the mechanism from one communication point to the next. [`model_description`] writes the same variables as the
//! `modelDescription.xml` of FMI 3.0: both come from one list, so they cannot differ. Nothing here is C; `dcb-fmu` puts the functions of FMI on top.

mod choice;
mod documentation;
mod error;
mod mode;
mod model_description;
mod motion;
mod parameter;
mod saved_state;
mod si_unit;
mod stepping;
mod terminals;
mod token;
mod unit;
mod variable;
mod xml;

pub use documentation::documentation;
pub use error::Error;
pub use mode::Mode;
pub use model_description::{Named, model_description};
pub use parameter::Parameter;
pub use saved_state::SavedState;
pub use si_unit::SiUnit;
pub use terminals::terminals;
pub use token::MARK;
pub use unit::{CoSimulation, SCENE};
pub use variable::{Source, Variable};
