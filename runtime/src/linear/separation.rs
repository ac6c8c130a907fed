//! The part of a linear system whose motions decay, apart from the rest.
//!
//! The sign function S of A + δ 1, by Newton's iteration, has the invariant subspaces of the eigenvalues on both sides of -δ as those of
//! (1 - S)/2 and (1 + S)/2; no eigenvector is asked for, so that repeated and defective eigenvalues do no harm.

use faer::Mat;
use faer::linalg::solvers::{DenseSolveCore, Solve};

use crate::error::Error;

/// Iterations of the sign function: two for each power of ten between the eigenvalues and the axis, and some.
const ITERATIONS: usize = 100;
/// The iteration has come to its end when it changes by less.
const CONVERGED: f64 = 1e-12;
/// What couples the parts, as a part of A, where they are apart.
const APART: f64 = 1e-7;

/// A system whose A is `diag(decaying, rest)`.
pub(super) struct Separated {
    /// Columns: a basis of the states that decay, then one of the rest.
    pub basis: Mat<f64>,
    /// Its inverse.
    pub inverse: Mat<f64>,
}

impl Separated {
    /// Of A, of which `count` eigenvalues have real parts below -`margin` and the others above.
    pub(super) fn of(a: &Mat<f64>, count: usize, margin: f64) -> Result<Self, Error> {
        let n = a.nrows();
        let one = Mat::<f64>::identity(n, n);
        if count == n {
            return Ok(Self {
                basis: one.clone(),
                inverse: one,
            });
        }
        let sign = sign(&(a + faer::Scale(margin) * &one))?;
        let half = faer::Scale(0.5);
        let decaying = range(&((&one - &sign) * half), count)?;
        let rest = range(&((&one + &sign) * half), n - count)?;
        let basis = Mat::from_fn(n, n, |i, j| match j < count {
            true => decaying[(i, j)],
            false => rest[(i, j - count)],
        });
        let inverse = basis.partial_piv_lu().inverse();
        let turned = &inverse * a * &basis;
        let coupling = turned.as_ref().submatrix(0, count, count, n - count);
        let back = turned.as_ref().submatrix(count, 0, n - count, count);
        let left = coupling.norm_l2().max(back.norm_l2());
        match left <= APART * turned.norm_l2() {
            true => Ok(Self { basis, inverse }),
            false => Err(Error::NoEigenvalues),
        }
    }
}

/// Orthonormal columns of a projector's range.
fn range(projector: &Mat<f64>, rank: usize) -> Result<Mat<f64>, Error> {
    let factors = projector.svd().map_err(|_| Error::NoEigenvalues)?;
    Ok(factors.U().subcols(0, rank).to_owned())
}

/// Newton's iteration `S ← (S / c + c S⁻¹) / 2` from A, with c that makes both alike.
fn sign(a: &Mat<f64>) -> Result<Mat<f64>, Error> {
    let mut sign = a.clone();
    for _ in 0..ITERATIONS {
        let (next, change) = improved(&sign);
        if !change.is_finite() {
            break;
        }
        sign = next;
        if change < CONVERGED {
            return Ok(sign);
        }
    }
    Err(Error::NoEigenvalues)
}

fn improved(sign: &Mat<f64>) -> (Mat<f64>, f64) {
    let inverse = sign.partial_piv_lu().inverse();
    let scale = factor(sign, &inverse);
    let next = faer::Scale(0.5 / scale) * sign + faer::Scale(0.5 * scale) * &inverse;
    let change = (&next - sign).norm_l2() / next.norm_l2();
    (next, change)
}

/// c: one near the end, where it would only disturb.
fn factor(sign: &Mat<f64>, inverse: &Mat<f64>) -> f64 {
    let scale = (sign.norm_l2() / inverse.norm_l2()).sqrt();
    if (scale - 1.0).abs() < 1e-2 {
        1.0
    } else {
        scale
    }
}

/// Factors of Gramians: Y with `A P + P Aᵀ + B Bᵀ = 0`, `P = Y Yᵀ`, for each B; A decays.
pub(super) fn gramian_factors(a: &Mat<f64>, inputs: Vec<Mat<f64>>) -> Result<Vec<Mat<f64>>, Error> {
    let mut inputs = inputs;
    let mut sign = a.clone();
    for _ in 0..ITERATIONS {
        let inverse = sign.partial_piv_lu();
        let inverse_matrix = inverse.inverse();
        let scale = factor(&sign, &inverse_matrix);
        for input in &mut inputs {
            let solved = inverse.solve(&*input);
            let (own, far) = ((0.5 / scale).sqrt(), (0.5 * scale).sqrt());
            let both = Mat::from_fn(input.nrows(), 2 * input.ncols(), |i, j| {
                match j < input.ncols() {
                    true => own * input[(i, j)],
                    false => far * solved[(i, j - input.ncols())],
                }
            });
            *input = compressed(both);
        }
        let next = faer::Scale(0.5 / scale) * &sign + faer::Scale(0.5 * scale) * inverse_matrix;
        let change = (&next - &sign).norm_l2() / next.norm_l2();
        if !change.is_finite() {
            break;
        }
        sign = next;
        if change < CONVERGED {
            let half = faer::Scale(0.5_f64.sqrt());
            return Ok(inputs.into_iter().map(|input| input * half).collect());
        }
    }
    Err(Error::NoEigenvalues)
}

/// A factor Y of the same Y Yᵀ with at most as many columns as rows.
pub(super) fn compressed(factor: Mat<f64>) -> Mat<f64> {
    match factor.ncols() > factor.nrows() {
        false => factor,
        true => factor
            .transpose()
            .to_owned()
            .qr()
            .thin_R()
            .transpose()
            .to_owned(),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// x' = -x + 2 u has the Gramian 2.
    #[test]
    fn gramians_solve_their_equations() {
        let a = Mat::from_fn(3, 3, |i, j| match (i, j) {
            (0, 0) => -1.0,
            (1, 1) | (2, 2) => -0.01,
            (1, 2) => 40.0,
            (2, 1) => -30.0,
            _ => 0.0,
        });
        let b = Mat::from_fn(3, 1, |i, _| 2.0 - i as f64);
        let factor = gramian_factors(&a, vec![b.clone()]).unwrap().remove(0);
        let gramian = &factor * factor.transpose();
        assert!((gramian[(0, 0)] - 2.0).abs() < 1e-12);
        let left = &a * &gramian + &gramian * a.transpose() + &b * b.transpose();
        assert!(left.norm_l2() < 1e-10 * gramian.norm_l2(), "{left:?}");
    }

    /// A double root at zero and one that grows, apart from two that decay, in mixed coordinates.
    #[test]
    fn defective_and_growing_states_come_apart() {
        let turn = Mat::from_fn(5, 5, |i, j| {
            ((3 * i + 7 * j) as f64).sin() + f64::from(u8::from(i == j))
        });
        let mut canonical = Mat::zeros(5, 5);
        canonical[(0, 1)] = 1.0;
        canonical[(2, 2)] = 3.0;
        canonical[(3, 3)] = -2.0;
        canonical[(4, 4)] = -0.1;
        let a = &turn * &canonical * turn.partial_piv_lu().inverse();
        let apart = Separated::of(&a, 2, 0.05).unwrap();
        let turned = &apart.inverse * &a * &apart.basis;
        let trace = turned[(0, 0)] + turned[(1, 1)];
        assert!((trace + 2.1).abs() < 1e-10, "{trace}");
    }
}
