//! The inner loops of products of tall blocks: a few thousand rows of a basis against a few columns, all of which stay in the
//! caches. General matrix products pack such operands first, which takes longer than the arithmetic on so few columns.
//!
//! The columns of a tile are read in pieces too short for the machine to see ahead, so the next tile's are asked for meanwhile.

#![allow(clippy::needless_range_loop)] // loops of a constant length over several arrays, to be unrolled

use faer::{MatMut, MatRef};

use crate::prefetch::ask_for_later;

/// Columns of `v` or `b` taken together.
const TILE: usize = 4;
/// Rows taken together, so that the narrow block stays in the nearest cache.
const ROWS: usize = 256;
/// Machines with so many registers hold more sums.
const MANY_REGISTERS: usize = 32;

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

    /// Some rows.
    #[inline(always)]
    fn rows(&self, first: usize, count: usize) -> Self {
        Self(self.0.subrows(first, count))
    }

    /// Where the `T` columns from `first` on start; beyond the end, the first ones at the rows that come next. To be asked for, not to be read.
    #[inline(always)]
    fn ahead<const T: usize>(&self, first: usize) -> [*const f64; T] {
        let last = self.0.ncols() - 1;
        let (first, rows) = if first <= last { (first, 0) } else { (0, ROWS) };
        let mut starts = [std::ptr::null(); T];
        for t in 0..T {
            starts[t] = self
                .0
                .col((first + t).min(last))
                .as_ptr()
                .wrapping_add(rows);
        }
        starts
    }

    /// `T` columns from `first` on; beyond the end the last one stands again.
    #[inline(always)]
    fn tile<const T: usize>(&self, first: usize) -> [&'a [f64]; T] {
        let mut tile: [&[f64]; T] = [&[]; T];
        for t in 0..T {
            let column = self.0.col((first + t).min(self.0.ncols() - 1));
            tile[t] = column.try_as_col_major().map_or(&[], |c| c.as_slice());
        }
        tile
    }
}

/// The tile that comes next, asked for in turns beside the products of this one.
#[derive(Clone, Copy)]
struct Ahead<const T: usize> {
    next: [*const f64; T],
    /// Half of it with each of two turns.
    turn: usize,
}

impl<const T: usize> Ahead<T> {
    #[inline(always)]
    fn ask<S: pulp::Simd>(&self, vector: usize) {
        if vector % 2 == self.turn % 2 {
            for start in self.next {
                ask_for_later(start.wrapping_add(vector * S::F64_LANES));
            }
        }
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
        self.out.fill(0.0);
        let rows = self.a.0.nrows();
        let mut first = 0;
        while first < rows {
            let count = ROWS.min(rows - first);
            let (a, b) = (self.a.rows(first, count), self.b.rows(first, count));
            match S::REGISTER_COUNT >= MANY_REGISTERS {
                true => add_dots::<S, 4>(simd, a, b, self.out.as_mut()),
                false => add_dots::<S, 3>(simd, a, b, self.out.as_mut()),
            }
            first += count;
        }
    }
}

/// `out += aᵀ b`, `A` columns of a at a time.
#[inline(always)]
fn add_dots<S: pulp::Simd, const A: usize>(
    simd: S,
    a: Columns<'_>,
    b: Columns<'_>,
    mut out: MatMut<'_, f64>,
) {
    for i in (0..a.0.ncols()).step_by(A) {
        let left = a.tile::<A>(i);
        let next = a.ahead::<A>(i + A);
        for j in (0..b.0.ncols()).step_by(TILE) {
            let ahead = Ahead {
                next,
                turn: j / TILE,
            };
            let sums = tile_dots(simd, left, b.tile::<TILE>(j), ahead);
            for s in 0..A.min(out.nrows() - i) {
                for t in 0..TILE.min(out.ncols() - j) {
                    out[(i + s, j + t)] += sums[s][t];
                }
            }
        }
    }
}

#[inline(always)]
fn tile_dots<S: pulp::Simd, const A: usize>(
    simd: S,
    a: [&[f64]; A],
    b: [&[f64]; TILE],
    ahead: Ahead<A>,
) -> [[f64; TILE]; A] {
    let rows = a[0].len();
    let packed = rows / S::F64_LANES;
    let mut x: [&[S::f64s]; A] = [&[]; A];
    let mut y: [&[S::f64s]; TILE] = [&[]; TILE];
    for s in 0..A {
        x[s] = &S::as_simd_f64s(a[s]).0[..packed];
    }
    for t in 0..TILE {
        y[t] = &S::as_simd_f64s(b[t]).0[..packed];
    }
    let mut sums = [[simd.splat_f64s(0.0); TILE]; A];
    for i in 0..packed {
        let mut left = [simd.splat_f64s(0.0); A];
        for s in 0..A {
            left[s] = x[s][i];
        }
        ahead.ask::<S>(i);
        for t in 0..TILE {
            let right = y[t][i];
            for s in 0..A {
                sums[s][t] = simd.mul_add_f64s(left[s], right, sums[s][t]);
            }
        }
    }
    let mut dots = [[0.0; TILE]; A];
    for s in 0..A {
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
    fn with_simd<S: pulp::Simd>(mut self, simd: S) {
        let rows = self.y.nrows();
        let mut first = 0;
        while first < rows {
            let count = ROWS.min(rows - first);
            let y = self.y.as_mut().subrows_mut(first, count);
            let v = self.v.rows(first, count);
            match S::REGISTER_COUNT >= MANY_REGISTERS {
                true => add_rows::<S, 4>(simd, y, v, self.c, self.factor),
                false => add_rows::<S, 2>(simd, y, v, self.c, self.factor),
            }
            first += count;
        }
    }
}

/// `y += factor · v c`, `Y` columns of y at a time.
#[inline(always)]
fn add_rows<S: pulp::Simd, const Y: usize>(
    simd: S,
    mut y: MatMut<'_, f64>,
    v: Columns<'_>,
    c: MatRef<'_, f64>,
    factor: f64,
) {
    for k in (0..v.0.ncols()).step_by(TILE) {
        let left = v.tile::<TILE>(k);
        let next = v.ahead::<TILE>(k + TILE);
        for j in (0..y.ncols()).step_by(Y) {
            let ahead = Ahead { next, turn: j / Y };
            let count = Y.min(y.ncols() - j);
            // Where the last column stands again it has no weight.
            let mut weights = [[0.0; Y]; TILE];
            for s in 0..TILE.min(c.nrows() - k) {
                for t in 0..count {
                    weights[s][t] = factor * c[(k + s, j + t)];
                }
            }
            let mut columns = y.as_mut().subcols_mut(j, count).col_iter_mut();
            let mut next = || Some(columns.next()?.try_as_col_major_mut()?.as_slice_mut());
            if count == Y {
                let mut together: [&mut [f64]; Y] = std::array::from_fn(|_| Default::default());
                for y in &mut together {
                    *y = next().unwrap_or_default();
                }
                add_tile(simd, together, left, &weights, ahead);
            } else {
                for t in 0..count {
                    let mut alone = [[0.0; 1]; TILE];
                    for s in 0..TILE {
                        alone[s][0] = weights[s][t];
                    }
                    add_tile(simd, [next().unwrap_or_default()], left, &alone, ahead);
                }
            }
        }
    }
}

/// `yₜ += Σₛ vₛ cₛₜ`
#[inline(always)]
fn add_tile<S: pulp::Simd, const Y: usize>(
    simd: S,
    y: [&mut [f64]; Y],
    v: [&[f64]; TILE],
    c: &[[f64; Y]; TILE],
    ahead: Ahead<TILE>,
) {
    let rows = y[0].len();
    let packed = rows / S::F64_LANES;
    for i in packed * S::F64_LANES..rows {
        for s in 0..TILE {
            for t in 0..Y {
                y[t][i] += v[s][i] * c[s][t];
            }
        }
    }
    let mut x: [&[S::f64s]; TILE] = [&[]; TILE];
    let mut weights = [[simd.splat_f64s(0.0); Y]; TILE];
    for s in 0..TILE {
        x[s] = &S::as_simd_f64s(v[s]).0[..packed];
        for t in 0..Y {
            weights[s][t] = simd.splat_f64s(c[s][t]);
        }
    }
    for i in 0..packed {
        let mut left = [simd.splat_f64s(0.0); TILE];
        for s in 0..TILE {
            left[s] = x[s][i];
        }
        ahead.ask::<S>(i);
        for t in 0..Y {
            let target = &mut S::as_mut_simd_f64s(y[t]).0[i];
            let mut sum = *target;
            for s in 0..TILE {
                sum = simd.mul_add_f64s(left[s], weights[s][t], sum);
            }
            *target = sum;
        }
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
