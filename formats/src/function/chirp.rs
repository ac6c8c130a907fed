//! A sine whose frequency sweeps from one value to another.

use std::f64::consts::TAU;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::FunctionValue;
use super::description::{named_finite, positive};
use crate::Error;

/// offset + amplitude · sin(φ(t)), with a frequency φ'/2π that goes from one value to another.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Chirp {
    /// Factor of the sine.
    pub amplitude: f64,
    /// Cycles per time unit at the start.
    pub from_hz: f64,
    /// Cycles per time unit at the end of the sweep, and after it.
    pub to_hz: f64,
    /// Time at which the sweep begins; constant before. 0 where absent.
    #[serde(default)]
    pub start: f64,
    /// How long the sweep takes.
    pub duration: f64,
    /// How the frequency goes.
    #[serde(default)]
    pub sweep: Sweep,
    /// Angle of the sine at the start, rad; 0 where absent.
    #[serde(default)]
    pub phase: f64,
    /// Value about which the sine oscillates; 0 where absent.
    #[serde(default)]
    pub offset: f64,
}

/// How the frequency goes from one value to another.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Sweep {
    /// By the same number of cycles per time unit in equal times.
    #[default]
    Linear,
    /// By the same factor in equal times.
    Logarithmic,
}

impl Chirp {
    pub(super) fn check(&self) -> Result<(), Error> {
        named_finite(&[
            ("amplitude", self.amplitude),
            ("start", self.start),
            ("phase", self.phase),
            ("offset", self.offset),
        ])?;
        positive("duration", self.duration)?;
        for (key, frequency) in [("from_hz", self.from_hz), ("to_hz", self.to_hz)] {
            match self.sweep {
                Sweep::Linear if frequency == 0.0 => {}
                Sweep::Linear => positive(key, frequency)?,
                Sweep::Logarithmic if frequency == 0.0 => {
                    return Err(Error::described(
                        key,
                        "is 0, from which no factor leads on; a logarithmic sweep needs positive frequencies, a linear one may have zero",
                    ));
                }
                Sweep::Logarithmic => positive(key, frequency)?,
            }
        }
        Ok(())
    }

    /// φ and its derivatives; the phase is the exact integral of the frequency.
    fn angle(&self, time: f64) -> [f64; 3] {
        let since = time - self.start;
        let within = since.clamp(0.0, self.duration);
        let after = (since - self.duration).max(0.0);
        let x = within / self.duration;
        let ratio = (self.to_hz / self.from_hz).ln();
        let [cycles, frequency, slope] = match self.sweep {
            Sweep::Logarithmic if ratio != 0.0 => {
                let grown = (ratio * x).exp_m1();
                let frequency = self.from_hz * (1.0 + grown);
                let cycles = self.from_hz * self.duration / ratio * grown;
                [cycles, frequency, frequency * ratio / self.duration]
            }
            Sweep::Linear | Sweep::Logarithmic => {
                let change = self.to_hz - self.from_hz;
                let frequency = self.from_hz + change * x;
                let cycles = within * (self.from_hz + 0.5 * change * x);
                [cycles, frequency, change / self.duration]
            }
        };
        let slope = if after > 0.0 { 0.0 } else { slope };
        let cycles = cycles + self.to_hz * after;
        [self.phase + TAU * cycles, TAU * frequency, TAU * slope]
    }

    /// Value and derivatives.
    pub fn evaluate(&self, time: f64) -> FunctionValue {
        let [angle, rate, second] = self.angle(time);
        let (sin, cos) = angle.sin_cos();
        let value = self.offset + self.amplitude * sin;
        if time < self.start {
            return FunctionValue {
                value,
                ..FunctionValue::default()
            };
        }
        FunctionValue {
            value,
            rate: self.amplitude * rate * cos,
            second_rate: self.amplitude * (second * cos - rate * rate * sin),
        }
    }

    /// About how much rounding there may be in the value.
    pub fn rounding(&self, time: f64) -> f64 {
        let [angle, ..] = self.angle(time);
        4.0 * f64::EPSILON * (self.offset.abs() + self.amplitude.abs() * (1.0 + angle.abs()))
    }

    /// Times at which a derivative jumps.
    pub fn breaks(&self) -> Vec<f64> {
        vec![self.start, self.start + self.duration]
    }
}
