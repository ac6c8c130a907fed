//! A hard case: what a plain method makes of it, what this project does, and the bound that it is held to. `docs/hard-cases.md` is
//! the table of all of them.

use serde_json::{Value, json};

/// What a case came to.
#[derive(Clone, Debug)]
pub struct HardCase {
    /// `reduction` or `dynamics`.
    pub group: &'static str,
    /// Its name, also that of its test.
    pub name: &'static str,
    /// What the plain method does, in a few words.
    pub naive_method: &'static str,
    /// What came of it, with its number.
    pub naive: String,
    /// What was asked of this project and came of it, in a few words.
    pub ours: String,
    /// The error of ours, and what it may be; `None` where a refusal by name is the right answer.
    pub error: Option<Bounded>,
}

/// A number and what it may be.
#[derive(Clone, Copy, Debug)]
pub struct Bounded {
    /// What was found.
    pub found: f64,
    /// What it may be.
    pub bound: f64,
}

impl HardCase {
    /// As one line of `docs/data/hard_cases.jsonl`.
    pub fn line(&self) -> Value {
        json!({
            "group": self.group, "name": self.name, "naive_method": self.naive_method, "naive": self.naive, "ours": self.ours,
            "error": self.error.map(|error| error.found), "bound": self.error.map(|error| error.bound),
        })
    }

    /// Asserts that ours is within its bound.
    pub fn assert_held(&self) {
        if let Some(Bounded { found, bound }) = self.error {
            assert!(found <= bound, "{}: {found:e} above {bound:e}", self.name);
        }
    }
}
