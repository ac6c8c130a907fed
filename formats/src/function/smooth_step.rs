//! A rise from one value to another in a given time.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::FunctionValue;
use super::description::{named_finite, positive};
use super::piecewise::Piecewise;
use crate::Error;

/// From one value to another, at rest before and after.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SmoothStep {
    /// Value before; 0 where absent.
    #[serde(default)]
    pub from: f64,
    /// Value after.
    pub to: f64,
    /// Time at which it begins; 0 where absent.
    #[serde(default)]
    pub start: f64,
    /// How long it takes.
    pub duration: f64,
    /// Its course.
    #[serde(default)]
    pub profile: Profile,
}

/// The course of a rise, x from 0 to 1. Both have continuous accelerations; the jerk jumps at both ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Profile {
    /// 10 x³ - 15 x⁴ + 6 x⁵; largest speed 1.875, largest acceleration 5.774 (times rise/duration and rise/duration²).
    #[default]
    #[serde(rename = "3-4-5")]
    Polynomial,
    /// x - sin(2 π x)/(2 π); largest speed 2, largest acceleration 6.283.
    Cycloidal,
}

impl SmoothStep {
    pub(super) fn check(&self) -> Result<(), Error> {
        named_finite(&[("from", self.from), ("to", self.to), ("start", self.start)])?;
        positive("duration", self.duration)
    }

    /// The quintic, which has zero slope and curvature at both ends.
    pub(super) fn quintic(&self) -> Piecewise {
        let times = [self.start, self.start + self.duration];
        Piecewise::quintic(&times, &[self.from, self.to], &[[0.0; 2]; 2])
    }

    pub(super) fn cycloid(&self) -> Cycloid {
        Cycloid {
            from: self.from,
            rise: self.to - self.from,
            start: self.start,
            duration: self.duration,
        }
    }
}

/// from + rise (x - sin(2 π x)/(2 π)), x = (t - start)/duration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cycloid {
    from: f64,
    rise: f64,
    start: f64,
    duration: f64,
}

impl Cycloid {
    /// Value and derivatives.
    pub fn evaluate(&self, time: f64) -> FunctionValue {
        use std::f64::consts::TAU;
        let x = ((time - self.start) / self.duration).clamp(0.0, 1.0);
        if x == 0.0 || x == 1.0 {
            return FunctionValue {
                value: self.from + x * self.rise,
                ..FunctionValue::default()
            };
        }
        let (sin, cos) = (TAU * x).sin_cos();
        let speed = self.rise / self.duration;
        FunctionValue {
            value: self.from + self.rise * (x - sin / TAU),
            rate: speed * (1.0 - cos),
            second_rate: speed / self.duration * TAU * sin,
        }
    }

    /// The integral from the start.
    pub fn antiderivative(&self, time: f64) -> f64 {
        use std::f64::consts::TAU;
        let since = time - self.start;
        let x = (since / self.duration).clamp(0.0, 1.0);
        // 1 - cos(2 π x) without cancellation.
        let sine = (0.5 * TAU * x).sin();
        let within = 0.5 * x * x - 2.0 * sine * sine / (TAU * TAU);
        let after = (since - self.duration).max(0.0);
        self.from * since + self.rise * (self.duration * within + after)
    }

    /// Times at which a derivative jumps.
    pub fn breaks(&self) -> Vec<f64> {
        vec![self.start, self.start + self.duration]
    }
}
