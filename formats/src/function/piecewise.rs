//! Piecewise polynomials: tables of values, and their integrals.

use super::FunctionValue;
use super::smooth_table::{monotone_slopes, slopes_and_curvatures};

/// A function made of polynomials between break points; the first and the last piece reach to infinity.
#[derive(Clone, Debug, PartialEq)]
pub struct Piecewise {
    /// (m), strictly increasing.
    breaks: Vec<f64>,
    /// (m + 1) pieces: piece i > 0 begins at break i - 1.
    pieces: Vec<[f64; COEFFICIENTS]>,
}

/// A quintic and one integration.
const COEFFICIENTS: usize = 7;

impl Piecewise {
    /// Straight lines between the points, constant beyond the ends.
    ///
    /// `times` (m ≥ 2) strictly increase, `values` are as many; the caller has checked both.
    pub fn linear(times: &[f64], values: &[f64]) -> Self {
        Self::between(times, values, |left, right, span| {
            [left, (right - left) / span, 0.0, 0.0, 0.0, 0.0]
        })
    }

    /// One value at all times.
    pub fn constant(time: f64, value: f64) -> Self {
        Self::pieces(vec![time], value, &[], value)
    }

    /// Cubics after each of `breaks` but the last, in the time since; constant beyond.
    pub fn pieces(breaks: Vec<f64>, before: f64, cubics: &[[f64; 4]], after: f64) -> Self {
        let whole = |[a, b, c, d]: [f64; 4]| [a, b, c, d, 0.0, 0.0, 0.0];
        let constant = |value: f64| whole([value, 0.0, 0.0, 0.0]);
        let inner = cubics.iter().map(|cubic| whole(*cubic));
        let pieces = std::iter::once(constant(before));
        let pieces = pieces.chain(inner).chain([constant(after)]).collect();
        Self { breaks, pieces }
    }

    /// The monotone cubic of Fritsch and Butland through the points, constant beyond the ends; the rate is continuous between the ends.
    pub fn monotone(times: &[f64], values: &[f64]) -> Self {
        let slopes = monotone_slopes(times, values);
        let mut index = 0;
        Self::between(times, values, |left, right, span| {
            let [start, end] = [slopes[index], slopes[index + 1]];
            index += 1;
            let mean = (right - left) / span;
            [
                left,
                start,
                (3.0 * mean - 2.0 * start - end) / span,
                (start + end - 2.0 * mean) / (span * span),
                0.0,
                0.0,
            ]
        })
    }

    /// Quintics through the points that rise where they rise, rest where they rest and fall where they fall; twice continuously
    /// differentiable everywhere.
    pub fn smooth(times: &[f64], values: &[f64]) -> Self {
        Self::quintic(times, values, &slopes_and_curvatures(times, values))
    }

    /// Quintics from value, slope and second derivative at the points; constant beyond the ends.
    pub fn quintic(times: &[f64], values: &[f64], derivatives: &[[f64; 2]]) -> Self {
        let mut index = 0;
        Self::between(times, values, |left, right, h| {
            let [[d0, m0], [d1, m1]] = [derivatives[index], derivatives[index + 1]];
            index += 1;
            let (c, d, e) = (
                right - left - h * (d0 + 0.5 * h * m0),
                h * (d1 - d0 - h * m0),
                h * h * (m1 - m0),
            );
            let cube = h * h * h;
            [
                left,
                d0,
                0.5 * m0,
                (10.0 * c - 4.0 * d + 0.5 * e) / cube,
                (-15.0 * c + 7.0 * d - e) / (cube * h),
                (6.0 * c - 3.0 * d + 0.5 * e) / (cube * h * h),
            ]
        })
    }

    /// The natural cubic spline through the points, constant beyond the ends.
    ///
    /// Value, slope and curvature are continuous between the ends; the curvature is zero at the ends. `times` (m ≥ 2) strictly
    /// increase, `values` are as many; the caller has checked both.
    pub fn spline(times: &[f64], values: &[f64]) -> Self {
        let curvatures = natural_curvatures(times, values);
        let mut index = 0;
        Self::between(times, values, |left, right, span| {
            let (start, end) = (curvatures[index], curvatures[index + 1]);
            index += 1;
            [
                left,
                (right - left) / span - span * (2.0 * start + end) / 6.0,
                start / 2.0,
                (end - start) / (6.0 * span),
                0.0,
                0.0,
            ]
        })
    }

    /// One quintic from the values at both ends and the length of every span.
    fn between(
        times: &[f64],
        values: &[f64],
        mut quintic: impl FnMut(f64, f64, f64) -> [f64; 6],
    ) -> Self {
        let constant = |value: f64| [value, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let inner = times.windows(2).zip(values.windows(2)).map(|(t, v)| {
            let [a, b, c, d, e, f] = quintic(v[0], v[1], t[1] - t[0]);
            [a, b, c, d, e, f, 0.0]
        });
        let pieces = values[..1]
            .iter()
            .map(|first| constant(*first))
            .chain(inner)
            .chain(
                values[values.len() - 1..]
                    .iter()
                    .map(|last| constant(*last)),
            )
            .collect();
        Self {
            breaks: times.to_vec(),
            pieces,
        }
    }

    /// The integral from time zero, exact to rounding. Of a function without terms of sixth order, thus not twice.
    pub fn integral(&self) -> Self {
        let mut pieces: Vec<_> = self
            .pieces
            .iter()
            .map(|[a, b, c, d, e, f, _]| [0.0, *a, b / 2.0, c / 3.0, d / 4.0, e / 5.0, f / 6.0])
            .collect();
        // Each piece starts where the one before ended; the first two start at the same point.
        for piece in 2..pieces.len() {
            let span = self.breaks[piece - 1] - self.breaks[piece - 2];
            pieces[piece][0] = polynomial(&pieces[piece - 1], span).value;
        }
        let mut integral = Self {
            breaks: self.breaks.clone(),
            pieces,
        };
        let at_zero = integral.evaluate(0.0).value;
        for piece in &mut integral.pieces {
            piece[0] -= at_zero;
        }
        integral
    }

    /// Times at which a derivative may jump.
    pub fn breaks(&self) -> &[f64] {
        &self.breaks
    }

    /// Value and derivatives; at a break those of the piece to the right. Does not allocate.
    pub fn evaluate(&self, time: f64) -> FunctionValue {
        let piece = self.breaks.partition_point(|start| *start <= time);
        let origin = self.breaks[piece.max(1) - 1];
        polynomial(&self.pieces[piece], time - origin)
    }
}

/// Value and derivatives of Σ c_k xᵏ by Horner's rule.
pub fn polynomial(coefficients: &[f64], x: f64) -> FunctionValue {
    let (mut value, mut rate, mut half_second) = (0.0, 0.0, 0.0);
    for coefficient in coefficients.iter().rev() {
        half_second = half_second * x + rate;
        rate = rate * x + value;
        value = value * x + coefficient;
    }
    FunctionValue {
        value,
        rate,
        second_rate: 2.0 * half_second,
    }
}

/// Second derivatives of the natural cubic spline at its points: a tridiagonal system, diagonally dominant.
fn natural_curvatures(times: &[f64], values: &[f64]) -> Vec<f64> {
    let count = times.len();
    let mut curvatures = vec![0.0; count];
    let mut ratios = vec![0.0; count];
    // h_{i-1} m_{i-1} + 2 (h_{i-1} + h_i) m_i + h_i m_{i+1} = 6 (slope_i - slope_{i-1})
    for i in 1..count - 1 {
        let (before, after) = (times[i] - times[i - 1], times[i + 1] - times[i]);
        let bend = (values[i + 1] - values[i]) / after - (values[i] - values[i - 1]) / before;
        let pivot = 2.0 * (before + after) - before * ratios[i - 1];
        ratios[i] = after / pivot;
        curvatures[i] = (6.0 * bend - before * curvatures[i - 1]) / pivot;
    }
    for i in (1..count - 1).rev() {
        curvatures[i] -= ratios[i] * curvatures[i + 1];
    }
    curvatures
}
