//! Checks and failures.

use std::fmt::Write as _;

use crate::scientific::scientific;

/// Stored and recomputed matrices may differ by this, relative to their scale.
pub const AGREEMENT: f64 = 1e-8;

/// Modes found twice agree only as closely as their residuals allow, a pair of close ones less.
pub const SHAPE_AGREEMENT: f64 = 1e-6;

/// Checks, line by line.
pub struct Findings {
    /// A line for each check.
    pub text: String,
    /// Those that failed.
    pub broken: Vec<String>,
}

impl Findings {
    /// A number that must not exceed its limit.
    pub fn check(&mut self, what: &str, value: f64, limit: f64) {
        let holds = value <= limit;
        let mark = if holds { "ok  " } else { "FAIL" };
        let _ = writeln!(
            self.text,
            "  {mark} {what:<58} {}  (limit {limit:.0e})",
            scientific(value, 1)
        );
        if !holds {
            self.broken
                .push(format!("{what}: {value:.1e}, above its limit {limit:.0e}"));
        }
    }

    /// A fact, with what was found.
    pub fn require(&mut self, what: &str, holds: bool, found: &str) {
        let mark = if holds { "ok  " } else { "FAIL" };
        let _ = writeln!(self.text, "  {mark} {what:<58} {found}");
        if !holds {
            self.broken.push(format!("{what}: {found}"));
        }
    }

    /// Something to know that can't fail.
    pub fn note(&mut self, line: &str) {
        let _ = writeln!(self.text, "       {line}");
    }
}
