//! Why a unit can't be made, or can't go on.

use crate::mode::Mode;

/// Errors: the finding, and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The scene or its motion.
    #[error(transparent)]
    Runtime(#[from] dcb_runtime::Error),
    /// There is no such variable.
    #[error("value reference {0}: there is no such variable in the model description")]
    UnknownReference(u32),
    /// The variable can't be set now, or at all.
    #[error("{name}: {why}")]
    NotSettable {
        /// Name of the variable.
        name: String,
        /// Why not, and what can be done.
        why: &'static str,
    },
    /// A value that no variable can have.
    #[error("{name}: is {value}, expected a finite number")]
    NotFinite {
        /// Name of the variable.
        name: String,
        /// The value.
        value: f64,
    },
    /// The call doesn't belong here.
    #[error("{call} isn't possible in mode {mode:?}; {remedy}")]
    WrongMode {
        /// What was called.
        call: &'static str,
        /// The mode.
        mode: Mode,
        /// What to call.
        remedy: &'static str,
    },
    /// A time that the unit can't begin at or go to.
    #[error("{quantity} is {found:?}, {expected}")]
    Time {
        /// Which time.
        quantity: &'static str,
        /// Its value.
        found: f64,
        /// What is possible.
        expected: String,
    },
    /// A saved state of another unit, or none.
    #[error("the saved state can't be used: {0}")]
    ForeignState(&'static str),
}
