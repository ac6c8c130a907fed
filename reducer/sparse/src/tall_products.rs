//! The inner loops of products of tall blocks: a few thousand rows of a basis against a few columns, all of which stay in the
//! caches. General matrix products pack such operands first, which takes longer than the arithmetic on so few columns.

#![allow(clippy::needless_range_loop)] // loops of a constant length over several arrays, to be unrolled

use faer::{MatMut, MatRef};

/// Columns of either block taken together.
const TILE: usize = 4;

/// `out = aᵀ b`, (k, l), for columns that are contiguous; `None` where they aren't.
pub fn dots(a: MatRef<'_, f64>, b: MatRef<'_, f64>, out: MatMut<'_, f64>) -> Option<()> {
    assert_eq!(a.nrows(), b.nrows());
    assert_eq!((out.nrows(), out.ncols()), (a.ncols(), b.ncols()));
    let (a, b) = (Columns::of(a)?, Columns::of(b)?);
    pulp::Arch::new().dispatch(Dots { a, b, out });
    Some(())
}

/// `y += factor · v c` for columns that are contiguous; `None`, with nothing done, where they aren't.
pub fn add(y: MatMut<'_, f64>, v: MatRef<'_, f64>, c: MatRef<'_, f64>, factor: f64) -> Option<()> {
    assert_eq!((y.nrows(), y.ncols()), (v.nrows(), c.ncols()));
    assert_eq!(v.ncols(), c.nrows());
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
        (block.row_stride() == 1).then_some(Self(block))
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
        let Self {
            mut y,
            v,
            c,
            factor,
        } = self;
        for k in (0..v.0.ncols()).step_by(TILE) {
            let left = v.tile(k);
            for j in (0..y.ncols()).step_by(TILE) {
                let count = TILE.min(y.ncols() - j);
                // Where the last column stands again it has no weight.
                let mut weights = [[0.0; TILE]; TILE];
                for s in 0..TILE.min(c.nrows() - k) {
                    for t in 0..count {
                        weights[s][t] = factor * c[(k + s, j + t)];
                    }
                }
                let mut columns = y.as_mut().subcols_mut(j, count).col_iter_mut();
                let mut next = || Some(columns.next()?.try_as_col_major_mut()?.as_slice_mut());
                if count == TILE
                    && let (Some(y0), Some(y1), Some(y2), Some(y3)) =
                        (next(), next(), next(), next())
                {
                    add_tile(simd, [y0, y1, y2, y3], left, &weights);
                } else {
                    for t in 0..count {
                        if let Some(y) = next() {
                            add_column(simd, y, left, weights.map(|row| row[t]));
                        }
                    }
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

/// `y += Σₛ vₛ cₛ`
#[inline(always)]
fn add_column<S: pulp::Simd>(simd: S, y: &mut [f64], v: [&[f64]; TILE], c: [f64; TILE]) {
    let rows = y.len();
    let packed = rows / S::F64_LANES;
    for i in packed * S::F64_LANES..rows {
        for s in 0..TILE {
            y[i] += v[s][i] * c[s];
        }
    }
    let mut x: [&[S::f64s]; TILE] = [&[]; TILE];
    let mut weights = [simd.splat_f64s(0.0); TILE];
    for s in 0..TILE {
        x[s] = &S::as_simd_f64s(v[s]).0[..packed];
        weights[s] = simd.splat_f64s(c[s]);
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use faer::Mat;

    fn filled(rows: usize, columns: usize, seed: usize) -> Mat<f64> {
        Mat::from_fn(rows, columns, |i, j| {
            ((i * (j + seed)) as f64 * 0.7 + 1.0).sin()
        })
    }

    #[test]
    fn products_of_any_shape_are_those_of_plain_loops() {
        for rows in [0, 1, 7, 8, 9, 130] {
            for k in [0, 1, 3, 4, 5, 9] {
                for l in [0, 1, 2, 4, 7, 8] {
                    let (a, b, c) = (filled(rows, k, 1), filled(rows, l, 2), filled(k, l, 3));
                    let mut out = Mat::from_fn(k, l, |_, _| f64::NAN);
                    dots(a.as_ref(), b.as_ref(), out.as_mut()).unwrap();
                    let mut y = b.clone();
                    add(y.as_mut(), a.as_ref(), c.as_ref(), -2.0).unwrap();
                    for j in 0..l {
                        for i in 0..k {
                            let sum: f64 = (0..rows).map(|r| a[(r, i)] * b[(r, j)]).sum();
                            assert!((out[(i, j)] - sum).abs() < 1e-12);
                        }
                        for r in 0..rows {
                            let sum: f64 = (0..k).map(|i| a[(r, i)] * c[(i, j)]).sum();
                            assert!((y[(r, j)] - (b[(r, j)] - 2.0 * sum)).abs() < 1e-12);
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn columns_that_are_not_contiguous_are_left_to_others() {
        let (wide, b) = (filled(3, 40, 1), filled(40, 2, 2));
        let mut out = Mat::zeros(3, 2);
        assert!(dots(wide.transpose(), b.as_ref(), out.as_mut()).is_none());
        let mut turned = filled(2, 40, 4);
        let before = turned.clone();
        let c = filled(2, 2, 5);
        assert!(add(turned.as_mut().transpose_mut(), b.as_ref(), c.as_ref(), 1.0).is_none());
        assert_eq!(turned, before);
    }
}
