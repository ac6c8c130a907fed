//! A formula of a scene's outputs: what a controller computes.
//!
//! Beside the time, constants and functions it names outputs: `angle` for one of a single number, `tip.z` for a component of another.
//! Names that aren't made of letters, digits and _ stand in quotes: `'left wheel'.x`.

use std::cell::RefCell;

use num_dual::Dual2_64;

use super::formula::{Constants, Formula};
use super::formula_text::FormulaText;
use crate::Error;
use crate::description::{listed, suggestion};

/// A number that a formula takes from outside.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputComponent {
    /// Name of the output.
    pub output: String,
    /// Name of the component; `None` of an output that is one number.
    pub component: Option<String>,
}

/// A checked formula of outputs.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputFormula {
    formula: Formula,
    variables: Vec<OutputComponent>,
}

/// Outputs that a formula may name, and those that it did name.
pub(super) struct Outside {
    outputs: Vec<String>,
    named: RefCell<Vec<OutputComponent>>,
}

impl OutputFormula {
    /// Parses a formula that may name these outputs.
    ///
    /// # Errors
    /// [`Error::Description`] with the formula, the position and what would be right there.
    pub fn parse<'a>(
        text: &FormulaText,
        outputs: impl Iterator<Item = &'a str>,
    ) -> Result<Self, Error> {
        let outside = Outside {
            outputs: outputs.map(str::to_owned).collect(),
            named: RefCell::default(),
        };
        let formula = Formula::parse_with(&text.text, &text.constants, &outside)?;
        Ok(Self {
            formula,
            variables: outside.named.into_inner(),
        })
    }

    /// The numbers that it depends on, in the order of the values of [`OutputFormula::evaluate`].
    pub fn variables(&self) -> &[OutputComponent] {
        &self.variables
    }

    /// The value. Does not allocate.
    pub fn evaluate(&self, time: f64, values: &[f64]) -> f64 {
        let constant = |index: usize| Dual2_64::from_re(values[index]);
        self.formula.evaluate_with(time, constant).re
    }

    /// Derivative by one of the values. Does not allocate.
    pub fn slope(&self, time: f64, values: &[f64], of: usize) -> f64 {
        let seeded = |index: usize| match Dual2_64::from_re(values[index]) {
            value if index == of => value.derivative(),
            value => value,
        };
        self.formula.evaluate_with(time, seeded).v1
    }
}

impl Outside {
    /// The index of a number by its name in a formula.
    pub(super) fn find(&self, name: &str) -> Option<usize> {
        let found = self.component(name)?;
        let mut named = self.named.borrow_mut();
        let known = named.iter().position(|one| *one == found);
        Some(known.unwrap_or_else(|| {
            named.push(found);
            named.len() - 1
        }))
    }

    fn component(&self, name: &str) -> Option<OutputComponent> {
        let (output, component) = match name.strip_prefix('\'') {
            Some(quoted) => quoted.rsplit_once('\'')?,
            None if self.has(name) => (name, ""),
            None => {
                let dot = name.find('.').unwrap_or(name.len());
                name.split_at(dot)
            }
        };
        self.has(output).then(|| OutputComponent {
            output: output.to_owned(),
            component: component.strip_prefix('.').map(str::to_owned),
        })
    }

    fn has(&self, name: &str) -> bool {
        self.outputs.iter().any(|output| output == name)
    }

    /// What to say of a name that is nothing.
    pub(super) fn unknown(&self, name: &str, constants: &Constants) -> String {
        let outputs = self.outputs.iter().map(String::as_str);
        let known = outputs.chain(constants.iter().map(|(name, _)| &name[..]));
        let hint = suggestion(name, known.clone());
        format!(
            "`{name}` is not known{hint}; there are t, outputs and constants of the scene ({}); a component is OUTPUT.NAME, as in tip.x",
            listed(known)
        )
    }
}
