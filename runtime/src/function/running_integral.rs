//! The running integral of a formula, tabulated once to near rounding.

use super::FunctionValue;
use super::formula::Formula;
use crate::Error;

/// Degree of the interpolant of each span.
const DEGREE: usize = 16;

/// Allowed error of the interpolant relative to the largest value of the formula.
const TOLERANCE: f64 = 1e-13;

/// Spans to begin with: a pulse shorter than a thousandth of the whole may be overlooked.
const FIRST_SPANS: usize = 64;

/// Halvings of a first span before giving up: a kink or a pole is then cornered in 1e-9 of the length.
const DEEPEST: u32 = 24;

/// Spans before giving up: a formula that oscillates more often is better given as its integral.
const MOST_SPANS: usize = 100_000;

/// Rounding that a time may lie outside of the table, relative to its end.
const SLACK: f64 = 1e-9;

/// ∫₀ᵗ f of a formula f for 0 ≤ t ≤ end.
///
/// Each span holds the integral of the Chebyshev interpolant of f; spans are halved until the interpolant's trailing
/// coefficients are below 1e-13 of the largest value of f, or below the rounding of the formula. Rate and second rate come from the formula itself.
#[derive(Clone, Debug, PartialEq)]
pub struct RunningIntegral {
    formula: Formula,
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
    /// [`Error::Description`] where the formula is not finite, or not smooth enough to be integrated to the tolerance.
    pub fn tabulate(formula: Formula, end: f64) -> Result<Self, Error> {
        let bound = |first: usize| end * first as f64 / FIRST_SPANS as f64;
        // Depth first, the earliest span on top: spans come out in order.
        let mut open: Vec<_> = (0..FIRST_SPANS)
            .rev()
            .map(|first| (bound(first), bound(first + 1), DEEPEST))
            .collect();
        let mut scale = 0.0_f64;
        for (start, stop, _) in &open {
            let sample = Interpolant::of(&formula, 0.5 * (start + stop), 0.5 * (stop - start))?;
            scale = scale.max(sample.largest);
        }
        let mut spans = Vec::new();
        let mut before = 0.0;
        while let Some((start, stop, halvings)) = open.pop() {
            let (centre, half) = (0.5 * (start + stop), 0.5 * (stop - start));
            let sample = Interpolant::of(&formula, centre, half)?;
            if sample.tail() <= TOLERANCE * scale + sample.rounding {
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
                    "formula",
                    format!(
                        "can't be integrated over time to 1e-12 near t = {centre}: it is not smooth there, or oscillates too \
                         often; give the integral itself as an angle or a position"
                    ),
                ));
            } else {
                open.push((centre, stop, halvings - 1));
                open.push((start, centre, halvings - 1));
            }
        }
        Ok(Self {
            formula,
            end,
            spans,
        })
    }

    /// Value and derivatives; the value is NaN outside of [0, end]. Does not allocate.
    pub fn evaluate(&self, time: f64) -> FunctionValue {
        let rate = self.formula.evaluate(time);
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
    fn of(formula: &Formula, centre: f64, half: f64) -> Result<Self, Error> {
        const COUNT: usize = DEGREE + 1;
        let angle = |node: usize| std::f64::consts::PI * (node as f64 + 0.5) / COUNT as f64;
        let mut values = [0.0; COUNT];
        let (mut largest, mut rounding) = (0.0_f64, 0.0_f64);
        for (node, value) in values.iter_mut().enumerate() {
            let time = centre + half * angle(node).cos();
            let (there, noise) = formula.evaluate_with_rounding(time);
            *value = there.value;
            if !value.is_finite() {
                return Err(Error::described(
                    "formula",
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
