//! Efforts of actuators on one coordinate.
//!
//! An effort σ(e, e', t) is conjugate to the coordinate e and positive where it makes e grow. It doesn't increase with e or e' but for
//! Stribeck's falling friction, so that a Newton iteration can look for it where the coordinate's own motion meets it ([`meeting`]).

mod controller;
mod end_stop;
mod friction;
mod servo;

pub use controller::{Controller, Sense, Timing};
pub use end_stop::{End, EndStop};
pub use friction::Friction;
pub use servo::{Integral, Limit, Servo};

/// An effort and its derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effort {
    /// σ.
    pub force: f64,
    /// ∂σ/∂e.
    pub by_value: f64,
    /// ∂σ/∂e'.
    pub by_rate: f64,
}

/// What gives an actuator its effort.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// A function of time, by its index.
    Given(usize),
    /// A controller, by its index.
    Controlled(usize),
    /// A servo, and the index of its target's function of time.
    Servo(Servo, usize),
    /// Friction.
    Friction(Friction),
    /// End stops.
    EndStop(EndStop),
}

/// One actuator of a system.
#[derive(Clone, Debug, PartialEq)]
pub struct Actuator {
    /// Its row.
    pub row: usize,
    /// Value of the row's measure at which the coordinate is zero.
    pub zero: f64,
    /// What gives its effort.
    pub source: Source,
    /// The first of its numbers in [`crate::system::State::memory`].
    pub memory: usize,
}

impl Source {
    /// Index of the function of time that the effort follows at once, if it follows one.
    pub fn signal(&self) -> Option<usize> {
        match self {
            Self::Given(signal) | Self::Servo(_, signal) => Some(*signal),
            Self::Controlled(_) | Self::Friction(_) | Self::EndStop(_) => None,
        }
    }

    /// How many numbers an actuator remembers from step to step.
    pub fn memory_count(&self) -> usize {
        match self {
            Self::Given(_) | Self::Controlled(_) | Self::Friction(_) => 0,
            // Deviation's integral, its rate and the time; or effort held, integral and number of samples.
            Self::Servo(servo, _) if servo.remembers() => 3,
            Self::Servo(..) => 0,
            // The coordinate and its rate.
            Self::EndStop(_) => 2,
        }
    }

    /// Whether the effort bends or saturates, so that Newton's straight lines alone may miss it.
    pub fn bends(&self) -> bool {
        match self {
            Self::Given(_) | Self::Controlled(_) => false,
            Self::Servo(servo, _) => servo.limit.is_some() && servo.sample.is_none(),
            Self::Friction(_) | Self::EndStop(_) => true,
        }
    }
}

/// Iterations of a scalar equation whose root is bracketed.
const MOST_ITERATIONS: usize = 100;
/// Doublings of a bracket: for efforts that grow with the coordinate somewhere.
const MOST_DOUBLINGS: usize = 60;
/// Part of the first change to which a root is found.
const FOUND: f64 = 1e-14;

/// Where an effort meets the coordinate's own motion: the change δ of the coordinate with `λ + δ/mobility = σ(δ)`, and σ there.
///
/// `effort` gives σ and dσ/dδ; the mobility is δ by a unit force, everything else of the system following. Newton's method within a
/// bracket.
pub fn meeting(lambda: f64, mobility: f64, effort: impl Fn(f64) -> (f64, f64)) -> (f64, f64) {
    // h rises by one or more with δ where σ doesn't rise.
    let h = |delta: f64| {
        let (force, slope) = effort(delta);
        (
            delta + mobility * (lambda - force),
            1.0 - mobility * slope,
            force,
        )
    };
    let (first, _, force) = h(0.0);
    if first == 0.0 || !first.is_finite() {
        return (0.0, force);
    }
    let (mut low, mut high) = match first > 0.0 {
        true => (-first, 0.0),
        false => (0.0, -first),
    };
    for _ in 0..MOST_DOUBLINGS {
        if h(low).0 <= 0.0 && h(high).0 >= 0.0 {
            break;
        }
        let width = high - low;
        (low, high) = match first > 0.0 {
            true => (low - width, high),
            false => (low, high + width),
        };
    }
    let mut delta = 0.5 * (low + high);
    let mut found = force;
    for _ in 0..MOST_ITERATIONS {
        let (value, slope, force) = h(delta);
        found = force;
        match value > 0.0 {
            true => high = delta,
            false => low = delta,
        }
        let next = delta - value / slope;
        let next = match next > low && next < high {
            true => next,
            false => 0.5 * (low + high),
        };
        if (next - delta).abs() <= FOUND * first.abs() {
            break;
        }
        delta = next;
    }
    (delta, found)
}
