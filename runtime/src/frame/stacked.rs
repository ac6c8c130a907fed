//! Several square matrices below each other, multiplied in one sweep with the widest instructions of the machine at hand.

use faer::MatRef;
use pulp::Simd;

/// Columns that one sweep over the result takes along: the result is loaded and stored once for all of them.
const SWEEP: usize = 4;

/// Matrices (n, n) below each other: column k of all of them is contiguous.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stacked {
    /// Number of rows, n times the number of matrices.
    rows: usize,
    values: Vec<f64>,
}

impl Stacked {
    /// The matrices, all of one size, in this order.
    pub fn of<'a>(matrices: impl Iterator<Item = MatRef<'a, f64>> + Clone) -> Self {
        let rows = matrices.clone().map(|matrix| matrix.nrows()).sum();
        let columns = matrices.clone().map(|matrix| matrix.ncols()).max();
        let mut values = Vec::with_capacity(rows * columns.unwrap_or(0));
        for column in 0..columns.unwrap_or(0) {
            for matrix in matrices.clone() {
                values.extend(matrix.col(column).iter().copied());
            }
        }
        Self { rows, values }
    }

    /// Column l of matrix `which` of size `n`.
    pub fn column(&self, which: usize, n: usize, l: usize) -> &[f64] {
        let first = l * self.rows + which * n;
        &self.values[first..first + n]
    }

    /// `out_r += factor · matrices · x_r` for `R` vectors at once: every entry is loaded once.
    #[inline(always)]
    pub fn add_products<S: Simd, const R: usize>(
        &self,
        simd: S,
        factor: f64,
        x: [&[f64]; R],
        out: [&mut [f64]; R],
    ) {
        let mut out = out;
        let (count, rows) = (x[0].len(), self.rows);
        let scaled = |k: usize| {
            let mut factors = [factor; R];
            for (scaled, x) in factors.iter_mut().zip(&x) {
                *scaled *= x[k];
            }
            factors
        };
        let swept = count - count % SWEEP;
        for (block, first) in self.values[..swept * rows]
            .chunks_exact((SWEEP * rows).max(1))
            .zip((0..swept).step_by(SWEEP))
        {
            let (front, back) = block.split_at(2 * rows);
            let ((a, b), (c, d)) = (front.split_at(rows), back.split_at(rows));
            let factors = [
                scaled(first),
                scaled(first + 1),
                scaled(first + 2),
                scaled(first + 3),
            ];
            add_columns(simd, [a, b, c, d], factors, &mut out);
        }
        for k in swept..count {
            let column = &self.values[k * rows..(k + 1) * rows];
            add_columns(simd, [column], [scaled(k)], &mut out);
        }
    }
}

/// `out_r += Σ_c factors[c][r] columns[c]`
#[inline(always)]
fn add_columns<S: Simd, const C: usize, const R: usize>(
    simd: S,
    columns: [&[f64]; C],
    factors: [[f64; R]; C],
    out: &mut [&mut [f64]; R],
) {
    // Loops instead of closures over arrays: a closure that isn't inlined loses the wide instructions.
    let zero = simd.splat_f64s(0.0);
    let mut wide = [[zero; R]; C];
    let mut heads: [&[S::f64s]; C] = [&[]; C];
    let mut tails: [&[f64]; C] = [&[]; C];
    let rows = columns[0].len();
    let length = rows / S::F64_LANES;
    for c in 0..C {
        let (head, tail) = S::as_simd_f64s(&columns[c][..rows]);
        (heads[c], tails[c]) = (&head[..length], tail);
        for r in 0..R {
            wide[c][r] = simd.splat_f64s(factors[c][r]);
        }
    }
    for (r, out) in out.iter_mut().enumerate() {
        let (head, tail) = S::as_mut_simd_f64s(&mut out[..rows]);
        for (i, out) in head[..length].iter_mut().enumerate() {
            let mut sum = *out;
            for c in 0..C {
                sum = simd.mul_add_e_f64s(wide[c][r], heads[c][i], sum);
            }
            *out = sum;
        }
        for (i, out) in tail.iter_mut().enumerate() {
            for c in 0..C {
                *out += factors[c][r] * tails[c][i];
            }
        }
    }
}

/// `((a + b) · y, b · rates)`, and `forces += weight b`, in one sweep.
#[inline(always)]
pub fn dot_and_add<S: Simd>(
    simd: S,
    [a, b]: [&[f64]; 2],
    [y, rates]: [&[f64]; 2],
    weight: f64,
    forces: &mut [f64],
) -> [f64; 2] {
    let n = forces.len();
    let (forces, last_forces) = S::as_mut_simd_f64s(forces);
    let (a, last_a) = S::as_simd_f64s(&a[..n]);
    let (b, last_b) = S::as_simd_f64s(&b[..n]);
    let (y, last_y) = S::as_simd_f64s(&y[..n]);
    let (rates, last_rates) = S::as_simd_f64s(&rates[..n]);
    let wide = simd.splat_f64s(weight);
    let (mut of_y, mut of_rates) = (simd.splat_f64s(0.0), simd.splat_f64s(0.0));
    for ((((a, b), y), rates), force) in a.iter().zip(b).zip(y).zip(rates).zip(forces) {
        of_y = simd.mul_add_e_f64s(simd.add_f64s(*a, *b), *y, of_y);
        of_rates = simd.mul_add_e_f64s(*b, *rates, of_rates);
        *force = simd.mul_add_e_f64s(wide, *b, *force);
    }
    let mut sums = [simd.reduce_sum_f64s(of_y), simd.reduce_sum_f64s(of_rates)];
    let last = last_a.iter().zip(last_b).zip(last_y).zip(last_rates);
    for ((((a, b), y), rates), force) in last.zip(last_forces) {
        sums[0] += (a + b) * y;
        sums[1] += b * rates;
        *force += weight * b;
    }
    sums
}

/// `a · b`
#[inline(always)]
pub fn dot<S: Simd>(simd: S, a: &[f64], b: &[f64]) -> f64 {
    let n = a.len();
    let (a, last_a) = S::as_simd_f64s(a);
    let (b, last_b) = S::as_simd_f64s(&b[..n]);
    let mut sum = simd.splat_f64s(0.0);
    for (a, b) in a.iter().zip(b) {
        sum = simd.mul_add_e_f64s(*a, *b, sum);
    }
    last_a
        .iter()
        .zip(last_b)
        .fold(simd.reduce_sum_f64s(sum), |sum, (a, b)| sum + a * b)
}

/// `y += factor x`
#[inline(always)]
pub fn add_scaled<S: Simd>(simd: S, factor: f64, x: &[f64], y: &mut [f64]) {
    let n = y.len();
    let (y, last_y) = S::as_mut_simd_f64s(y);
    let (x, last_x) = S::as_simd_f64s(&x[..n]);
    let wide = simd.splat_f64s(factor);
    for (y, x) in y.iter_mut().zip(x) {
        *y = simd.mul_add_e_f64s(wide, *x, *y);
    }
    for (y, x) in last_y.iter_mut().zip(last_x) {
        *y += factor * x;
    }
}
