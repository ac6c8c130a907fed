//! Values at the start.

/// What an importer may set before the start.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Choice {
    /// Values of the parameters.
    pub parameters: Vec<f64>,
    /// Inputs at the start.
    pub inputs: Vec<f64>,
    /// Time at which the scene ends, or later if the importer says so.
    pub end: f64,
}
