//! The life of a unit.

/// Where a unit is in its life, by the names of FMI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Made or reset: start values may be set.
    Instantiated,
    /// Start values may be set, and what follows from them can be asked for.
    Initialization,
    /// Steps may be made, inputs set.
    Step,
    /// Only values may be asked for.
    Terminated,
}
