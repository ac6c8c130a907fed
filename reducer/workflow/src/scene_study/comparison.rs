//! How far two runs are apart, quantity by quantity.
//!
//! ```text
//! maximum   max over the times of |u − v|        |·| over the columns of the quantity
//! rms       √(mean over the times of |u − v|²)
//! range     √(Σ (max v − min v)² over the columns), the diagonal of the box that the reference stays in
//! ```

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::grid::Trace;
use super::subject::Quantity;

/// A range below this part of the largest value is rounding: the quantity is constant, and its size is the scale.
const CONSTANT: f64 = 1e-9;

/// The largest and the mean square distance of two runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Distance {
    /// Largest, in the quantity's unit.
    pub maximum: f64,
    /// Root of the mean of squares, in the quantity's unit.
    pub rms: f64,
}

impl Distance {
    /// Between two traces in the columns of a quantity, as far as both go.
    pub fn between(a: &Trace, b: &Trace, columns: Range<usize>) -> Self {
        let count = a.len().min(b.len());
        let (mut largest, mut sum) = (0.0_f64, 0.0);
        for index in 0..count {
            let (Some(a), Some(b)) = (a.row(index), b.row(index)) else {
                continue;
            };
            let pairs = a[columns.clone()].iter().zip(&b[columns.clone()]);
            let square: f64 = pairs.map(|(a, b)| (a - b).powi(2)).sum();
            largest = largest.max(square);
            sum += square;
        }
        Self {
            maximum: largest.sqrt(),
            rms: (sum / count.max(1) as f64).sqrt(),
        }
    }

    /// Both times a factor.
    pub fn scaled(self, factor: f64) -> Self {
        Self {
            maximum: factor * self.maximum,
            rms: factor * self.rms,
        }
    }
}

/// Reference size of a quantity's errors: its range, or its size where it is constant; `None` where it is zero.
pub fn scale(trace: &Trace, columns: Range<usize>) -> Option<f64> {
    let (mut ranges, mut sizes) = (0.0, 0.0);
    for column in columns {
        let values = trace.values.iter().skip(column).step_by(trace.width);
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values {
            (least, most) = (least.min(*value), most.max(*value));
        }
        if least <= most {
            ranges += (most - least).powi(2);
            sizes += least.abs().max(most.abs()).powi(2);
        }
    }
    let (range, size) = (f64::sqrt(ranges), f64::sqrt(sizes));
    let scale = if range > CONSTANT * size { range } else { size };
    (scale > 0.0).then_some(scale)
}

/// The columns of each quantity in a trace.
pub fn places(quantities: &[Quantity]) -> Vec<Range<usize>> {
    let mut first = 0;
    quantities
        .iter()
        .map(|quantity| {
            let range = first..first + quantity.width();
            first = range.end;
            range
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_and_ranges_are_those_of_vectors() {
        let trace = |values: &[f64]| Trace {
            width: 2,
            values: values.to_vec(),
        };
        let still = trace(&[0.0, 5.0, 0.0, 5.0]);
        let moving = trace(&[3.0, 9.0, 0.0, 5.0, 7.0, 7.0]);
        let distance = Distance::between(&moving, &still, 0..2);
        assert!((distance.maximum - 5.0).abs() < 1e-15);
        assert!((distance.rms - (25.0_f64 / 2.0).sqrt()).abs() < 1e-15);
        assert_eq!(Distance::between(&moving, &still, 1..2).maximum, 4.0);
        // 7 by 4; a constant has its size, nothing has none.
        assert_eq!(scale(&moving, 0..2), Some(65.0_f64.sqrt()));
        assert_eq!(scale(&still, 0..2), Some(5.0));
        assert_eq!(scale(&still, 0..1), None);
    }
}
