//! How finely a run integrates: by a step, or by an accuracy that steps follow.

use serde::{Deserialize, Serialize};

/// How finely a run integrates.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fineness {
    /// Equal steps of this length, the scene's unit of time.
    Step(f64),
    /// Steps that make errors of this size, relative: radau's `tolerance`.
    Accuracy(f64),
}

impl Fineness {
    /// The step or the accuracy.
    pub fn value(self) -> f64 {
        match self {
            Self::Step(value) | Self::Accuracy(value) => value,
        }
    }

    /// `step` or `accuracy`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Step(_) => "step",
            Self::Accuracy(_) => "accuracy",
        }
    }

    /// The letter that stands for the scene's own: a step is h, an accuracy e.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Step(_) => "h",
            Self::Accuracy(_) => "e",
        }
    }

    /// Unit of the value; `time` is that of steps.
    pub fn unit(self, time: &str) -> &str {
        match self {
            Self::Step(_) => time,
            Self::Accuracy(_) => "1",
        }
    }

    /// For people: `step 1.2e-5 s`, `accuracy 1e-4`.
    pub fn told(self, time: &str) -> String {
        match self {
            Self::Step(step) => format!("step {step:.4e} {time}"),
            Self::Accuracy(accuracy) => format!("accuracy {accuracy:.1e}"),
        }
    }

    /// The same kind with another value.
    pub fn with(self, value: f64) -> Self {
        match self {
            Self::Step(_) => Self::Step(value),
            Self::Accuracy(_) => Self::Accuracy(value),
        }
    }

    /// The next finer run of a reference: half the step, a quarter of the error. Both make a run of second order err by a quarter.
    pub fn finer(self) -> Self {
        match self {
            Self::Step(step) => Self::Step(0.5 * step),
            Self::Accuracy(accuracy) => Self::Accuracy(0.25 * accuracy),
        }
    }

    /// Of which this is the next finer.
    pub fn coarser(self) -> Self {
        match self {
            Self::Step(step) => Self::Step(2.0 * step),
            Self::Accuracy(accuracy) => Self::Accuracy(4.0 * accuracy),
        }
    }

    /// As a multiple of the scene's own: `4 h`, `h/2`, `e/10`.
    pub fn multiple_of(self, own: Self) -> String {
        let (ratio, symbol) = (self.value() / own.value(), self.symbol());
        let whole = |ratio: f64| (ratio - ratio.round()).abs() < 1e-9 * ratio;
        match (ratio == 1.0, whole(ratio), whole(1.0 / ratio)) {
            (true, _, _) => symbol.to_owned(),
            (_, true, _) => format!("{ratio:.0} {symbol}"),
            (_, _, true) => format!("{symbol}/{:.0}", 1.0 / ratio),
            _ => format!("{ratio:.3} {symbol}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_and_accuracies_are_told_as_multiples() {
        for (ratio, text) in [(1.0, "h"), (16.0, "16 h"), (0.25, "h/4"), (1.5, "1.500 h")] {
            assert_eq!(Fineness::Step(ratio).multiple_of(Fineness::Step(1.0)), text);
        }
        let own = Fineness::Accuracy(1e-4);
        assert_eq!(Fineness::Accuracy(1e-5).multiple_of(own), "e/10");
        assert_eq!(own.finer(), Fineness::Accuracy(0.25e-4));
    }

    #[test]
    fn a_step_is_stored_as_before() {
        let stored = serde_json::to_string(&Fineness::Step(0.5)).ok();
        assert_eq!(stored.as_deref(), Some(r#"{"step":0.5}"#));
    }
}
