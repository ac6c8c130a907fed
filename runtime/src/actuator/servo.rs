//! A PID controller with a limited effort.
//!
//! ```text
//! d = target - e,    u = P d + D d' + I z,    σ = S(u),    z' = d + (C(u) - u)/(I T)
//! ```
//! S cuts off at the limit L, or is L tanh(u/L). The last term of z' keeps the integral from winding up while the effort is at its limit
//! (back-calculation; Åström and Hägglund, PID Controllers, 1995, section 3.5): C cuts off at L, with tanh at 2 L, where it is 0.96 L.
//! Continuous integrals follow the trapezoidal rule over the
//! steps of the run; sampled ones z + period z' from sample to sample.

use dcb_formats::function::FunctionValue;

use super::Effort;

/// A smooth saturation counts as reached where this many limits are asked for.
const SMOOTH_REACH: f64 = 2.0;

/// A servo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Servo {
    /// P.
    pub proportional: f64,
    /// D.
    pub derivative: f64,
    /// I.
    pub integral: f64,
    /// Largest effort.
    pub limit: Option<Limit>,
    /// T, the time in which the integral follows; not used without integral or limit.
    pub tracking_time: f64,
    /// Interval of samples; continuous where absent.
    pub sample: Option<f64>,
}

/// The largest effort and how it is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// Cut off.
    Hard(f64),
    /// L tanh(u/L).
    Smooth(f64),
}

/// z and z' at the start of a step, and the time since.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Integral {
    /// z.
    pub value: f64,
    /// z'.
    pub rate: f64,
    /// Time since.
    pub elapsed: f64,
}

impl Limit {
    /// The effort asked for beyond which the integral is taken back.
    fn reach(self) -> f64 {
        match self {
            Self::Hard(limit) => limit,
            Self::Smooth(limit) => SMOOTH_REACH * limit,
        }
    }

    /// S and its slope.
    fn of(self, effort: f64) -> (f64, f64) {
        match self {
            Self::Hard(limit) if effort.abs() <= limit => (effort, 1.0),
            Self::Hard(limit) => (limit.copysign(effort), 0.0),
            Self::Smooth(limit) => {
                let part = (effort / limit).tanh();
                (limit * part, 1.0 - part * part)
            }
        }
    }
}

impl Servo {
    /// Whether it has numbers to remember.
    pub fn remembers(&self) -> bool {
        self.integral > 0.0 || self.sample.is_some()
    }

    /// σ at a deviation `d` from a target, with z carried on from the start of a step.
    pub fn effort(&self, target: &FunctionValue, value: f64, rate: f64, z: &Integral) -> Effort {
        let (_, [force, slope]) = self.saturated(target, value, rate, z);
        let by_value = self.proportional + 0.5 * self.integral * z.elapsed;
        Effort {
            force,
            by_value: -slope * by_value,
            by_rate: -slope * self.derivative,
        }
    }

    /// z and z' at the end of the step.
    pub fn carried(
        &self,
        target: &FunctionValue,
        value: f64,
        rate: f64,
        z: &Integral,
    ) -> (f64, f64) {
        let (u, _) = self.saturated(target, value, rate, z);
        let z_rate = target.value - value + self.unwinding(u);
        (z.value + 0.5 * z.elapsed * (z.rate + z_rate), z_rate)
    }

    /// The effort to be held from a sample on, and z at the next.
    pub fn sampled(
        &self,
        period: f64,
        target: &FunctionValue,
        value: f64,
        rate: f64,
        z: f64,
    ) -> (f64, f64) {
        let deviation = target.value - value;
        let u = self.proportional * deviation
            + self.derivative * (target.rate - rate)
            + self.integral * z;
        let (force, _) = self.limited(u);
        (force, z + period * (deviation + self.unwinding(u)))
    }

    /// (C(u) - u)/(I T).
    fn unwinding(&self, u: f64) -> f64 {
        match self.limit {
            Some(limit) if self.integral > 0.0 => {
                let reach = limit.reach();
                (u.clamp(-reach, reach) - u) / (self.integral * self.tracking_time)
            }
            _ => 0.0,
        }
    }

    fn limited(&self, u: f64) -> (f64, f64) {
        self.limit.map_or((u, 1.0), |limit| limit.of(u))
    }

    /// u, and σ with its derivative by what the coordinate gives.
    fn saturated(
        &self,
        target: &FunctionValue,
        value: f64,
        rate: f64,
        z: &Integral,
    ) -> (f64, [f64; 2]) {
        let deviation = target.value - value;
        let carried = z.value + 0.5 * z.elapsed * (z.rate + deviation);
        let asked = self.proportional * deviation
            + self.derivative * (target.rate - rate)
            + self.integral * carried;
        let (mut u, mut share) = (asked, 1.0);
        if let Some(limit) = self.limit.filter(|_| self.integral > 0.0) {
            // u + k (u - C(u)) = asked
            let (k, reach) = (0.5 * z.elapsed / self.tracking_time, limit.reach());
            if asked.abs() > reach {
                share = 1.0 / (1.0 + k);
                u = (asked + k * reach.copysign(asked)) * share;
            }
        }
        let (force, slope) = self.limited(u);
        (u, [force, slope * share])
    }
}
