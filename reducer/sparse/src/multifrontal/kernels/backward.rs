//! Backward sweep of one front: `w₁ = L₁₁⁻ᵀ (w₁ - L₂₁ᵀ w₂)`.

#![allow(clippy::needless_range_loop)] // loops of a constant length over several arrays, to be unrolled

use super::registers::{ask_ahead, rows, scale, subtract_scaled};
use super::{GROUP, Real, STRIP};

/// Rows below that stay in the nearest cache while they serve all columns of a group.
const ROWS: usize = 64;
/// A group of so many bytes is in a cache when its turn comes if it was asked for during the one before.
const CACHED: usize = 128 << 10;

pub(super) struct Backward<'a, T, const N: usize> {
    pub(super) packed: &'a [T],
    pub(super) columns: usize,
    pub(super) w: &'a mut [[f64; N]],
}

impl<T: Real, const N: usize> pulp::WithSimd for Backward<'_, T, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        // Registers of a row, those of them taken together, and columns of a strip taken together.
        match (S::F64_LANES, N / S::F64_LANES) {
            (8, 1) => front::<S, T, N, 1, 1, 8>(simd, self),
            (8, 2) => front::<S, T, N, 2, 2, 8>(simd, self),
            (8, 4) => front::<S, T, N, 4, 2, 8>(simd, self),
            (_, 2) => front::<S, T, N, 2, 2, 4>(simd, self),
            (_, 4) => front::<S, T, N, 4, 2, 4>(simd, self),
            (_, 8) => front::<S, T, N, 8, 2, 4>(simd, self),
            (_, 16) => front::<S, T, N, 16, 2, 4>(simd, self),
            _ => front::<S, T, N, 32, 2, 4>(simd, self),
        }
    }
}

/// The strips of the forward sweep from the last to the first.
#[inline(always)]
fn front<S: pulp::Simd, T: Real, const N: usize, const R: usize, const C: usize, const D: usize>(
    simd: S,
    Backward { packed, columns, w }: Backward<'_, T, N>,
) {
    let (mut packed, mut first, w) = (packed, columns, rows::<S, N, R>(w));
    if columns & 1 != 0 {
        first -= 1;
        packed = group::<S, T, R, C, 1, 1, 1>(simd, packed, &mut w[first..]);
    }
    if columns & 2 != 0 {
        first -= 2;
        packed = group::<S, T, R, C, 2, 2, 1>(simd, packed, &mut w[first..]);
    }
    if columns & 4 != 0 {
        first -= 4;
        packed = group::<S, T, R, C, 4, 4, 1>(simd, packed, &mut w[first..]);
    }
    let strips = columns / STRIP;
    first -= STRIP * (strips % GROUP);
    packed = match strips % GROUP {
        3 => group::<S, T, R, C, D, STRIP, 3>(simd, packed, &mut w[first..]),
        2 => group::<S, T, R, C, D, STRIP, 2>(simd, packed, &mut w[first..]),
        1 => group::<S, T, R, C, D, STRIP, 1>(simd, packed, &mut w[first..]),
        _ => packed,
    };
    for _ in 0..strips / GROUP {
        first -= STRIP * GROUP;
        packed = group::<S, T, R, C, D, STRIP, GROUP>(simd, packed, &mut w[first..]);
    }
}

/// Takes the part of the rows below from the first `G` strips of `W` columns and solves for them; returns the strips before these.
#[inline(always)]
fn group<
    'a,
    S: pulp::Simd,
    T: Real,
    const R: usize,
    const C: usize,
    const D: usize,
    const W: usize,
    const G: usize,
>(
    simd: S,
    packed: &'a [T],
    w: &mut [[S::f64s; R]],
) -> &'a [T] {
    let (own, below) = w.split_at_mut(W * G);
    let mut before = packed;
    let mut strips: [&[[T; W]]; G] = [&[]; G];
    for g in (0..G).rev() {
        let strip;
        (before, strip) = before.split_at(before.len() - (W * (G - g) + below.len()) * W);
        strips[g] = strip.as_chunks::<W>().0;
    }
    let bytes = size_of_val(packed) - size_of_val(before);
    let ahead = match bytes > CACHED {
        true => (ROWS * size_of::<[T; W]>()) as isize,
        false => -(bytes as isize),
    };
    for (number, known) in below.chunks(ROWS).enumerate() {
        for g in 0..G {
            let at = W * (G - g) + number * ROWS;
            let factors = &strips[g][at..at + known.len()];
            let sums = &mut own[W * g..W * (g + 1)];
            subtract::<S, T, R, C, D, W>(simd, factors, ahead, known, sums);
        }
    }
    for g in (0..G).rev() {
        let (open, solved) = own[W * g..].split_at_mut(W);
        let (triangle, inside) = strips[g].split_at(W);
        let factors = &inside[..solved.len()];
        subtract::<S, T, R, C, D, W>(simd, factors, ahead, solved, open);
        solve::<S, T, R, W>(simd, triangle, open);
    }
    before
}

/// `sums -= factorsᵀ known`, `D` of the strip's columns and `C` registers of a row at a time; what stands `ahead` bytes behind the factors is asked for.
#[inline(always)]
fn subtract<
    S: pulp::Simd,
    T: Real,
    const R: usize,
    const C: usize,
    const D: usize,
    const W: usize,
>(
    simd: S,
    factors: &[[T; W]],
    ahead: isize,
    known: &[[S::f64s; R]],
    sums: &mut [[S::f64s; R]],
) {
    let mut column = 0;
    while column < W {
        let mut first = 0;
        while first < R {
            let mut own = [[simd.splat_f64s(0.0); C]; D];
            for d in 0..D {
                own[d].copy_from_slice(&sums[column + d][first..first + C]);
            }
            for (factors, known) in factors.iter().zip(known) {
                // Row by row: many lines asked for at once make the arithmetic wait.
                if column + first == 0 {
                    ask_ahead(factors, ahead);
                }
                let mut x = [simd.splat_f64s(0.0); C];
                x.copy_from_slice(&known[first..first + C]);
                for d in 0..D {
                    subtract_scaled(simd, &mut own[d], factors[column + d].wide(), &x);
                }
            }
            for d in 0..D {
                sums[column + d][first..first + C].copy_from_slice(&own[d]);
            }
            first += C;
        }
        column += D;
    }
}

/// `w = L⁻ᵀ w` for the lower triangle of a strip: what is solved is taken from all open rows at once, so that these don't wait for
/// each other.
#[inline(always)]
fn solve<S: pulp::Simd, T: Real, const R: usize, const W: usize>(
    simd: S,
    triangle: &[[T; W]],
    w: &mut [[S::f64s; R]],
) {
    for c in (0..W).rev() {
        let (open, solved) = w.split_at_mut(c);
        let x = &mut solved[0];
        scale(simd, x, triangle[c][c].wide());
        for (j, w) in open.iter_mut().enumerate() {
            subtract_scaled(simd, w, triangle[c][j].wide(), x);
        }
    }
}
