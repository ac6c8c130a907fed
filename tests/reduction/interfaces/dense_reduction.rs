//! The interface reduction of a component by dense algebra: X', F' and M' as the static response within the softest directions, and
//! what is lost as a generalized eigenproblem.

use faer::{Mat, Side};

use dcb_tests::dense::{eigen, solve, symmetric};
use dcb_tests::oracle::Oracle;

/// A residual flexibility that keeps some directions only.
pub struct DenseReduction {
    /// F₀, no mode kept.
    pub flexibility0: Mat<f64>,
    /// X', (n, n_b).
    pub shapes: Mat<f64>,
    /// F'.
    pub flexibility: Mat<f64>,
    /// M'.
    pub mass: Mat<f64>,
    /// σ² of the directions kept, ascending.
    pub sigma_squared: Vec<f64>,
    /// Eigenvalues of the scaled F_res, descending.
    pub values: Vec<f64>,
    /// Largest (F_res - F')_ii / (F₀)_ii.
    pub flexibility_error: f64,
    /// Largest (F_res - F')_ii / (F_res)_ii.
    pub residual_error: f64,
    /// Largest eigenvalue of F_res - F' relative to F₀.
    pub worst_direction_error: f64,
    /// Lowest ω² of the directions left out.
    pub lowest_left_out: f64,
}

/// Ascending eigenvalues of A z = x B z for positive B.
fn relative_eigenvalues(a: &Mat<f64>, b: &Mat<f64>) -> Vec<f64> {
    let root = b.llt(Side::Lower).expect("a positive matrix");
    let half = |matrix: &Mat<f64>| {
        let mut half = matrix.clone();
        faer::linalg::triangular_solve::solve_lower_triangular_in_place(
            root.L(),
            half.as_mut(),
            faer::Par::Seq,
        );
        half.transpose().to_owned()
    };
    eigen(&symmetric(&half(&half(a)))).0
}

impl DenseReduction {
    /// Keeps the `kept` softest directions beside the `modes` lowest modes; F₀ must be positive definite.
    pub fn of(oracle: &Oracle, modes: usize, kept: usize) -> Self {
        let flexibility0 = oracle.residual_flexibility(0);
        let whole = oracle.residual_flexibility(modes);
        let (all_shapes, all_mass) = (oracle.residual_shapes(modes), oracle.residual_mass(modes));
        let n = whole.nrows();
        let root = |i: usize| flexibility0[(i, i)].sqrt();
        let scaled = Mat::from_fn(n, n, |i, j| whole[(i, j)] / (root(i) * root(j)));
        let (ascending, vectors) = eigen(&symmetric(&scaled));
        let forces = |range: std::ops::Range<usize>| {
            Mat::from_fn(n, range.len(), |i, k| {
                vectors[(i, n - 1 - range.start - k)] / root(i)
            })
        };
        // The response within the forces V to any force: V (Vᵀ F V)⁻¹ Vᵀ F.
        let v = forces(0..kept);
        let stiffness = symmetric(&(v.transpose() * &whole * &v));
        let projector = &v * solve(&stiffness, &(v.transpose() * &whole));
        let shapes = &all_shapes * &projector;
        let flexibility = symmetric(&(&whole * &projector));
        let mass = symmetric(&(projector.transpose() * &all_mass * &projector));
        let lost = &whole - &flexibility;
        let largest_share = |of: &Mat<f64>| {
            (0..n)
                .map(|i| lost[(i, i)] / of[(i, i)])
                .fold(0.0, f64::max)
        };
        let within = |matrix: &Mat<f64>, v: &Mat<f64>| symmetric(&(v.transpose() * matrix * v));
        let rest = forces(kept..n);
        Self {
            sigma_squared: relative_eigenvalues(&within(&whole, &v), &within(&all_mass, &v)),
            flexibility_error: largest_share(&flexibility0),
            residual_error: largest_share(&whole),
            worst_direction_error: relative_eigenvalues(&symmetric(&lost), &flexibility0)
                .last()
                .copied()
                .unwrap_or(0.0),
            // 1/σ² by unit energy: the mass of what is left out may be singular to rounding.
            lowest_left_out: relative_eigenvalues(
                &within(&all_mass, &rest),
                &within(&whole, &rest),
            )
            .last()
            .map_or(f64::INFINITY, |inverse| 1.0 / inverse),
            values: ascending.into_iter().rev().collect(),
            flexibility0,
            shapes,
            flexibility,
            mass,
        }
    }
}
