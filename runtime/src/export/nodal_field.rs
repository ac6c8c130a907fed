//! Nodal displacements of a body, recovered from its dynamic coordinates.
//!
//! ```text
//! u      =  Φ η  +  (G_res L_bᵀ T + X T_x) ζ  (n_f), body axes; only translations are recovered
//! x      =  R  +  A (X − origin + u)          world position of the node that stands at X in the component
//! ```
//!
//! The basis is large, n_f rows: it is read only where nodal output is wanted.

use dcb_formats::mesh::Mesh;
use dcb_formats::superelement::RecoveryBasis;
use faer::Mat;
use nalgebra::{Matrix3, Vector3};

use crate::body::{Compatibility, FlexibleBody};
use crate::error::Error;

/// Translations of a body's nodes over its dynamic coordinates.
#[derive(Clone, Debug)]
pub struct NodalField {
    /// Node coordinates relative to the body frame's origin, body axes.
    positions: Vec<Vector3<f64>>,
    /// Node and axis of each row of `shapes`.
    rows: Vec<(usize, usize)>,
    /// Ψ_r, one column a coordinate.
    shapes: Mat<f64>,
    /// G_res L_bᵀ where interface forces deflect the body beside its coordinates (static compatibility); else without columns.
    residual: Mat<f64>,
    recovered: Vec<u8>,
}

impl PartialEq for NodalField {
    /// Matrices of different sizes are compared too: bodies of one part may carry different coordinates.
    fn eq(&self, other: &Self) -> bool {
        let is_same = |a: &Mat<f64>, b: &Mat<f64>| a.shape() == b.shape() && a == b;
        self.positions == other.positions
            && self.rows == other.rows
            && self.recovered == other.recovered
            && is_same(&self.shapes, &other.shapes)
            && is_same(&self.residual, &other.residual)
    }
}

impl NodalField {
    /// The field of a body over a mesh.
    ///
    /// Nodes may lack dofs: those that the fields were pruned of, and those that no element moves. They move with the
    /// frame, and [`NodalField::recovered`] marks them.
    ///
    /// # Errors
    /// [`Error::Field`] if body, basis and mesh aren't of one component, or no node's translations are in the basis.
    pub fn new(body: &FlexibleBody, basis: &RecoveryBasis, mesh: &Mesh) -> Result<Self, Error> {
        let refused = |message: String| Error::Field {
            body: body.name.clone(),
            message,
        };
        check_counts(body, basis, mesh).map_err(refused)?;
        let node_count = mesh.node_count();
        let transform = &body.attachment_transform;
        let translations: Vec<usize> = (0..basis.dofs.len())
            .filter(|&row| !basis.dofs[row].direction.is_rotation())
            .collect();
        let mut found_axes = vec![0; node_count];
        for &row in &translations {
            found_axes[basis.dofs[row].node as usize] += 1;
        }
        let d = mesh.dimension.coordinate_count();
        let recovered: Vec<u8> = found_axes.iter().map(|&axes| u8::from(axes == d)).collect();
        if !recovered.contains(&1) {
            return Err(refused(
                "its nodal fields hold no node's translations; reduce it with the fields of the nodes to show"
                    .to_owned(),
            ));
        }
        let attached = attached_fields(body, basis).map_err(refused)?;
        let n_k = body.mode_count;
        let shapes = Mat::from_fn(translations.len(), body.coordinate_count(), |i, j| {
            let row = translations[i];
            if j < n_k {
                basis.modes[(row, j)]
            } else {
                attached[(row, j - n_k)]
            }
        });
        let residual = match body.compatibility {
            Compatibility::Static => Mat::from_fn(translations.len(), transform.nrows(), |i, b| {
                basis.residual[(translations[i], b)]
            }),
            Compatibility::Strong | Compatibility::Weak => Mat::zeros(translations.len(), 0),
        };
        let place = |&row: &usize| {
            let dof = basis.dofs[row];
            (dof.node as usize, dof.direction.axis())
        };
        let origin = Vector3::from(body.origin);
        Ok(Self {
            positions: (0..node_count as u32)
                .map(|node| Vector3::from(mesh.position(node)) - origin)
                .collect(),
            rows: translations.iter().map(place).collect(),
            shapes,
            residual,
            recovered,
        })
    }

    /// Number of nodes of the mesh.
    pub fn node_count(&self) -> usize {
        self.positions.len()
    }

    /// For each node 1 if the basis has all its translations, 0 if some are taken as zero.
    pub fn recovered(&self) -> &[u8] {
        &self.recovered
    }

    /// Elastic displacement u of every node at the coordinates y, (n), body axes.
    pub fn displacement(&self, y: &[f64]) -> Vec<Vector3<f64>> {
        let mut displacement = vec![Vector3::zeros(); self.node_count()];
        for (coordinate, &value) in y.iter().enumerate() {
            let shape = self.shapes.col_as_slice(coordinate);
            for (&(node, axis), shape) in self.rows.iter().zip(shape) {
                displacement[node][axis] += shape * value;
            }
        }
        displacement
    }

    /// Adds what interface forces g, (n_b), deflect beside the coordinates; nothing but for static compatibility.
    pub fn add_residual(&self, forces: &[f64], displacement: &mut [Vector3<f64>]) {
        for (column, force) in self.residual.col_iter().zip(forces) {
            for (&(node, axis), shape) in self.rows.iter().zip(column.iter()) {
                displacement[node][axis] += shape * force;
            }
        }
    }

    /// Places of all nodes at rest, from the origin of the body's frame.
    pub fn positions(&self) -> &[Vector3<f64>] {
        &self.positions
    }

    /// Number of columns of [`NodalField::pattern`]: elastic coordinates, then, with static compatibility, forces on interface rows.
    pub fn pattern_count(&self) -> usize {
        self.shapes.ncols() + self.residual.ncols()
    }

    /// Displacement of all nodes, body axes, a length for each unit of a coordinate, or of a force on an interface row.
    pub fn pattern(&self, index: usize) -> Vec<Vector3<f64>> {
        let column = match index.checked_sub(self.shapes.ncols()) {
            None => self.shapes.col(index),
            Some(row) => self.residual.col(row),
        };
        let mut displacement = vec![Vector3::zeros(); self.node_count()];
        for (&(node, axis), shape) in self.rows.iter().zip(column.iter()) {
            displacement[node][axis] += shape;
        }
        displacement
    }

    /// World positions of the undeformed nodes, moved by the frame alone: R is the position of the body frame's
    /// origin, A its rotation matrix, body axes to world axes.
    pub fn rigid_positions(
        &self,
        position: &Vector3<f64>,
        axes: &Matrix3<f64>,
    ) -> Vec<Vector3<f64>> {
        let moved = self.positions.iter().map(|at| position + axes * at);
        moved.collect()
    }
}

/// Whether modes, attachments and nodes of a basis are those of the body and the mesh.
fn check_counts(body: &FlexibleBody, basis: &RecoveryBasis, mesh: &Mesh) -> Result<(), String> {
    let found = (basis.modes.ncols(), basis.residual.ncols());
    let expected = (body.mode_count, body.attachment_transform.nrows());
    if found != expected {
        return Err(format!(
            "its nodal fields have {} modes and {} attachments, but the body has {} and {}; read both from one file",
            found.0, found.1, expected.0, expected.1
        ));
    }
    let node_count = mesh.node_count();
    let mut dofs = basis.dofs.iter();
    match dofs.find(|dof| dof.node as usize >= node_count) {
        Some(dof) => Err(format!(
            "its nodal fields name node {}, but the mesh has {node_count} nodes",
            dof.node
        )),
        None => Ok(()),
    }
}

/// G_res L_bᵀ T + X T_x, (n_f, n - n_k).
fn attached_fields(body: &FlexibleBody, basis: &RecoveryBasis) -> Result<Mat<f64>, String> {
    let mut attached = &basis.residual * &body.attachment_transform;
    let further = &body.further_transform;
    match &basis.enrichment {
        Some(fields) if fields.ncols() == further.nrows() => attached += fields * further,
        None if further.nrows() == 0 => {}
        found => {
            let found = found.as_ref().map_or(0, |fields| fields.ncols());
            return Err(format!(
                "its nodal fields have {found} further columns, but the body has {}; read both from one file, of format 1.1 or later",
                further.nrows()
            ));
        }
    }
    Ok(attached)
}
