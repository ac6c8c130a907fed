//! Forward sweep of one front: `w₁ = L₁₁⁻¹ w₁`, then `w₂ -= L₂₁ w₁`.

#![allow(clippy::needless_range_loop)] // loops of a constant length over several arrays, to be unrolled

use super::registers::{ANY, WIDE, ask_ahead, has_registers, rows, scale, subtract_scaled};
use super::{GROUP, Real, STRIP};

/// How far ahead of the arithmetic the factor is asked for, bytes.
const AHEAD: isize = 2048;

pub(super) struct Forward<'a, T, const N: usize> {
    pub(super) packed: &'a [T],
    pub(super) columns: usize,
    pub(super) w: &'a mut [[f64; N]],
}

impl<T: Real, const N: usize> pulp::WithSimd for Forward<'_, T, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        // Registers of a row, those of them taken together, and rows taken together; registers of one or two rows that are left over; strips taken together.
        // The conditions are known when this is compiled: one sweep is. Machines without vectors get a short one.
        if const { S::F64_LANES == 1 } {
            front::<S, T, N, N, 2, 2, 2, 1>(simd, self)
        } else if const { has_registers::<S, N>(1, WIDE) } {
            front::<S, T, N, 1, 1, 12, 1, GROUP>(simd, self)
        } else if const { has_registers::<S, N>(2, WIDE) } {
            front::<S, T, N, 2, 2, 12, 2, GROUP>(simd, self)
        } else if const { has_registers::<S, N>(2, ANY) } {
            front::<S, T, N, 2, 2, 6, 2, GROUP>(simd, self)
        } else if const { has_registers::<S, N>(4, ANY) } {
            front::<S, T, N, 4, 2, 6, 4, GROUP>(simd, self)
        } else if const { has_registers::<S, N>(8, ANY) } {
            front::<S, T, N, 8, 2, 6, 4, GROUP>(simd, self)
        } else {
            front::<S, T, N, 16, 2, 6, 4, GROUP>(simd, self)
        }
    }
}

#[inline(always)]
fn front<
    S: pulp::Simd,
    T: Real,
    const N: usize,
    const R: usize,
    const C: usize,
    const M: usize,
    const L: usize,
    const G: usize,
>(
    simd: S,
    Forward { packed, columns, w }: Forward<'_, T, N>,
) {
    let (mut packed, mut w) = (packed, rows::<S, N, R>(w));
    let strips = columns / STRIP;
    for _ in 0..strips / G {
        (packed, w) = group::<S, T, R, C, M, L, STRIP, G>(simd, packed, w);
    }
    if const { G > 1 } {
        (packed, w) = match strips % G {
            3 => group::<S, T, R, C, M, L, STRIP, 3>(simd, packed, w),
            2 => group::<S, T, R, C, M, L, STRIP, 2>(simd, packed, w),
            1 => group::<S, T, R, C, M, L, STRIP, 1>(simd, packed, w),
            _ => (packed, w),
        };
    }
    if columns & 4 != 0 {
        (packed, w) = group::<S, T, R, C, M, L, 4, 1>(simd, packed, w);
    }
    if columns & 2 != 0 {
        (packed, w) = group::<S, T, R, C, M, L, 2, 1>(simd, packed, w);
    }
    if columns & 1 != 0 {
        group::<S, T, R, C, M, L, 1, 1>(simd, packed, w);
    }
}

/// Solves for the first `G` strips of `W` columns and takes their part from the rows below; returns the strips and rows after these.
#[inline(always)]
fn group<
    'a,
    'w,
    S: pulp::Simd,
    T: Real,
    const R: usize,
    const C: usize,
    const M: usize,
    const L: usize,
    const W: usize,
    const G: usize,
>(
    simd: S,
    packed: &'a [T],
    w: &'w mut [[S::f64s; R]],
) -> (&'a [T], &'w mut [[S::f64s; R]]) {
    let (own, below) = w.split_at_mut(W * G);
    let mut rest = packed;
    let mut strips: [&[[T; W]]; G] = [&[]; G];
    for g in 0..G {
        let (_, open) = own.split_at_mut(W * g);
        let (strip, after) = rest.split_at((open.len() + below.len()) * W);
        let (triangle, strip) = strip.as_chunks::<W>().0.split_at(W);
        let (solved, open) = open.split_at_mut(W);
        solve::<S, T, R, W>(simd, triangle, solved);
        let (inside, strip) = strip.split_at(open.len());
        let solved = solved.as_chunks::<W>().0;
        subtract::<S, T, R, C, M, L, W, 1>(simd, [inside], solved, open);
        strips[g] = strip;
        rest = after;
    }
    let solved = own.as_chunks::<W>().0;
    subtract::<S, T, R, C, M, L, W, G>(simd, strips, solved, below);
    (rest, below)
}

/// `w = L⁻¹ w` for the lower triangle of a strip.
#[inline(always)]
fn solve<S: pulp::Simd, T: Real, const R: usize, const W: usize>(
    simd: S,
    triangle: &[[T; W]],
    w: &mut [[S::f64s; R]],
) {
    for c in 0..W {
        let (solved, open) = w.split_at_mut(c + 1);
        scale(simd, &mut solved[c], triangle[c][c].wide());
        let x = solved[c];
        for (row, w) in open[..W - c - 1].iter_mut().enumerate() {
            subtract_scaled(simd, w, triangle[c + 1 + row][c].wide(), &x);
        }
    }
}

/// `w -= Σ stripᵍ solvedᵍ`
#[inline(always)]
fn subtract<
    S: pulp::Simd,
    T: Real,
    const R: usize,
    const C: usize,
    const M: usize,
    const L: usize,
    const W: usize,
    const G: usize,
>(
    simd: S,
    strips: [&[[T; W]]; G],
    solved: &[[[S::f64s; R]; W]],
    w: &mut [[S::f64s; R]],
) {
    let mut at = 0;
    while at + M <= w.len() {
        tile::<S, T, R, C, M, W, G>(simd, strips, solved, at, w);
        at += M;
    }
    while const { M > 3 } && at + 3 <= w.len() {
        tile::<S, T, R, C, 3, W, G>(simd, strips, solved, at, w);
        at += 3;
    }
    if at + 2 <= w.len() {
        tile::<S, T, R, L, 2, W, G>(simd, strips, solved, at, w);
        at += 2;
    }
    if at < w.len() {
        tile::<S, T, R, L, 1, W, G>(simd, strips, solved, at, w);
    }
}

/// `M` rows from `at` on, `C` registers at a time.
#[inline(always)]
fn tile<
    S: pulp::Simd,
    T: Real,
    const R: usize,
    const C: usize,
    const M: usize,
    const W: usize,
    const G: usize,
>(
    simd: S,
    strips: [&[[T; W]]; G],
    solved: &[[[S::f64s; R]; W]],
    at: usize,
    w: &mut [[S::f64s; R]],
) {
    let (Some(w), Some(factors)) = (
        w[at..].first_chunk_mut::<M>(),
        all_at::<T, M, W, G>(strips, at),
    ) else {
        return;
    };
    let mut first = 0;
    while first < R {
        let mut sums = [[simd.splat_f64s(0.0); C]; M];
        for i in 0..M {
            sums[i].copy_from_slice(&w[i][first..first + C]);
        }
        for (factors, solved) in factors.iter().zip(solved) {
            for c in 0..W {
                // Bit by bit: many lines asked for at once make the arithmetic wait.
                if first == 0 {
                    for i in (c..M).step_by(W) {
                        ask_ahead(&factors[i], AHEAD);
                    }
                }
                let mut x = [simd.splat_f64s(0.0); C];
                x.copy_from_slice(&solved[c][first..first + C]);
                for i in 0..M {
                    subtract_scaled(simd, &mut sums[i], factors[i][c].wide(), &x);
                }
            }
        }
        for i in 0..M {
            w[i][first..first + C].copy_from_slice(&sums[i]);
        }
        first += C;
    }
}

/// `M` rows of each strip; `None` if one has fewer.
#[inline(always)]
fn all_at<T, const M: usize, const W: usize, const G: usize>(
    strips: [&[[T; W]]; G],
    at: usize,
) -> Option<[&[[T; W]; M]; G]> {
    let mut all = [strips[0][at..].first_chunk::<M>()?; G];
    for (chosen, strip) in all.iter_mut().zip(strips) {
        *chosen = strip[at..].first_chunk::<M>()?;
    }
    Some(all)
}
