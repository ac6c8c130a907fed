//! The scale of the spectrum before anything is factorized: how low the first elastic eigenvalue lies, and how far
//! rounding in the stiffness matrix reaches.
//!
//! The estimate is the lowest Ritz value over all displacement fields that are quadratic in the coordinates. They contain
//! uniform strain and the pure bending of a straight part (with its anticlastic curvature), so for parts that are not
//! strongly curved the value lies within a factor of two above the first eigenvalue; it is always an upper bound.

use dcb_dense::symmetric_eigen;
use dcb_formats::SparseMatrix;
use dcb_formats::mesh::Dimension;
use dcb_sparse::block_algebra::{
    absolute_product, column_norms, combination, gram, symmetric_product,
};
use dcb_sparse::column_products::BLOCK;
use faer::{Mat, MatRef};
use rayon::prelude::*;

use crate::model::condensation::Model;
use crate::model::piece_motions::Pieces;
use crate::model::rigid_body::RigidBodyModes;
use crate::model::rigid_frame::PointMotion;

/// Shift σ of the factorized K + σ M as a fraction of the estimated first elastic eigenvalue: small enough that the
/// first modes dominate, large enough that K + σ M is far from singular.
const SHIFT_FRACTION: f64 = 1e-5;
/// The shift stays this many times above what rounding does to a rigid motion's eigenvalue,
const SHIFT_OVER_ROUNDING: f64 = 1e4;
/// and this many times above what entries known to few digits do.
const SHIFT_OVER_PRECISION: f64 = 10.0;
/// Entries known to fewer digits than this are no stiffness matrix.
const FEWEST_DIGITS: f64 = 1e-5;

/// Scale of the spectrum, ω² in 1/time².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectrumScale {
    /// Upper bound of the first elastic eigenvalue; 0 for a part without elastic motion.
    pub first_elastic: f64,
    /// Lower limit of a shift that the precision of K's entries sets.
    pub shift_floor: f64,
}

impl SpectrumScale {
    /// Estimates the scale.
    pub fn of(
        model: &Model,
        rigid: &RigidBodyModes,
        pieces: &Pieces,
        dimension: Dimension,
        centre: [f64; 3],
    ) -> Self {
        let mut fields = quadratic_fields(model, dimension, centre, rigid.length);
        rigid.project_out(&mut fields);
        let energies = AbsoluteForces::of(&model.stiffness, rigid.shapes.as_ref()).energies;
        let mut largest = energies.into_iter().fold(0.0, f64::max);
        // Pieces that nothing connects have rigid motions of their own; those of a light, stiff one have more rounding than the whole's.
        if let Some(pieces) = &pieces.motions {
            pieces.project_out(model, &mut fields);
            largest = largest.max(pieces.largest_energy(model));
        }
        let first_elastic = lowest_ritz_value(model, fields.as_ref()).unwrap_or(0.0);
        // A larger defect is not a matter of digits: the part is held, or the mesh is another's.
        let precision = match rigid.stiffness_precision {
            digits if digits <= FEWEST_DIGITS => digits,
            _ => f64::EPSILON,
        };
        let shift_floor =
            (SHIFT_OVER_ROUNDING * f64::EPSILON).max(SHIFT_OVER_PRECISION * precision) * largest;
        Self {
            first_elastic,
            shift_floor,
        }
    }

    /// σ for the factorization of K + σ M.
    pub fn shift(&self) -> f64 {
        (SHIFT_FRACTION * self.first_elastic).max(self.shift_floor)
    }
}

/// |K| |x| of each column: times machine precision, a bound of the rounding in K x.
pub struct AbsoluteForces {
    /// `|x|ᵀ |K| |x|`: times machine precision, the rounding in `xᵀ K x`.
    pub energies: Vec<f64>,
    /// ‖|K| |x|‖.
    pub norms: Vec<f64>,
}

impl AbsoluteForces {
    /// Of columns x, (n, k).
    pub fn of(stiffness: &SparseMatrix, x: MatRef<'_, f64>) -> Self {
        let (mut energies, mut norms) = (Vec::new(), Vec::new());
        for first in (0..x.ncols()).step_by(BLOCK) {
            let x = x.subcols(first, BLOCK.min(x.ncols() - first));
            let forces = absolute_product(stiffness, x);
            let energy = |j: usize| -> f64 {
                let pairs = x.col(j).iter().zip(forces.col(j).iter());
                pairs.map(|(x, f)| x.abs() * f).sum()
            };
            energies.par_extend((0..x.ncols()).into_par_iter().map(energy));
            norms.extend(column_norms(forces.as_ref()));
        }
        Self { energies, norms }
    }
}

/// A bound of |x|ᵀ |K| |x| that costs one pass over K for any number of columns: Σ wᵢ xᵢ² with wᵢ = √kᵢᵢ Σⱼ |kᵢⱼ| / √kⱼⱼ, from
/// 2 |xᵢ xⱼ| ≤ √(kᵢᵢ/kⱼⱼ) xᵢ² + √(kⱼⱼ/kᵢᵢ) xⱼ². It doesn't depend on units, and for motions that are smooth it is hardly above.
pub struct EnergyBound {
    weights: Vec<f64>,
}

impl EnergyBound {
    /// Of a symmetric matrix with all its entries.
    pub fn of(stiffness: &SparseMatrix) -> Self {
        let n = stiffness.ncols();
        let roots: Vec<f64> = (0..n)
            .into_par_iter()
            .map(|i| {
                let entry = stiffness.as_ref().get(i, i).copied().unwrap_or(0.0);
                entry.max(0.0).sqrt()
            })
            .collect();
        let weights = (0..n)
            .into_par_iter()
            .map(|j| {
                let rows = stiffness.as_ref().row_idx_of_col(j);
                let entries = rows.zip(stiffness.as_ref().val_of_col(j));
                let scaled = |(i, entry): (usize, &f64)| match roots[i] {
                    root if root > 0.0 => entry.abs() / root,
                    _ => 0.0,
                };
                roots[j] * entries.map(scaled).sum::<f64>()
            })
            .collect();
        Self { weights }
    }

    /// Of each column x, (n, k).
    pub fn energies(&self, x: MatRef<'_, f64>) -> Vec<f64> {
        x.par_col_iter()
            .map(|column| {
                let pairs = column.iter().zip(&self.weights);
                pairs.map(|(x, weight)| weight * x * x).sum()
            })
            .collect()
    }
}

/// All displacement fields with one quadratic or linear monomial in one component, with half their curl as rotations; internal rows are at
/// rest.
fn quadratic_fields(
    model: &Model,
    dimension: Dimension,
    centre: [f64; 3],
    length: f64,
) -> Mat<f64> {
    let d = dimension.coordinate_count();
    let mut monomials: Vec<Vec<usize>> = (0..d).map(|a| vec![a]).collect();
    for a in 0..d {
        for b in a..d {
            monomials.push(vec![a, b]);
        }
    }
    let mut fields = Mat::zeros(model.len(), d * monomials.len());
    fields
        .par_col_iter_mut()
        .enumerate()
        .for_each(|(column, field)| {
            let component = column / monomials.len();
            let monomial = &monomials[column % monomials.len()];
            for (value, dof) in field.iter_mut().zip(&model.dofs) {
                let Some(PointMotion {
                    direction,
                    position,
                }) = dof.motion
                else {
                    continue;
                };
                let xi: [f64; 3] =
                    std::array::from_fn(|axis| (position[axis] - centre[axis]) / length);
                *value = match direction.is_rotation() {
                    false if direction.axis() == component => {
                        monomial.iter().map(|a| xi[*a]).product()
                    }
                    false => 0.0,
                    true => half_curl(monomial, component, direction.axis(), &xi) / length,
                };
            }
        });
    fields
}

/// Component `about` of half the curl of the field `monomial · e_component`, derivatives in scaled coordinates.
fn half_curl(monomial: &[usize], component: usize, about: usize, xi: &[f64; 3]) -> f64 {
    // (curl u)_about = ∂u_{about+2}/∂x_{about+1} - ∂u_{about+1}/∂x_{about+2}
    let (next, after) = ((about + 1) % 3, (about + 2) % 3);
    let (along, sign) = match component {
        c if c == after => (next, 0.5),
        c if c == next => (after, -0.5),
        _ => return 0.0,
    };
    let derivative: f64 = (0..monomial.len())
        .filter(|i| monomial[*i] == along)
        .map(|i| {
            monomial
                .iter()
                .enumerate()
                .filter(|(j, _)| *j != i)
                .map(|(_, a)| xi[*a])
                .product::<f64>()
        })
        .sum();
    sign * derivative
}

fn lowest_ritz_value(model: &Model, fields: MatRef<'_, f64>) -> Option<f64> {
    let mass = gram(fields, symmetric_product(&model.mass, fields).as_ref());
    let (values, vectors) = symmetric_eigen(mass.as_ref())?;
    let largest = values.last().copied()?;
    // Fields that a flat or straight part cannot tell apart, and those that were rigid, have no mass left.
    let kept: Vec<usize> = (0..values.len())
        .filter(|i| values[*i] > 1e-9 * largest)
        .collect();
    let scaled = Mat::from_fn(values.len(), kept.len(), |i, j| {
        vectors[(i, kept[j])] / values[kept[j]].sqrt()
    });
    let fields = combination(fields, scaled.as_ref());
    let stiffness = gram(
        fields.as_ref(),
        symmetric_product(&model.stiffness, fields.as_ref()).as_ref(),
    );
    let (values, _) = symmetric_eigen(stiffness.as_ref())?;
    values.first().map(|value| value.max(0.0))
}
