//! Interpolation at the Chebyshev points of an interval: of a function that is analytic as far as its poles, each point more takes a factor off the error.

use std::f64::consts::PI;

use faer::c64;

/// Interpolation is off by this part of a function's size near its poles: between the points, where it is smaller, that is below rounding.
const TRUNCATION: f64 = 1e-20;
/// Points for a polynomial of a low degree, which has no poles.
const LEAST: f64 = 12.0;

/// Chebyshev points of the first kind, and the weights of the barycentric formula (Berrut and Trefethen, Barycentric Lagrange interpolation, 2004, equation 5.3).
pub(super) struct ChebyshevPoints {
    pub places: Vec<f64>,
    weights: Vec<f64>,
}

impl ChebyshevPoints {
    /// As many points as functions with these poles need; `None` if they need more than so many.
    pub(super) fn for_poles(
        ends: [f64; 2],
        poles: impl Iterator<Item = c64>,
        most: usize,
    ) -> Option<Self> {
        let [middle, half] = [0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0])];
        // The ellipse with ends at -1 and 1 that a pole lies on: the sum of its half axes.
        let ellipse = |pole: c64| {
            let place = (pole - middle) / half;
            let root = (place * place - 1.0).sqrt();
            (place + root).norm().max((place - root).norm())
        };
        let mut nearest = f64::INFINITY;
        for size in poles.map(ellipse) {
            if size.is_nan() {
                return None;
            }
            nearest = nearest.min(size);
        }
        let count = (TRUNCATION.ln() / -nearest.ln()).ceil().max(LEAST);
        (half > 0.0 && nearest > 1.0 && count <= most as f64)
            .then(|| Self::new(middle, half, count as usize))
    }

    fn new(middle: f64, half: f64, count: usize) -> Self {
        let angle = |k: usize| PI * (2 * k + 1) as f64 / (2 * count) as f64;
        let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        Self {
            places: (0..count).map(|k| middle + half * angle(k).cos()).collect(),
            weights: (0..count).map(|k| sign(k) * angle(k).sin()).collect(),
        }
    }

    /// How much of its value at each point a function has at a place.
    pub(super) fn shares(&self, place: f64) -> Vec<f64> {
        if let Some(known) = self.places.iter().position(|known| *known == place) {
            let share = |k: usize| f64::from(u8::from(k == known));
            return (0..self.places.len()).map(share).collect();
        }
        let pairs = self.places.iter().zip(&self.weights);
        let parts: Vec<f64> = pairs.map(|(known, w)| w / (place - known)).collect();
        let sum: f64 = parts.iter().sum();
        parts.into_iter().map(|part| part / sum).collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_function_with_poles_is_right_to_rounding() {
        let poles = [c64::new(5.0, 0.1), c64::new(-3.0, 0.0)];
        let function = |x: f64| 1.0 / (poles[0] - x) + 2.0 / (poles[1] - x);
        let points = ChebyshevPoints::for_poles([-1.0, 2.0], poles.into_iter(), 60).unwrap();
        assert!(points.places.len() > 20);
        for step in 0..=30 {
            let x = -1.0 + 0.1 * f64::from(step);
            let shares = points.shares(x).into_iter().zip(&points.places);
            let found: c64 = shares.map(|(share, place)| function(*place) * share).sum();
            assert!((found - function(x)).norm() < 1e-14, "{x}");
        }
        let at_a_point = points.shares(points.places[3]);
        assert_eq!((at_a_point[3], at_a_point[4]), (1.0, 0.0));
    }

    #[test]
    fn poles_that_are_near_and_intervals_without_length_have_no_points() {
        let points =
            |ends, pole| ChebyshevPoints::for_poles(ends, [c64::new(pole, 0.0)].into_iter(), 100);
        assert!(points([0.0, 1.0], 2.0).is_some());
        assert!(points([0.0, 1.0], 1.001).is_none());
        assert!(points([0.0, 1.0], 0.5).is_none());
        assert!(points([0.0, 1.0], f64::NAN).is_none());
        assert!(points([1.0, 1.0], 2.0).is_none());
    }
}
