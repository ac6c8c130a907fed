//! Where weak compatibility can be used: step sizes that are long enough.
//!
//! With interface forces as coordinates, a mechanism has exactly as many eigenvalues of growing motions, `x'' = μ² x` with
//! μ ≥ σ_min, as the flexibility that modes leave out has independent directions on the rows that join the bodies, whatever
//! the number of modes:
//!
//! ```text
//! F = Σ Bᵀ F_res B over the bodies;   rank F negative eigenvalues;   σ² = eig(F_res, M_res)
//! h σ_min > z,   z² = 2 (1 - 2 α_m) / ((2 β - γ)(1 - 2 α_f)),   z = 2 √3 (1 + ρ)/(1 - ρ) for generalized-alpha
//! ```
//! Below that step the integrator follows the growth; above it, numerical damping hides it.

use faer::Mat;

use crate::error::Error;
use crate::initial::dependent_rows;
use crate::system::evaluation::Evaluation;
use crate::system::residual::row_forces;
use crate::system::{State, System};
use dcb_formats::scene::Scheme;

/// Where one body of weak compatibility can be used.
#[derive(Clone, Debug, PartialEq)]
pub struct WeakBody {
    /// Name in the system.
    pub body: String,
    /// Independent directions of its residual flexibility on the rows that join it.
    pub negative_eigenvalue_count: usize,
    /// The slowest growth, 1/time; infinite where nothing grows.
    pub sigma_min: f64,
    /// The smallest step at which the growth is damped; zero where nothing grows, infinite if the method never damps it.
    pub smallest_step: f64,
}

/// Where the weak bodies of a system can be used.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WeakWindow {
    /// The bodies of weak compatibility.
    pub bodies: Vec<WeakBody>,
    /// Negative eigenvalues of the whole system. Bodies that meet in a row share one, so this is not their sum.
    pub negative_eigenvalue_count: usize,
}

impl WeakWindow {
    /// For a system at a state, by the rows as they are there. Empty if no body is of weak compatibility.
    pub fn of(system: &System, state: &State, scheme: &Scheme) -> Self {
        let mut window = Self::default();
        let mut evaluation = Evaluation::of(system);
        evaluation.place(system, state);
        evaluation.measure(system, state);
        let count = system.rows.len();
        let mut sum = Mat::<f64>::zeros(count, count);
        for (index, body) in system.bodies.iter().enumerate() {
            let Some(growing) = &body.flexible.growing else {
                continue;
            };
            let seen = growing.shapes.transpose() * row_forces(system, &evaluation, index);
            // W Wᵀ is the flexibility of the directions with mass.
            let w = Mat::from_fn(count, seen.nrows(), |row, k| {
                seen[(k, row)] / growing.sigma_squared[k].sqrt()
            });
            let flexibility = &w * w.transpose();
            let negative_eigenvalue_count = rank(&flexibility);
            sum += flexibility;
            let (sigma_min, smallest_step) = match growing.sigma_squared.first() {
                Some(squared) if negative_eigenvalue_count > 0 => {
                    (squared.sqrt(), scheme.growth_limit() / squared.sqrt())
                }
                _ => (f64::INFINITY, 0.0),
            };
            window.bodies.push(WeakBody {
                body: body.name.clone(),
                negative_eigenvalue_count,
                sigma_min,
                smallest_step,
            });
        }
        window.negative_eigenvalue_count = rank(&sum);
        window
    }

    /// Whether a step is long enough for every body.
    ///
    /// # Errors
    /// [`Error::WeakUnstable`] with the body that needs the longest step.
    pub fn check(&self, step: f64) -> Result<(), Error> {
        let longest = self
            .bodies
            .iter()
            .max_by(|a, b| a.smallest_step.total_cmp(&b.smallest_step));
        match longest {
            Some(body) if body.smallest_step >= step => Err(Error::WeakUnstable {
                body: body.body.clone(),
                sigma_min: body.sigma_min,
                step,
                smallest_step: body.smallest_step,
            }),
            _ => Ok(()),
        }
    }
}

fn rank(matrix: &Mat<f64>) -> usize {
    let diagonal: Vec<f64> = (0..matrix.nrows()).map(|i| matrix[(i, i)]).collect();
    let dependent = dependent_rows(&diagonal, |chosen, sum| {
        for (row, entry) in matrix.col(chosen).iter().enumerate() {
            sum.add(row, *entry);
        }
    });
    matrix.nrows() - dependent.rows.len()
}
