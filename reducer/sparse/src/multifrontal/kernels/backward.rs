//! Backward sweep of one front: `w₁ = L₁₁⁻ᵀ (w₁ - L₂₁ᵀ w₂)`.

#![allow(clippy::needless_range_loop)] // loops of a constant length over several arrays, to be unrolled

use super::registers::{ANY, WIDE, ask_ahead, has_registers, rows, scale, subtract_scaled};
use super::{Real, STRIP};

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
        // Registers of a row, those of them taken together, columns whose sums are in registers together, and strips taken together; one of these is compiled.
        if const { S::F64_LANES == 1 } {
            front::<S, T, N, N, 2, 8, 1>(simd, self)
        } else if const { has_registers::<S, N>(1, WIDE) } {
            front::<S, T, N, 1, 1, 8, 4>(simd, self)
        } else if const { has_registers::<S, N>(2, WIDE) } {
            front::<S, T, N, 2, 2, 8, 4>(simd, self)
        } else if const { has_registers::<S, N>(4, WIDE) } {
            front::<S, T, N, 4, 2, 8, 4>(simd, self)
        } else if const { has_registers::<S, N>(2, ANY) } {
            front::<S, T, N, 2, 2, 6, 3>(simd, self)
        } else if const { has_registers::<S, N>(4, ANY) } {
            front::<S, T, N, 4, 2, 6, 3>(simd, self)
        } else if const { has_registers::<S, N>(8, ANY) } {
            front::<S, T, N, 8, 2, 6, 3>(simd, self)
        } else {
            front::<S, T, N, 16, 2, 6, 3>(simd, self)
        }
    }
}

/// The strips of the forward sweep from the last to the first.
#[inline(always)]
fn front<
    S: pulp::Simd,
    T: Real,
    const N: usize,
    const R: usize,
    const C: usize,
    const D: usize,
    const G: usize,
>(
    simd: S,
    Backward { packed, columns, w }: Backward<'_, T, N>,
) {
    let (mut packed, mut first, w) = (packed, columns, rows::<S, N, R>(w));
    if columns & 1 != 0 {
        first -= 1;
        packed = group::<S, T, R, C, D, 1, 1>(simd, packed, &mut w[first..]);
    }
    if columns & 2 != 0 {
        first -= 2;
        packed = group::<S, T, R, C, D, 2, 1>(simd, packed, &mut w[first..]);
    }
    if columns & 4 != 0 {
        first -= 4;
        packed = group::<S, T, R, C, D, 4, 1>(simd, packed, &mut w[first..]);
    }
    let strips = columns / STRIP;
    first -= STRIP * (strips % G);
    if const { G > 1 } {
        packed = match strips % G {
            3 => group::<S, T, R, C, D, STRIP, 3>(simd, packed, &mut w[first..]),
            2 => group::<S, T, R, C, D, STRIP, 2>(simd, packed, &mut w[first..]),
            1 => group::<S, T, R, C, D, STRIP, 1>(simd, packed, &mut w[first..]),
            _ => packed,
        };
    }
    for _ in 0..strips / G {
        first -= STRIP * G;
        packed = group::<S, T, R, C, D, STRIP, G>(simd, packed, &mut w[first..]);
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
        let mut factors = strips;
        for g in 0..G {
            factors[g] = &strips[g][W * (G - g) + number * ROWS..][..known.len()];
        }
        subtract::<S, T, R, C, D, W, G>(simd, factors, ahead, known, own);
    }
    for g in (0..G).rev() {
        let (open, solved) = own[W * g..].split_at_mut(W);
        let (triangle, inside) = strips[g].split_at(W);
        let factors = [&inside[..solved.len()]];
        subtract::<S, T, R, C, D, W, 1>(simd, factors, ahead, solved, open);
        solve::<S, T, R, W>(simd, triangle, open);
    }
    before
}

/// `sums -= factorsᵀ known` for the columns of the strips, `D` of them at a time where so many are left, from one strip to the next; what stands
/// `ahead` bytes behind the factors is asked for.
#[inline(always)]
fn subtract<
    S: pulp::Simd,
    T: Real,
    const R: usize,
    const C: usize,
    const D: usize,
    const W: usize,
    const G: usize,
>(
    simd: S,
    strips: [&[[T; W]]; G],
    ahead: isize,
    known: &[[S::f64s; R]],
    sums: &mut [[S::f64s; R]],
) {
    if const { D != 6 || W != STRIP } {
        for (one, sums) in strips.into_iter().zip(sums.chunks_mut(W)) {
            tile::<S, T, R, C, W, W, 0>(simd, [one, one], 0, ahead, known, sums);
        }
    } else if const { G == 1 } {
        let (left, right) = sums.split_at_mut(4);
        let one = strips[0];
        tile::<S, T, R, C, W, 4, 0>(simd, [one, one], 0, ahead, known, left);
        tile::<S, T, R, C, W, 4, 0>(simd, [one, one], 4, ahead, known, right);
    } else {
        let [one, two] = [strips[0], strips[1]];
        tile::<S, T, R, C, W, 6, 0>(simd, [one, one], 0, ahead, known, &mut sums[..6]);
        tile::<S, T, R, C, W, 2, 4>(simd, [one, two], 6, ahead, known, &mut sums[6..12]);
        if const { G == 2 } {
            tile::<S, T, R, C, W, 4, 0>(simd, [two, two], 4, ahead, known, &mut sums[12..]);
        } else {
            let three = strips[2];
            tile::<S, T, R, C, W, 4, 2>(simd, [two, three], 4, ahead, known, &mut sums[12..18]);
            tile::<S, T, R, C, W, 6, 0>(simd, [three, three], 2, ahead, known, &mut sums[18..]);
        }
    }
}

/// `A` columns of a strip from `column` on and the first `B` of the next, `C` registers of a row at a time.
#[inline(always)]
fn tile<
    S: pulp::Simd,
    T: Real,
    const R: usize,
    const C: usize,
    const W: usize,
    const A: usize,
    const B: usize,
>(
    simd: S,
    [strip, next]: [&[[T; W]]; 2],
    column: usize,
    ahead: isize,
    known: &[[S::f64s; R]],
    sums: &mut [[S::f64s; R]],
) {
    let mut first = 0;
    while first < R {
        let mut own = [[simd.splat_f64s(0.0); C]; A];
        let mut beside = [[simd.splat_f64s(0.0); C]; B];
        for d in 0..A {
            own[d].copy_from_slice(&sums[d][first..first + C]);
        }
        for d in 0..B {
            beside[d].copy_from_slice(&sums[A + d][first..first + C]);
        }
        for ((factors, next), known) in strip.iter().zip(next).zip(known) {
            // Row by row, each strip once: many lines asked for at once make the arithmetic wait.
            if first == 0 && column == 0 {
                ask_ahead(factors, ahead);
            }
            if first == 0 && B > 0 {
                ask_ahead(next, ahead);
            }
            let mut x = [simd.splat_f64s(0.0); C];
            x.copy_from_slice(&known[first..first + C]);
            for d in 0..A {
                subtract_scaled(simd, &mut own[d], factors[column + d].wide(), &x);
            }
            for d in 0..B {
                subtract_scaled(simd, &mut beside[d], next[d].wide(), &x);
            }
        }
        for d in 0..A {
            sums[d][first..first + C].copy_from_slice(&own[d]);
        }
        for d in 0..B {
            sums[A + d][first..first + C].copy_from_slice(&beside[d]);
        }
        first += C;
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
