//! Slopes and curvatures with which quintics through the points of a table keep their shape.
//!
//! On a span of length h and mean slope Δ the quintic with slopes d₀, d₁ and curvatures m₀, m₁ has the derivative
//!
//! ```text
//! Σ c_k B_k⁴(x),   c = [d₀,  d₀ + h m₀/4,  5 Δ - (the others),  d₁ - h m₁/4,  d₁]
//! ```
//! It has one sign where all c_k have it (Schmidt and Heß, "Positive quartic, monotone quintic C²-spline interpolation", J. Comput. Appl. Math. 55,
//! 1994). Slope and curvature are zero where the table rests: at a span without change and at the ends, beyond which it is constant; at extremes
//! the slope is zero. Elsewhere they come from the polynomial through up to five points, as in Lux, Watson et al., "Algorithm 1031: MQSI", ACM
//! Trans. Math. Softw. 49, 2023, and are made smaller as far as the condition asks. It is homogeneous in (d, m) of a point, so that one pass is
//! enough, and zeros always meet it.

/// Slope and second derivative at every point.
///
/// `times` (m ≥ 2) strictly increase, `values` are as many.
pub fn slopes_and_curvatures(times: &[f64], values: &[f64]) -> Vec<[f64; 2]> {
    let last = times.len() - 1;
    let spans: Vec<f64> = times.windows(2).map(|t| t[1] - t[0]).collect();
    let means: Vec<f64> = (values.windows(2).zip(&spans))
        .map(|(v, span)| (v[1] - v[0]) / span)
        .collect();
    let rests = |i: usize| i == 0 || i == last || means[i - 1] == 0.0 || means[i] == 0.0;
    let turns = |i: usize| !rests(i) && means[i - 1].signum() != means[i].signum();
    let mut found: Vec<[f64; 2]> = (0..=last)
        .map(|i| {
            if rests(i) {
                return [0.0; 2];
            }
            let (before, after) = (spans[i - 1], spans[i]);
            let bend = 2.0 * (means[i] - means[i - 1]) / (before + after);
            if turns(i) {
                return [0.0, bend];
            }
            // Two points on either side, none beyond one where the table rests or turns.
            let is_stop = |i: usize| rests(i) || turns(i);
            let from = if is_stop(i - 1) { i - 1 } else { i - 2 };
            let to = if is_stop(i + 1) { i + 1 } else { i + 2 };
            let [slope, curvature] = derivatives(&times[from..=to], &values[from..=to], times[i]);
            let (low, high) = match means[i - 1].abs() < means[i].abs() {
                true => (means[i - 1], means[i]),
                false => (means[i], means[i - 1]),
            };
            let part = slope / low;
            let mut at = match part >= 0.5 && slope.abs() <= 1.5 * high.abs() {
                true => [slope, curvature],
                // Where the points tell no slope: the harmonic mean of Fritsch and Butland, which lies between those of the spans.
                false => [harmonic(before, after, means[i - 1], means[i]), bend],
            };
            // c₁ of the span after and c₃ of the span before keep their sign.
            let (least, most) = (-4.0 * at[0] / after, 4.0 * at[0] / before);
            at[1] = at[1].clamp(least.min(most), least.max(most));
            at
        })
        .collect();
    let mut factors = vec![1.0_f64; times.len()];
    for (i, (span, mean)) in spans.iter().zip(&means).enumerate() {
        // What both ends take of 5 |Δ|; neither is negative.
        let sign = mean.signum();
        let [of_start, of_end] = [(i, 1.0), (i + 1, -1.0)].map(|(point, side)| {
            let [slope, curvature] = found[point];
            sign * (2.0 * slope + side * span * curvature / 4.0)
        });
        let allowed = 5.0 * mean.abs();
        if of_start + of_end <= allowed {
            continue;
        }
        let half = 0.5 * allowed;
        let (start, end) = if of_start <= half {
            (1.0, (allowed - of_start) / of_end)
        } else if of_end <= half {
            ((allowed - of_end) / of_start, 1.0)
        } else {
            (half / of_start, half / of_end)
        };
        factors[i] = factors[i].min(start);
        factors[i + 1] = factors[i + 1].min(end);
    }
    for (at, factor) in found.iter_mut().zip(factors) {
        *at = at.map(|derivative| factor * derivative);
    }
    found
}

/// Slopes of the monotone cubic of Fritsch and Butland (1984), with the one-sided slopes of Moler's `pchip` at the ends.
pub fn monotone_slopes(times: &[f64], values: &[f64]) -> Vec<f64> {
    let last = times.len() - 1;
    let spans: Vec<f64> = times.windows(2).map(|t| t[1] - t[0]).collect();
    let means: Vec<f64> = (values.windows(2).zip(&spans))
        .map(|(v, span)| (v[1] - v[0]) / span)
        .collect();
    let at_end = |own: usize, next: usize| {
        let (h, k) = (spans[own], spans[next]);
        let slope = ((2.0 * h + k) * means[own] - h * means[next]) / (h + k);
        if slope * means[own] <= 0.0 {
            0.0
        } else if means[own] * means[next] < 0.0 && slope.abs() > 3.0 * means[own].abs() {
            3.0 * means[own]
        } else {
            slope
        }
    };
    (0..=last)
        .map(|i| match i {
            _ if last == 1 => means[0],
            0 => at_end(0, 1),
            _ if i == last => at_end(last - 1, last - 2),
            _ if means[i - 1] * means[i] <= 0.0 => 0.0,
            _ => harmonic(spans[i - 1], spans[i], means[i - 1], means[i]),
        })
        .collect()
}

/// The weighted harmonic mean of two slopes of one sign.
fn harmonic(before: f64, after: f64, slope_before: f64, slope_after: f64) -> f64 {
    let (first, second) = (2.0 * after + before, after + 2.0 * before);
    (first + second) / (first / slope_before + second / slope_after)
}

/// First and second derivative at a time of the polynomial through a few points: Newton's form, differentiated term by term.
fn derivatives(times: &[f64], values: &[f64], time: f64) -> [f64; 2] {
    let mut divided = values.to_vec();
    for order in 1..times.len() {
        for i in (order..times.len()).rev() {
            divided[i] = (divided[i] - divided[i - 1]) / (times[i] - times[i - order]);
        }
    }
    // Horner's rule with its derivatives.
    let (mut value, mut slope, mut half) = (0.0, 0.0, 0.0);
    for (coefficient, at) in divided.iter().zip(times).rev() {
        let x = time - at;
        half = half * x + slope;
        slope = slope * x + value;
        value = value * x + coefficient;
    }
    [slope, 2.0 * half]
}
