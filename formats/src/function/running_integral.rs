//! The running integral of a formula or a chirp, tabulated once to near rounding.

use super::FunctionValue;
use super::chirp::Chirp;
use super::formula::Formula;
use crate::Error;

/// Degree of the interpolant of each span.
const DEGREE: usize = 16;

/// Allowed error of the interpolant relative to the largest value of the formula.
const TOLERANCE: f64 = 1e-13;

/// Allowed error of the integral of a span that isn't smooth, relative to the largest value times the whole length: its kink or jump is cornered
/// until no more than this depends on it.
const CORNERED: f64 = 1e-13;

/// Spans to begin with: a pulse shorter than a thousandth of the whole may be overlooked.
const FIRST_SPANS: usize = 64;

/// Rounding of the values may leave no more than this of the integral unknown, by the same measure: close to a pole it exceeds all else.
const ROUNDED: f64 = 1e-9;

/// Halvings of a first span before giving up: a jump is then cornered in 1e-14 of the length; in less, rounding of the time would make a pole flat.
const DEEPEST: u32 = 40;

/// Spans before giving up: a formula that oscillates more often is better given as its integral.
const MOST_SPANS: usize = 100_000;

/// Rounding that a time may lie outside of the table, relative to its end.
const SLACK: f64 = 1e-9;

/// Integrand.
#[derive(Clone, Debug, PartialEq)]
pub enum Integrand {
    /// A formula.
    Formula(Formula),
    /// A chirp, whose integral no elementary function is.
    Chirp(Chirp),
}

impl Integrand {
    fn evaluate(&self, time: f64) -> FunctionValue {
        match self {
            Self::Formula(formula) => formula.evaluate(time),
            Self::Chirp(chirp) => chirp.evaluate(time),
        }
    }

    fn key(&self) -> &'static str {
        match self {
            Self::Formula(_) => "formula",
            Self::Chirp(_) => "chirp",
        }
    }

    /// The value, and about how much rounding there may be in it.
    fn sample(&self, time: f64) -> (f64, f64) {
        match self {
            Self::Formula(formula) => {
                let (at, rounding) = formula.evaluate_with_rounding(time);
                (at.value, rounding)
            }
            Self::Chirp(chirp) => (chirp.evaluate(time).value, chirp.rounding(time)),
        }
    }
}

/// ∫₀ᵗ f of a function f for 0 ≤ t ≤ end.
///
/// Each span holds the integral of the Chebyshev interpolant of f; spans are halved until the interpolant's trailing
/// coefficients are below 1e-13 of the largest value of f, or below the rounding of f, or until the span is so short that its kink or jump doesn't count.
/// Rate and second rate come from f itself.
#[derive(Clone, Debug, PartialEq)]
pub struct RunningIntegral {
    integrand: Integrand,
    end: f64,
    /// Spans in order; together they cover [0, end].
    spans: Vec<Span>,
}

#[derive(Clone, Debug, PartialEq)]
struct Span {
    centre: f64,
    half: f64,
    /// Integral from zero to the start of the span.
    before: f64,
    /// Chebyshev coefficients of the integral from the start of the span.
    series: [f64; DEGREE + 2],
}

impl RunningIntegral {
    /// Tabulates the integral up to `end` > 0.
    ///
    /// # Errors
    /// [`Error::Description`] where the function is not finite, or can't be integrated to the tolerance.
    pub fn tabulate(integrand: Integrand, end: f64) -> Result<Self, Error> {
        let bound = |first: usize| end * first as f64 / FIRST_SPANS as f64;
        // Depth first, the earliest span on top: spans come out in order.
        let mut open: Vec<_> = (0..FIRST_SPANS)
            .rev()
            .map(|first| (bound(first), bound(first + 1), DEEPEST))
            .collect();
        let mut scale = 0.0_f64;
        for (start, stop, _) in &open {
            let sample = Interpolant::of(&integrand, 0.5 * (start + stop), 0.5 * (stop - start))?;
            scale = scale.max(sample.largest);
        }
        let mut spans = Vec::new();
        let mut before = 0.0;
        while let Some((start, stop, halvings)) = open.pop() {
            let (centre, half) = (0.5 * (start + stop), 0.5 * (stop - start));
            let sample = Interpolant::of(&integrand, centre, half)?;
            let tail = sample.tail();
            let unknown = tail * half / (scale * end);
            let is_smooth = tail <= TOLERANCE * scale
                || tail <= TOLERANCE * scale + sample.rounding && unknown <= ROUNDED;
            if is_smooth || unknown <= CORNERED {
                let series = integrated(&sample.series, half);
                spans.push(Span {
                    centre,
                    half,
                    before,
                    series,
                });
                before += clenshaw(&series, 1.0);
            } else if halvings == 0 || spans.len() + open.len() > MOST_SPANS {
                return Err(Error::described(
                    integrand.key(),
                    format!(
                        "can't be integrated over time to 1e-12 near t = {centre}: it is too large there, or jumps or oscillates too \
                         often; give the integral itself as an angle or a position"
                    ),
                ));
            } else {
                open.push((centre, stop, halvings - 1));
                open.push((start, centre, halvings - 1));
            }
        }
        Ok(Self {
            integrand,
            end,
            spans,
        })
    }

    /// Times at which a derivative jumps, of the integrand.
    pub fn breaks(&self) -> Vec<f64> {
        match &self.integrand {
            Integrand::Formula(formula) => formula.breaks(self.end),
            Integrand::Chirp(chirp) => chirp.breaks(),
        }
    }

    /// Value and derivatives; the value is NaN outside of [0, end]. Does not allocate.
    pub fn evaluate(&self, time: f64) -> FunctionValue {
        let rate = self.integrand.evaluate(time);
        let inside = time.clamp(0.0, self.end);
        let beyond = time - inside;
        let value = if beyond.abs() <= SLACK * self.end {
            let next = self
                .spans
                .partition_point(|span| span.centre - span.half <= inside);
            let span = &self.spans[next.max(1) - 1];
            let within = ((inside - span.centre) / span.half).clamp(-1.0, 1.0);
            span.before + clenshaw(&span.series, within) + beyond * rate.value
        } else {
            f64::NAN
        };
        FunctionValue {
            value,
            rate: rate.value,
            second_rate: rate.rate,
        }
    }
}

/// The polynomial through the values of the formula at the Chebyshev points of a span.
struct Interpolant {
    /// Chebyshev coefficients.
    series: [f64; DEGREE + 1],
    /// Largest value met.
    largest: f64,
    /// Largest rounding of the values.
    rounding: f64,
}

impl Interpolant {
    fn of(integrand: &Integrand, centre: f64, half: f64) -> Result<Self, Error> {
        const COUNT: usize = DEGREE + 1;
        let angle = |node: usize| std::f64::consts::PI * (node as f64 + 0.5) / COUNT as f64;
        let mut values = [0.0; COUNT];
        let (mut largest, mut rounding) = (0.0_f64, 0.0_f64);
        for (node, value) in values.iter_mut().enumerate() {
            let time = centre + half * angle(node).cos();
            let noise;
            (*value, noise) = integrand.sample(time);
            if !value.is_finite() {
                return Err(Error::described(
                    integrand.key(),
                    format!(
                        "is {value} at t = {time}; it must be finite to be integrated over time"
                    ),
                ));
            }
            largest = largest.max(value.abs());
            if noise.is_finite() {
                rounding = rounding.max(noise);
            }
        }
        let mut series = [0.0; COUNT];
        for (degree, coefficient) in series.iter_mut().enumerate() {
            let sum: f64 = values
                .iter()
                .enumerate()
                .map(|(node, value)| value * (degree as f64 * angle(node)).cos())
                .sum();
            *coefficient = sum * if degree == 0 { 1.0 } else { 2.0 } / COUNT as f64;
        }
        Ok(Self {
            series,
            largest,
            rounding,
        })
    }

    /// Size of the trailing coefficients, of both parities: what a higher degree would still change.
    fn tail(&self) -> f64 {
        self.series[DEGREE - 2..].iter().map(|c| c.abs()).sum()
    }
}

/// The integral of a Chebyshev series from the start of its span: ∫ T_k = T_{k+1} / 2(k+1) - T_{k-1} / 2(k-1).
fn integrated(series: &[f64; DEGREE + 1], half: f64) -> [f64; DEGREE + 2] {
    let coefficient = |degree: usize| series.get(degree).copied().unwrap_or(0.0);
    let mut integral = [0.0; DEGREE + 2];
    for (degree, entry) in integral.iter_mut().enumerate().skip(1) {
        let lower = coefficient(degree - 1) * if degree == 1 { 2.0 } else { 1.0 };
        *entry = half * (lower - coefficient(degree + 1)) / (2.0 * degree as f64);
    }
    integral[0] = -clenshaw(&integral, -1.0);
    integral
}

/// Σ c_k T_k(x).
fn clenshaw(series: &[f64], x: f64) -> f64 {
    let (mut newer, mut older) = (0.0, 0.0);
    for coefficient in series[1..].iter().rev() {
        (newer, older) = (2.0 * x * newer - older + coefficient, newer);
    }
    x * newer - older + series[0]
}
