//! Springs with dampers beyond a lower and an upper value, which never pull.
//!
//! With the way d beyond the stop, and on the onset s
//!
//! ```text
//! σ = max(0, f(d) + c g(d) d'),    f = k d²/2s for d < s, k (d - s/2) beyond,    g = min(d/s, 1)
//! ```
//! f and g d' are continuous where the stop is met. Without onset f = k d and g = 1.

use super::Effort;

/// Two stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EndStop {
    /// The stop acts below; minus infinity for none.
    pub lower: f64,
    /// The stop acts above; infinity for none.
    pub upper: f64,
    /// k.
    pub stiffness: f64,
    /// c.
    pub damping: f64,
    /// s.
    pub onset: f64,
}

/// One of the two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The lower.
    Lower,
    /// The upper.
    Upper,
}

impl EndStop {
    /// σ and its derivatives.
    pub fn effort(&self, value: f64, rate: f64) -> Effort {
        let Some((end, beyond)) = self.beyond(value) else {
            return Effort::default();
        };
        let sign = end.sign();
        let (push, slope, by_rate) = self.push(beyond, sign * rate);
        Effort {
            force: -sign * push,
            by_value: -slope,
            by_rate: -by_rate,
        }
    }

    /// Energy of the spring.
    pub fn potential(&self, value: f64) -> f64 {
        let Some((_, d)) = self.beyond(value) else {
            return 0.0;
        };
        let (k, s) = (self.stiffness, self.onset);
        match d < s {
            true => k * d * d * d / (6.0 * s),
            // k s²/6 at the end of the onset.
            false => k * (0.5 * d * (d - s) + s * s / 6.0),
        }
    }

    /// Power that becomes heat: of the damper, and of the spring where it is left behind.
    pub fn dissipation(&self, value: f64, rate: f64) -> f64 {
        let Some((end, beyond)) = self.beyond(value) else {
            return 0.0;
        };
        let rate = end.sign() * rate;
        (self.push(beyond, rate).0 - self.spring(beyond).0) * rate
    }

    /// Which stop a coordinate is beyond, and how far.
    pub fn beyond(&self, value: f64) -> Option<(End, f64)> {
        if value < self.lower {
            Some((End::Lower, self.lower - value))
        } else if value > self.upper {
            Some((End::Upper, value - self.upper))
        } else {
            None
        }
    }

    /// The value of a stop.
    pub fn at(&self, end: End) -> f64 {
        match end {
            End::Lower => self.lower,
            End::Upper => self.upper,
        }
    }

    /// f and its slope.
    fn spring(&self, d: f64) -> (f64, f64) {
        let (k, s) = (self.stiffness, self.onset);
        match d < s {
            true => (0.5 * k * d * d / s, k * d / s),
            false => (k * (d - 0.5 * s), k),
        }
    }

    /// The force, and its derivatives by d and d'.
    fn push(&self, d: f64, d_rate: f64) -> (f64, f64, f64) {
        let (spring, slope) = self.spring(d);
        let (share, share_slope) = match d < self.onset {
            true => (d / self.onset, 1.0 / self.onset),
            false => (1.0, 0.0),
        };
        let push = spring + self.damping * share * d_rate;
        match push > 0.0 {
            true => (
                push,
                slope + self.damping * share_slope * d_rate,
                self.damping * share,
            ),
            false => (0.0, 0.0, 0.0),
        }
    }
}

impl End {
    /// The direction beyond it.
    fn sign(self) -> f64 {
        match self {
            Self::Lower => -1.0,
            Self::Upper => 1.0,
        }
    }

    /// Its name for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lower => "lower",
            Self::Upper => "upper",
        }
    }
}
