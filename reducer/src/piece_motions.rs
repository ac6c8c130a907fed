//! Rigid motions of pieces that no stiffness connects, each on its own.
//!
//! Restricted to a piece, the rigid motions of the whole are those of the piece. Pieces have no dof in common, so that one column holds a
//! motion of every piece at once.

use faer::Mat;

use crate::block_algebra::{
    absolute_product, gram, symmetric_eigen, symmetric_product, symmetrized,
};
use crate::condensation::Model;
use crate::diagnosis::pieces;
use crate::rigid_body::RigidBodyModes;

/// Motions of a piece with less than this part of the mass of its others don't exist: those of single points and of points on a line.
const DEPENDENT_MOTION: f64 = 1e-10;

/// Rigid motions of each of several pieces, M-orthonormal.
pub struct PieceMotions {
    /// The piece of each dof.
    piece_of: Vec<usize>,
    count: usize,
    /// How many motions they have together.
    total: usize,
    /// (n_c, 3 or 6); zero where a piece has fewer.
    motions: Mat<f64>,
}

impl PieceMotions {
    /// Of a model; `None` if it is in one piece.
    pub fn of(model: &Model, rigid: &RigidBodyModes) -> Option<Self> {
        let found = pieces(model);
        if found.len() < 2 {
            return None;
        }
        let points = model.points();
        let mut piece_of_point = vec![0; points.iter().max().map_or(0, |most| *most as usize + 1)];
        for (index, piece) in found.iter().enumerate() {
            for point in piece {
                piece_of_point[*point as usize] = index;
            }
        }
        let piece_of: Vec<usize> = points
            .iter()
            .map(|point| piece_of_point[*point as usize])
            .collect();
        let count = found.len();
        let (shapes, mass_shapes) = (&rigid.shapes, &rigid.mass_shapes);
        let columns = shapes.ncols();
        let mut masses = vec![Mat::<f64>::zeros(columns, columns); count];
        for (row, piece) in piece_of.iter().enumerate() {
            for j in 0..columns {
                for i in 0..columns {
                    masses[*piece][(i, j)] += shapes[(row, i)] * mass_shapes[(row, j)];
                }
            }
        }
        let turns = masses
            .iter()
            .map(orthonormal)
            .collect::<Option<Vec<Mat<f64>>>>()?;
        let motions = Mat::from_fn(model.len(), columns, |row, column| {
            let turn = &turns[piece_of[row]];
            (0..columns)
                .map(|i| shapes[(row, i)] * turn[(i, column)])
                .sum()
        });
        let is_motion = |turn: &Mat<f64>, j: usize| (0..columns).any(|i| turn[(i, j)] != 0.0);
        let motions_of = |turn: &Mat<f64>| (0..columns).filter(|j| is_motion(turn, *j)).count();
        Some(Self {
            piece_of,
            count,
            total: turns.iter().map(motions_of).sum(),
            motions,
        })
    }

    /// Takes the motions of every piece out of displacements.
    pub fn project_out(&self, model: &Model, x: &mut Mat<f64>) {
        let columns = self.motions.ncols();
        for _ in 0..2 {
            let momenta = symmetric_product(&model.mass, x.as_ref());
            for j in 0..x.ncols() {
                let mut amounts = vec![0.0; self.count * columns];
                for (row, piece) in self.piece_of.iter().enumerate() {
                    for i in 0..columns {
                        amounts[piece * columns + i] += self.motions[(row, i)] * momenta[(row, j)];
                    }
                }
                for (row, piece) in self.piece_of.iter().enumerate() {
                    for i in 0..columns {
                        x[(row, j)] -= self.motions[(row, i)] * amounts[piece * columns + i];
                    }
                }
            }
        }
    }

    /// Parts the span of M-orthonormal columns x into its motions of pieces, exactly rigid, and what else it has: both M-orthonormal, the
    /// first without motions of the whole. `None` where these aren't all motions of pieces that there are.
    pub fn split(
        &self,
        model: &Model,
        rigid: &RigidBodyModes,
        x: &Mat<f64>,
    ) -> Option<(Mat<f64>, Mat<f64>)> {
        let mut elastic = x.clone();
        self.project_out(model, &mut elastic);
        let mass = gram(
            elastic.as_ref(),
            symmetric_product(&model.mass, elastic.as_ref()).as_ref(),
        );
        let (shares, vectors) = symmetric_eigen(symmetrized(mass.as_ref()).as_ref())?;
        let loose_count = shares.iter().filter(|share| **share < 0.5).count();
        if loose_count + rigid.count() != self.total {
            return None;
        }
        let (loose, elastic) = (
            x * vectors.as_ref().subcols(0, loose_count),
            &elastic
                * vectors
                    .as_ref()
                    .subcols(loose_count, shares.len() - loose_count),
        );
        let mut rest = loose.clone();
        self.project_out(model, &mut rest);
        let mut loose = loose - rest;
        rigid.project_out(&mut loose);
        let mass = gram(
            loose.as_ref(),
            symmetric_product(&model.mass, loose.as_ref()).as_ref(),
        );
        let turn = orthonormal(&mass)?;
        Some((&loose * turn, elastic))
    }

    /// Largest |r|ᵀ|K||r| of the motions r of a piece.
    pub fn largest_energy(&self, model: &Model) -> f64 {
        let forces = absolute_product(&model.stiffness, self.motions.as_ref());
        let mut largest = 0.0_f64;
        for column in 0..self.motions.ncols() {
            let mut energies = vec![0.0; self.count];
            for (row, piece) in self.piece_of.iter().enumerate() {
                energies[*piece] += self.motions[(row, column)].abs() * forces[(row, column)];
            }
            largest = energies.into_iter().fold(largest, f64::max);
        }
        largest
    }
}

/// T with Tᵀ A T = I over the directions that A has, and zero columns for the others.
fn orthonormal(mass: &Mat<f64>) -> Option<Mat<f64>> {
    let n = mass.nrows();
    let sizes: Vec<f64> = (0..n)
        .map(|i| mass[(i, i)].max(0.0).sqrt())
        .map(|size| if size > 0.0 { size.recip() } else { 0.0 })
        .collect();
    let scaled = Mat::from_fn(n, n, |i, j| mass[(i, j)] * sizes[i] * sizes[j]);
    let (values, vectors) = symmetric_eigen(symmetrized(scaled.as_ref()).as_ref())?;
    let least = DEPENDENT_MOTION * values.last().copied().unwrap_or(0.0);
    Some(Mat::from_fn(n, n, |i, j| match values[j] > least {
        true => sizes[i] * vectors[(i, j)] / values[j].sqrt(),
        false => 0.0,
    }))
}
