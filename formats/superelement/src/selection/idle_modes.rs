//! Modes that were left out and that no force moves which a selection is made for: those that lead out of a plane of symmetry, under forces in it.
//!
//! They don't take part, whatever their frequency is. A share below [`MOVED`] is what rounding and meshes leave of a symmetry; what it can do at a resonance
//! counts as rounding of the rows.

use crate::LOSS_FACTOR;
use faer::Mat;

use super::in_plane::SYMMETRIC;

/// A mode is moved by a force from this fraction on of the most that it could be, as a cosine.
const MOVED: f64 = SYMMETRIC;
/// How far a resonance enlarges a response over its static one.
const RESONANCE: f64 = 1.0 / LOSS_FACTOR;

/// Effect of modes left out on rows.
pub(super) struct Shares {
    /// c over the root of μ and of the row's moment, the largest of the four moments, (rows, modes).
    pub cosines: Mat<f64>,
    /// The same over the root of the moment with all modes in it.
    pub of_all: Mat<f64>,
    /// Rows that forces act on, one each.
    pub acting: Vec<usize>,
    /// Rows that are only observed.
    pub observed: Vec<usize>,
}

impl Shares {
    /// Places of the modes that no force moves.
    pub fn idle(&self) -> Vec<usize> {
        let moved = |mode: usize| {
            let mut rows = self.acting.iter();
            rows.any(|row| self.of_all[(*row, mode)] > MOVED)
        };
        match self.acting.is_empty() {
            true => Vec::new(),
            false => (0..self.of_all.ncols())
                .filter(|mode| !moved(*mode))
                .collect(),
        }
    }

    /// Adds to each row's rounding what an idle mode could do: the root of the product of two rows' is not below 1/η of the product of their cosines.
    pub fn add_leak(&self, mode: usize, rounding: &mut [f64]) {
        let cosine = |row: &usize| self.cosines[(*row, mode)];
        let of_acting = self.acting.iter().map(cosine).fold(0.0, f64::max);
        let of_all = self.observed.iter().map(cosine).fold(of_acting, f64::max);
        for row in &self.acting {
            rounding[*row] += RESONANCE * cosine(row) * of_all;
        }
        for row in &self.observed {
            rounding[*row] += RESONANCE * cosine(row) * of_acting;
        }
    }
}
