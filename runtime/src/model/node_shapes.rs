//! Elastic displacement of nodes over the coordinates of a body, and their deflection from a chord.

use faer::Mat;
use nalgebra::Vector3;

use super::library::FieldsOfNode;
use super::moment::Moment;
use crate::body::{Compatibility, FlexibleBody};
use crate::system::marker::{Marker, halves};

/// Displacement of one node by the coordinates.
#[derive(Clone, Debug)]
pub(super) struct NodeShapes {
    /// At rest from the centre of mass, body axes.
    pub position: Vector3<f64>,
    /// By axes, (n) each.
    shapes: [Vec<f64>; 3],
    /// G_res L_bᵀ at the node by axes, (n_b) each, where interface forces deflect the body beside the coordinates; else empty.
    residual: [Vec<f64>; 3],
}

impl NodeShapes {
    /// Of the node whose fields these are.
    pub fn of(body: &FlexibleBody, fields: &FieldsOfNode) -> Self {
        let basis = &fields.basis;
        let mut shapes = [(); 3].map(|()| vec![0.0; body.coordinate_count()]);
        let rows = match body.compatibility {
            Compatibility::Static => body.rows.len(),
            Compatibility::Strong | Compatibility::Weak => 0,
        };
        let mut residual = [(); 3].map(|()| vec![0.0; rows]);
        for (row, dof) in basis.dofs.iter().enumerate() {
            if dof.direction.is_rotation() {
                continue;
            }
            let own = &mut residual[dof.direction.axis()];
            for (b, entry) in own.iter_mut().enumerate() {
                *entry = basis.residual[(row, b)];
            }
            let shape = &mut shapes[dof.direction.axis()];
            for (k, entry) in shape.iter_mut().enumerate() {
                *entry = if k < body.mode_count {
                    basis.modes[(row, k)]
                } else {
                    let at_row = |fields: &Mat<f64>, transform: &Mat<f64>| -> f64 {
                        let column = transform.col(k - body.mode_count);
                        (0..column.nrows())
                            .map(|b| fields[(row, b)] * column[b])
                            .sum()
                    };
                    let further = basis.enrichment.as_ref();
                    at_row(&basis.residual, &body.attachment_transform)
                        + further.map_or(0.0, |fields| at_row(fields, &body.further_transform))
                };
            }
        }
        Self {
            position: Vector3::from(fields.position) - Vector3::from(body.origin),
            shapes,
            residual,
        }
    }

    /// u, body axes, of a node of body `index`.
    pub fn displacement(&self, at: &Moment, index: usize) -> Vector3<f64> {
        let body = &at.system.bodies[index];
        let y = &at.state.coordinates[body.coordinates.clone()];
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut u = Vector3::from_fn(|axis, _| product(&self.shapes[axis], y));
        if !self.residual[0].is_empty() {
            let mut forces = vec![0.0; self.residual[0].len()];
            at.evaluation
                .write_interface_forces(at.system, index, &mut forces);
            u += Vector3::from_fn(|axis, _| product(&self.residual[axis], &forces));
        }
        u
    }
}

/// A node between two interfaces.
#[derive(Clone, Debug)]
pub(super) struct Chord {
    node: NodeShapes,
    ends: [Marker; 2],
    /// Where the node is along the chord, 0 to 1.
    fraction: f64,
    pub direction: Vector3<f64>,
    length: f64,
}

impl Chord {
    /// `None` if the ends coincide.
    pub fn between(node: NodeShapes, ends: [Marker; 2]) -> Option<Self> {
        let chord = ends[1].position - ends[0].position;
        let length = chord.norm();
        (length > 0.0).then(|| {
            let direction = chord / length;
            Self {
                fraction: direction.dot(&(node.position - ends[0].position)) / length,
                node,
                ends,
                direction,
                length,
            }
        })
    }

    /// Deflection across the chord, divided by its length, body axes.
    pub fn deflection(&self, at: &Moment, index: usize) -> Vector3<f64> {
        let body = &at.system.bodies[index];
        let y = &at.state.coordinates[body.coordinates.clone()];
        let [a, b] = self.ends.each_ref().map(|end| {
            let extra = at.evaluation.extra(at.system, at.state, end);
            end.displacement(y).0 + halves(&extra).0
        });
        let node = self.node.displacement(at, index);
        let off = node - a * (1.0 - self.fraction) - b * self.fraction;
        (off - self.direction * self.direction.dot(&off)) / self.length
    }
}
