//! A pulse, once or again and again.

use std::f64::consts::{PI, TAU};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::FunctionValue;
use super::description::{named_finite, positive};
use crate::Error;

/// A pulse of given width.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pulse {
    /// Its shape.
    #[serde(default)]
    pub shape: Shape,
    /// Height over the offset.
    pub amplitude: f64,
    /// Time at which it begins; 0 where absent.
    #[serde(default)]
    pub start: f64,
    /// How long it lasts.
    pub width: f64,
    /// Time from one pulse to the next, not shorter than the width; a single pulse where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub period: Option<f64>,
    /// Value outside of pulses; 0 where absent.
    #[serde(default)]
    pub offset: f64,
}

/// The shape of a pulse, x from 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// (1 - cos(2 π x))/2: continuous with its rate.
    #[default]
    Haversine,
    /// sin(π x): continuous, its rate jumps at both ends.
    HalfSine,
    /// 1: jumps at both ends.
    Rectangle,
}

/// Breaks of a periodic pulse that are told, at most.
const MOST_BREAKS: u64 = 1 << 14;

impl Pulse {
    pub(super) fn check(&self) -> Result<(), Error> {
        named_finite(&[
            ("amplitude", self.amplitude),
            ("start", self.start),
            ("offset", self.offset),
        ])?;
        positive("width", self.width)?;
        match self.period {
            None => Ok(()),
            Some(period) if period >= self.width && period.is_finite() => Ok(()),
            Some(period) => Err(Error::described(
                "period",
                format!(
                    "is {period}, expected a number not below the width, {}",
                    self.width
                ),
            )),
        }
    }

    /// Pulses that are over or have begun, and the time since the last one began; before the first, below zero.
    fn place(&self, time: f64) -> (f64, f64) {
        let since = time - self.start;
        match self.period {
            Some(period) if since > 0.0 => {
                let before = (since / period).floor();
                (before, before.mul_add(-period, since).clamp(0.0, period))
            }
            _ => (0.0, since),
        }
    }

    /// Value and derivatives.
    pub fn evaluate(&self, time: f64) -> FunctionValue {
        let (_, since) = self.place(time);
        let x = since / self.width;
        if !(0.0..1.0).contains(&x) {
            return FunctionValue {
                value: self.offset,
                ..FunctionValue::default()
            };
        }
        let [value, slope, curvature] = match self.shape {
            Shape::Rectangle => [1.0, 0.0, 0.0],
            Shape::HalfSine => {
                let (sin, cos) = (PI * x).sin_cos();
                [sin, PI * cos, -PI * PI * sin]
            }
            Shape::Haversine => {
                let (sin, cos) = (TAU * x).sin_cos();
                [0.5 * (1.0 - cos), PI * sin, PI * TAU * cos]
            }
        };
        FunctionValue {
            value: self.offset + self.amplitude * value,
            rate: self.amplitude * slope / self.width,
            second_rate: self.amplitude * curvature / (self.width * self.width),
        }
    }

    /// The integral from the start of the first pulse.
    pub fn antiderivative(&self, time: f64) -> f64 {
        let (before, since) = self.place(time);
        let x = (since / self.width).clamp(0.0, 1.0);
        let (whole, part) = match self.shape {
            Shape::Rectangle => (1.0, x),
            Shape::HalfSine => {
                let sine = (0.5 * PI * x).sin();
                (2.0 / PI, 2.0 * sine * sine / PI)
            }
            Shape::Haversine => (0.5, 0.5 * x - (TAU * x).sin() / (2.0 * TAU)),
        };
        self.offset * (time - self.start) + self.amplitude * self.width * (before * whole + part)
    }

    /// Times up to an end at which a derivative jumps.
    pub fn breaks(&self, end: f64) -> Vec<f64> {
        let Some(period) = self.period else {
            return vec![self.start, self.start + self.width];
        };
        let count = ((end - self.start) / period).floor().max(0.0) as u64;
        (0..=count.min(MOST_BREAKS))
            .flat_map(|pulse| {
                let begin = self.start + pulse as f64 * period;
                [begin, begin + self.width]
            })
            .collect()
    }
}
