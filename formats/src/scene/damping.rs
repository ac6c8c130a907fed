//! Damping that a scene gives a superelement in place of its file's.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::values::not_negative;
use crate::Error;
use crate::component::Damping;

/// Damping that replaces the one of a superelement's file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DampingOverride {
    /// Ratio to critical: one for all modes, or one per mode of which the last holds for all further ones.
    Modal(ModalRatios),
    /// C = alpha M + beta K of the deflection, by the factors or by the ratios to critical at two frequencies.
    Rayleigh(Rayleigh),
}

/// Both factors of Rayleigh damping, or what determines them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected [alpha, beta], or {\"frequencies\": [f1, f2], \"ratios\": [z1, z2]}"
)]
pub enum Rayleigh {
    /// alpha in 1/time, beta in time.
    Factors([f64; 2]),
    /// By two ratios.
    Through(RayleighPoints),
}

/// Ratios to critical at two frequencies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RayleighPoints {
    /// Cycles per time, above zero.
    pub frequencies: [f64; 2],
    /// The ratio at each, not negative.
    pub ratios: [f64; 2],
}

impl Rayleigh {
    /// `[alpha, beta]`.
    ///
    /// # Errors
    /// Found and expected, for factors below zero or ratios that need them.
    pub fn factors(&self) -> Result<[f64; 2], String> {
        match self {
            Self::Factors(factors) => match factors.iter().find(|f| !(**f >= 0.0 && f.is_finite()))
            {
                Some(found) => Err(format!("has the factor {found}, expected factors >= 0")),
                None => Ok(*factors),
            },
            Self::Through(points) => Damping::rayleigh_through(points.frequencies, points.ratios),
        }
    }
}

/// One ratio to critical damping, or a list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected a damping ratio or a list of them")]
pub enum ModalRatios {
    /// The same for every mode.
    Uniform(f64),
    /// Mode by mode; the last holds for all further ones.
    PerMode(Vec<f64>),
}

impl DampingOverride {
    pub(super) fn check(&self, location: &str) -> Result<(), Error> {
        let at = format!("{location}.modal");
        match self {
            Self::Modal(ModalRatios::Uniform(ratio)) => not_negative(&at, *ratio),
            Self::Rayleigh(rayleigh) => match rayleigh.factors() {
                Ok(_) => Ok(()),
                Err(message) => Err(Error::described(format!("{location}.rayleigh"), message)),
            },
            Self::Modal(ModalRatios::PerMode(ratios)) => {
                if ratios.is_empty() {
                    return Err(Error::described(
                        at,
                        "is an empty list; expected at least one ratio",
                    ));
                }
                ratios
                    .iter()
                    .enumerate()
                    .try_for_each(|(mode, ratio)| not_negative(&format!("{at}[{mode}]"), *ratio))
            }
        }
    }
}
