//! The frequencies at which responses are compared.

use faer::c64;

/// Frequencies of a band, as λ = ω².
#[derive(Clone, Debug, PartialEq)]
pub struct FrequencyBand {
    /// ω² of each point, ascending.
    pub squares: Vec<f64>,
}

impl FrequencyBand {
    /// `points` equally spaced frequencies between two ω² (the first one a step above zero if `from` is `None`), and those of all
    /// modes between them.
    pub fn new(from: Option<f64>, to: f64, points: usize, eigenvalues: &[f64]) -> Self {
        let top = to.sqrt();
        let steps = points.max(2);
        let frequency = |step: usize| match from {
            None => top * (step + 1) as f64 / steps as f64,
            Some(from) => {
                let bottom = from.sqrt();
                bottom + (top - bottom) * step as f64 / (steps - 1) as f64
            }
        };
        let mut squares: Vec<f64> = (0..steps - 1).map(|step| frequency(step).powi(2)).collect();
        squares.push(to);
        let inside = squares[0]..to;
        squares.extend(eigenvalues.iter().filter(|value| inside.contains(value)));
        squares.sort_by(f64::total_cmp);
        squares.dedup();
        Self { squares }
    }

    /// ω² at the upper end.
    pub fn top(&self) -> f64 {
        self.squares.last().copied().unwrap_or(0.0)
    }

    /// λ = ω² / (1 + iη) of every point.
    pub fn damped(&self, loss_factor: f64) -> impl Iterator<Item = c64> {
        let stiffness = c64::new(1.0, loss_factor);
        self.squares
            .iter()
            .map(move |square| c64::new(*square, 0.0) / stiffness)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_band_has_its_ends_and_the_resonances_between() {
        let band = FrequencyBand::new(None, 100.0, 5, &[1.0, 4.5 * 4.5, 144.0]);
        let frequencies: Vec<f64> = band.squares.iter().map(|square| square.sqrt()).collect();
        assert_eq!(frequencies, [2.0, 4.0, 4.5, 6.0, 8.0, 10.0]);
        let band = FrequencyBand::new(Some(4.0), 100.0, 3, &[]);
        let frequencies: Vec<f64> = band.squares.iter().map(|square| square.sqrt()).collect();
        assert_eq!(frequencies, [2.0, 6.0, 10.0]);
    }
}
