//! How the equations of motion are integrated over time.

mod scheme;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::values::positive;
use crate::Error;
use crate::named::object;

pub use scheme::Scheme;

/// Largest spectral radius at infinity of the hard constraints: beyond it their multipliers ring, and in the end grow.
const LARGEST_INDEX_3_RADIUS: f64 = 0.9;

/// A method and its step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(from = "IntegratorPart", into = "IntegratorPart")]
pub struct Integrator {
    /// Family of methods and its parameter.
    pub method: Method,
    /// Length of a step; with `adaptive` the first, with Radau the longest.
    pub step: f64,
    /// Time at which the run ends.
    pub end: f64,
    /// How the constraints are met.
    pub formulation: Formulation,
    /// Error of the accelerations at which Newton's iteration ends, relative to the accelerations of the run; with Radau the error that the
    /// motion may have.
    pub tolerance: f64,
    /// Newton iterations allowed in a step.
    pub max_iterations: u32,
    /// Steps that follow an error estimate; constant where `None`.
    pub adaptive: Option<AdaptiveStep>,
}

/// Family of methods and the parameter that sets its numerical damping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// Generalised alpha, by its spectral radius at infinite frequency, in [0, 1].
    GeneralizedAlpha {
        /// 1 damps nothing, 0 damps the highest frequencies in one step.
        rho_infinity: f64,
    },
    /// Hilber, Hughes and Taylor, by alpha in [-1/3, 0].
    Hht {
        /// 0 damps nothing.
        alpha: f64,
    },
    /// Radau IIA, of steps as long as the tolerance allows.
    Radau {
        /// 5 or 9.
        order: u32,
        /// Cycles per time unit of the fastest motion that parts are modelled for; `None` for all that their files have.
        highest_frequency: Option<f64>,
        /// Error that the forces in bodies may have, relative to the largest in each; `None` where only the motion counts.
        force_tolerance: Option<f64>,
    },
}

impl Method {
    /// Its key in a scene.
    pub fn name(self) -> &'static str {
        match self {
            Self::GeneralizedAlpha { .. } => "generalized_alpha",
            Self::Hht { .. } => "hht",
            Self::Radau { .. } => "radau",
        }
    }
}

/// How constraints enter the equations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Formulation {
    /// Positions meet the constraints.
    #[serde(rename = "index-3")]
    #[default]
    Index3,
    /// Positions and velocities meet the constraints.
    #[serde(rename = "stabilized-index-2")]
    StabilizedIndex2,
}

/// Step sizes that follow an error estimate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AdaptiveStep {
    /// Local error allowed relative to the size of the motion.
    pub tolerance: f64,
    /// Shortest step: a run that needs a shorter one stops.
    pub minimum_step: f64,
    /// Longest step.
    pub maximum_step: f64,
}

const TOLERANCE: f64 = 1e-8;
const MAX_ITERATIONS: u32 = 12;
const RHO_INFINITY: f64 = 0.8;
const ALPHA: f64 = -0.1;
const RADAU_TOLERANCE: f64 = 1e-4;
const RADAU_ORDER: u32 = 9;
/// Smallest tolerance of a motion: below it, rounding is mistaken for errors.
const SMALLEST_TOLERANCE: f64 = 1e-12;

impl Integrator {
    /// Generalised alpha with the usual settings.
    pub fn generalized_alpha(step: f64, end: f64) -> Self {
        Self {
            method: Method::GeneralizedAlpha {
                rho_infinity: RHO_INFINITY,
            },
            step,
            end,
            formulation: Formulation::default(),
            tolerance: TOLERANCE,
            max_iterations: MAX_ITERATIONS,
            adaptive: None,
        }
    }

    /// Radau IIA with the usual settings.
    pub fn radau(tolerance: f64, end: f64) -> Self {
        Self {
            method: Method::Radau {
                order: RADAU_ORDER,
                highest_frequency: None,
                force_tolerance: None,
            },
            step: end,
            tolerance,
            ..Self::generalized_alpha(end, end)
        }
    }

    /// Whether all steps but the last are of one length.
    pub fn has_equal_steps(&self) -> bool {
        self.adaptive.is_none() && !self.is_radau()
    }

    /// Whether steps follow from an accuracy alone.
    pub fn is_radau(&self) -> bool {
        matches!(self.method, Method::Radau { .. })
    }

    /// The fastest motion that parts are modelled for, where the scene says so; cycles per time unit.
    pub fn highest_frequency(&self) -> Option<f64> {
        match self.method {
            Method::Radau {
                highest_frequency, ..
            } => highest_frequency,
            Method::GeneralizedAlpha { .. } | Method::Hht { .. } => None,
        }
    }

    /// Error that the forces in bodies may have, where the scene says so.
    pub fn force_tolerance(&self) -> Option<f64> {
        match self.method {
            Method::Radau {
                force_tolerance, ..
            } => force_tolerance,
            Method::GeneralizedAlpha { .. } | Method::Hht { .. } => None,
        }
    }

    /// Lets Radau hold forces to this error, too.
    pub fn hold_forces(&mut self, tolerance: f64) {
        if let Method::Radau {
            force_tolerance, ..
        } = &mut self.method
        {
            *force_tolerance = Some(tolerance);
        }
    }

    fn check_radau(&self, order: u32) -> Result<(), Error> {
        let at = |key: &str| format!("integrator.radau.{key}");
        if let Some(frequency) = self.highest_frequency() {
            positive(&at("highest_frequency"), frequency)?;
        }
        if let Some(tolerance) = self.force_tolerance() {
            positive(&at("force_tolerance"), tolerance)?;
            if !(SMALLEST_TOLERANCE..=1.0).contains(&tolerance) {
                return Err(Error::described(
                    at("force_tolerance"),
                    format!(
                        "is {tolerance}, expected from {SMALLEST_TOLERANCE:e} to 1: the error of the forces in a body, relative to the largest in it"
                    ),
                ));
            }
        }
        super::values::not_negative(&at("end"), self.end)?;
        positive(&at("tolerance"), self.tolerance)?;
        if !(SMALLEST_TOLERANCE..=0.1).contains(&self.tolerance) {
            return Err(Error::described(
                at("tolerance"),
                format!(
                    "is {}, expected from {SMALLEST_TOLERANCE:e} to 0.1: the error of the motion, relative to the bodies' lengths and deflections",
                    self.tolerance
                ),
            ));
        }
        if self.end > 0.0 {
            positive(&at("maximum_step"), self.step)?;
        }
        match order {
            5 | 9 => Ok(()),
            found => Err(Error::described(
                at("order"),
                format!("is {found}, expected 5 or 9"),
            )),
        }
    }

    pub(super) fn check(&self) -> Result<(), Error> {
        if let Method::Radau { order, .. } = self.method {
            return self.check_radau(order);
        }
        let at = |key: &str| format!("integrator.{}.{key}", self.method.name());
        positive(&at("step"), self.step)?;
        super::values::not_negative(&at("end"), self.end)?;
        if self.end > 0.0 && self.step > self.end * (1.0 + 1e-9) {
            return Err(Error::described(
                at("step"),
                format!(
                    "is {}, longer than the whole run, which ends at {}",
                    self.step, self.end
                ),
            ));
        }
        positive(&at("tolerance"), self.tolerance)?;
        if self.tolerance >= 1.0 {
            return Err(Error::described(
                at("tolerance"),
                format!("is {}, expected less than 1", self.tolerance),
            ));
        }
        if self.max_iterations == 0 {
            return Err(Error::described(
                at("max_iterations"),
                "is 0, expected at least 1",
            ));
        }
        let (key, parameter, range, radius) = match self.method {
            Method::GeneralizedAlpha { rho_infinity } => {
                ("rho_infinity", rho_infinity, (0.0, 1.0), rho_infinity)
            }
            Method::Hht { alpha } => (
                "alpha",
                alpha,
                (-1.0 / 3.0, 0.0),
                (1.0 + alpha) / (1.0 - alpha),
            ),
            Method::Radau { .. } => return Ok(()),
        };
        let rounding = 1e-12;
        if !(parameter >= range.0 - rounding && parameter <= range.1) {
            return Err(Error::described(
                at(key),
                format!(
                    "is {parameter}, expected a number from {} to {}",
                    range.0, range.1
                ),
            ));
        }
        if self.formulation == Formulation::Index3 && radius > LARGEST_INDEX_3_RADIUS + rounding {
            let largest = match self.method {
                Method::GeneralizedAlpha { .. } => LARGEST_INDEX_3_RADIUS,
                Method::Hht { .. } | Method::Radau { .. } => {
                    (LARGEST_INDEX_3_RADIUS - 1.0) / (LARGEST_INDEX_3_RADIUS + 1.0)
                }
            };
            return Err(Error::described(
                at(key),
                format!(
                    "is {parameter}, but the hard constraints of the formulation index-3 are weakly unstable with so little \
                     numerical damping; use at most {largest:.3}, or \"formulation\": \"stabilized-index-2\""
                ),
            ));
        }
        match &self.adaptive {
            Some(adaptive) => adaptive.check(&at("adaptive"), self.step),
            None => Ok(()),
        }
    }
}

impl AdaptiveStep {
    fn check(&self, location: &str, step: f64) -> Result<(), Error> {
        positive(&format!("{location}.tolerance"), self.tolerance)?;
        positive(&format!("{location}.minimum_step"), self.minimum_step)?;
        positive(&format!("{location}.maximum_step"), self.maximum_step)?;
        if self.minimum_step <= step && step <= self.maximum_step {
            return Ok(());
        }
        Err(Error::described(
            location,
            format!(
                "allows steps from {} to {}, but the first is {step}",
                self.minimum_step, self.maximum_step
            ),
        ))
    }
}

/// Method of integration over time.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(rename = "Integrator")]
enum IntegratorPart {
    /// Generalised alpha.
    #[serde(deserialize_with = "object")]
    GeneralizedAlpha(GeneralizedAlphaPart),
    /// Hilber, Hughes and Taylor.
    #[serde(deserialize_with = "object")]
    Hht(HhtPart),
    /// Radau IIA: the accuracy is given, the steps follow.
    #[serde(deserialize_with = "object")]
    Radau(RadauPart),
}

/// Generalised alpha.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "GeneralizedAlpha")]
struct GeneralizedAlphaPart {
    /// Length of a step.
    step: f64,
    /// Time at which the run ends.
    end: f64,
    /// Spectral radius at infinite frequency: 0 to 0.9 (`index-3`) or 1 (`stabilized-index-2`).
    #[serde(default = "rho_infinity")]
    rho_infinity: f64,
    /// How constraints are met.
    #[serde(default)]
    formulation: Formulation,
    /// Error of the accelerations at which Newton's iteration ends, relative to the accelerations of the run.
    #[serde(default = "tolerance")]
    tolerance: f64,
    /// Newton iterations allowed in a step.
    #[serde(default = "max_iterations")]
    max_iterations: u32,
    /// Steps that follow an error estimate; constant where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    adaptive: Option<AdaptiveStep>,
}

/// Hilber, Hughes and Taylor.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Hht")]
struct HhtPart {
    /// Length of a step.
    step: f64,
    /// Time at which the run ends.
    end: f64,
    /// From -1/3 to -0.053 (`index-3`) or 0 (`stabilized-index-2`).
    #[serde(default = "alpha")]
    alpha: f64,
    /// How constraints are met.
    #[serde(default)]
    formulation: Formulation,
    /// Error of the accelerations at which Newton's iteration ends, relative to the accelerations of the run.
    #[serde(default = "tolerance")]
    tolerance: f64,
    /// Newton iterations allowed in a step.
    #[serde(default = "max_iterations")]
    max_iterations: u32,
    /// Steps that follow an error estimate; constant where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    adaptive: Option<AdaptiveStep>,
}

/// Radau IIA: the accuracy is given, the steps follow.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Radau")]
struct RadauPart {
    /// Time at which the run ends.
    end: f64,
    /// Error that the motion may have, relative to the lengths of the bodies and to their largest deflections.
    #[serde(default = "radau_tolerance")]
    tolerance: f64,
    /// Longest step; none where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    maximum_step: Option<f64>,
    /// Order of the method: 9, or 5.
    #[serde(default = "radau_order")]
    order: u32,
    /// Fastest motion that matters, cycles per time unit: parts are modelled up to it, and as stiff beyond it. All that their files have where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    highest_frequency: Option<f64>,
    /// Error that the forces in bodies, and so those of joints, may have, relative to the largest in each body so far. Only the motion counts where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    force_tolerance: Option<f64>,
}

fn radau_tolerance() -> f64 {
    RADAU_TOLERANCE
}

fn radau_order() -> u32 {
    RADAU_ORDER
}

fn tolerance() -> f64 {
    TOLERANCE
}

fn max_iterations() -> u32 {
    MAX_ITERATIONS
}

fn rho_infinity() -> f64 {
    RHO_INFINITY
}

fn alpha() -> f64 {
    ALPHA
}

impl From<IntegratorPart> for Integrator {
    fn from(part: IntegratorPart) -> Self {
        match part {
            IntegratorPart::GeneralizedAlpha(part) => Self {
                method: Method::GeneralizedAlpha {
                    rho_infinity: part.rho_infinity,
                },
                step: part.step,
                end: part.end,
                formulation: part.formulation,
                tolerance: part.tolerance,
                max_iterations: part.max_iterations,
                adaptive: part.adaptive,
            },
            IntegratorPart::Hht(part) => Self {
                method: Method::Hht { alpha: part.alpha },
                step: part.step,
                end: part.end,
                formulation: part.formulation,
                tolerance: part.tolerance,
                max_iterations: part.max_iterations,
                adaptive: part.adaptive,
            },
            IntegratorPart::Radau(part) => Self {
                method: Method::Radau {
                    order: part.order,
                    highest_frequency: part.highest_frequency,
                    force_tolerance: part.force_tolerance,
                },
                step: part.maximum_step.unwrap_or(part.end),
                ..Self::radau(part.tolerance, part.end)
            },
        }
    }
}

impl From<Integrator> for IntegratorPart {
    fn from(integrator: Integrator) -> Self {
        let Integrator {
            method,
            step,
            end,
            formulation,
            tolerance,
            max_iterations,
            adaptive,
        } = integrator;
        match method {
            Method::GeneralizedAlpha { rho_infinity } => {
                Self::GeneralizedAlpha(GeneralizedAlphaPart {
                    step,
                    end,
                    rho_infinity,
                    formulation,
                    tolerance,
                    max_iterations,
                    adaptive,
                })
            }
            Method::Radau {
                order,
                highest_frequency,
                force_tolerance,
            } => Self::Radau(RadauPart {
                end,
                tolerance,
                maximum_step: (step != end).then_some(step),
                order,
                highest_frequency,
                force_tolerance,
            }),
            Method::Hht { alpha } => Self::Hht(HhtPart {
                step,
                end,
                alpha,
                formulation,
                tolerance,
                max_iterations,
                adaptive,
            }),
        }
    }
}
