//! The inner loops of triangular solutions: one front's columns against some right-hand sides, whose rows stand together.
//!
//! As many sums are held in registers as the machine has room for: rows times registers of a row when the solved rows are taken
//! from those below (`forward`), columns times registers of a row the other way round (`backward`). Some strips of columns go
//! together: forward, a sum is loaded and stored once for the products of four; backward, six columns have their sums in the sixteen
//! registers of AVX2, and three strips are four times six columns.

mod backward;
mod forward;
mod registers;

use rayon::prelude::*;

use backward::Backward;
use forward::Forward;

use super::dense::Trapezoid;

/// Columns of a whole strip.
const STRIP: usize = 8;
/// Strips taken together in the forward sweep.
const GROUP: usize = 4;
/// Threads share the packing of a front of so many entries.
const LARGE: usize = 1 << 18;

/// How the entries of a factor are stored; all arithmetic is in double precision.
pub trait Real: Default + pulp::bytemuck::Pod + Send + Sync {
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

/// Columns of each strip of a packed front, from its first column on.
fn strip_widths(columns: usize) -> impl Iterator<Item = usize> {
    let rest = columns % STRIP;
    let last = [4, 2, 1].into_iter().filter(move |width| rest & width != 0);
    std::iter::repeat_n(STRIP, columns / STRIP).chain(last)
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
/// its first diagonal entry on. The upper triangle of a strip's first rows is never used, and its diagonal holds reciprocals: a
/// division would make every column wait. What was eliminated is thus read from one end to the other, or back.
pub fn pack<T: Real>(values: &[f64], layout: Trapezoid, packed: &mut [T]) {
    let Trapezoid { rows, columns } = layout;
    let mut first = 0;
    let mut rest = packed;
    let mut strips = Vec::with_capacity(columns / STRIP + 3);
    for width in strip_widths(columns) {
        let (strip, after) = rest.split_at_mut((rows - first) * width);
        strips.push((first, width, strip));
        rest = after;
        first += width;
    }
    let pack = |(first, width, strip): (usize, usize, &mut [T])| {
        for c in 0..width {
            let (range, start) = layout.column(first + c);
            let column = &values[range][first - start..];
            for (to, from) in strip[c..].iter_mut().step_by(width).zip(column) {
                *to = T::of(*from);
            }
            strip[c * width + c] = T::of(1.0 / column[c]);
        }
    };
    match values.len() >= LARGE {
        true => strips.into_par_iter().for_each(pack),
        false => strips.into_iter().for_each(pack),
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

#[cfg(test)]
mod tests {
    use pulp::Simd;

    use super::*;

    fn entry(i: usize, j: usize) -> f64 {
        ((1 + i) as f64 * (2 + j) as f64).sin() + if i == j { 4.0 } else { 0.0 }
    }

    /// Instructions that sweeps run with.
    #[derive(Clone, Copy)]
    enum Instructions {
        /// The widest that this machine has.
        Widest,
        Scalar,
    }

    /// Both sweeps of one front against sums entry by entry.
    fn sweeps_are_substitutions<const N: usize>(columns: usize, below: usize, with: Instructions) {
        let layout = Trapezoid {
            rows: columns + below,
            columns,
        };
        let mut values = vec![0.0; layout.len()];
        for column in 0..columns {
            let (range, first) = layout.column(column);
            for (row, value) in (first..).zip(&mut values[range]) {
                *value = entry(row, column);
            }
        }
        let mut packed = vec![0.0_f64; packed_length(layout.rows, columns)];
        pack(&values, layout, &mut packed);
        let given: Vec<[f64; N]> = (0..layout.rows)
            .map(|row| std::array::from_fn(|l| ((row * (l + 2)) as f64).cos()))
            .collect();
        let (mut down, mut up) = (given.clone(), given);
        let (mut solved, mut open) = (down.clone(), up.clone());
        match with {
            Instructions::Widest => {
                forward(&packed, columns, &mut down);
                backward(&packed, columns, &mut up);
            }
            Instructions::Scalar => {
                let (packed, w) = (packed.as_slice(), down.as_mut_slice());
                pulp::Scalar.vectorize(Forward { packed, columns, w });
                let w = up.as_mut_slice();
                pulp::Scalar.vectorize(Backward { packed, columns, w });
            }
        }
        for l in 0..N {
            for row in 0..layout.rows {
                for column in 0..row.min(columns) {
                    solved[row][l] -= entry(row, column) * solved[column][l];
                }
                if row < columns {
                    solved[row][l] /= entry(row, row);
                }
            }
            for column in (0..columns).rev() {
                for row in column + 1..layout.rows {
                    open[column][l] -= entry(row, column) * open[row][l];
                }
                open[column][l] /= entry(column, column);
            }
        }
        for (found, expected) in [(&down, &solved), (&up, &open)] {
            let size = expected
                .as_flattened()
                .iter()
                .fold(1.0, |size: f64, value| size.max(value.abs()));
            for (found, expected) in found.as_flattened().iter().zip(expected.as_flattened()) {
                assert!(
                    (found - expected).abs() < 1e-12 * size,
                    "{columns} + {below}, {N}"
                );
            }
        }
    }

    #[test]
    fn sweeps_of_any_front_are_substitutions() {
        for columns in (1..=34).chain([48, 55, 71]) {
            for below in [0, 1, 5, 64, 150] {
                sweeps_are_substitutions::<8>(columns, below, Instructions::Widest);
                sweeps_are_substitutions::<16>(columns, below, Instructions::Widest);
                sweeps_are_substitutions::<32>(columns, below, Instructions::Widest);
                sweeps_are_substitutions::<8>(columns, below, Instructions::Scalar);
            }
        }
    }
}
