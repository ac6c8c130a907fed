//! Rigid-body motions from the node positions, and the mass properties that follow from them.
//!
//! The columns are not computed from the stiffness matrix but written down from geometry and then confirmed: K r must
//! vanish ([`RigidBodyModes::stiffness_defects`]). That finds wrong dof maps, which a numerical null space never would.

use dcb_formats::SparseMatrix;
use dcb_formats::component::Component;
use dcb_formats::mesh::Dimension;
use dcb_sparse::block_algebra::{absolute_product, combination, gram, symmetric_product};
use faer::concat;
use faer::{Mat, MatRef};

use crate::error::{Error, MatrixRefusal};
use crate::model::condensation::Model;
use crate::model::frame::{nodes_with_dofs, offset, part_size, rigid_motion};
use crate::model::mass_sign::{diagonal, largest_scaled_row_sum};
use crate::model::rigid_frame::PointMotion;

/// Mass, centre of mass and inertia about it, from the mass matrix alone.
#[derive(Clone, Debug, PartialEq)]
pub struct MassProperties {
    /// Total mass (mean over the directions).
    pub mass: f64,
    /// Centre of mass, component coordinates.
    pub centre: [f64; 3],
    /// Inertia tensor about the centre of mass, component axes; planar: only (z, z).
    pub tensor: [[f64; 3]; 3],
    /// Largest relative disagreement between the directions: 0 for a mass matrix that moves as a rigid body should.
    pub defect: f64,
}

/// Rigid-body columns over some list of dofs; internal rows (`None`) stay at rest.
pub(crate) fn columns(
    dimension: Dimension,
    dofs: impl Iterator<Item = Option<PointMotion>>,
    reference: [f64; 3],
    count: usize,
) -> Mat<f64> {
    let directions = dimension.frame_directions();
    let mut columns = Mat::zeros(count, directions.len());
    for (row, motion) in dofs.enumerate() {
        let Some(motion) = motion else {
            continue;
        };
        let arm = offset(motion.position, reference);
        for (column, direction) in directions.iter().enumerate() {
            columns[(row, column)] = rigid_motion(*direction, arm)[motion.direction.index()];
        }
    }
    columns
}

/// The rigid columns X = [T, X_r] over the component's dofs about a reference point, (n_e, 3 or 6); zero in internal rows.
pub fn component_columns(component: &Component, reference: [f64; 3]) -> Mat<f64> {
    let dofs = component.dofs.rows().iter().map(|row| {
        row.dof().map(|dof| PointMotion {
            direction: dof.direction,
            position: component.mesh.position(dof.node),
        })
    });
    columns(component.dimension(), dofs, reference, component.dofs.len())
}

impl MassProperties {
    /// Reads the mass properties off Xᵀ M X.
    ///
    /// # Errors
    /// [`Error::Matrix`] if the total mass is not positive.
    pub fn of(component: &Component) -> Result<Self, Error> {
        let dimension = component.dimension();
        let d = dimension.coordinate_count();
        let middle = component_middle(component);
        let rigid_mass = |reference| {
            let x = component_columns(component, reference);
            gram(
                x.as_ref(),
                symmetric_product(&component.mass, x.as_ref()).as_ref(),
            )
        };
        let about_middle = rigid_mass(middle);
        let mass = (0..d).map(|i| about_middle[(i, i)]).sum::<f64>() / d as f64;
        if mass.is_nan() || mass <= 0.0 {
            let x = component_columns(component, middle);
            let translations = x.as_ref().get(.., ..d);
            return Err(
                match are_swapped(&component.stiffness, &component.mass, translations) {
                    true => MatrixRefusal::Swapped,
                    false => MatrixRefusal::NoMass {
                        mass,
                        unit: component.units.mass.clone(),
                    },
                }
                .into(),
            );
        }
        // Translation i against rotation a couples by m (e_a × s)_i, with s from the reference to the centre of mass.
        let mut s = [0.0; 3];
        match dimension {
            Dimension::Planar => {
                s[0] = about_middle[(1, 2)] / mass;
                s[1] = -about_middle[(0, 2)] / mass;
            }
            Dimension::Spatial => {
                for (k, along) in s.iter_mut().enumerate() {
                    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                    *along = (about_middle[(i, 3 + j)] - about_middle[(j, 3 + i)]) / (2.0 * mass);
                }
            }
        }
        let centre = [middle[0] + s[0], middle[1] + s[1], middle[2] + s[2]];
        let about_centre = rigid_mass(centre);
        let size = part_size(component);
        let mut defect = 0.0_f64;
        for i in 0..d {
            for j in 0..d {
                let expected = if i == j { mass } else { 0.0 };
                defect = defect.max((about_centre[(i, j)] - expected).abs() / mass);
            }
            for a in d..about_centre.ncols() {
                defect = defect.max(about_centre[(i, a)].abs() / (mass * size));
            }
        }
        let mut tensor = [[0.0; 3]; 3];
        match dimension {
            Dimension::Planar => tensor[2][2] = about_centre[(2, 2)],
            Dimension::Spatial => {
                for (a, row) in tensor.iter_mut().enumerate() {
                    for (b, entry) in row.iter_mut().enumerate() {
                        *entry =
                            0.5 * (about_centre[(3 + a, 3 + b)] + about_centre[(3 + b, 3 + a)]);
                    }
                }
            }
        }
        Ok(Self {
            mass,
            centre,
            tensor,
            defect,
        })
    }
}

/// Mean position of the nodes with dofs: a reference near the part, so that nothing cancels for parts far from the origin.
fn component_middle(component: &Component) -> [f64; 3] {
    let nodes = nodes_with_dofs(component);
    crate::model::frame::weighted_centroid(component, &nodes, &vec![1.0; nodes.len()])
}

/// Rigid-body motions of the model about the centre of mass.
#[derive(Clone, Debug)]
pub struct RigidBodyModes {
    /// As written down from geometry, rotations divided by the part's size, (n_c, 3 or 6).
    pub geometric: Mat<f64>,
    /// M-orthonormal columns spanning the same space, (n_c, 3 or 6).
    pub shapes: Mat<f64>,
    /// M times `shapes`.
    pub mass_shapes: Mat<f64>,
    /// The part's size, the length by which rotations are scaled.
    pub length: f64,
    /// Relative precision of the stiffness entries as the rigid motions show it: machine precision, or what few printed
    /// digits left.
    pub stiffness_precision: f64,
}

/// A matrix of which the rigid translations take less than this share of the diagonal's sum acts as a stiffness.
const SHARE_OF_A_STIFFNESS: f64 = 1e-6;
/// A matrix of which they take more acts as a mass.
const SHARE_OF_A_MASS: f64 = 1e-2;

/// Largest quotient g^T A g / sum |A_ii| g_i^2 over translations g: 1 and more for a mass, rounding for a stiffness.
fn translation_share(matrix: &SparseMatrix, translations: MatRef<'_, f64>) -> f64 {
    let product = symmetric_product(matrix, translations);
    let diagonal = diagonal(matrix);
    let share = |column: usize| {
        let (mut whole, mut sum) = (0.0, 0.0);
        for (row, entry) in diagonal.iter().enumerate() {
            let motion = translations[(row, column)];
            whole += entry.abs() * motion * motion;
            sum += motion * product[(row, column)];
        }
        if whole > 0.0 { sum.abs() / whole } else { 0.0 }
    };
    (0..translations.ncols()).map(share).fold(0.0, f64::max)
}

/// Whether the mass acts as a stiffness against rigid translations, and the stiffness as a mass.
fn are_swapped(
    stiffness: &SparseMatrix,
    mass: &SparseMatrix,
    translations: MatRef<'_, f64>,
) -> bool {
    translation_share(mass, translations) < SHARE_OF_A_STIFFNESS
        && translation_share(stiffness, translations) > SHARE_OF_A_MASS
}

/// Sums of a row's entries round to this many machine precisions; a larger defect is in the entries themselves.
const ROUNDING_OF_A_ROW: f64 = 64.0;

impl RigidBodyModes {
    /// Writes the columns down and orthonormalises them.
    ///
    /// # Errors
    /// [`Error::Matrix`] if the mass matrix is not positive on them (a part without extent or without mass in a direction).
    pub fn of(
        component: &Component,
        model: &Model,
        properties: &MassProperties,
    ) -> Result<Self, Error> {
        let length = part_size(component);
        let dofs = model.dofs.iter().map(|dof| dof.motion);
        let mut geometric = columns(component.dimension(), dofs, properties.centre, model.len());
        for (column, direction) in component.dimension().frame_directions().iter().enumerate() {
            if direction.is_rotation() {
                geometric
                    .as_mut()
                    .col_mut(column)
                    .iter_mut()
                    .for_each(|entry| *entry /= length);
            }
        }
        let translations = geometric
            .as_ref()
            .get(.., ..component.dimension().coordinate_count());
        if are_swapped(&model.stiffness, &model.mass, translations) {
            return Err(MatrixRefusal::Swapped.into());
        }
        let shapes =
            orthonormalized(&model.mass, geometric.as_ref()).ok_or(MatrixRefusal::NoInertia)?;
        let mass_shapes = symmetric_product(&model.mass, shapes.as_ref());
        // Internal rows rest, but their size counts: what they share with nodes may be nothing but rounding.
        let amounts = model.unit_amounts(length);
        let bounds = Mat::from_fn(model.len(), 1, |row, _| amounts[row]);
        let stiffness_precision =
            entry_precision(&model.stiffness, geometric.as_ref(), bounds.as_ref());
        Ok(Self {
            geometric,
            shapes,
            mass_shapes,
            length,
            stiffness_precision,
        })
    }

    /// No rigid motion: for a part that is held.
    pub fn none(&self) -> Self {
        let n = self.shapes.nrows();
        Self {
            geometric: Mat::zeros(n, 0),
            shapes: Mat::zeros(n, 0),
            mass_shapes: Mat::zeros(n, 0),
            length: self.length,
            stiffness_precision: f64::EPSILON,
        }
    }

    /// With other motions, M-orthonormal to each other and to these, among those that [`RigidBodyModes::project_out`] removes.
    pub fn joined_by(&self, model: &Model, others: &Mat<f64>) -> Self {
        let mass_others = symmetric_product(&model.mass, others.as_ref());
        Self {
            shapes: concat![[self.shapes, others]],
            mass_shapes: concat![[self.mass_shapes, mass_others]],
            ..self.clone()
        }
    }

    /// Number of rigid motions.
    pub fn count(&self) -> usize {
        self.shapes.ncols()
    }

    /// Removes the rigid part of each column: `x -= R (M R)ᵀ x`, twice for accuracy.
    pub fn project_out(&self, x: &mut Mat<f64>) {
        for _ in 0..2 {
            let amounts = gram(self.mass_shapes.as_ref(), x.as_ref());
            dcb_sparse::block_algebra::add_combination(
                x.as_mut(),
                self.shapes.as_ref(),
                amounts.as_ref(),
                -1.0,
            );
        }
    }

    /// `max|K r| / (max row sum of |K| · max|r|)` for each rigid column, rotational rows and columns scaled by the part's
    /// size so that the ratio has no unit.
    pub fn stiffness_defects(&self, model: &Model) -> StiffnessDefects {
        let scale = model.unit_amounts(self.length);
        let row_sum = largest_scaled_row_sum(&model.stiffness, &scale).max(f64::MIN_POSITIVE);
        let products = symmetric_product(&model.stiffness, self.geometric.as_ref());
        let forces = Mat::from_fn(products.nrows(), products.ncols(), |i, j| {
            products[(i, j)] * scale[i] / row_sum
        });
        let per_column = (0..products.ncols())
            .map(|column| {
                let largest = |m: MatRef<'_, f64>, s: &dyn Fn(usize) -> f64| {
                    (0..m.nrows())
                        .map(|i| (m[(i, column)] * s(i)).abs())
                        .fold(0.0, f64::max)
                };
                largest(forces.as_ref(), &|_| 1.0)
                    / largest(self.geometric.as_ref(), &|i| 1.0 / scale[i])
            })
            .collect();
        StiffnessDefects { per_column, forces }
    }
}

/// How well K r = 0 holds for the geometric rigid motions.
pub struct StiffnessDefects {
    /// The ratio per column.
    pub per_column: Vec<f64>,
    /// Scaled K r, (n_c, 3 or 6): large where a motion is resisted.
    pub forces: Mat<f64>,
}

impl StiffnessDefects {
    /// The largest ratio.
    pub fn largest(&self) -> f64 {
        self.per_column.iter().copied().fold(0.0, f64::max)
    }
}

/// Largest `|K r|` of a row over its row sum of `|K|` times `|r|` at its largest: relative error of the entries, as far as
/// K r = 0 tells. `bounds` holds the largest `|r|` of each dof, and what is alike of internal rows, (n_c, 1).
fn entry_precision(
    stiffness: &SparseMatrix,
    rigid: MatRef<'_, f64>,
    bounds: MatRef<'_, f64>,
) -> f64 {
    let sums = symmetric_product(stiffness, rigid);
    let sizes = absolute_product(stiffness, bounds);
    let mut largest = 0.0_f64;
    for column in sums.col_iter() {
        for (sum, size) in column.iter().zip(sizes.col(0).iter()) {
            if *size > 0.0 {
                largest = largest.max(sum.abs() / size);
            }
        }
    }
    if largest <= ROUNDING_OF_A_ROW * f64::EPSILON {
        f64::EPSILON
    } else {
        largest
    }
}

/// M-orthonormal columns with the same span; `None` if M is not positive on it.
fn orthonormalized(mass: &SparseMatrix, columns: MatRef<'_, f64>) -> Option<Mat<f64>> {
    let mut x = columns.to_owned();
    for _ in 0..2 {
        let small = gram(x.as_ref(), symmetric_product(mass, x.as_ref()).as_ref());
        let (values, vectors) = dcb_dense::symmetric_eigen(small.as_ref())?;
        let largest = values.last().copied().unwrap_or(0.0);
        if values.iter().any(|value| *value <= 1e-14 * largest) {
            return None;
        }
        let scaled = Mat::from_fn(vectors.nrows(), vectors.ncols(), |i, j| {
            vectors[(i, j)] / values[j].sqrt()
        });
        x = combination(x.as_ref(), scaled.as_ref());
    }
    Some(x)
}
