//! Efforts that are formulas of outputs.

use std::ops::Range;

use dcb_formats::function::OutputFormula;

/// A formula of outputs, and when it is computed.
#[derive(Clone, Debug, PartialEq)]
pub struct Controller {
    /// Name in the scene.
    pub name: String,
    /// The formula.
    pub formula: OutputFormula,
    /// Where its arguments come from.
    pub timing: Timing,
}

/// When a controller is computed.
#[derive(Clone, Debug, PartialEq)]
pub enum Timing {
    /// Always: of coordinates and their rates.
    Continuous {
        /// One for each argument of the formula.
        senses: Vec<Sense>,
        /// The first of its derivatives among those of all controllers.
        first: usize,
    },
    /// At all multiples of a period, and held in between: of any outputs.
    Sampled {
        /// The period.
        period: f64,
        /// Its arguments among those of all controllers.
        arguments: Range<usize>,
        /// Where the effort is remembered, and after it the number of samples.
        memory: usize,
    },
}

/// A sensed coordinate, by the index of its sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sense {
    /// Its value.
    Value(usize),
    /// Its rate.
    Rate(usize),
}
