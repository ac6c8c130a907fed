//! What a frequency analysis of a scene is asked for.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::spectrum::{Correlation, check_amplitudes, check_density};
use super::values::{not_negative, positive};
use super::{Linearization, ModalRatios};
use crate::Error;

/// Frequencies at most.
const MOST: usize = 1_000_000;

/// Steady oscillations of outputs under oscillating inputs, about a placement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FrequencyResponse {
    /// Placement about which the equations are linearised.
    #[serde(default)]
    pub at: Linearization,
    /// Loads, components of loads as NAME/INDEX, and drives that oscillate, each by itself with unit amplitude; all of the scene where empty.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inputs: Vec<String>,
    /// Outputs or other recorded channels, for example reactions/JOINT; those of the scene where empty.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub outputs: Vec<String>,
    /// Frequencies, cycles per time.
    pub frequencies: Frequencies,
    /// Damping beside that of the files and springs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping: Option<ResponseDamping>,
    /// Whether outputs are taken as they are, or as their rates.
    #[serde(default)]
    pub output_as: OutputForm,
    /// Which motion of a drive has unit amplitude.
    #[serde(default)]
    pub drive_as: DriveForm,
    /// Random inputs: for each a table of its one-sided power spectral density, `[[frequency, density], ...]`, zero beyond its ends.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub random: BTreeMap<String, Vec<[f64; 2]>>,
    /// Random inputs that belong together; all others are independent of each other.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub correlated: Vec<Correlation>,
    /// Load cases: for each its complex amplitudes by input, `[[frequency, real, imaginary], ...]`, joined by lines, zero beyond their ends. The outputs are shown
    /// by each case too.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub cases: BTreeMap<String, BTreeMap<String, Vec<[f64; 3]>>>,
    /// Springs, bushings and joints through which the outputs are reached: each output is split into what comes through each of them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub paths: Vec<String>,
    /// What happens where a superelement's file isn't made for the highest frequency.
    #[serde(default)]
    pub beyond_band: BeyondBand,
}

/// Frequencies of an analysis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected a list of frequencies, or {\"from\": 1, \"to\": 500, \"count\": 200}"
)]
pub enum Frequencies {
    /// These, ascending.
    List(Vec<f64>),
    /// A range.
    Range(FrequencyRange),
}

/// A range of frequencies.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FrequencyRange {
    /// The lowest.
    pub from: f64,
    /// The highest.
    pub to: f64,
    /// How many, before resonances get more.
    pub count: u32,
    /// How they are spread.
    #[serde(default)]
    pub spacing: Spacing,
}

/// How frequencies are spread over a range.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Spacing {
    /// Equal differences, and more at each resonance: 21 points over ten half-power widths.
    #[default]
    Resonances,
    /// Equal differences.
    Linear,
    /// Equal quotients.
    Logarithmic,
}

/// Damping of a frequency analysis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ResponseDamping {
    /// Loss factor η of all stiffness, which becomes (1 + iη) K; beside the other damping.
    Structural(f64),
    /// Ratio to critical of the modes of the mechanism, one for all or one for each by rising frequency, the last for all further ones; in place of the other
    /// damping.
    AssembledModal(ModalRatios),
}

/// What is made of an output y.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OutputForm {
    /// y: receptance, where it is a displacement by a force.
    #[default]
    Itself,
    /// iω y: mobility.
    Rate,
    /// −ω² y: accelerance.
    SecondRate,
}

/// What has unit amplitude at a drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DriveForm {
    /// The angle or position: an output by it is a transmissibility.
    #[default]
    Displacement,
    /// Its rate.
    Velocity,
    /// Its second rate.
    Acceleration,
}

/// Treatment of frequencies that a superelement's file isn't made for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum BeyondBand {
    /// They are computed, with a note.
    #[default]
    Warn,
    /// The analysis is refused.
    Refuse,
}

impl FrequencyResponse {
    /// The highest frequency, cycles per time.
    pub fn highest(&self) -> f64 {
        match &self.frequencies {
            Frequencies::List(list) => list.last().copied().unwrap_or(0.0),
            Frequencies::Range(range) => range.to,
        }
    }

    /// The lowest frequency, cycles per time.
    pub fn lowest(&self) -> f64 {
        match &self.frequencies {
            Frequencies::List(list) => list.first().copied().unwrap_or(0.0),
            Frequencies::Range(range) => range.from,
        }
    }

    /// Loss factor η of all stiffness; zero for other damping.
    pub fn loss_factor(&self) -> f64 {
        match self.damping {
            Some(ResponseDamping::Structural(loss)) => loss,
            _ => 0.0,
        }
    }

    pub(super) fn check(&self, location: &str) -> Result<(), Error> {
        self.check_frequencies(&format!("{location}.frequencies"))?;
        match &self.damping {
            None => {}
            Some(ResponseDamping::Structural(factor)) => {
                not_negative(&format!("{location}.damping.structural"), *factor)?;
            }
            Some(ResponseDamping::AssembledModal(ratios)) => {
                ratios.check(&format!("{location}.damping.assembled_modal"))?;
            }
        }
        for (name, table) in &self.random {
            check_density(&format!("{location}.random.{name}"), table)?;
        }
        for (index, correlation) in self.correlated.iter().enumerate() {
            correlation.check(&format!("{location}.correlated[{index}]"))?;
        }
        for (case, inputs) in &self.cases {
            let at = format!("{location}.cases.{case}");
            if inputs.is_empty() {
                return Err(Error::described(
                    at,
                    "is empty; expected {\"INPUT\": [[frequency, real, imaginary], ...]}",
                ));
            }
            for (name, table) in inputs {
                check_amplitudes(&format!("{at}.{name}"), table)?;
            }
        }
        Ok(())
    }

    fn check_frequencies(&self, location: &str) -> Result<(), Error> {
        match &self.frequencies {
            Frequencies::List(list) if list.is_empty() => Err(Error::described(
                location,
                "is empty; expected at least one frequency",
            )),
            Frequencies::List(list) => {
                for (index, frequency) in list.iter().enumerate() {
                    positive(&format!("{location}[{index}]"), *frequency)?;
                }
                match list.windows(2).position(|pair| pair[0] >= pair[1]) {
                    None => Ok(()),
                    Some(index) => Err(Error::described(
                        format!("{location}[{}]", index + 1),
                        format!(
                            "is {}, after {}; expected ascending frequencies",
                            list[index + 1],
                            list[index]
                        ),
                    )),
                }
            }
            Frequencies::Range(range) => {
                positive(&format!("{location}.from"), range.from)?;
                positive(&format!("{location}.to"), range.to)?;
                if range.to <= range.from {
                    return Err(Error::described(
                        format!("{location}.to"),
                        format!("is {}, not above `from`, which is {}", range.to, range.from),
                    ));
                }
                if range.count < 2 || range.count as usize > MOST {
                    return Err(Error::described(
                        format!("{location}.count"),
                        format!("is {}, expected 2 to {MOST}", range.count),
                    ));
                }
                Ok(())
            }
        }
    }
}
