//! Coefficients of the Radau IIA methods.
//!
//! ```text
//! c_1 .. c_s   zeros of P_s(2c - 1) - P_{s-1}(2c - 1), the last of them 1
//! A_ij         ∫_0^{c_i} ℓ_j,  with the Lagrange polynomials ℓ_j of c_1 .. c_s
//! A = T diag(μ) T⁻¹,          one μ real, the others in conjugate pairs
//! ```
//! (Hairer and Wanner, Solving Ordinary Differential Equations II, IV.5 and IV.8.) Everything is computed from the nodes.

use faer::linalg::solvers::{DenseSolveCore, FullPivLu};
use faer::{Mat, c64};

/// Number of stages of a method; its order is twice that less one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stages {
    /// Order 5.
    Three,
    /// Order 9.
    Five,
}

impl Stages {
    /// How many.
    pub fn count(self) -> usize {
        match self {
            Self::Three => 3,
            Self::Five => 5,
        }
    }

    /// Order of positions and velocities.
    pub fn order(self) -> usize {
        2 * self.count() - 1
    }
}

/// An eigenvalue of A with its row of T⁻¹ and its column of T.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Transformed<T> {
    /// μ.
    pub value: T,
    /// Row of T⁻¹.
    pub gather: Vec<T>,
    /// Column of T; of a pair twice that, so that the real part is what both add.
    pub spread: Vec<T>,
}

/// Coefficients of one method.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Coefficients {
    /// c.
    pub nodes: Vec<f64>,
    /// A, row by row.
    pub weights: Vec<Vec<f64>>,
    /// A², row by row.
    pub double_weights: Vec<Vec<f64>>,
    /// The real eigenvalue.
    pub real: Transformed<f64>,
    /// One of each pair.
    pub pairs: Vec<Transformed<c64>>,
    /// Differences of the weights of an embedded formula of order s, which also uses the start, by start and stages.
    pub estimate: Vec<f64>,
    /// The polynomials of the start and the stages: coefficients of ascending powers, one polynomial after the other.
    polynomials: Vec<Vec<f64>>,
}

impl Coefficients {
    pub fn of(stages: Stages) -> Self {
        let s = stages.count();
        let nodes = nodes(s);
        let with_start: Vec<f64> = std::iter::once(0.0).chain(nodes.iter().copied()).collect();
        let of_stages = lagrange(&nodes);
        let weights: Vec<Vec<f64>> = nodes
            .iter()
            .map(|node| of_stages.iter().map(|p| integral(p, *node)).collect())
            .collect();
        let double_weights = (0..s)
            .map(|i| {
                let entry = |j: usize| (0..s).map(|k| weights[i][k] * weights[k][j]).sum();
                (0..s).map(entry).collect()
            })
            .collect();
        let (real, pairs) = transformed(&weights);
        let estimate = estimate(&nodes, &weights[s - 1], real.value);
        Self {
            nodes,
            weights,
            double_weights,
            real,
            pairs,
            estimate,
            polynomials: lagrange(&with_start),
        }
    }

    pub fn count(&self) -> usize {
        self.nodes.len()
    }

    /// Weights of values at the start and the stages for the value at a part `x` of the step.
    pub fn write_values(&self, x: f64, weights: &mut [f64]) {
        for (weight, polynomial) in weights.iter_mut().zip(&self.polynomials) {
            *weight = polynomial.iter().rev().fold(0.0, |sum, c| sum * x + c);
        }
    }

    /// Weights of rates at the start and the stages for their integral from the start to a part `x` of a step of length one.
    pub fn write_integrals(&self, x: f64, weights: &mut [f64]) {
        for (weight, polynomial) in weights.iter_mut().zip(&self.polynomials) {
            *weight = integral(polynomial, x);
        }
    }

    /// The same of second rates for their twofold integral.
    pub fn write_double_integrals(&self, x: f64, weights: &mut [f64]) {
        for (weight, polynomial) in weights.iter_mut().zip(&self.polynomials) {
            let powers = polynomial.iter().enumerate().rev();
            let sum = powers.fold(0.0, |sum, (k, c)| sum * x + c / ((k + 1) * (k + 2)) as f64);
            *weight = sum * x * x;
        }
    }
}

/// The nodes, ascending.
fn nodes(s: usize) -> Vec<f64> {
    let difference = |c: f64| {
        let x = 2.0 * c - 1.0;
        let (mut before, mut now) = (1.0, x);
        for k in 1..s {
            let k_ = k as f64;
            let next = ((2.0 * k_ + 1.0) * x * now - k_ * before) / (k_ + 1.0);
            (before, now) = (now, next);
        }
        now - before
    };
    // Zeros lie further apart than this, and none but the last at 1.
    let count = 64 * s;
    let mut found = Vec::with_capacity(s);
    for k in 0..count - 1 {
        let (mut low, mut high) = (k as f64 / count as f64, (k + 1) as f64 / count as f64);
        if difference(low) * difference(high) > 0.0 {
            continue;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            match difference(low) * difference(middle) > 0.0 {
                true => low = middle,
                false => high = middle,
            }
        }
        found.push(0.5 * (low + high));
    }
    found.push(1.0);
    found
}

/// The Lagrange polynomials of some nodes by their coefficients, ascending.
fn lagrange(nodes: &[f64]) -> Vec<Vec<f64>> {
    let of = |j: usize| {
        let mut coefficients = vec![1.0];
        for (_, node) in nodes.iter().enumerate().filter(|(i, _)| *i != j) {
            let over = 1.0 / (nodes[j] - node);
            let mut next = vec![0.0; coefficients.len() + 1];
            for (k, c) in coefficients.iter().enumerate() {
                next[k + 1] += c * over;
                next[k] -= c * node * over;
            }
            coefficients = next;
        }
        coefficients
    };
    (0..nodes.len()).map(of).collect()
}

/// The integral of a polynomial from zero.
fn integral(polynomial: &[f64], x: f64) -> f64 {
    let powers = polynomial.iter().enumerate().rev();
    powers.fold(0.0, |sum, (k, c)| sum * x + c / (k + 1) as f64) * x
}

/// The eigenvalues of A with T and T⁻¹, pairs once.
fn transformed(weights: &[Vec<f64>]) -> (Transformed<f64>, Vec<Transformed<c64>>) {
    let s = weights.len();
    let matrix = Mat::from_fn(s, s, |i, j| weights[i][j]);
    // The matrices are of a handful of rows and have distinct eigenvalues: there is always a decomposition.
    let (vectors, values) = match matrix.eigen() {
        Ok(eigen) => {
            let values = (0..s).map(|k| eigen.S().column_vector()[k]).collect();
            (eigen.U().to_owned(), values)
        }
        Err(_) => (Mat::identity(s, s), vec![c64::new(f64::NAN, 0.0); s]),
    };
    let values: Vec<c64> = values;
    let inverse = FullPivLu::new(vectors.as_ref()).inverse();
    let gather = |k: usize| (0..s).map(|i| inverse[(k, i)]).collect::<Vec<c64>>();
    let spread = |k: usize| (0..s).map(|i| vectors[(i, k)]).collect::<Vec<c64>>();
    let by_size = |a: &&usize, b: &&usize| values[**a].im.abs().total_cmp(&values[**b].im.abs());
    let all: Vec<usize> = (0..s).collect();
    let of_real = all.iter().min_by(by_size).copied().unwrap_or_default();
    // Vectors of the real eigenvalue are real but for a factor.
    let turn = spread(of_real)[s - 1];
    let real = Transformed {
        value: values[of_real].re,
        gather: gather(of_real).iter().map(|x| (x * turn).re).collect(),
        spread: spread(of_real).iter().map(|x| (x / turn).re).collect(),
    };
    let pairs = all
        .iter()
        .filter(|k| **k != of_real && values[**k].im > 0.0)
        .map(|&k| Transformed {
            value: values[k],
            gather: gather(k),
            spread: spread(k).iter().map(|x| x * 2.0).collect(),
        });
    (real, pairs.collect())
}

/// `b̂ - b` with the weight μ of the start: exact for polynomials of degree s - 1 (Hairer and Wanner IV.8, Eq. 8.17).
fn estimate(nodes: &[f64], b: &[f64], of_start: f64) -> Vec<f64> {
    let s = nodes.len();
    let powers = Mat::from_fn(s, s, |k, j| nodes[j].powi(k as i32));
    let moments = Mat::from_fn(s, 1, |k, _| {
        let start = if k == 0 { of_start } else { 0.0 };
        1.0 / (k + 1) as f64 - start
    });
    let embedded = FullPivLu::new(powers.as_ref()).inverse() * moments;
    let of_stages = (0..s).map(|j| embedded[(j, 0)] - b[j]);
    std::iter::once(of_start).chain(of_stages).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOTH: [Stages; 2] = [Stages::Three, Stages::Five];

    /// The published coefficients of the method of order 5.
    #[test]
    fn order_five_has_the_published_coefficients() {
        let found = Coefficients::of(Stages::Three);
        let root = 6.0_f64.sqrt();
        let nodes = [(4.0 - root) / 10.0, (4.0 + root) / 10.0, 1.0];
        let last = [(16.0 - root) / 36.0, (16.0 + root) / 36.0, 1.0 / 9.0];
        for k in 0..3 {
            assert!((found.nodes[k] - nodes[k]).abs() < 1e-15);
            assert!((found.weights[2][k] - last[k]).abs() < 1e-15);
        }
        assert!((found.weights[0][0] - (88.0 - 7.0 * root) / 360.0).abs() < 1e-15);
        assert!((1.0 / found.real.value - 3.637_834_252_744_496).abs() < 1e-12);
        let pair = c64::new(1.0, 0.0) / found.pairs[0].value;
        assert!((pair.re - 2.681_082_873_627_752).abs() < 1e-12);
        assert!((pair.im.abs() - 3.050_430_199_247_41).abs() < 1e-12);
    }

    /// T diag(μ) T⁻¹ is A, and the weights integrate powers as they should.
    #[test]
    fn transformation_and_quadrature_are_exact() {
        for stages in BOTH {
            let found = Coefficients::of(stages);
            let s = found.count();
            assert_eq!(2 * found.pairs.len() + 1, s);
            for i in 0..s {
                for j in 0..s {
                    let real = &found.real;
                    let mut sum = real.spread[i] * real.value * real.gather[j];
                    for pair in &found.pairs {
                        sum += (pair.spread[i] * pair.value * pair.gather[j]).re;
                    }
                    assert!((sum - found.weights[i][j]).abs() < 1e-13, "{s} {i} {j}");
                }
            }
            for power in 0..stages.order() {
                let terms = found.weights[s - 1].iter().zip(&found.nodes);
                let sum: f64 = terms.map(|(b, c)| b * c.powi(power as i32)).sum();
                assert!((sum * (power + 1) as f64 - 1.0).abs() < 1e-13, "{power}");
            }
            // The embedded formula is of order s and no more.
            let estimated = |power: i32| -> f64 {
                let stages = found.estimate[1..].iter().zip(&found.nodes);
                let start = if power == 0 { found.estimate[0] } else { 0.0 };
                start + stages.map(|(d, c)| d * c.powi(power)).sum::<f64>()
            };
            for power in 0..s {
                assert!(estimated(power as i32).abs() < 1e-13);
            }
            assert!(estimated(s as i32).abs() > 1e-4);
        }
    }

    /// Values, integrals and twofold integrals of a polynomial that the nodes determine.
    #[test]
    fn polynomials_between_the_nodes_are_exact() {
        for stages in BOTH {
            let found = Coefficients::of(stages);
            let degree = found.count() as i32;
            let nodes: Vec<f64> = std::iter::once(0.0).chain(found.nodes.clone()).collect();
            let mut weights = vec![0.0; nodes.len()];
            for x in [-0.3, 0.2, 0.7, 1.0, 1.6] {
                let sum = |weights: &[f64]| -> f64 {
                    let terms = weights.iter().zip(&nodes);
                    terms.map(|(w, c)| w * c.powi(degree)).sum()
                };
                let d = f64::from(degree);
                found.write_values(x, &mut weights);
                assert!((sum(&weights) - x.powi(degree)).abs() < 1e-11);
                found.write_integrals(x, &mut weights);
                assert!((sum(&weights) - x.powi(degree + 1) / (d + 1.0)).abs() < 1e-11);
                found.write_double_integrals(x, &mut weights);
                let twofold = x.powi(degree + 2) / ((d + 1.0) * (d + 2.0));
                assert!((sum(&weights) - twofold).abs() < 1e-11);
            }
        }
    }
}
