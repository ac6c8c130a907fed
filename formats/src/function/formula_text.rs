//! A formula as a scene writes it, and the constants that it may name.

use std::sync::Arc;

use serde::{Serialize, Serializer};

/// A formula's text, with the scene's constants.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FormulaText {
    /// The formula.
    pub text: String,
    /// Values of the names beside `t`, `pi` and `e`.
    pub constants: Arc<[(String, f64)]>,
}

impl From<String> for FormulaText {
    fn from(text: String) -> Self {
        Self {
            text,
            constants: Arc::default(),
        }
    }
}

impl From<&str> for FormulaText {
    fn from(text: &str) -> Self {
        text.to_owned().into()
    }
}

impl Serialize for FormulaText {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.text)
    }
}
