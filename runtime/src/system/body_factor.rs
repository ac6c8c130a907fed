//! One body's part of a Newton iteration, eliminated: a step costs O(n) per body.
//!
//! The iteration matrix of a body over (rigid, y) is, with the elastic block taken as its diagonal D,
//!
//! ```text
//! S = | S_rr  S_ry |      X = D⁻¹ S_yr,    Ŝ = S_rr - S_ry X
//!     | S_yr  D    |
//! S⁻¹ (b_r, b_y):   t = D⁻¹ b_y,   x_r = Ŝ⁻¹ (b_r - S_ry t),   x_y = t - X x_r
//! ```
//! Rows and columns of the six rigid motions are `(Aᵀ δR, δφ)`: in body axes the matrix doesn't change when the body turns.
//! A body's *response* to a wrench at each of its markers, `Z = S⁻¹ Nᵀ`, and the compliance `N Z` between markers are all that
//! the joints need of it.

use dcb_formats::mesh::Dimension;
use nalgebra::{Matrix3, Matrix6};

use super::marker::{Marker, MarkerPlace};
use super::number::Number;
use crate::kinematics::frame_motion::SixOf;

/// Motions and wrenches of a plane among the six.
const PLANAR: [usize; 3] = [0, 1, 5];

/// Whether the coordinates y move in a solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Elastic {
    /// They do.
    Moving,
    /// They stay: the bodies are rigid in this solve.
    Frozen,
}

/// The blocks of a body's iteration matrix, (rigid, y) in body axes.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyMatrix<T: Number = f64> {
    /// S_rr.
    pub rigid: Matrix6<T>,
    /// S_ryᵀ, (n, 6) by columns.
    pub rigid_elastic: Vec<T>,
    /// S_yr, (n, 6) by columns.
    pub elastic_rigid: Vec<T>,
    /// D, (n).
    pub elastic: Vec<T>,
    /// Which rigid motions the body has; the others stay zero.
    pub free: [bool; 6],
}

impl<T: Number> BodyMatrix<T> {
    /// Room for n coordinates.
    pub fn for_coordinates(count: usize, free: [bool; 6]) -> Self {
        Self {
            rigid: Matrix6::zeros(),
            rigid_elastic: vec![T::of(0.0); 6 * count],
            elastic_rigid: vec![T::of(0.0); 6 * count],
            elastic: vec![T::of(0.0); count],
            free,
        }
    }
}

/// S⁻¹ of one body.
#[derive(Clone, Debug, PartialEq)]
struct Elimination<T: Number> {
    /// Ŝ⁻¹; rows and columns of motions that the body hasn't are zero.
    schur_inverse: Matrix6<T>,
    /// S_ryᵀ, (n, 6).
    rigid_elastic: Vec<T>,
    /// X, (n, 6).
    elastic_rigid: Vec<T>,
    /// D⁻¹, (n).
    elastic_inverse: Vec<T>,
}

impl<T: Number> Elimination<T> {
    fn factor(&mut self, matrix: &BodyMatrix<T>, elastic: Elastic) -> bool {
        let n = matrix.elastic.len();
        for (inverse, d) in self.elastic_inverse.iter_mut().zip(&matrix.elastic) {
            *inverse = match elastic {
                Elastic::Moving => T::of(1.0) / *d,
                Elastic::Frozen => T::of(0.0),
            };
        }
        self.rigid_elastic.copy_from_slice(&matrix.rigid_elastic);
        for (x, (entry, inverse)) in self.elastic_rigid.iter_mut().zip(
            matrix
                .elastic_rigid
                .iter()
                .zip(self.elastic_inverse.iter().cycle()),
        ) {
            *x = *entry * *inverse;
        }
        let mut schur = matrix.rigid;
        if n > 0 {
            for (j, x) in self.elastic_rigid.chunks_exact(n).enumerate() {
                let mut products = [T::of(0.0); 6];
                T::add_own_products(&mut products, &self.rigid_elastic, x);
                for (i, product) in products.into_iter().enumerate() {
                    schur[(i, j)] -= product;
                }
            }
        }
        let regular = invert_free(&schur, &matrix.free, &mut self.schur_inverse);
        regular
            && self
                .elastic_inverse
                .iter()
                .all(nalgebra::ComplexField::is_finite)
    }

    fn solve(&self, rigid: &mut SixOf<T>, elastic: &mut [T]) {
        for (x, inverse) in elastic.iter_mut().zip(&self.elastic_inverse) {
            *x *= *inverse;
        }
        let mut carried = [T::of(0.0); 6];
        T::add_own_products(&mut carried, &self.rigid_elastic, elastic);
        *rigid = self.schur_inverse * (*rigid - SixOf::from(carried));
        T::add_own_columns(elastic, &self.elastic_rigid, (-*rigid).as_slice());
    }
}

/// S⁻¹ of one body and its responses at its markers.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyFactor<T: Number = f64> {
    elimination: Elimination<T>,
    /// Rigid rows of Z, one (6, 6) block for each marker.
    rigid_responses: Vec<Matrix6<T>>,
    /// Elastic rows of Z, (n, 6) by columns for each marker.
    elastic_responses: Vec<T>,
    /// N Z by marker pairs, (twist at the row's marker, wrench at the column's); empty where nobody asks for it.
    compliance: Vec<Matrix6<T>>,
}

impl<T: Number> BodyFactor<T> {
    /// Room for a body of n coordinates and its markers.
    pub fn with_room(count: usize, markers: usize) -> Self {
        Self {
            elimination: Elimination {
                schur_inverse: Matrix6::zeros(),
                rigid_elastic: vec![T::of(0.0); 6 * count],
                elastic_rigid: vec![T::of(0.0); 6 * count],
                elastic_inverse: vec![T::of(0.0); count],
            },
            rigid_responses: vec![Matrix6::zeros(); markers],
            elastic_responses: vec![T::of(0.0); 6 * count * markers],
            compliance: vec![Matrix6::zeros(); markers * markers],
        }
    }

    /// Room for a rigid body whose compliance between markers nobody asks for.
    pub fn with_responses_alone(markers: usize) -> Self {
        let mut factor = Self::with_room(0, 0);
        factor.rigid_responses = vec![Matrix6::zeros(); markers];
        factor
    }

    /// S⁻¹ of a rigid body; rows and columns of motions that the body hasn't are zero.
    pub fn rigid_inverse(&self) -> &Matrix6<T> {
        &self.elimination.schur_inverse
    }

    /// Eliminates the body. Returns whether its matrix is regular; if not, the factor can't be used.
    pub fn factor(&mut self, matrix: &BodyMatrix<T>, elastic: Elastic) -> bool {
        self.elimination.factor(matrix, elastic)
    }

    /// S⁻¹, in place.
    pub fn solve(&self, rigid: &mut SixOf<T>, elastic: &mut [T]) {
        self.elimination.solve(rigid, elastic);
    }

    /// Responses to wrenches at the markers, and the compliance between them.
    pub fn respond<'a>(
        &mut self,
        dimension: Dimension,
        markers: impl Iterator<Item = (&'a Marker, &'a MarkerPlace)> + Clone,
    ) {
        let n = self.elimination.elastic_inverse.len();
        let count = self.rigid_responses.len();
        // Nothing answers to other wrenches.
        let wrenches: &[usize] = match dimension {
            Dimension::Planar => &PLANAR,
            Dimension::Spatial => &[0, 1, 2, 3, 4, 5],
        };
        for (k, (marker, place)) in markers.clone().enumerate() {
            let responses = &mut self.elastic_responses[6 * n * k..6 * n * (k + 1)];
            for &wrench in wrenches {
                let mut rigid = SixOf::<T>::zeros();
                let elastic = &mut responses[n * wrench..n * (wrench + 1)];
                elastic.fill(T::of(0.0));
                let mut unit = SixOf::<T>::zeros();
                unit[wrench] = T::of(1.0);
                marker.add_force(place, &unit, 1.0, &mut rigid, elastic);
                self.elimination.solve(&mut rigid, elastic);
                self.rigid_responses[k].set_column(wrench, &rigid);
            }
            if self.compliance.is_empty() {
                continue;
            }
            for (l, (seen, seen_place)) in markers.clone().enumerate() {
                let mut block = Matrix6::zeros();
                for &wrench in wrenches {
                    let rigid = self.rigid_responses[k].column(wrench).into_owned();
                    let elastic = &responses[n * wrench..n * (wrench + 1)];
                    block.set_column(wrench, &seen.twist(seen_place, &rigid, elastic));
                }
                self.compliance[l * count + k] = block;
            }
        }
    }

    /// Twist at marker `seen` for a wrench at marker `loaded`, both counted among the body's own.
    pub fn compliance(&self, seen: usize, loaded: usize) -> &Matrix6<T> {
        &self.compliance[seen * self.rigid_responses.len() + loaded]
    }

    /// Adds to the compliance what an interface gives beside the coordinates.
    pub fn add_compliance(&mut self, seen: usize, loaded: usize, more: &Matrix6<T>) {
        let count = self.rigid_responses.len();
        self.compliance[seen * count + loaded] += more;
    }

    /// Adds the body's response to a wrench at one of its markers.
    pub fn add_response(
        &self,
        marker: usize,
        wrench: &SixOf<T>,
        rigid: &mut SixOf<T>,
        elastic: &mut [T],
    ) {
        *rigid += self.rigid_responses[marker] * wrench;
        let size = 6 * elastic.len();
        let responses = &self.elastic_responses[size * marker..size * (marker + 1)];
        T::add_own_columns(elastic, responses, wrench.as_slice());
    }
}

/// The inverse over the free rows and columns, zero elsewhere; whether it exists.
fn invert_free<T: Number>(matrix: &Matrix6<T>, free: &[bool; 6], inverse: &mut Matrix6<T>) -> bool {
    if *free == [true, true, false, false, false, true] {
        let own = Matrix3::from_fn(|i, j| matrix[(PLANAR[i], PLANAR[j])]);
        let Some(found) = own.try_inverse() else {
            return false;
        };
        inverse.fill(T::of(0.0));
        for i in 0..3 {
            for j in 0..3 {
                inverse[(PLANAR[i], PLANAR[j])] = found[(i, j)];
            }
        }
        return found.iter().all(nalgebra::ComplexField::is_finite);
    }
    let mut pinned = *matrix;
    for (i, free) in free.iter().enumerate() {
        if !free {
            pinned.row_mut(i).fill(T::of(0.0));
            pinned.column_mut(i).fill(T::of(0.0));
            pinned[(i, i)] = T::of(1.0);
        }
    }
    let Some(found) = pinned.try_inverse() else {
        return false;
    };
    *inverse = found;
    for (i, free) in free.iter().enumerate() {
        if !free {
            inverse[(i, i)] = T::of(0.0);
        }
    }
    inverse.iter().all(nalgebra::ComplexField::is_finite)
}
