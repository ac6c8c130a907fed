//! Tables over frequency: amplitudes of load cases, densities of random inputs, and how these belong together.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::finite;
use super::values::not_negative;
use crate::Error;

/// How two random inputs belong together: by `coherence` and `delay`, or by their cross density.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Correlation {
    /// Two of the random inputs, a and b.
    pub inputs: [String; 2],
    /// Coherence γ² = |S_ab|² / (S_a S_b), 0 to 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coherence: Option<f64>,
    /// Time by which b comes after a.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub delay: Option<f64>,
    /// One-sided cross density S_ab of a and the complex conjugate of b, `[[frequency, real, imaginary], ...]`, joined by lines, zero beyond its ends.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density: Option<Vec<[f64; 3]>>,
}

impl Correlation {
    pub(super) fn check(&self, location: &str) -> Result<(), Error> {
        if self.inputs[0] == self.inputs[1] {
            return Err(Error::described(
                format!("{location}.inputs"),
                format!("has {:?} twice", self.inputs[0]),
            ));
        }
        match (self.coherence, self.delay, &self.density) {
            (Some(coherence), delay, None) => {
                if !(0.0..=1.0).contains(&coherence) {
                    return Err(Error::described(
                        format!("{location}.coherence"),
                        format!("is {coherence}, expected 0 to 1"),
                    ));
                }
                delay.map_or(Ok(()), |delay| finite(&format!("{location}.delay"), delay))
            }
            (None, None, Some(table)) => check_amplitudes(&format!("{location}.density"), table),
            _ => Err(Error::described(
                location,
                "needs either `coherence`, with or without `delay`, or `density`",
            )),
        }
    }
}

/// A table of complex amplitudes `[[frequency, real, imaginary], ...]`.
pub(super) fn check_amplitudes(location: &str, table: &[[f64; 3]]) -> Result<(), Error> {
    check_count(location, table.len(), "[[frequency, real, imaginary], ...]")?;
    for (index, row) in table.iter().enumerate() {
        for (column, entry) in row.iter().enumerate() {
            finite(&format!("{location}[{index}][{column}]"), *entry)?;
        }
    }
    check_frequencies(location, table.iter().map(|row| row[0]))
}

/// A table of densities `[[frequency, density], ...]`.
pub(super) fn check_density(location: &str, table: &[[f64; 2]]) -> Result<(), Error> {
    check_count(location, table.len(), "[[frequency, density], ...]")?;
    for (index, [frequency, density]) in table.iter().enumerate() {
        finite(&format!("{location}[{index}][0]"), *frequency)?;
        not_negative(&format!("{location}[{index}][1]"), *density)?;
    }
    check_frequencies(location, table.iter().map(|row| row[0]))
}

fn check_count(location: &str, count: usize, form: &str) -> Result<(), Error> {
    if count < 2 {
        return Err(Error::described(
            location,
            format!("has {count} points, expected at least 2: {form}"),
        ));
    }
    Ok(())
}

fn check_frequencies(location: &str, frequencies: impl Iterator<Item = f64>) -> Result<(), Error> {
    let mut last: Option<f64> = None;
    for (index, frequency) in frequencies.enumerate() {
        let at = || format!("{location}[{index}][0]");
        if frequency < 0.0 {
            return Err(Error::described(
                at(),
                format!("is {frequency}, expected a frequency that is not negative"),
            ));
        }
        if let Some(last) = last.filter(|last| *last >= frequency) {
            return Err(Error::described(
                at(),
                format!("is {frequency}, after {last}; expected ascending frequencies"),
            ));
        }
        last = Some(frequency);
    }
    Ok(())
}
