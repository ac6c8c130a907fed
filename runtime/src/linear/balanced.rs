//! Balanced truncation: fewer states, with a bound on the error at every frequency.
//!
//! Poles that don't decay have no Gramians; their part is kept apart, exactly. Of the part G that decays, with Hankel singular values σ₁ ≥ σ₂ …
//! of the system whose inputs and outputs are scaled, G̃ = S⁻¹ G R⁻¹, the truncation to r states is off by
//!
//! ```text
//! |G̃ - G̃_r|(iω)  ≤  2 (σ_{r+1} + … + σ_n)            |G - G_r|_ij  ≤  s_i r_j 2 (σ_{r+1} + … + σ_n)
//! ```
//! (Glover; Enns). s and r make the H₂ norms of outputs by inputs alike and σ₁ one, so that what is left out doesn't depend on units.

use dcb_formats::linear_system::{LinearSystem, Pole, Truncation, Variable};
use faer::Mat;

use super::separation::{Separated, compressed, gramian_factors};
use crate::error::Error;

/// Poles nearer to the axis than this part of the largest are kept apart: their decay could be rounding.
const SLOW: f64 = 1e-7;
/// Hankel singular values below this part of the largest belong to states that no input moves or no output sees.
const UNSEEN: f64 = 1e-13;
/// Rounds of scaling, of which each makes the norms of rows and columns alike.
const ROUNDS: usize = 40;
/// An output that an input moves by less than this part of the most that it could isn't moved by it.
const COUPLED: f64 = 1e-9;

/// The system with `order` states, those of poles that don't decay among them; fewer where inputs and outputs see fewer. `units`: amounts of the
/// coordinates that are as large as each other.
pub(super) fn truncated(
    system: LinearSystem,
    order: usize,
    units: &[f64],
) -> Result<LinearSystem, Error> {
    let full = system.order();
    let refused = |message: String| Err(Error::described("order", message));
    if order == 0 || order > full {
        return refused(format!(
            "is {order}, but the system has {full} states; give a number from 1 to {full}"
        ));
    }
    if order == full {
        return Ok(system);
    }
    let fastest = system.poles.last().map_or(0.0, Pole::magnitude);
    let decays = |pole: &&Pole| pole.is_stable() && -pole.growth > SLOW * fastest;
    let count = system.poles.iter().filter(decays).count();
    let kept = full - count;
    if count == 0 {
        return refused(format!(
            "is {order}, but none of the {full} poles decays, and only what decays can be left out; give the parts or springs damping, or ask for all states"
        ));
    }
    if order < kept {
        return refused(format!(
            "is {order}, but {kept} of the {full} poles don't decay (free, undamped or growing motions, drives as inputs) and are kept; give {kept} or more, hold free bodies, or give damping"
        ));
    }
    let slowest = (system.poles.iter().filter(decays))
        .map(|pole| -pole.growth)
        .fold(f64::INFINITY, f64::min);
    // Time in units of the fastest pole, states as parts of what is as large as each other.
    let rates = units.iter().map(|unit| unit * fastest);
    let scale: Vec<f64> = units.iter().copied().chain(rates).collect();
    let n = full;
    let a = Mat::from_fn(n, n, |i, j| {
        system.a[(i, j)] * scale[j] / (scale[i] * fastest)
    });
    let b = Mat::from_fn(n, system.b.ncols(), |i, j| system.b[(i, j)] / scale[i]);
    let c = Mat::from_fn(system.c.nrows(), n, |i, j| system.c[(i, j)] * scale[j]);
    let apart = Separated::of(&a, count, 0.5 * slowest / fastest)?;
    let a = &apart.inverse * a * &apart.basis;
    let b = &apart.inverse * b;
    let c = c * &apart.basis;
    let own = Part {
        a: a.as_ref().submatrix(0, 0, count, count).to_owned(),
        b: b.as_ref().subrows(0, count).to_owned(),
        c: c.as_ref().subcols(0, count).to_owned(),
    };
    let balanced = own.balanced(order - kept)?;
    let rest = Part {
        a: a.as_ref().submatrix(count, count, kept, kept).to_owned(),
        b: b.as_ref().subrows(count, kept).to_owned(),
        c: c.as_ref().subcols(count, kept).to_owned(),
    };
    let mut poles: Vec<Pole> = eigenvalues(&balanced.part.a)?
        .into_iter()
        .map(|pole| Pole {
            growth: pole.growth * fastest,
            angular_frequency: pole.angular_frequency * fastest,
        })
        .collect();
    poles.extend(system.poles.iter().filter(|pole| !decays(pole)));
    poles.sort_by(|a, b| a.magnitude().total_cmp(&b.magnitude()));
    let whole = rest.beside(&balanced.part);
    let state = |index: usize| Variable {
        name: match index < kept {
            true => format!("kept {}", index + 1),
            false => format!("balanced {}", index - kept + 1),
        },
        unit: "1".to_owned(),
        at: 0.0,
    };
    Ok(LinearSystem {
        states: (0..whole.a.nrows()).map(state).collect(),
        a: whole.a * faer::Scale(fastest),
        b: whole.b,
        c: whole.c,
        poles,
        truncation: Some(Truncation {
            full_order: full,
            kept_apart: kept,
            hankel: balanced.hankel,
            bound: balanced.bound,
            // In the unit of time of the scaled system G is larger by this.
            bounds: balanced.bounds * faer::Scale(1.0 / fastest),
        }),
        ..system
    })
}

/// A part of a system.
struct Part {
    a: Mat<f64>,
    b: Mat<f64>,
    c: Mat<f64>,
}

struct Balanced {
    part: Part,
    hankel: Vec<f64>,
    bound: f64,
    bounds: Mat<f64>,
}

impl Part {
    /// Balanced, and cut off after so many states.
    fn balanced(&self, order: usize) -> Result<Balanced, Error> {
        let n = self.a.nrows();
        let columns = self.b.col_iter();
        let mut columns: Vec<Mat<f64>> = columns.map(|column| column.as_mat().to_owned()).collect();
        columns.push(Mat::identity(n, n));
        let mut by_input = gramian_factors(&self.a, columns)?;
        let by_all = by_input.pop().unwrap_or_else(|| Mat::zeros(n, n));
        let outputs = self.c.nrows();
        let norms = Mat::from_fn(outputs, by_input.len(), |i, j| {
            (self.c.row(i) * &by_input[j]).norm_l2()
        });
        // The most that inputs of this size could do to each output.
        let most = Mat::from_fn(outputs, by_input.len(), |i, j| {
            (self.c.row(i) * &by_all).norm_l2() * self.b.col(j).norm_l2()
        });
        let (s, r) = scales(&norms, &most);
        let reached: Vec<Mat<f64>> = (by_input.into_iter().zip(&r))
            .map(|(factor, r)| factor * faer::Scale(1.0 / r))
            .collect();
        let width: usize = reached.iter().map(Mat::ncols).sum();
        let mut joined = Mat::zeros(n, width);
        let mut first = 0;
        for factor in &reached {
            joined
                .as_mut()
                .subcols_mut(first, factor.ncols())
                .copy_from(factor);
            first += factor.ncols();
        }
        let reached = compressed(joined);
        let scaled = Mat::from_fn(n, s.len(), |i, j| self.c[(j, i)] / s[j]);
        let seen = gramian_factors(&self.a.transpose().to_owned(), vec![scaled])?.remove(0);
        let seen = compressed(seen);
        let product = seen.transpose() * &reached;
        let factors = product.thin_svd().map_err(|_| Error::NoEigenvalues)?;
        let hankel: Vec<f64> = factors.S().column_vector().iter().copied().collect();
        let largest = hankel.first().copied().unwrap_or(0.0);
        let seen_count = (hankel.iter())
            .take_while(|sigma| **sigma > UNSEEN * largest && **sigma > 0.0)
            .count();
        let order = order.min(seen_count);
        let root = |k: usize| hankel[k].sqrt();
        let left = &seen * factors.U().subcols(0, order);
        let right = &reached * factors.V().subcols(0, order);
        let left = Mat::from_fn(n, order, |i, k| left[(i, k)] / root(k));
        let right = Mat::from_fn(n, order, |i, k| right[(i, k)] / root(k));
        // As parts of the largest.
        let largest = largest.max(f64::MIN_POSITIVE);
        let relative: Vec<f64> = hankel.iter().map(|sigma| sigma / largest).collect();
        let bound = 2.0 * relative[order..].iter().sum::<f64>();
        Ok(Balanced {
            part: Self {
                a: left.transpose() * &self.a * &right,
                b: left.transpose() * &self.b,
                c: &self.c * &right,
            },
            bounds: Mat::from_fn(s.len(), r.len(), |i, j| bound * largest * s[i] * r[j]),
            hankel: relative,
            bound,
        })
    }

    /// Both beside each other, this one first.
    fn beside(&self, other: &Self) -> Self {
        let (own, n) = (self.a.nrows(), self.a.nrows() + other.a.nrows());
        Self {
            a: Mat::from_fn(n, n, |i, j| match (i < own, j < own) {
                (true, true) => self.a[(i, j)],
                (false, false) => other.a[(i - own, j - own)],
                _ => 0.0,
            }),
            b: Mat::from_fn(n, self.b.ncols(), |i, j| match i < own {
                true => self.b[(i, j)],
                false => other.b[(i - own, j)],
            }),
            c: Mat::from_fn(self.c.nrows(), n, |i, j| match j < own {
                true => self.c[(i, j)],
                false => other.c[(i, j - own)],
            }),
        }
    }
}

/// s and r with `norms_ij / (s_i r_j)` about one, in the mean of logarithms over each row and column; what is rounding has no part in it. An output that
/// no input moves, and an input that moves no output, has the scale of the most that it could.
fn scales(norms: &Mat<f64>, most: &Mat<f64>) -> (Vec<f64>, Vec<f64>) {
    let coupled = Mat::from_fn(norms.nrows(), norms.ncols(), |i, j| {
        match norms[(i, j)] > COUPLED * most[(i, j)] {
            true => norms[(i, j)],
            false => 0.0,
        }
    });
    let (mut s, mut r) = alternated(&coupled);
    for i in 0..s.len() {
        if coupled.row(i).norm_max() == 0.0 {
            let scales = (0..r.len()).map(|j| most[(i, j)] / r[j]);
            s[i] = positive(scales.fold(0.0, f64::max));
        }
    }
    for j in 0..r.len() {
        if coupled.col(j).norm_max() == 0.0 {
            let scales = (0..s.len()).map(|i| most[(i, j)] / s[i]);
            r[j] = positive(scales.fold(0.0, f64::max));
        }
    }
    (s, r)
}

/// A scale, or one for what is zero.
fn positive(scale: f64) -> f64 {
    if scale > 0.0 { scale } else { 1.0 }
}

/// Scales of rows and of columns by turns, each the mean of what the others leave.
fn alternated(norms: &Mat<f64>) -> (Vec<f64>, Vec<f64>) {
    let (mut s, mut r) = (vec![1.0; norms.nrows()], vec![1.0; norms.ncols()]);
    let mean = |ratios: Vec<f64>| {
        let logarithms: Vec<f64> = (ratios.iter().filter(|x| **x > 0.0))
            .map(|x| x.ln())
            .collect();
        let count = logarithms.len().max(1);
        f64::exp(logarithms.iter().sum::<f64>() / count as f64)
    };
    for _ in 0..ROUNDS {
        for j in 0..r.len() {
            r[j] = mean((0..s.len()).map(|i| norms[(i, j)] / s[i]).collect());
        }
        for i in 0..s.len() {
            s[i] = mean((0..r.len()).map(|j| norms[(i, j)] / r[j]).collect());
        }
    }
    (s, r)
}

fn eigenvalues(a: &Mat<f64>) -> Result<Vec<Pole>, Error> {
    if a.nrows() == 0 {
        return Ok(Vec::new());
    }
    let values = a.eigenvalues().map_err(|_| Error::NoEigenvalues)?;
    let pole = |value: &faer::c64| Pole {
        growth: value.re,
        angular_frequency: value.im,
    };
    Ok(values.iter().map(pole).collect())
}
