//! What the parts' own truncation can do to the modes of the whole: rigorous bounds, and which part they come from.
//!
//! A part's file says how its omitted modes answer to forces g at its rows, below its eigenvalue bound λ_b:
//!
//! ```text
//! E(λ) = Σ c cᵀ / (ω² − λ)  ≤  E⁺(λ) = M_1 + λ M_2 + λ² (λ_b + σ)/(λ_b − λ) M_3
//! ```
//! The whole has as many eigenvalues below λ as K − λ M has negative ones over the kept coordinates, the omitted ones eliminated; that is the form
//!
//! ```text
//! diag(0, ω²) − λ + Gᵀ D⁻¹ G       G what joints and springs see of the kept coordinates,  D = Σ g E g + diag(1/k)
//! ```
//! With E⁺ for E the form is lower and the count no less. So an eigenvalue of the whole is not below the λ at which that count reaches its place, and, as the
//! parts' coordinates are real motions, not above the assembly's own. To first order the distance is Σ gᵀ (E⁺ − Ẽ) g over the parts, with Ẽ of their own coordinates
//! and g the forces on them in the mode: the share of each part.

use dcb_dense::{symmetric_eigen, symmetric_eigenvalues, symmetrized};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, Par, Scale, Side};
use serde::{Deserialize, Serialize};

use crate::closing::Closing;
use crate::joint::Held;
use crate::measure::{Measure, Measured, starts};
use crate::part::{Flexible, Part};
use crate::spring::Sprung;

/// Compliance that is added to joints, beside their own: more than rounding, and on the safe side.
const SOFTENED: f64 = 1e-11;
/// Relative distances below an eigenvalue that are tried, from the least on, by factors of two to ten.
const LEAST: f64 = 1e-13;
const STEPS: usize = 13;
/// Distances that are tried after these.
const FAR: [f64; 6] = [0.2, 0.35, 0.5, 0.7, 0.9, 0.99];
/// How much closer a distance is found.
const CLOSER: usize = 3;
/// Bounds of responses end this much below a part's eigenvalue bound.
const BELOW: f64 = 1.0 - 1e-9;

/// A frequency of the whole between its bounds, and where the distance comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModeBound {
    /// ω² of the assembly: no less than that of the parts' meshes, joined.
    pub reduced: f64,
    /// That of the meshes is not below this.
    pub lower: f64,
    /// Share of each part in the distance, to first order, relative to ω²; in the order of the bodies.
    pub shares: Vec<f64>,
}

impl ModeBound {
    /// Relative bound of what the frequency may be too high.
    pub fn frequency_error(&self) -> f64 {
        match self.lower > 0.0 {
            true => (self.reduced / self.lower).sqrt() - 1.0,
            false => f64::INFINITY,
        }
    }
}

/// The comparison that counts eigenvalues of the whole.
pub(crate) struct Count<'a> {
    parts: &'a [Part],
    /// Kept coordinates: ω², lowered by what they may be off; zero for rigid motions.
    squares: Vec<f64>,
    /// G, (joint rows and springs, kept coordinates).
    shapes: Mat<f64>,
    /// 1/k of springs; zero for joint rows.
    compliance: Vec<f64>,
    /// Weights of each part's rows, (n_b, joint rows and springs).
    rows: Vec<Mat<f64>>,
    /// λ_b, the least of the parts'.
    pub limit: f64,
}

impl<'a> Count<'a> {
    /// `Err` with the name of a part whose file has no moments.
    pub fn of(parts: &'a [Part], held: &[Held], sprung: &[Sprung]) -> Result<Self, String> {
        let mut limit = f64::INFINITY;
        for part in parts {
            if let Some(flexible) = part.flexible() {
                let Some(moments) = &flexible.element.moments else {
                    return Err(part.name.clone());
                };
                limit = limit.min(moments.eigenvalue_bound);
            }
        }
        let stiff: Vec<&Sprung> = sprung.iter().filter(|one| one.stiffness > 0.0).collect();
        let measures: Vec<&Measure> = (held.iter().map(|held| &held.measure))
            .chain(stiff.iter().map(|one| &one.measure))
            .collect();
        let measured = Measured::of(&measures, parts);
        let starts = starts(parts);
        let mut squares = Vec::new();
        let mut kept = Vec::new();
        for (part, start) in parts.iter().zip(&starts) {
            for k in 0..part.rigid_count() {
                squares.push(0.0);
                kept.push(start + k);
            }
            if let Some(flexible) = part.flexible() {
                let element = &flexible.element;
                let errors = element
                    .moments
                    .as_ref()
                    .map(|of| of.eigenvalue_errors.as_slice());
                for (k, square) in element.modes.eigenvalues.iter().enumerate() {
                    let error = errors
                        .and_then(|errors| errors.get(k))
                        .copied()
                        .unwrap_or(0.0);
                    squares.push(square * (1.0 - error).max(0.0));
                    kept.push(start + part.rigid_count() + k);
                }
            }
        }
        let joints = held.len();
        Ok(Self {
            parts,
            squares,
            shapes: Mat::from_fn(measures.len(), kept.len(), |i, j| {
                measured.motion[(i, kept[j])]
            }),
            compliance: (0..measures.len())
                .map(|i| {
                    if i < joints {
                        0.0
                    } else {
                        1.0 / stiff[i - joints].stiffness
                    }
                })
                .collect(),
            rows: measured.rows,
            limit,
        })
    }

    /// Eigenvalues of the whole below λ are no more than these; `None` where that isn't known.
    pub fn below(&self, lambda: f64) -> Option<usize> {
        if lambda >= self.limit * BELOW {
            return None;
        }
        let count = self.shapes.nrows();
        let mut answer = Mat::<f64>::zeros(count, count);
        for (part, rows) in self.parts.iter().zip(&self.rows) {
            if let Some(flexible) = part.flexible() {
                answer += rows.transpose() * upper_response(flexible, lambda)? * rows;
            }
        }
        // In units of each row's flexibility with what the kept coordinates give it.
        let lowest = self
            .squares
            .iter()
            .copied()
            .filter(|square| *square > 0.0)
            .fold(f64::INFINITY, f64::min);
        let lowest = if lowest.is_finite() { lowest } else { lambda };
        let scale: Vec<f64> = (0..count)
            .map(|i| {
                let kept: f64 = (0..self.squares.len())
                    .map(|k| self.shapes[(i, k)].powi(2) / self.squares[k].max(lowest))
                    .sum();
                match kept + answer[(i, i)] + self.compliance[i] {
                    whole if whole > 0.0 => whole.sqrt().recip(),
                    _ => 1.0,
                }
            })
            .collect();
        let answer = Mat::from_fn(count, count, |i, j| {
            let own = if i == j {
                SOFTENED + self.compliance[i] * scale[i].powi(2)
            } else {
                0.0
            };
            0.5 * (answer[(i, j)] + answer[(j, i)]) * scale[i] * scale[j] + own
        });
        let root = answer.llt(Side::Lower).ok()?;
        let mut shapes = Mat::from_fn(count, self.squares.len(), |i, k| {
            scale[i] * self.shapes[(i, k)]
        });
        solve_lower_triangular_in_place(root.L(), shapes.as_mut(), Par::Seq);
        let mut form = shapes.transpose() * &shapes;
        for (k, square) in self.squares.iter().enumerate() {
            form[(k, k)] += square - lambda;
        }
        // Signs don't change where rows and columns are scaled.
        let unit: Vec<f64> = (0..form.nrows())
            .map(|k| form[(k, k)].abs().max(lambda).sqrt().recip())
            .collect();
        let form = Mat::from_fn(form.nrows(), form.nrows(), |i, j| {
            unit[i] * form[(i, j)] * unit[j]
        });
        let values = symmetric_eigenvalues(symmetrized(form).as_ref())?;
        Some(values.iter().filter(|value| **value < 0.0).count())
    }

    /// λ below which the whole has no more than `place` eigenvalues, as near below `from` as it is found.
    pub fn lower(&self, place: usize, from: f64) -> f64 {
        let from = from.min(self.limit * BELOW * (1.0 - LEAST));
        let holds = |distance: f64| {
            self.below(from * (1.0 - distance))
                .is_some_and(|count| count <= place)
        };
        // The least distance that holds, among LEAST, 10 LEAST, ... 0.1 and those of FAR; then closer by bisection of the exponent.
        let mut outer = None;
        let mut inner = 0.0;
        for step in 0..STEPS {
            let distance = LEAST * 10_f64.powi(step as i32);
            if holds(distance) {
                outer = Some(distance);
                break;
            }
            inner = distance;
        }
        let far = || FAR.iter().copied().find(|distance| holds(*distance));
        let Some(mut outer) = outer.or_else(far) else {
            return 0.0;
        };
        if inner > 0.0 {
            for _ in 0..CLOSER {
                let middle = (inner * outer).sqrt();
                if holds(middle) {
                    outer = middle;
                } else {
                    inner = middle;
                }
            }
        }
        from * (1.0 - outer)
    }
}

/// E⁺(λ) between the rows of a part, with what its moments may be off; `None` beyond its eigenvalue bound.
fn upper_response(flexible: &Flexible, lambda: f64) -> Option<Mat<f64>> {
    let moments = flexible.element.moments.as_ref()?;
    let n_b = flexible.element.rows.len();
    let factor = match moments.eigenvalue_bound {
        infinite if infinite.is_infinite() => 1.0,
        bound if lambda < bound => (bound + moments.shift) / (bound - lambda),
        _ => return None,
    };
    let block = |of: &Mat<f64>| of.as_ref().submatrix(0, 0, n_b, n_b).to_owned();
    let mut upper = block(&moments.first)
        + block(&moments.second) * Scale(lambda)
        + block(&moments.third) * Scale(lambda * lambda * factor);
    // A semi-definite matrix whose rows are off by ρ_i is off by no more than n ρ_i of its diagonal.
    for i in 0..n_b {
        upper[(i, i)] *= 1.0 + n_b as f64 * moments.rounding.get(i).copied().unwrap_or(0.0);
    }
    Some(upper)
}

/// Ẽ(λ) between the rows of a part: its own coordinates beyond the modes.
fn own_response(flexible: &Flexible, lambda: f64) -> Mat<f64> {
    let n_k = flexible.element.mode_count();
    let n = flexible.stiffness.len();
    let seen = flexible.shapes.subcols(n_k, n - n_k);
    let weighted = Mat::from_fn(seen.nrows(), n - n_k, |i, k| {
        seen[(i, k)] / (flexible.stiffness[n_k + k] - lambda)
    });
    let dynamic = weighted * seen.transpose();
    match &flexible.massless {
        Some(massless) => dynamic + massless,
        None => dynamic,
    }
}

/// E⁺ − Ẽ between the rows of a part; `None` beyond its eigenvalue bound, or without moments.
pub(crate) fn excess(flexible: &Flexible, lambda: f64) -> Option<Mat<f64>> {
    Some(upper_response(flexible, lambda)? - own_response(flexible, lambda))
}

/// Forces in the rows of H that hold modes, (h, modes): Hᵀ μ = K φ − ω² φ.
pub(crate) fn multipliers(
    closing: &Closing,
    stiffness: &[f64],
    squares: &[f64],
    shapes: &Mat<f64>,
) -> Mat<f64> {
    let closed = closing.stiffness_root.transpose() * (&closing.stiffness_root * shapes);
    let rest = Mat::from_fn(shapes.nrows(), shapes.ncols(), |i, k| {
        (stiffness[i] - squares[k]) * shapes[(i, k)] + closed[(i, k)]
    });
    let constraints = &closing.constraints;
    least(
        &(constraints * constraints.transpose()),
        &(constraints * &rest),
    )
}

/// Share of each part in what modes may be off, relative to ω²: for each mode, in the order of the parts. `shapes` are of unit mass over all coordinates.
pub(crate) fn shares(
    parts: &[Part],
    closing: &Closing,
    stiffness: &[f64],
    squares: &[f64],
    shapes: &Mat<f64>,
) -> Vec<Vec<f64>> {
    let none = Mat::zeros(closing.interfaces.nrows(), shapes.ncols());
    let held = multipliers(closing, stiffness, squares, shapes);
    let mut all = vec![vec![0.0; parts.len()]; squares.len()];
    for (i, part) in parts.iter().enumerate() {
        let Some(flexible) = part.flexible() else {
            continue;
        };
        let forces = closing.forces_on(i, shapes, &none) + closing.constraint_forces_on(i, &held);
        for (k, square) in squares.iter().enumerate() {
            all[k][i] = match excess(flexible, *square) {
                None => f64::INFINITY,
                Some(excess) => {
                    let own = forces.subcols(k, 1);
                    let energy = own.transpose() * excess * own;
                    (energy[(0, 0)] / square).max(0.0)
                }
            };
        }
    }
    all
}

/// The smallest solution of a positive semi-definite system.
pub(crate) fn least(matrix: &Mat<f64>, rhs: &Mat<f64>) -> Mat<f64> {
    let Some((values, vectors)) = symmetric_eigen(symmetrized(matrix).as_ref()) else {
        return Mat::zeros(rhs.nrows(), rhs.ncols());
    };
    let largest = values.last().copied().unwrap_or(0.0);
    let amounts = vectors.transpose() * rhs;
    let shares = Mat::from_fn(amounts.nrows(), amounts.ncols(), |k, j| {
        match values[k] > 1e-12 * largest {
            true => amounts[(k, j)] / values[k],
            false => 0.0,
        }
    });
    vectors * shares
}
