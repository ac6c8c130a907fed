//! Numbers that look random and are the same everywhere, for tests.

use faer::Mat;

/// A linear congruential generator with the constants of Knuth's MMIX.
#[derive(Clone, Debug)]
pub struct PseudoRandom(u64);

impl PseudoRandom {
    /// The sequence of a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    fn advance(&mut self) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        self.0
    }

    /// A number in [-1, 1).
    pub fn number(&mut self) -> f64 {
        (self.advance() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Numbers in [-1, 1).
    pub fn numbers(&mut self, count: usize) -> Vec<f64> {
        (0..count).map(|_| self.number()).collect()
    }

    /// A matrix of numbers in [-1, 1).
    pub fn matrix(&mut self, rows: usize, columns: usize) -> Mat<f64> {
        Mat::from_fn(rows, columns, |_, _| self.number())
    }

    /// A whole number below a limit, which is 1 at least.
    pub fn below(&mut self, limit: usize) -> usize {
        (self.advance() >> 33) as usize % limit
    }
}
