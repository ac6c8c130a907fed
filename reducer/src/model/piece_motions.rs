//! Rigid motions of pieces that no stiffness connects, each on its own.
//!
//! Pieces have no dof in common, so that one column holds a motion of every piece at once. A piece turns about its own middle: about that of
//! the whole, a small one far out would only seem to be displaced.

use dcb_dense::{symmetric_eigen, symmetrized};
use dcb_formats::SparseMatrix;
use dcb_formats::mesh::Dimension;
use dcb_sparse::block_algebra::{absolute_product, symmetric_product};
use faer::Mat;

use crate::error::{BodyRefusal, Error, PieceSize};
use crate::model::condensation::Model;
use crate::model::frame::offset;
use crate::model::rigid_body::{RigidBodyModes, columns};
use crate::model::rigid_frame::PointMotion;

/// Motions of a piece with less than this part of the mass of its others don't exist: those of single points and of points on a line.
const DEPENDENT_MOTION: f64 = 1e-10;

/// Pieces that no stiffness connects.
pub struct Pieces {
    /// Points of each, the largest piece first; nodes and frames come before the points of internal rows.
    points: Vec<Vec<u32>>,
    /// The first point of an internal row.
    first_internal: u32,
    /// Rigid motions of each; `None` of one piece, or if masses connect them.
    pub(crate) motions: Option<PieceMotions>,
}

impl Pieces {
    /// Of a model; motions are those that it has as a whole.
    pub fn of(model: &Model, rigid: &RigidBodyModes) -> Self {
        let points = connected_points(model);
        let motions = PieceMotions::of(model, &points, rigid);
        Self {
            points,
            first_internal: first_internal_point(model),
            motions,
        }
    }

    /// # Errors
    /// [`BodyRefusal::InPieces`] unless there is but one.
    pub(crate) fn refuse_several(&self) -> Result<(), BodyRefusal> {
        if self.points.len() < 2 {
            return Ok(());
        }
        let pieces = self.points.iter().map(|piece| PieceSize {
            nodes: piece.partition_point(|point| *point < self.first_internal),
            first_node: piece.first().copied().unwrap_or(0),
        });
        Err(BodyRefusal::InPieces {
            pieces: pieces.collect(),
        })
    }
}

/// The first point that is an internal row's; those before it are nodes and frames.
fn first_internal_point(model: &Model) -> u32 {
    let internal = model.dofs.iter().filter(|dof| dof.motion.is_none());
    internal.map(|dof| dof.point).min().unwrap_or(u32::MAX)
}

/// Sets of model points that the stiffness matrix connects, largest first. An internal row, which has no place of its own, goes with what
/// stiffness or mass connect it to, and is no piece by itself.
fn connected_points(model: &Model) -> Vec<Vec<u32>> {
    let points = model.points();
    let count = points
        .iter()
        .map(|point| *point as usize + 1)
        .max()
        .unwrap_or(0);
    let mut parent: Vec<u32> = (0..count as u32).collect();
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }
    // One entry of a point says all of its dofs.
    let mut join = |matrix: &SparseMatrix, column: usize, rows: &[u32]| {
        let mut joined = points[column];
        for (row, value) in rows.iter().zip(matrix.val_of_col(column)) {
            let point = points[*row as usize];
            if point == joined || *value == 0.0 {
                continue;
            }
            joined = point;
            let (a, b) = (root(&mut parent, point), root(&mut parent, points[column]));
            parent[a.max(b) as usize] = a.min(b);
        }
    };
    for column in 0..model.len() {
        // Rows above the diagonal say all, because every column is joined.
        let rows = model.stiffness.row_idx_of_col_raw(column);
        let above = rows.partition_point(|row| (*row as usize) < column);
        join(&model.stiffness, column, &rows[..above]);
        if model.is_internal(column) {
            let rows = model.mass.row_idx_of_col_raw(column);
            join(&model.mass, column, rows);
        }
    }
    let mut by_root: std::collections::BTreeMap<u32, Vec<u32>> = Default::default();
    let mut distinct = points;
    distinct.sort_unstable();
    distinct.dedup();
    for point in distinct {
        by_root
            .entry(root(&mut parent, point))
            .or_default()
            .push(point);
    }
    let first_internal = first_internal_point(model);
    by_root.retain(|first, _| *first < first_internal);
    let mut pieces: Vec<Vec<u32>> = by_root.into_values().collect();
    pieces.sort_by_key(|piece| std::cmp::Reverse(piece.len()));
    pieces
}

/// Rigid motions of each of several pieces, M-orthonormal.
pub(crate) struct PieceMotions {
    /// The piece of each dof.
    piece_of: Vec<usize>,
    count: usize,
    /// Whether each motion of each piece exists: a point and a line of points have fewer.
    exists: Vec<bool>,
    /// (n_c, 3 or 6); zero where a piece has fewer.
    motions: Mat<f64>,
}

impl PieceMotions {
    /// Of a model in several pieces; `None` if masses connect these.
    fn of(model: &Model, found: &[Vec<u32>], rigid: &RigidBodyModes) -> Option<Self> {
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
        if is_coupled(&model.mass, &piece_of) {
            return None;
        }
        let mut motions = about_own_middles(model, rigid.count(), &piece_of, count);
        let columns = motions.ncols();
        let mut turns = Vec::new();
        // Twice: the second time removes what rounding left of the first.
        for _ in 0..2 {
            let momenta = symmetric_product(&model.mass, motions.as_ref());
            let mut masses = vec![Mat::<f64>::zeros(columns, columns); count];
            for (row, piece) in piece_of.iter().enumerate() {
                for j in 0..columns {
                    for i in 0..columns {
                        masses[*piece][(i, j)] += motions[(row, i)] * momenta[(row, j)];
                    }
                }
            }
            turns = masses
                .iter()
                .map(orthonormal)
                .collect::<Option<Vec<Mat<f64>>>>()?;
            motions = Mat::from_fn(model.len(), columns, |row, column| {
                let turn = &turns[piece_of[row]];
                (0..columns)
                    .map(|i| motions[(row, i)] * turn[(i, column)])
                    .sum()
            });
        }
        let is_motion = |turn: &Mat<f64>, j: usize| (0..columns).any(|i| turn[(i, j)] != 0.0);
        let exists = turns
            .iter()
            .flat_map(|turn| (0..columns).map(move |j| is_motion(turn, j)))
            .collect();
        Some(Self {
            piece_of,
            count,
            exists,
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

    /// Motions of the pieces beyond those of the whole: M-orthonormal to each other and to these, exactly rigid on each piece,
    /// (n_c, l).
    ///
    /// # Errors
    /// [`Error::NotFinite`] if the mass matrix has entries that aren't numbers.
    pub fn beyond(&self, rigid: &RigidBodyModes) -> Result<Mat<f64>, Error> {
        let columns = self.motions.ncols();
        // A: the whole's motions in terms of those of the pieces, AᵀA = I. What is orthogonal to it are eigenvectors of A Aᵀ for 0.
        let mut whole = Mat::<f64>::zeros(self.count * columns, rigid.count());
        for (row, piece) in self.piece_of.iter().enumerate() {
            for i in 0..columns {
                for j in 0..rigid.count() {
                    whole[(piece * columns + i, j)] +=
                        self.motions[(row, i)] * rigid.mass_shapes[(row, j)];
                }
            }
        }
        let exists: Vec<usize> = (0..self.count * columns)
            .filter(|i| self.exists[*i])
            .collect();
        let whole = Mat::from_fn(exists.len(), rigid.count(), |i, j| whole[(exists[i], j)]);
        let (_, vectors) =
            symmetric_eigen((&whole * whole.transpose()).as_ref()).ok_or(Error::NotFinite {
                what: "the motions of loose pieces",
            })?;
        let count = exists.len() - rigid.count();
        let mut turn = Mat::<f64>::zeros(self.count * columns, count);
        for (i, motion) in exists.iter().enumerate() {
            for j in 0..count {
                turn[(*motion, j)] = vectors[(i, j)];
            }
        }
        Ok(Mat::from_fn(self.piece_of.len(), count, |row, j| {
            let first = self.piece_of[row] * columns;
            (0..columns)
                .map(|i| self.motions[(row, i)] * turn[(first + i, j)])
                .sum()
        }))
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

/// Whether an entry of a matrix connects dofs of different pieces.
fn is_coupled(matrix: &SparseMatrix, piece_of: &[usize]) -> bool {
    (0..matrix.ncols()).any(|column| {
        let rows = matrix.row_idx_of_col_raw(column).iter();
        rows.zip(matrix.val_of_col(column))
            .any(|(row, value)| *value != 0.0 && piece_of[*row as usize] != piece_of[column])
    })
}

/// Displacements and turns; nothing for a part that has no rigid motions because it is held.
fn about_own_middles(
    model: &Model,
    motion_count: usize,
    piece_of: &[usize],
    pieces: usize,
) -> Mat<f64> {
    let dimension = match motion_count {
        0 => return Mat::zeros(model.len(), 0),
        3 => Dimension::Planar,
        _ => Dimension::Spatial,
    };
    let (mut middles, mut counts) = (vec![[0.0; 3]; pieces], vec![0.0; pieces]);
    for (dof, piece) in model.dofs.iter().zip(piece_of) {
        let Some(motion) = dof.motion else {
            continue;
        };
        counts[*piece] += 1.0;
        for (sum, x) in middles[*piece].iter_mut().zip(motion.position) {
            *sum += x;
        }
    }
    for (middle, count) in middles.iter_mut().zip(&counts) {
        middle.iter_mut().for_each(|sum| *sum /= count);
    }
    let arms = model.dofs.iter().zip(piece_of);
    let arms = arms.map(|(dof, piece)| {
        dof.motion.map(|motion| PointMotion {
            position: offset(motion.position, middles[*piece]),
            ..motion
        })
    });
    columns(dimension, arms, [0.0; 3], model.len())
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
