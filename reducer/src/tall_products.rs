//! The inner loops of products of tall blocks: a few thousand rows of a basis against a few columns, all of which stay in the
//! caches. General matrix products pack such operands first, which takes longer than the arithmetic on so few columns.

#![allow(clippy::needless_range_loop)] // loops of a constant length over several arrays, to be unrolled

use faer::{MatMut, MatRef};

/// Columns of either block taken together.
const TILE: usize = 4;

/// `out = aᵀ b`, (k, l), for columns that are contiguous; `None` where they aren't.
pub fn dots(a: MatRef<'_, f64>, b: MatRef<'_, f64>, out: MatMut<'_, f64>) -> Option<()> {
    let (a, b) = (Columns::of(a)?, Columns::of(b)?);
    pulp::Arch::new().dispatch(Dots { a, b, out });
    Some(())
}

/// `y += factor · v c` for columns that are contiguous; `None`, with nothing done, where they aren't.
pub fn add(y: MatMut<'_, f64>, v: MatRef<'_, f64>, c: MatRef<'_, f64>, factor: f64) -> Option<()> {
    let v = Columns::of(v)?;
    if y.row_stride() != 1 {
        return None;
    }
    pulp::Arch::new().dispatch(Add { y, v, c, factor });
    Some(())
}

/// The columns of a block with unit row stride.
#[derive(Clone, Copy)]
struct Columns<'a>(MatRef<'a, f64>);

impl<'a> Columns<'a> {
    fn of(block: MatRef<'a, f64>) -> Option<Self> {
        (block.row_stride() == 1 || block.nrows() <= 1).then_some(Self(block))
    }

    /// `TILE` columns from `first` on; beyond the end the last one stands again.
    #[inline(always)]
    fn tile(&self, first: usize) -> [&'a [f64]; TILE] {
        let mut tile: [&[f64]; TILE] = [&[]; TILE];
        for t in 0..TILE {
            let column = self.0.col((first + t).min(self.0.ncols() - 1));
            tile[t] = column.try_as_col_major().map_or(&[], |c| c.as_slice());
        }
        tile
    }
}

struct Dots<'a> {
    a: Columns<'a>,
    b: Columns<'a>,
    out: MatMut<'a, f64>,
}

impl pulp::WithSimd for Dots<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, simd: S) {
        for i in (0..self.a.0.ncols()).step_by(TILE) {
            let a = self.a.tile(i);
            for j in (0..self.b.0.ncols()).step_by(TILE) {
                let sums = tile_dots(simd, a, self.b.tile(j));
                for s in 0..TILE.min(self.out.nrows() - i) {
                    for t in 0..TILE.min(self.out.ncols() - j) {
                        self.out[(i + s, j + t)] = sums[s][t];
                    }
                }
            }
        }
    }
}

#[inline(always)]
fn tile_dots<S: pulp::Simd>(simd: S, a: [&[f64]; TILE], b: [&[f64]; TILE]) -> [[f64; TILE]; TILE] {
    let rows = a[0].len();
    let packed = rows / S::F64_LANES;
    let mut x: [&[S::f64s]; TILE] = [&[]; TILE];
    let mut y: [&[S::f64s]; TILE] = [&[]; TILE];
    for t in 0..TILE {
        x[t] = &S::as_simd_f64s(a[t]).0[..packed];
        y[t] = &S::as_simd_f64s(b[t]).0[..packed];
    }
    let mut sums = [[simd.splat_f64s(0.0); TILE]; TILE];
    for i in 0..packed {
        let right = [y[0][i], y[1][i], y[2][i], y[3][i]];
        for s in 0..TILE {
            let left = x[s][i];
            for t in 0..TILE {
                sums[s][t] = simd.mul_add_f64s(left, right[t], sums[s][t]);
            }
        }
    }
    let mut dots = [[0.0; TILE]; TILE];
    for s in 0..TILE {
        for t in 0..TILE {
            let mut sum = simd.reduce_sum_f64s(sums[s][t]);
            for i in packed * S::F64_LANES..rows {
                sum += a[s][i] * b[t][i];
            }
            dots[s][t] = sum;
        }
    }
    dots
}

struct Add<'a> {
    y: MatMut<'a, f64>,
    v: Columns<'a>,
    c: MatRef<'a, f64>,
    factor: f64,
}

impl pulp::WithSimd for Add<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let Self { y, v, c, factor } = self;
        let mut y = y;
        for k in (0..v.0.ncols()).step_by(TILE) {
            let left = v.tile(k);
            // Where the last column stands again it has no weight.
            let weight = |s: usize, j: usize| match k + s < c.nrows() {
                true => factor * c[(k + s, j)],
                false => 0.0,
            };
            let mut columns = y.as_mut().col_iter_mut();
            let mut next = || {
                let column = columns.next()?;
                Some(column.try_as_col_major_mut()?.as_slice_mut())
            };
            let mut j = 0;
            while let Some(first) = next() {
                let mut weights = [[0.0; TILE]; TILE];
                let count = TILE.min(c.ncols() - j);
                for s in 0..TILE {
                    for t in 0..count {
                        weights[s][t] = weight(s, j + t);
                    }
                }
                if count == TILE
                    && let (Some(second), Some(third), Some(fourth)) = (next(), next(), next())
                {
                    add_tile(simd, [first, second, third, fourth], left, &weights);
                    j += TILE;
                } else {
                    add_column(simd, first, left, &weights);
                    j += 1;
                }
            }
        }
    }
}

/// `yₜ += Σₛ vₛ cₛₜ`
#[inline(always)]
fn add_tile<S: pulp::Simd>(
    simd: S,
    y: [&mut [f64]; TILE],
    v: [&[f64]; TILE],
    c: &[[f64; TILE]; TILE],
) {
    let [y0, y1, y2, y3] = y;
    let rows = y0.len();
    let packed = rows / S::F64_LANES;
    for i in packed * S::F64_LANES..rows {
        for s in 0..TILE {
            y0[i] += v[s][i] * c[s][0];
            y1[i] += v[s][i] * c[s][1];
            y2[i] += v[s][i] * c[s][2];
            y3[i] += v[s][i] * c[s][3];
        }
    }
    let mut x: [&[S::f64s]; TILE] = [&[]; TILE];
    let mut weights = [[simd.splat_f64s(0.0); TILE]; TILE];
    for s in 0..TILE {
        x[s] = &S::as_simd_f64s(v[s]).0[..packed];
        for t in 0..TILE {
            weights[s][t] = simd.splat_f64s(c[s][t]);
        }
    }
    let y0 = &mut S::as_mut_simd_f64s(y0).0[..packed];
    let y1 = &mut S::as_mut_simd_f64s(y1).0[..packed];
    let y2 = &mut S::as_mut_simd_f64s(y2).0[..packed];
    let y3 = &mut S::as_mut_simd_f64s(y3).0[..packed];
    for i in 0..packed {
        let mut sums = [y0[i], y1[i], y2[i], y3[i]];
        for s in 0..TILE {
            let left = x[s][i];
            for t in 0..TILE {
                sums[t] = simd.mul_add_f64s(left, weights[s][t], sums[t]);
            }
        }
        [y0[i], y1[i], y2[i], y3[i]] = sums;
    }
}

/// `y += Σₛ vₛ cₛ₀`
#[inline(always)]
fn add_column<S: pulp::Simd>(simd: S, y: &mut [f64], v: [&[f64]; TILE], c: &[[f64; TILE]; TILE]) {
    let rows = y.len();
    let packed = rows / S::F64_LANES;
    for i in packed * S::F64_LANES..rows {
        for s in 0..TILE {
            y[i] += v[s][i] * c[s][0];
        }
    }
    let mut x: [&[S::f64s]; TILE] = [&[]; TILE];
    let mut weights = [simd.splat_f64s(0.0); TILE];
    for s in 0..TILE {
        x[s] = &S::as_simd_f64s(v[s]).0[..packed];
        weights[s] = simd.splat_f64s(c[s][0]);
    }
    let y = &mut S::as_mut_simd_f64s(y).0[..packed];
    for i in 0..packed {
        let mut sum = y[i];
        for s in 0..TILE {
            sum = simd.mul_add_f64s(x[s][i], weights[s], sum);
        }
        y[i] = sum;
    }
}
