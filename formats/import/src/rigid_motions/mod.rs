//! Whether a stiffness resists no rigid motion of the nodes that its rows are said to belong to: the proof of an order of rows.

pub(crate) mod null_space;

use dcb_formats::SparseMatrix;
use dcb_formats::mesh::Direction;
use rayon::prelude::*;

/// Node and direction of a row; `None` for an internal row, which is at rest in rigid motions.
pub(crate) type RowPlace = Option<([f64; 3], Direction)>;

/// How a stiffness resists the rigid motions: translations along x, y, z, rotations about them through the middle of the nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Resistance {
    /// max |K r| over max |K| for each motion r. Rotations are scaled with the largest distance from the middle, moments and angles with
    /// it too: a number without unit, the same in any system of units.
    pub motions: [f64; 6],
    /// The row that resists most.
    pub worst_row: usize,
}

impl Resistance {
    /// The largest of the six.
    pub fn worst(&self) -> f64 {
        self.motions.iter().copied().fold(0.0, f64::max)
    }
}

/// Middle of the rows' nodes and the largest distance from it.
fn extent(places: &[RowPlace]) -> ([f64; 3], f64) {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for (point, _) in places.iter().flatten() {
        for axis in 0..3 {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
        }
    }
    let middle: [f64; 3] = std::array::from_fn(|axis| 0.5 * (low[axis] + high[axis]));
    let far = places
        .iter()
        .flatten()
        .map(|(point, _)| distance(*point, middle));
    let size = far.fold(0.0, f64::max);
    (middle, if size > 0.0 { size } else { 1.0 })
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let squares = (0..3).map(|axis| (a[axis] - b[axis]).powi(2));
    squares.sum::<f64>().sqrt()
}

/// K r for the rigid motions.
pub(crate) fn resistance(stiffness: &SparseMatrix, places: &[RowPlace]) -> Resistance {
    let (middle, size) = extent(places);
    let motion = |place: &RowPlace| -> [f64; 6] {
        let mut row = [0.0; 6];
        let Some((point, direction)) = place else {
            return row;
        };
        let axis = direction.axis();
        if direction.is_rotation() {
            row[3 + axis] = 1.0;
            return row;
        }
        row[axis] = 1.0;
        let arm: [f64; 3] = std::array::from_fn(|axis| (point[axis] - middle[axis]) / size);
        // (e_a × arm)_axis
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        row[3 + next] = arm[last];
        row[3 + last] = -arm[next];
        row
    };
    let motions: Vec<[f64; 6]> = places.iter().map(motion).collect();
    // Angles are in units of 1/size, so rows and columns of rotations are divided by it.
    let scale = |row: usize| match &places[row] {
        Some((_, direction)) if direction.is_rotation() => 1.0 / size,
        _ => 1.0,
    };
    // Symmetric: the column is the row.
    let of_row = |row: usize| {
        let (mut forces, mut largest) = ([0.0; 6], 0.0_f64);
        let entries = stiffness.row_idx_of_col_raw(row).iter();
        for (column, value) in entries.zip(stiffness.val_of_col(row)) {
            let column = *column as usize;
            let value = value * scale(row) * scale(column);
            largest = largest.max(value.abs());
            for (force, motion) in forces.iter_mut().zip(&motions[column]) {
                *force += value * motion;
            }
        }
        (row, forces.map(f64::abs), largest)
    };
    let (worst_row, forces, largest) = (0..places.len()).into_par_iter().map(of_row).reduce(
        || (0, [0.0; 6], 0.0),
        |a, b| {
            let most = |forces: &[f64; 6]| forces.iter().copied().fold(0.0, f64::max);
            let worst_row = match most(&b.1) > most(&a.1) {
                true => b.0,
                false => a.0,
            };
            let forces = std::array::from_fn(|motion| a.1[motion].max(b.1[motion]));
            (worst_row, forces, a.2.max(b.2))
        },
    );
    let over = if largest > 0.0 { largest } else { 1.0 };
    Resistance {
        motions: forces.map(|force| force / over),
        worst_row,
    }
}
