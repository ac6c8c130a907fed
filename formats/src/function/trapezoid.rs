//! A rise as fast as limits of speed, acceleration and jerk allow.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::description::{named_finite, positive};
use super::piecewise::Piecewise;
use crate::Error;

/// From one value to another in the shortest time within limits, at rest before and after; limits that the way is too short for are not reached.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Trapezoid {
    /// Value before; 0 where absent.
    #[serde(default)]
    pub from: f64,
    /// Value after.
    pub to: f64,
    /// Time at which it begins; 0 where absent.
    #[serde(default)]
    pub start: f64,
    /// Largest speed.
    pub max_speed: f64,
    /// Largest acceleration, speeding up and slowing down.
    pub max_acceleration: f64,
    /// Largest jerk; without it the acceleration jumps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_jerk: Option<f64>,
}

/// Times and peaks of a rise: seven intervals, of which some may take no time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Course {
    /// Of each of the four intervals in which the acceleration changes; zero without a limit of jerk.
    changing: f64,
    /// Of each of the two intervals of constant acceleration.
    accelerating: f64,
    /// At the largest speed.
    cruising: f64,
    /// Largest acceleration.
    peak: f64,
}

impl Trapezoid {
    pub(super) fn check(&self) -> Result<(), Error> {
        named_finite(&[("from", self.from), ("to", self.to), ("start", self.start)])?;
        positive("max_speed", self.max_speed)?;
        positive("max_acceleration", self.max_acceleration)?;
        match self.max_jerk {
            Some(jerk) => positive("max_jerk", jerk),
            None => Ok(()),
        }
    }

    /// For a way above zero.
    fn course(&self, way: f64) -> Course {
        let (v, a) = (self.max_speed, self.max_acceleration);
        // The time in which the largest acceleration is built up.
        let build_up = self.max_jerk.map_or(0.0, |jerk| a / jerk);
        let jerk = self.max_jerk.unwrap_or(f64::INFINITY);
        // What the limits of acceleration and jerk need to reach the largest speed, and then for the way there and back.
        let (changing, accelerating) = match v < a * build_up {
            true => ((v / jerk).sqrt(), 0.0),
            false => (build_up, v / a - build_up),
        };
        let ramp = 2.0 * changing + accelerating;
        let peak = |changing: f64| if changing > 0.0 { jerk * changing } else { a };
        if v * ramp <= way {
            return Course {
                changing,
                accelerating,
                cruising: way / v - ramp,
                peak: if changing < build_up {
                    peak(changing)
                } else {
                    a
                },
            };
        }
        if way < 2.0 * a * build_up * build_up {
            // Neither speed nor acceleration reach their limits: way = 2 jerk changing³.
            let changing = (way / (2.0 * jerk)).cbrt();
            return Course {
                changing,
                accelerating: 0.0,
                cruising: 0.0,
                peak: peak(changing),
            };
        }
        // way = speed (speed/a + build_up)
        let speed = 0.5 * a * ((build_up * build_up + 4.0 * way / a).sqrt() - build_up);
        Course {
            changing: build_up,
            accelerating: (speed / a - build_up).max(0.0),
            cruising: 0.0,
            peak: a,
        }
    }

    /// The cubics between the changes of jerk, or the parabolas between those of acceleration.
    pub(super) fn piecewise(&self) -> Piecewise {
        let way = self.to - self.from;
        if way == 0.0 {
            return Piecewise::constant(self.start, self.to);
        }
        let sign = way.signum();
        let course = self.course(way.abs());
        let Course {
            changing: c,
            accelerating: k,
            cruising,
            peak,
        } = course;
        let jerk = if c > 0.0 { peak / c } else { 0.0 };
        // Duration, acceleration at its start, jerk.
        let parts = [
            (c, 0.0, jerk),
            (k, peak, 0.0),
            (c, peak, -jerk),
            (cruising, 0.0, 0.0),
            (c, 0.0, -jerk),
            (k, -peak, 0.0),
            (c, -peak, jerk),
        ];
        let (mut since, mut value, mut speed) = (0.0, 0.0, 0.0);
        let mut breaks = Vec::new();
        let mut cubics = Vec::new();
        for (duration, acceleration, jerk) in parts {
            if duration <= 0.0 {
                continue;
            }
            breaks.push(self.start + since);
            cubics.push([
                self.from + sign * value,
                sign * speed,
                sign * acceleration / 2.0,
                sign * jerk / 6.0,
            ]);
            let gained = acceleration + 0.5 * jerk * duration;
            value += duration * (speed + duration * (acceleration / 2.0 + jerk * duration / 6.0));
            speed += duration * gained;
            since += duration;
        }
        breaks.push(self.start + since);
        Piecewise::pieces(breaks, self.from, &cubics, self.to)
    }
}
