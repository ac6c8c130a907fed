//! Functions of time that drives, loads and inputs follow.
//!
//! [`Function`] is the description, as a scene writes it; [`TimeFunction`] is the same, checked and ready to be evaluated with its
//! first and second derivative, or the integral of it where a drive prescribes a speed.

mod chirp;
mod description;
mod elementary;
mod formula;
mod formula_parser;
mod formula_text;
mod output_formula;
mod piecewise;
mod pulse;
mod running_integral;
mod smooth_step;
mod smooth_table;
mod trapezoid;

pub use chirp::{Chirp, Sweep};
pub use description::{Function, Harmonic, InputSignal, Interpolation, Table};
pub use formula_text::FormulaText;
pub use output_formula::{OutputComponent, OutputFormula};
pub use pulse::{Pulse, Shape};
pub use smooth_step::{Profile, SmoothStep};
pub use trapezoid::Trapezoid;

pub(crate) use description::FunctionKey;
pub(crate) use formula::check_constant;

use crate::Error;
use formula::Formula;
use piecewise::{Piecewise, polynomial};
use running_integral::{Integrand, RunningIntegral};
use smooth_step::Cycloid;

/// A function of time at one time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FunctionValue {
    /// The value itself.
    pub value: f64,
    /// First derivative, 1/time.
    pub rate: f64,
    /// Second derivative, 1/time².
    pub second_rate: f64,
}

/// A function of time that has been checked and can be evaluated.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeFunction(FunctionForm);

#[derive(Clone, Debug, PartialEq)]
enum FunctionForm {
    Polynomial(Vec<f64>),
    Wave(Wave),
    Piecewise(Piecewise),
    Law(Law),
    /// The antiderivative of a law, less its value at time zero.
    IntegratedLaw(Law, f64),
    Chirp(Chirp),
    Formula(Formula),
    RunningIntegral(RunningIntegral),
    Input,
}

/// A motion law whose integral is known in closed form.
#[derive(Clone, Debug, PartialEq)]
enum Law {
    Cycloid(Cycloid),
    Pulse(Pulse),
}

impl Law {
    fn evaluate(&self, time: f64) -> FunctionValue {
        match self {
            Self::Cycloid(cycloid) => cycloid.evaluate(time),
            Self::Pulse(pulse) => pulse.evaluate(time),
        }
    }

    fn antiderivative(&self, time: f64) -> f64 {
        match self {
            Self::Cycloid(cycloid) => cycloid.antiderivative(time),
            Self::Pulse(pulse) => pulse.antiderivative(time),
        }
    }
}

/// offset + drift t + amplitude sin(ω t + phase): a harmonic, or the integral of one.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Wave {
    offset: f64,
    drift: f64,
    amplitude: f64,
    angular_frequency: f64,
    phase: f64,
}

impl TimeFunction {
    /// Checks a description and makes it ready.
    ///
    /// # Errors
    /// [`Error::Description`] with the key, what was found and what would be right: numbers that are not finite, tables
    /// whose times don't strictly increase, formulas that can't be read.
    pub fn new(function: &Function) -> Result<Self, Error> {
        function.check()?;
        Ok(Self(match function {
            Function::Constant(value) => FunctionForm::Polynomial(vec![*value]),
            Function::Polynomial(coefficients) => FunctionForm::Polynomial(coefficients.clone()),
            Function::Harmonic(harmonic) => FunctionForm::Wave(Wave {
                offset: harmonic.offset,
                drift: 0.0,
                amplitude: harmonic.amplitude,
                angular_frequency: harmonic.radians_per_time(),
                phase: harmonic.phase,
            }),
            Function::Table(table) => FunctionForm::Piecewise(match table.interpolation {
                Interpolation::Smooth => Piecewise::smooth(&table.times, &table.values),
                Interpolation::Pchip => Piecewise::monotone(&table.times, &table.values),
                Interpolation::Spline => Piecewise::spline(&table.times, &table.values),
                Interpolation::Linear => Piecewise::linear(&table.times, &table.values),
            }),
            Function::SmoothStep(step) => match step.profile {
                Profile::Polynomial => FunctionForm::Piecewise(step.quintic()),
                Profile::Cycloidal => FunctionForm::Law(Law::Cycloid(step.cycloid())),
            },
            Function::Trapezoid(trapezoid) => FunctionForm::Piecewise(trapezoid.piecewise()),
            Function::Chirp(chirp) => FunctionForm::Chirp(*chirp),
            Function::Pulse(pulse) => FunctionForm::Law(Law::Pulse(*pulse)),
            Function::Formula(formula) => {
                FunctionForm::Formula(Formula::parse(&formula.text, &formula.constants)?)
            }
            Function::Input(_) => FunctionForm::Input,
            Function::Controller(_) => {
                return Err(Error::described(
                    "controller",
                    "is no function of time; only the actuators torque and force follow a controller",
                ));
            }
        }))
    }

    /// The integral of a function from time zero: the angle of a drive that prescribes a speed.
    ///
    /// Exact to rounding at all times, but for formulas and chirps: their integral is tabulated for 0 ≤ t ≤ `end` to 1e-12 of their
    /// largest value times `end`, kinks and jumps included; it is NaN outside. A pulse in a formula that is shorter than a thousandth of `end`
    /// may be overlooked.
    ///
    /// # Errors
    /// As [`TimeFunction::new`]; also for an input, whose future is not known, and for a formula that is not finite.
    pub fn integral_of(function: &Function, end: f64) -> Result<Self, Error> {
        let Self(kind) = Self::new(function)?;
        Ok(Self(match kind {
            FunctionForm::Polynomial(coefficients) => FunctionForm::Polynomial(
                std::iter::once(0.0)
                    .chain(
                        coefficients
                            .iter()
                            .enumerate()
                            .map(|(power, c)| c / (power + 1) as f64),
                    )
                    .collect(),
            ),
            FunctionForm::Wave(wave) => FunctionForm::Wave(wave.integral()),
            FunctionForm::Piecewise(table) => FunctionForm::Piecewise(table.integral()),
            FunctionForm::Law(law) => {
                let at_zero = law.antiderivative(0.0);
                FunctionForm::IntegratedLaw(law, at_zero)
            }
            FunctionForm::Formula(formula) => {
                tabulated(Integrand::Formula(formula), "formula", end)?
            }
            FunctionForm::Chirp(chirp) => tabulated(Integrand::Chirp(chirp), "chirp", end)?,
            FunctionForm::Input
            | FunctionForm::RunningIntegral(_)
            | FunctionForm::IntegratedLaw(..) => {
                return Err(Error::described(
                    "input",
                    "can't be integrated over time, because its future is not known; drive the angle or the position",
                ));
            }
        }))
    }

    /// Times from zero to an end at which the value or a derivative may jump, ascending.
    pub fn breaks(&self, end: f64) -> Vec<f64> {
        let mut breaks = match &self.0 {
            FunctionForm::Piecewise(table) => table.breaks().to_vec(),
            FunctionForm::Law(law) | FunctionForm::IntegratedLaw(law, _) => match law {
                Law::Cycloid(cycloid) => cycloid.breaks(),
                Law::Pulse(pulse) => pulse.breaks(end),
            },
            FunctionForm::Chirp(chirp) => chirp.breaks(),
            FunctionForm::Formula(formula) => formula.breaks(end),
            FunctionForm::RunningIntegral(integral) => integral.breaks(),
            FunctionForm::Polynomial(_) | FunctionForm::Wave(_) | FunctionForm::Input => Vec::new(),
        };
        breaks.retain(|time| (0.0..=end).contains(time));
        breaks
    }

    /// Value and derivatives at a time; `input` is the value of an [`Function::Input`] and has no effect on other kinds.
    ///
    /// A formula may have no finite value or derivative at some time (`sqrt(t)` at zero): the numbers are then not finite
    /// either. Does not allocate.
    pub fn evaluate(&self, time: f64, input: f64) -> FunctionValue {
        match &self.0 {
            FunctionForm::Polynomial(coefficients) => polynomial(coefficients, time),
            FunctionForm::Wave(wave) => wave.evaluate(time),
            FunctionForm::Piecewise(table) => table.evaluate(time),
            FunctionForm::Law(law) => law.evaluate(time),
            FunctionForm::IntegratedLaw(law, at_zero) => {
                let rate = law.evaluate(time);
                FunctionValue {
                    value: law.antiderivative(time) - at_zero,
                    rate: rate.value,
                    second_rate: rate.rate,
                }
            }
            FunctionForm::Chirp(chirp) => chirp.evaluate(time),
            FunctionForm::Formula(formula) => formula.evaluate(time),
            FunctionForm::RunningIntegral(integral) => integral.evaluate(time),
            FunctionForm::Input => FunctionValue {
                value: input,
                ..FunctionValue::default()
            },
        }
    }
}

/// The integral of what has none in closed form.
fn tabulated(integrand: Integrand, key: &str, end: f64) -> Result<FunctionForm, Error> {
    if end > 0.0 {
        return Ok(FunctionForm::RunningIntegral(RunningIntegral::tabulate(
            integrand, end,
        )?));
    }
    Err(Error::described(
        key,
        format!("can't be integrated over time up to {end}; expected an end > 0"),
    ))
}

impl Wave {
    fn evaluate(&self, time: f64) -> FunctionValue {
        let omega = self.angular_frequency;
        let (sin, cos) = (omega * time + self.phase).sin_cos();
        FunctionValue {
            value: self.offset + self.drift * time + self.amplitude * sin,
            rate: self.drift + self.amplitude * omega * cos,
            second_rate: -self.amplitude * omega * omega * sin,
        }
    }

    /// ∫₀ᵗ (offset + A sin(ω t + φ)) = offset t + A/ω (cos φ - cos(ω t + φ)); of a wave without drift.
    fn integral(&self) -> Self {
        let amplitude = self.amplitude / self.angular_frequency;
        Self {
            offset: amplitude * self.phase.cos(),
            drift: self.offset,
            amplitude,
            angular_frequency: self.angular_frequency,
            phase: self.phase - std::f64::consts::FRAC_PI_2,
        }
    }
}
