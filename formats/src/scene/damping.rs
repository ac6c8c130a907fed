//! Damping that a scene gives a superelement in place of its file's.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::settings::Linearization;
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

/// Damping of the modes of the mechanism as it is put together, in place of that of its superelements. Exactly one kind is given.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AssembledDamping {
    /// Ratio to critical: one for all assembled modes, or one per mode from the lowest, of which the last holds for all further ones.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub assembled_modal: Option<ModalRatios>,
    /// The ratio that Rayleigh damping through two ratios has at the frequency of each assembled mode.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub assembled_rayleigh: Option<RayleighPoints>,
    /// Loss factor: half of it is the ratio to critical of every assembled mode.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub assembled_structural: Option<f64>,
    /// Placement at which the modes are those of the mechanism.
    #[serde(default)]
    pub at: Linearization,
}

impl AssembledDamping {
    /// The key that is given.
    pub fn key(&self) -> &'static str {
        match (&self.assembled_modal, &self.assembled_rayleigh) {
            (Some(_), _) => "assembled_modal",
            (None, Some(_)) => "assembled_rayleigh",
            (None, None) => "assembled_structural",
        }
    }

    pub(super) fn check(&self, location: &str) -> Result<(), Error> {
        let given = [
            self.assembled_modal.is_some(),
            self.assembled_rayleigh.is_some(),
            self.assembled_structural.is_some(),
        ];
        let count = given.iter().filter(|given| **given).count();
        if count != 1 {
            return Err(Error::described(
                location,
                format!(
                    "has {count} kinds of damping, expected one of \"assembled_modal\", \"assembled_rayleigh\" and \"assembled_structural\""
                ),
            ));
        }
        if let Some(ratios) = &self.assembled_modal {
            ratios.check(&format!("{location}.assembled_modal"))?;
        }
        if let Some(points) = &self.assembled_rayleigh {
            Damping::rayleigh_through(points.frequencies, points.ratios).map_err(|message| {
                Error::described(format!("{location}.assembled_rayleigh"), message)
            })?;
        }
        if let Some(loss) = self.assembled_structural {
            not_negative(&format!("{location}.assembled_structural"), loss)?;
        }
        Ok(())
    }
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
        match self {
            Self::Modal(ratios) => ratios.check(&format!("{location}.modal")),
            Self::Rayleigh(rayleigh) => match rayleigh.factors() {
                Ok(_) => Ok(()),
                Err(message) => Err(Error::described(format!("{location}.rayleigh"), message)),
            },
        }
    }
}

impl ModalRatios {
    /// The ratio of the mode at a place, counted from the lowest; of ratios that have been checked.
    pub fn of_mode(&self, place: usize) -> f64 {
        match self {
            Self::Uniform(ratio) => *ratio,
            Self::PerMode(list) => {
                let last = list.last().copied().unwrap_or(0.0);
                list.get(place).copied().unwrap_or(last)
            }
        }
    }

    pub(super) fn check(&self, at: &str) -> Result<(), Error> {
        match self {
            Self::Uniform(ratio) => not_negative(at, *ratio),
            Self::PerMode(ratios) => {
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
