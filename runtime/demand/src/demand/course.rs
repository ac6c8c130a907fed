//! A function of time over the course of a run.

use std::f64::consts::FRAC_PI_2;

use dcb_formats::Error;
use dcb_formats::function::{Function, FunctionValue, TimeFunction};
use dcb_formats::scene::Drive;

/// Samples over a run; more where a function has many points at which it may bend.
const SAMPLES: usize = 4096;
/// Samples for each such point.
const SAMPLES_PER_POINT: usize = 4;
/// Most samples.
const MOST_SAMPLES: usize = 1 << 18;
/// How far beside such a point its other side is looked at, by the length of the run.
const BESIDE: f64 = 1e-9;

/// A function of time from 0 to the end of a run.
pub(super) struct Course {
    function: TimeFunction,
    /// Times at which it may bend, or is largest.
    pub(super) special: Vec<f64>,
    /// Of a sine, cycles per time unit.
    pub(super) frequency: Option<f64>,
    pub(super) end: f64,
    pub(super) samples: usize,
}

impl Course {
    /// `None` of an input and of a controller, whose course nobody knows.
    pub(super) fn of(function: &Function, end: f64) -> Result<Option<Self>, Error> {
        match function {
            Function::Input(_) | Function::Controller(_) => Ok(None),
            _ => Ok(Some(Self::around(
                TimeFunction::new(function)?,
                function,
                end,
            ))),
        }
    }

    /// Of the driven coordinate.
    pub(super) fn of_drive(drive: &Drive, end: f64) -> Result<Option<Self>, Error> {
        let function = &drive.motion().function;
        match (drive, function) {
            (_, Function::Input(_)) => Ok(None),
            // Without a run there is no integral, and nothing moves.
            (Drive::Speed(_), Function::Formula(_) | Function::Chirp(_)) if end <= 0.0 => Ok(None),
            _ => Ok(Some(Self::around(drive.coordinate(end)?, function, end))),
        }
    }

    fn around(time_function: TimeFunction, function: &Function, end: f64) -> Self {
        let mut course = Self {
            function: time_function,
            special: Vec::new(),
            frequency: None,
            end,
            samples: SAMPLES,
        };
        match function {
            Function::Harmonic(harmonic) => {
                let omega = harmonic.radians_per_time();
                course.frequency = Some(omega / std::f64::consts::TAU);
                let first = (harmonic.phase / FRAC_PI_2).ceil();
                let quarters =
                    (0..4).map(|k| (FRAC_PI_2 * (first + f64::from(k)) - harmonic.phase) / omega);
                course.special = quarters.filter(|time| (0.0..=end).contains(time)).collect();
            }
            _ => {
                course.special = course.function.breaks(end);
                let wanted = (SAMPLES_PER_POINT * course.special.len()).next_power_of_two();
                course.samples = wanted.clamp(SAMPLES, MOST_SAMPLES);
            }
        }
        course
    }

    pub(super) fn at(&self, time: f64) -> FunctionValue {
        self.function.evaluate(time, 0.0)
    }

    /// Just before and at a time.
    pub(super) fn both_sides(&self, time: f64) -> [FunctionValue; 2] {
        [self.at((time - BESIDE * self.end).max(0.0)), self.at(time)]
    }

    /// Values at equal steps, the end left out; (samples).
    pub(super) fn sampled(&self, of: impl Fn(&FunctionValue) -> f64) -> Vec<f64> {
        let step = self.end / self.samples as f64;
        (0..self.samples)
            .map(|index| of(&self.at(index as f64 * step)))
            .collect()
    }

    /// The largest size over the run; `None` where it isn't finite.
    pub(super) fn largest(&self, of: impl Fn(&FunctionValue) -> f64) -> Option<f64> {
        let beside = self.special.iter().flat_map(|time| self.both_sides(*time));
        let largest = beside
            .chain([self.at(self.end)])
            .map(|value| of(&value))
            .chain(self.sampled(&of))
            .fold(0.0_f64, |largest, size| match size.is_nan() {
                true => f64::INFINITY,
                false => largest.max(size.abs()),
            });
        largest.is_finite().then_some(largest)
    }
}

/// Whether a function is zero at all times, as written.
pub(super) fn is_zero(function: &Function) -> bool {
    let zero = |number: &f64| *number == 0.0;
    match function {
        Function::Constant(value) => *value == 0.0,
        Function::Polynomial(coefficients) => coefficients.iter().all(zero),
        Function::Harmonic(harmonic) => harmonic.amplitude == 0.0 && harmonic.offset == 0.0,
        Function::Table(table) => table.values.iter().all(zero),
        Function::SmoothStep(step) => step.from == 0.0 && step.to == 0.0,
        Function::Trapezoid(trapezoid) => trapezoid.from == 0.0 && trapezoid.to == 0.0,
        Function::Chirp(chirp) => chirp.amplitude == 0.0 && chirp.offset == 0.0,
        Function::Pulse(pulse) => pulse.amplitude == 0.0 && pulse.offset == 0.0,
        Function::Formula(_) | Function::Input(_) | Function::Controller(_) => false,
    }
}
