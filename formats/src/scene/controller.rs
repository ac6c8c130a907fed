//! Controllers: formulas of outputs, whose values are efforts of actuators.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::Checker;
use super::output::Output;
use super::values::positive;
use crate::Error;
use crate::function::{FormulaText, OutputFormula};

/// A formula of outputs, time and constants.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Controller {
    /// For example `-20*angle - 3*rate + 5*sin(t)`; a component of an output is OUTPUT.NAME, as in `tip.x`.
    #[serde(deserialize_with = "formula")]
    #[schemars(with = "String")]
    pub formula: FormulaText,
    /// Interval of time at which it is computed; its value is held in between. Continuous where absent, which outputs
    /// `joint_coordinate` and `joint_rate` allow.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub period: Option<f64>,
}

fn formula<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<FormulaText, D::Error> {
    String::deserialize(deserializer).map(FormulaText::from)
}

impl Controller {
    /// The formula with the outputs of a scene.
    ///
    /// # Errors
    /// [`Error::Description`] where it can't be read.
    pub fn parsed<'a>(
        &self,
        outputs: impl Iterator<Item = &'a str>,
    ) -> Result<OutputFormula, Error> {
        OutputFormula::parse(&self.formula, outputs)
    }

    pub(super) fn check(&self, location: &str, checker: &Checker) -> Result<(), Error> {
        let outputs = checker.outputs();
        let parsed = self
            .parsed(outputs.keys().map(String::as_str))
            .map_err(|error| error.within(location))?;
        if let Some(period) = self.period {
            return positive(&format!("{location}.period"), period);
        }
        for variable in parsed.variables() {
            match outputs.get(&variable.output) {
                Some(Output::JointCoordinate(_) | Output::JointRate(_)) | None => {}
                Some(other) => {
                    return Err(Error::described(
                        format!("{location}.formula"),
                        format!(
                            "uses output {:?}, which is {}; without a period only joint_coordinate and joint_rate can be used; add for example \
                             \"period\": 1e-3",
                            variable.output,
                            other.kind()
                        ),
                    ));
                }
            }
        }
        Ok(())
    }
}
