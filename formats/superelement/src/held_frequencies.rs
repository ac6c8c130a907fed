//! Eigenvalues with all interfaces held: of a superelement by dense algebra, of the unreduced component by counting.
//!
//! *Reduced.* ReducedCoordinates y with stiffness diag(k), mass 1 or 0 each and interface motion B y: the motions with B y = 0 are spanned by Z, and
//! the eigenvalues are those of (Zᵀ k Z, Zᵀ m Z). With all motions shifted by τ and (k + τ m)^½ Z = Q R they are those of the compliances
//! R⁻ᵀ Zᵀ m Z R⁻¹, inverted; the lowest eigenvalues keep their digits however stiff the attachments are.
//!
//! *Unreduced.* Holding m independent rows of K - λ M takes as many pivots of one sign as H(λ) has (Sylvester's law for the bordered matrix):
//!
//! ```text
//! number of held eigenvalues below λ  =  number of free ones  -  number of negative eigenvalues of H(λ)
//! ```
//! The free ones are certified, H(λ) is exact, so bisection finds every held eigenvalue (Wittrick and Williams).

use dcb_dense::symmetric_eigen;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, Par};

use crate::Receptance;

/// Pivots of the interface motions below this fraction of the largest belong to dependent rows.
const DEPENDENT: f64 = 1e-10;
/// Steps of a bisection: more than a double has digits.
const BISECTIONS: usize = 70;
/// Relative width at which a bisection ends.
const WIDTH: f64 = 4.0 * f64::EPSILON;
/// A count at an eigenvalue is repeated this far beside it, relatively.
const BESIDE: f64 = 1e-13;

/// Reduced coordinates of a superelement.
#[derive(Clone, Debug)]
pub struct ReducedCoordinates {
    /// k; positive for massless coordinates.
    pub stiffness: Vec<f64>,
    /// How many of them, the last ones, have no mass; the others have mass 1.
    pub massless: usize,
    /// B, (m, n).
    pub shapes: Mat<f64>,
}

impl ReducedCoordinates {
    /// All with mass.
    pub fn dynamic(stiffness: &[f64], shapes: &Mat<f64>) -> Self {
        Self {
            stiffness: stiffness.to_vec(),
            massless: 0,
            shapes: shapes.clone(),
        }
    }

    /// ω² with B y = 0, ascending, without the `loose` lowest, which are motions without stiffness.
    pub fn held(&self, loose: usize) -> Option<Vec<f64>> {
        let n = self.stiffness.len();
        let dynamic = n - self.massless;
        if n == 0 || self.shapes.nrows() == 0 {
            return Some(Vec::new());
        }
        let motions = free_motions(&self.shapes);
        let free = motions.ncols();
        if free == 0 {
            return Some(Vec::new());
        }
        let positive = self.stiffness[..dynamic].iter().filter(|k| **k > 0.0);
        let shift = positive.copied().reduce(f64::min).unwrap_or(1.0);
        let mass = |i: usize| if i < dynamic { 1.0 } else { 0.0 };
        let stretched = Mat::from_fn(n, free, |i, j| {
            (self.stiffness[i] + shift * mass(i)).sqrt() * motions[(i, j)]
        });
        // A = Q R: the compliances are the squared singular values of m^1/2 Z R^-1, transposed here.
        let triangle = stretched.qr().thin_R().transpose().to_owned();
        let mut moving = motions.subrows(0, dynamic).transpose().to_owned();
        solve_lower_triangular_in_place(triangle.as_ref(), moving.as_mut(), Par::Seq);
        let product = &moving * moving.transpose();
        let (compliances, _) = symmetric_eigen(product.as_ref())?;
        // A direction without mass has the compliance zero: no eigenvalue.
        let largest = compliances.last().copied().unwrap_or(0.0);
        Some(
            (compliances.iter().rev())
                .filter(|compliance| **compliance > f64::EPSILON * free as f64 * largest)
                .map(|compliance| 1.0 / compliance - shift)
                .skip(loose)
                .collect(),
        )
    }
}

/// How many independent motions B (m, n) gives its rows.
pub fn rank(shapes: &Mat<f64>) -> usize {
    shapes.ncols() - free_motions(shapes).ncols()
}

/// Orthonormal basis Z of the null space of B, (m, n): B Z = 0. It takes finitely many steps, even if rows repeat.
fn free_motions(rows: &Mat<f64>) -> Mat<f64> {
    let n = rows.ncols();
    if rows.nrows() == 0 {
        return Mat::identity(n, n);
    }
    let of_rows = rows.transpose().col_piv_qr();
    let pivots = of_rows.thin_R();
    let sizes: Vec<f64> = (0..pivots.nrows()).map(|i| pivots[(i, i)].abs()).collect();
    let limit = DEPENDENT * sizes.iter().copied().fold(0.0, f64::max);
    let rank = sizes.iter().filter(|size| **size > limit).count();
    of_rows.compute_Q().subcols(rank, n - rank).to_owned()
}

/// ω² with the interfaces held where interface forces are coordinates (weak), ascending; the growing motions, with negative ω², are left
/// out, as are the `loose` lowest.
///
/// ```text
/// [ Zᵀ diag(k) Z   -Zᵀ Bᵀ T    ] [ y ]        [ y ]
/// [   -Tᵀ B Z       -diag(σ²)  ] [ t ]  =  ω² [ t ]
/// ```
/// Z are the motions that don't move the rows in the `rigid` directions, in which the form has no residual flexibility.
pub fn dual_eigenvalues(
    stiffness: &[f64],
    shapes: &Mat<f64>,
    sigma_squared: &[f64],
    forces: &Mat<f64>,
    rigid: &Mat<f64>,
    loose: usize,
) -> Option<Vec<f64>> {
    let motions = free_motions(&(rigid.transpose() * shapes));
    let (n, rank) = (motions.ncols(), sigma_squared.len());
    let loaded = Mat::from_fn(stiffness.len(), n, |i, j| stiffness[i] * motions[(i, j)]);
    let elastic = motions.transpose() * loaded;
    let coupling = motions.transpose() * shapes.transpose() * forces;
    let matrix = Mat::from_fn(n + rank, n + rank, |i, j| match (i < n, j < n) {
        (true, true) => 0.5 * (elastic[(i, j)] + elastic[(j, i)]),
        (false, false) if i == j => -sigma_squared[i - n],
        (true, false) => -coupling[(i, j - n)],
        (false, true) => -coupling[(j, i - n)],
        _ => 0.0,
    });
    let (values, _) = symmetric_eigen(matrix.as_ref())?;
    Some(values.into_iter().skip(rank + loose).collect())
}

/// Held eigenvalues of the unreduced component below `limit`, ascending. `response` is H between independent combinations of
/// rows, `free` the free eigenvalues, rigid ones as zeros, ascending.
pub fn counted_eigenvalues(
    response: &Receptance,
    free: &[f64],
    loose: usize,
    limit: f64,
) -> Option<Vec<f64>> {
    let count = |lambda: f64| -> Option<usize> {
        let at = |lambda: f64| {
            let (values, _) = symmetric_eigen(response.at_real(lambda).as_ref())?;
            let negative = values.iter().filter(|value| **value < 0.0).count();
            let below = free
                .iter()
                .filter(|eigenvalue| **eigenvalue < lambda)
                .count();
            Some(below.saturating_sub(negative))
        };
        at(lambda).or_else(|| at(lambda * (1.0 + BESIDE)))
    };
    let total = count(limit)?;
    let mut found: Vec<f64> = Vec::new();
    for index in loose..total {
        let mut below = found.last().map_or(0.0, |last| last * (1.0 - BESIDE));
        let mut above = limit;
        for _ in 0..BISECTIONS {
            if above - below <= WIDTH * above {
                break;
            }
            let middle = 0.5 * (below + above);
            match count(middle)? > index {
                true => above = middle,
                false => below = middle,
            }
        }
        found.push(0.5 * (below + above));
    }
    Some(found)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// A chain of three unit masses and two unit springs: free eigenvalues 0, 1, 3; held at the first mass those of
    /// [[2, -1], [-1, 1]], (3 ± √5)/2; held at both ends 2.
    fn chain() -> (Vec<f64>, Mat<f64>) {
        let (a, b, c) = (3.0_f64.sqrt(), 2.0_f64.sqrt(), 6.0_f64.sqrt());
        let shapes = [
            [1.0 / a, 1.0 / b, 1.0 / c],
            [1.0 / a, 0.0, -2.0 / c],
            [1.0 / a, -1.0 / b, 1.0 / c],
        ];
        (vec![0.0, 1.0, 3.0], Mat::from_fn(3, 3, |i, j| shapes[i][j]))
    }

    fn agree(found: &[f64], expected: &[f64]) {
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }

    #[test]
    fn a_chain_held_at_one_and_at_both_ends() {
        let (free, shapes) = chain();
        let one = [(3.0 - 5.0_f64.sqrt()) / 2.0, (3.0 + 5.0_f64.sqrt()) / 2.0];
        for (rows, expected) in [(vec![0], one.to_vec()), (vec![0, 2], vec![2.0])] {
            let at_rows = Mat::from_fn(rows.len(), 3, |i, j| shapes[(rows[i], j)]);
            agree(
                &ReducedCoordinates::dynamic(&free, &at_rows)
                    .held(0)
                    .unwrap(),
                &expected,
            );
            let response = Receptance::symmetric(free.clone(), at_rows, Vec::new(), 1.0);
            let counted = counted_eigenvalues(&response, &free, 0, 2.9).unwrap();
            agree(&counted, &expected);
        }
    }

    #[test]
    fn coordinates_without_mass_follow() {
        // A unit mass that hangs on a spring of stiffness 4: the spring is the massless coordinate.
        let coordinates = ReducedCoordinates {
            stiffness: vec![0.0, 1.0],
            massless: 1,
            shapes: Mat::from_fn(1, 2, |_, j| [1.0, 0.5][j]),
        };
        agree(&coordinates.held(0).unwrap(), &[4.0]);
    }

    #[test]
    fn growing_motions_of_the_dual_form_are_left_out() {
        // K = [[1, -c], [-c, -4]] with c = 3: eigenvalues (-3 ± √61)/2.
        let unit = |value: f64| Mat::from_fn(1, 1, |_, _| value);
        let found = dual_eigenvalues(&[1.0], &unit(3.0), &[4.0], &unit(1.0), &Mat::zeros(1, 0), 0);
        agree(&found.unwrap(), &[(61.0_f64.sqrt() - 3.0) / 2.0]);
        // Without residual flexibility the row is held itself, and what is left of a chain of three is as above.
        let (free, shapes) = chain();
        let end = Mat::from_fn(1, 3, |_, j| shapes[(0, j)]);
        let found = dual_eigenvalues(&free, &end, &[], &Mat::zeros(1, 0), &unit(1.0), 0);
        agree(
            &found.unwrap(),
            &[(3.0 - 5.0_f64.sqrt()) / 2.0, (3.0 + 5.0_f64.sqrt()) / 2.0],
        );
    }
}
