//! Additions to the inertia by a frame that isn't on mean axes, and by coordinates that aren't orthonormal.

use dcb_formats::superelement::Inertia;
use faer::{Mat, MatMut, MatRef};
use nalgebra::Vector3;

/// Momentum of the coordinates in a frame of kind `given`: L1 and I3, which vanish on mean axes.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameMomentum {
    /// L1ᵀ, axis by axis, (n) each: momentum of unit rates, √mass.
    pub(super) linear: Vec<f64>,
    /// I3ᵀ, axis by axis, (n) each: angular momentum about the undeformed centre of mass, √mass·length.
    pub(super) angular: Vec<f64>,
}

impl FrameMomentum {
    /// L1 and I3 over the coordinates that the columns combine; `None` where both vanish.
    pub fn over(inertia: &Inertia, columns: MatRef<'_, f64>) -> Option<Self> {
        // Planar files have two rows of L1 and, in I3, only the one about z.
        let spread = |rows: &Mat<f64>, first: usize| -> Vec<f64> {
            let product = rows * columns;
            (0..3)
                .flat_map(|axis: usize| {
                    let row = axis.checked_sub(first).filter(|row| *row < product.nrows());
                    (0..product.ncols())
                        .map(|k| row.map_or(0.0, |row| product[(row, k)]))
                        .collect::<Vec<f64>>()
                })
                .collect()
        };
        let linear = spread(&inertia.l1, 0);
        let angular = spread(&inertia.i3, 3 - inertia.i3.nrows().min(3));
        let vanishes = linear.iter().chain(&angular).all(|entry| *entry == 0.0);
        (!vanishes).then_some(Self { linear, angular })
    }

    /// `L1 x`
    pub(super) fn linear_of(&self, x: &[f64]) -> Vector3<f64> {
        Vector3::from_fn(|axis, _| {
            let row = &self.linear[axis * x.len()..(axis + 1) * x.len()];
            row.iter().zip(x).map(|(a, b)| a * b).sum()
        })
    }

    /// Column k of L1.
    pub(super) fn linear_column(&self, k: usize) -> Vector3<f64> {
        let n = self.linear.len() / 3;
        Vector3::from_fn(|axis, _| self.linear[axis * n + k])
    }
}

/// Mass of the last coordinates where they aren't orthonormal: attachments measured by their forces (M_res). The first ones,
/// modes, have unit mass. Kept whole, not as its difference from the identity: M_res is tiny in most units.
#[derive(Clone, Debug, PartialEq)]
pub struct AttachmentMass {
    /// M_res, symmetric.
    mass: Mat<f64>,
}

impl AttachmentMass {
    /// Of the mass matrix of the last coordinates, symmetric.
    pub fn of(mass: &Mat<f64>) -> Self {
        Self {
            mass: Mat::from_fn(mass.nrows(), mass.ncols(), |i, j| {
                0.5 * (mass[(i, j)] + mass[(j, i)])
            }),
        }
    }

    /// `out += factor M x` over all coordinates.
    pub(super) fn add_product(&self, factor: f64, x: &[f64], out: &mut [f64]) {
        let first = x.len() - self.mass.ncols();
        for (out, x) in out[..first].iter_mut().zip(x) {
            *out += factor * x;
        }
        for (x, column) in x[first..].iter().zip(self.mass.col_iter()) {
            for (out, entry) in out[first..].iter_mut().zip(column.iter()) {
                *out += factor * x * entry;
            }
        }
    }

    /// `xᵀ M x`
    pub(super) fn square(&self, x: &[f64]) -> f64 {
        let (modal, attached) = x.split_at(x.len() - self.mass.ncols());
        let columns = self.mass.col_iter().zip(attached);
        let of_attachments: f64 = columns
            .map(|(column, x)| x * column.iter().zip(attached).map(|(m, x)| m * x).sum::<f64>())
            .sum();
        modal.iter().map(|x| x * x).sum::<f64>() + of_attachments
    }

    /// `out += factor M`, (n, n).
    pub(super) fn add_matrix(&self, factor: f64, mut out: MatMut<'_, f64>) {
        let first = out.ncols() - self.mass.ncols();
        for k in 0..first {
            out[(k, k)] += factor;
        }
        for k in 0..self.mass.ncols() {
            for l in 0..self.mass.nrows() {
                out[(first + l, first + k)] += factor * self.mass[(l, k)];
            }
        }
    }

    /// Diagonal entry k of M, of `count` coordinates.
    pub(super) fn diagonal(&self, count: usize, k: usize) -> f64 {
        let first = count - self.mass.ncols();
        k.checked_sub(first).map_or(1.0, |k| self.mass[(k, k)])
    }
}
