//! The inner loops of triangular solutions: one front's columns against a few right-hand sides, whose rows stand together
//! so that a row is one or two registers. Every entry of the factor is loaded once for all right-hand sides.

/// How the entries of a factor are stored; all arithmetic is in double precision.
pub trait Real: pulp::bytemuck::Pod + Send + Sync {
    /// 0.
    const ZERO: Self;

    /// Rounded from double precision.
    fn of(value: f64) -> Self;

    /// In double precision.
    fn wide(self) -> f64;
}

impl Real for f64 {
    const ZERO: Self = 0.0;

    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn wide(self) -> f64 {
        self
    }
}

impl Real for f32 {
    const ZERO: Self = 0.0;

    #[inline(always)]
    fn of(value: f64) -> Self {
        value as Self
    }

    #[inline(always)]
    fn wide(self) -> f64 {
        f64::from(self)
    }
}

/// Rows of the right-hand sides held in registers.
const TILE: usize = 8;

/// How far ahead of the arithmetic the factor is asked for.
const AHEAD: usize = 2048;

/// Asks for the cache lines of a tile's entries some tiles ahead: the arithmetic on one tile is shorter than memory's latency.
#[inline(always)]
fn ask_ahead<T, const W: usize>(tile: &[[T; W]; TILE]) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let start = tile.as_ptr().cast::<i8>().wrapping_add(AHEAD);
        let mut offset = 0;
        while offset < size_of::<[[T; W]; TILE]>() {
            // SAFETY: a prefetch of any address, mapped or not, has no effect but on caches.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(offset)) };
            offset += 64;
        }
    }
}

/// A row of right-hand sides in `R` of the machine's registers.
#[derive(Clone, Copy)]
struct Registers<S: pulp::Simd, const R: usize>([S::f64s; R]);

impl<S: pulp::Simd, const R: usize> Registers<S, R> {
    #[inline(always)]
    fn zero(simd: S) -> Self {
        Self([simd.splat_f64s(0.0); R])
    }

    #[inline(always)]
    fn load(simd: S, row: &[f64]) -> Self {
        let mut registers = Self::zero(simd);
        let (packed, _) = S::as_simd_f64s(row);
        registers.0.copy_from_slice(&packed[..R]);
        registers
    }

    #[inline(always)]
    fn store(self, row: &mut [f64]) {
        let (packed, _) = S::as_mut_simd_f64s(row);
        packed[..R].copy_from_slice(&self.0);
    }

    /// `self += factor · x`
    #[inline(always)]
    fn add_scaled(&mut self, simd: S, factor: f64, x: &Self) {
        let factor = simd.splat_f64s(factor);
        for i in 0..R {
            self.0[i] = simd.mul_add_f64s(factor, x.0[i], self.0[i]);
        }
    }

    #[inline(always)]
    fn scale(&mut self, simd: S, factor: f64) {
        let factor = simd.splat_f64s(factor);
        for i in 0..R {
            self.0[i] = simd.mul_f64s(factor, self.0[i]);
        }
    }
}

/// Columns of each strip of a packed front, from its first column on.
fn strip_widths(columns: usize) -> impl Iterator<Item = usize> {
    let rest = columns % 8;
    let last = [4, 2, 1].into_iter().filter(move |width| rest & width != 0);
    std::iter::repeat_n(8, columns / 8).chain(last)
}

/// Entries of a packed front of `rows` rows and `columns` columns.
pub fn packed_length(rows: usize, columns: usize) -> usize {
    let mut first = 0;
    let mut length = 0;
    for width in strip_widths(columns) {
        length += (rows - first) * width;
        first += width;
    }
    length
}

/// Packs a front's columns as the solutions read them: strips of eight columns (at the end four, two, one), each row by row from
/// its first diagonal entry on. The upper triangle of a strip's first rows is never used. What was eliminated is thus read
/// from one end to the other, or back.
pub fn pack<T: Real>(values: &[f64], rows: usize, columns: usize, packed: &mut [T]) {
    let mut first = 0;
    let mut rest = packed;
    for width in strip_widths(columns) {
        let (strip, after) = rest.split_at_mut((rows - first) * width);
        for c in 0..width {
            let column = &values[(first + c) * rows + first..][..rows - first];
            for (to, from) in strip[c..].iter_mut().step_by(width).zip(column) {
                *to = T::of(*from);
            }
        }
        rest = after;
        first += width;
    }
}

/// `w₁ = L₁₁⁻¹ w₁`, then `w₂ -= L₂₁ w₁`.
pub fn forward<T: Real, const N: usize>(packed: &[T], columns: usize, w: &mut [[f64; N]]) {
    pulp::Arch::new().dispatch(Forward { packed, columns, w });
}

/// `w₁ = L₁₁⁻ᵀ (w₁ - L₂₁ᵀ w₂)`.
pub fn backward<T: Real, const N: usize>(packed: &[T], columns: usize, w: &mut [[f64; N]]) {
    pulp::Arch::new().dispatch(Backward { packed, columns, w });
}

struct Forward<'a, T, const N: usize> {
    packed: &'a [T],
    columns: usize,
    w: &'a mut [[f64; N]],
}

impl<T: Real, const N: usize> pulp::WithSimd for Forward<'_, T, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let Self { packed, columns, w } = self;
        match N / S::F64_LANES {
            1 => forward_front::<S, T, N, 1>(simd, packed, columns, w),
            2 => forward_front::<S, T, N, 2>(simd, packed, columns, w),
            4 => forward_front::<S, T, N, 4>(simd, packed, columns, w),
            8 => forward_front::<S, T, N, 8>(simd, packed, columns, w),
            _ => forward_front::<S, T, N, 16>(simd, packed, columns, w),
        }
    }
}

struct Backward<'a, T, const N: usize> {
    packed: &'a [T],
    columns: usize,
    w: &'a mut [[f64; N]],
}

impl<T: Real, const N: usize> pulp::WithSimd for Backward<'_, T, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let Self { packed, columns, w } = self;
        match N / S::F64_LANES {
            1 => backward_front::<S, T, N, 1>(simd, packed, columns, w),
            2 => backward_front::<S, T, N, 2>(simd, packed, columns, w),
            4 => backward_front::<S, T, N, 4>(simd, packed, columns, w),
            8 => backward_front::<S, T, N, 8>(simd, packed, columns, w),
            _ => backward_front::<S, T, N, 16>(simd, packed, columns, w),
        }
    }
}

#[inline(always)]
fn forward_front<S: pulp::Simd, T: Real, const N: usize, const R: usize>(
    simd: S,
    packed: &[T],
    columns: usize,
    w: &mut [[f64; N]],
) {
    let (mut packed, mut w) = (packed, w);
    for _ in 0..columns / 8 {
        (packed, w) = forward_strip::<S, T, N, R, 8>(simd, packed, w);
    }
    if columns & 4 != 0 {
        (packed, w) = forward_strip::<S, T, N, R, 4>(simd, packed, w);
    }
    if columns & 2 != 0 {
        (packed, w) = forward_strip::<S, T, N, R, 2>(simd, packed, w);
    }
    if columns & 1 != 0 {
        forward_strip::<S, T, N, R, 1>(simd, packed, w);
    }
}

/// The strips of the forward solution from the last to the first.
#[inline(always)]
fn backward_front<S: pulp::Simd, T: Real, const N: usize, const R: usize>(
    simd: S,
    packed: &[T],
    columns: usize,
    w: &mut [[f64; N]],
) {
    let (mut packed, mut first) = (packed, columns);
    if columns & 1 != 0 {
        first -= 1;
        packed = backward_strip::<S, T, N, R, 1>(simd, packed, &mut w[first..]);
    }
    if columns & 2 != 0 {
        first -= 2;
        packed = backward_strip::<S, T, N, R, 2>(simd, packed, &mut w[first..]);
    }
    if columns & 4 != 0 {
        first -= 4;
        packed = backward_strip::<S, T, N, R, 4>(simd, packed, &mut w[first..]);
    }
    for _ in 0..columns / 8 {
        first -= 8;
        packed = backward_strip::<S, T, N, R, 8>(simd, packed, &mut w[first..]);
    }
}

/// Solves for the first `W` rows of w and takes their part from the rows below; returns the strips and rows after these.
#[inline(always)]
fn forward_strip<'a, 'w, S: pulp::Simd, T: Real, const N: usize, const R: usize, const W: usize>(
    simd: S,
    packed: &'a [T],
    w: &'w mut [[f64; N]],
) -> (&'a [T], &'w mut [[f64; N]]) {
    let (strip, after) = packed.split_at(w.len() * W);
    let (strip, _) = strip.as_chunks::<W>();
    let (triangle, strip) = strip.split_at(W);
    let (solved, below) = w.split_at_mut(W);
    let mut x = [Registers::<S, R>::zero(simd); W];
    for c in 0..W {
        x[c] = Registers::load(simd, &solved[c]);
    }
    for c in 0..W {
        x[c].scale(simd, 1.0 / triangle[c][c].wide());
        let done = x[c];
        for r in c + 1..W {
            x[r].add_scaled(simd, -triangle[r][c].wide(), &done);
        }
        done.store(&mut solved[c]);
    }
    let (tiles, rest) = below.as_chunks_mut::<TILE>();
    let (factors, last) = strip.as_chunks::<TILE>();
    for (tile, factors) in tiles.iter_mut().zip(factors) {
        ask_ahead(factors);
        let mut sums = [Registers::<S, R>::zero(simd); TILE];
        for i in 0..TILE {
            sums[i] = Registers::load(simd, &tile[i]);
        }
        for c in 0..W {
            for i in 0..TILE {
                sums[i].add_scaled(simd, -factors[i][c].wide(), &x[c]);
            }
        }
        for i in 0..TILE {
            sums[i].store(&mut tile[i]);
        }
    }
    for (w, factors) in rest.iter_mut().zip(last) {
        let mut sum = Registers::load(simd, w);
        for c in 0..W {
            sum.add_scaled(simd, -factors[c].wide(), &x[c]);
        }
        sum.store(w);
    }
    (after, below)
}

/// Takes the part of the rows below from the first `W` rows of w and solves for them; returns the strips before this one.
#[inline(always)]
fn backward_strip<'a, S: pulp::Simd, T: Real, const N: usize, const R: usize, const W: usize>(
    simd: S,
    packed: &'a [T],
    w: &mut [[f64; N]],
) -> &'a [T] {
    let (before, strip) = packed.split_at(packed.len() - w.len() * W);
    let (strip, _) = strip.as_chunks::<W>();
    let (triangle, strip) = strip.split_at(W);
    let (solved, below) = w.split_at_mut(W);
    let mut sums = [Registers::<S, R>::zero(simd); W];
    for c in 0..W {
        sums[c] = Registers::load(simd, &solved[c]);
    }
    let (tiles, rest) = below.as_chunks::<TILE>();
    let (factors, last) = strip.as_chunks::<TILE>();
    for (tile, factors) in tiles.iter().zip(factors) {
        ask_ahead(factors);
        for i in 0..TILE {
            let known = Registers::load(simd, &tile[i]);
            for c in 0..W {
                sums[c].add_scaled(simd, -factors[i][c].wide(), &known);
            }
        }
    }
    for (w, factors) in rest.iter().zip(last) {
        let known = Registers::load(simd, w);
        for c in 0..W {
            sums[c].add_scaled(simd, -factors[c].wide(), &known);
        }
    }
    for c in 0..W {
        sums[c].store(&mut solved[c]);
    }
    for c in (0..W).rev() {
        let mut x = Registers::<S, R>::load(simd, &solved[c]);
        for r in c + 1..W {
            let done = Registers::load(simd, &solved[r]);
            x.add_scaled(simd, -triangle[r][c].wide(), &done);
        }
        x.scale(simd, 1.0 / triangle[c][c].wide());
        x.store(&mut solved[c]);
    }
    before
}
