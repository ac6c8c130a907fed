//! The analysis of a scene, and how strict it is.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::FrequencyResponse;
use crate::named::object;

/// The analysis of a scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Analysis {
    /// The motion over time.
    #[default]
    Transient,
    /// The equilibrium at time zero.
    Static,
    /// The rest in the frame that the loads accelerate, of a mechanism that isn't held.
    InertiaRelief,
    /// The motion that drives and joints alone determine, and the forces for it.
    Kinematic,
    /// Frequencies and shapes of small oscillations.
    #[serde(deserialize_with = "object")]
    Modes(ModesAnalysis),
    /// Steady oscillations under oscillating inputs, over a range of frequencies.
    #[serde(deserialize_with = "object")]
    FrequencyResponse(FrequencyResponse),
}

/// How many oscillations, and about which placement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModesAnalysis {
    /// Number of frequencies, from the lowest.
    pub count: u32,
    /// Placement about which the equations are linearised.
    #[serde(default)]
    pub at: Linearization,
}

/// A placement about which the equations are linearised.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Linearization {
    /// The initial one.
    #[default]
    Initial,
    /// The equilibrium.
    Static,
}

/// How the interfaces of superelements follow their coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Compatibility {
    /// All columns of the basis are dynamic coordinates.
    #[default]
    Strong,
    /// Modes are dynamic, the residual flexibility follows the interface forces without inertia.
    Static,
    /// Interfaces are compatible in the weak sense of the dual method; unstable where the step is short against the
    /// residual frequencies.
    Weak,
}

impl Compatibility {
    /// Name in scenes, tables and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Strong => "strong",
            Self::Static => "static",
            Self::Weak => "weak",
        }
    }
}

/// Treatment of joints that constrain the same motion twice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RedundantConstraints {
    /// Of all possible reactions the smallest are taken.
    #[default]
    MinimumNorm,
    /// The scene is refused.
    Refuse,
}

/// How the initial placement is made to fit the joints.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Initial {
    /// Bodies that stay where they are.
    #[serde(default)]
    pub hold: Vec<String>,
    /// How far a body may be moved to close the joints; half the sizes of all bodies together where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub allow_gap: Option<f64>,
}
