//! Counts the negative pivots of `L D Lᵀ` with pivoting inside blocks of a front's columns (Bunch and Kaufman); nothing is kept
//! but the count. No pivot is ever changed: a matrix that is indefinite is counted as such.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::lblt::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::triangular_solve::solve_unit_lower_triangular_in_place;
use faer::reborrow::*;
use faer::{Accum, ColMut, Mat, MatMut, Par};
use rayon::prelude::*;

use super::dense::{
    CHUNK, Panel, Trapezoid, subtract_chunk, subtract_from_later, subtract_from_update,
};
use super::elimination::{Elimination, NotPositive};

/// Columns within which pivots are chosen: half a chunk.
const BLOCK: usize = CHUNK / 2;
/// How many negative pivots are listed by position.
const LISTED: usize = 8;

/// `A = L D Lᵀ`, of which only the signs of D count.
pub struct Indefinite;

/// Signs of pivots.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Signs {
    /// Number of negative pivots.
    pub negative: usize,
    /// Number of pivots that are zero or not a number.
    pub zero: usize,
    /// Positions of the first negative pivots in the elimination order.
    pub negative_positions: Vec<usize>,
}

impl Signs {
    fn count(&mut self, pivot: f64, position: usize) {
        if pivot < 0.0 {
            self.negative += 1;
            if self.negative_positions.len() < LISTED {
                self.negative_positions.push(position);
            }
        } else if pivot.is_nan() || pivot == 0.0 {
            self.zero += 1;
        }
    }

    /// A 2×2 pivot `[[a, b], [b, c]]` by its determinant and trace.
    fn count_pair(&mut self, (a, b, c): (f64, f64, f64), positions: [usize; 2]) {
        let (determinant, trace) = (a * c - b * b, a + c);
        let (first, second) = if determinant < 0.0 {
            (1.0, -1.0)
        } else {
            (trace, determinant * trace)
        };
        self.count(first, positions[0]);
        self.count(second, positions[1]);
    }
}

impl Elimination for Indefinite {
    type Stored = f64;
    type Outcome = Signs;
    const KEEPS: bool = false;

    fn eliminate(
        &self,
        first: usize,
        panel: &mut Panel<'_>,
        update: &mut [f64],
        outcome: &mut Signs,
    ) -> Result<(), NotPositive> {
        let Trapezoid { rows, columns } = panel.layout;
        let order = rows - columns;
        let mut chunks = panel.layout.chunks(panel.values);
        let mut rest = &mut chunks[..];
        while let Some(((start, chunk), after)) = rest.split_first_mut() {
            for begin in (0..chunk.ncols()).step_by(BLOCK) {
                let width = BLOCK.min(chunk.ncols() - begin);
                let (height, left) = (chunk.nrows() - begin, chunk.ncols() - begin);
                let open = chunk.rb_mut().submatrix_mut(begin, begin, height, left);
                let (block, same) = open.split_at_col_mut(width);
                let (diagonal, mut below) = block.split_at_row_mut(width);
                let pivots = Pivots::of(diagonal, first + *start + begin, outcome);
                let scaled = pivots.divide(below.rb_mut());
                let (scaled, below) = (scaled.as_ref(), below.rb());
                let same = same.split_at_row_mut(width).1;
                subtract_chunk(same, 0, scaled, below, Accum::Add);
                let end = *start + begin + width;
                subtract_from_later(after, end, scaled, below);
                let accumulate = match end == width {
                    true => Accum::Replace,
                    false => Accum::Add,
                };
                subtract_from_update(
                    update,
                    scaled.subrows(columns - end, order),
                    below.subrows(columns - end, order),
                    accumulate,
                );
            }
            rest = after;
        }
        Ok(())
    }

    fn merge(into: &mut Signs, other: Signs) {
        into.negative += other.negative;
        into.zero += other.zero;
        let room = LISTED - into.negative_positions.len();
        into.negative_positions
            .extend(other.negative_positions.into_iter().take(room));
    }
}

/// `P A Pᵀ = L D Lᵀ` of one diagonal block.
struct Pivots<'a> {
    lower: MatMut<'a, f64>,
    below_diagonal: Vec<f64>,
    /// Original place of each pivot.
    places: Vec<usize>,
}

impl<'a> Pivots<'a> {
    fn of(mut block: MatMut<'a, f64>, position: usize, signs: &mut Signs) -> Self {
        let n = block.nrows();
        let mut below_diagonal = vec![0.0; n];
        let (mut places, mut inverse) = (vec![0_usize; n], vec![0_usize; n]);
        let scratch = cholesky_in_place_scratch::<usize, f64>(n, Par::Seq, Default::default());
        let mut memory = MemBuffer::new(scratch);
        cholesky_in_place(
            block.rb_mut(),
            ColMut::from_slice_mut(&mut below_diagonal).as_diagonal_mut(),
            &mut places,
            &mut inverse,
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        );
        let mut column = 0;
        while column < n {
            let here = position + places[column];
            if below_diagonal[column] == 0.0 {
                signs.count(block[(column, column)], here);
                column += 1;
            } else {
                let pair = (
                    block[(column, column)],
                    below_diagonal[column],
                    block[(column + 1, column + 1)],
                );
                signs.count_pair(pair, [here, position + places[column + 1]]);
                column += 2;
            }
        }
        Self {
            lower: block,
            below_diagonal,
            places,
        }
    }

    /// Turns the rows below, B, into `L₂₁ = B Pᵀ L⁻ᵀ D⁻¹`; returns `L₂₁ D`.
    fn divide(&self, mut below: MatMut<'_, f64>) -> Mat<f64> {
        let mut scaled = Mat::zeros(below.nrows(), below.ncols());
        if below.nrows() <= CHUNK {
            self.divide_rows(below, scaled.as_mut());
        } else {
            below
                .rb_mut()
                .par_row_chunks_mut(CHUNK)
                .zip(scaled.par_row_chunks_mut(CHUNK))
                .for_each(|(below, scaled)| self.divide_rows(below, scaled));
        }
        scaled
    }

    /// The same for some of the rows; `scaled` becomes `L₂₁ D`.
    fn divide_rows(&self, mut below: MatMut<'_, f64>, mut scaled: MatMut<'_, f64>) {
        for (column, place) in self.places.iter().enumerate() {
            scaled
                .rb_mut()
                .col_mut(column)
                .copy_from(below.rb().col(*place));
        }
        solve_unit_lower_triangular_in_place(
            self.lower.rb(),
            scaled.rb_mut().transpose_mut(),
            Par::Seq,
        );
        let n = self.places.len();
        let mut column = 0;
        while column < n {
            let b = self.below_diagonal[column];
            let a = self.lower[(column, column)];
            if b == 0.0 {
                let factor = 1.0 / a;
                let source = scaled.rb().col(column);
                for (to, from) in below.rb_mut().col_mut(column).iter_mut().zip(source.iter()) {
                    *to = factor * from;
                }
                column += 1;
            } else {
                let c = self.lower[(column + 1, column + 1)];
                // [[a, b], [b, c]]⁻¹, divided by b first because b² may dwarf a c.
                let (ab, cb) = (a / b, c / b);
                let factor = 1.0 / ((ab * cb - 1.0) * b);
                for row in 0..below.nrows() {
                    let (x, y) = (scaled[(row, column)], scaled[(row, column + 1)]);
                    below[(row, column)] = factor * (cb * x - y);
                    below[(row, column + 1)] = factor * (ab * y - x);
                }
                column += 2;
            }
        }
    }
}
