//! Elastic displacement of nodes over the coordinates of a body, and their deflection from a chord.

use dcb_dense::{symmetric_eigen, symmetrized};
use dcb_formats::component::Role;
use faer::Mat;
use nalgebra::Vector3;

use super::library::FieldsOfNode;
use super::moment::Moment;
use crate::body::{Compatibility, FlexibleBody};
use crate::system::marker::{Marker, halves};
use crate::system::state::rates;

/// Part of the largest flexibility below which a direction of interface forces deflects nothing.
const NEGLIGIBLE: f64 = 1e-12;

/// Displacement of one node by the coordinates.
#[derive(Clone, Debug)]
pub(super) struct NodeShapes {
    /// At rest from the centre of mass, body axes.
    pub position: Vector3<f64>,
    /// By axes, (n) each.
    shapes: [Vec<f64>; 3],
    /// G_res L_bᵀ at the node by axes, (n_b) each, where interface forces deflect the body beside the coordinates; else empty.
    residual: [Vec<f64>; 3],
    /// The same by the displacement of the interfaces beside the coordinates, in place of the forces: what rates are known of.
    carried: [Vec<f64>; 3],
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
            carried: carried(body, &residual),
            residual,
        }
    }

    /// Where the node is, world axes.
    pub fn place(&self, at: &Moment, index: usize) -> Vector3<f64> {
        let pose = &at.evaluation.poses[index];
        pose.origin + pose.axes * (self.position + self.displacement(at, index))
    }

    /// `V + A (ω × (r + u) + u')`, world axes.
    pub fn velocity(&self, at: &Moment, index: usize) -> Vector3<f64> {
        let (rigid, rates) = at.state.body_rates(at.system, index);
        let arm = self.position + self.displacement(at, index);
        let rate = self.moved(at, index, rates, &at.state.residual_rates);
        rigid.linear + at.evaluation.poses[index].axes * (rigid.angular.cross(&arm) + rate)
    }

    /// `V' + A (ω' × (r + u) + ω × (ω × (r + u) + 2 u') + u'')`, world axes.
    pub fn acceleration(&self, at: &Moment, index: usize) -> Vector3<f64> {
        let (rigid, y_rates) = at.state.body_rates(at.system, index);
        let all = &at.state.accelerations[at.system.bodies[index].velocities.clone()];
        let changing = rates(all);
        let arm = self.position + self.displacement(at, index);
        let rate = self.moved(at, index, y_rates, &at.state.residual_rates);
        let second = self.moved(at, index, &all[6..], &at.state.residual_accelerations);
        let spin = rigid.angular;
        let own = changing.angular.cross(&arm) + spin.cross(&(spin.cross(&arm) + rate * 2.0));
        changing.linear + at.evaluation.poses[index].axes * (own + second)
    }

    /// Motion of the node in its body of coordinates and of the displacements of interfaces beside them, of all bodies.
    fn moved(&self, at: &Moment, index: usize, y: &[f64], beside: &[f64]) -> Vector3<f64> {
        let own = Vector3::from_fn(|axis, _| product(&self.shapes[axis], y));
        match self.carried[0].is_empty() {
            true => own,
            false => {
                let rows = &beside[at.system.bodies[index].residual_rows.clone()];
                own + Vector3::from_fn(|axis, _| product(&self.carried[axis], rows))
            }
        }
    }

    /// u, body axes, of a node of body `index`.
    pub fn displacement(&self, at: &Moment, index: usize) -> Vector3<f64> {
        let body = &at.system.bodies[index];
        let y = &at.state.coordinates[body.coordinates.clone()];
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

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `G_res L_bᵀ F⁻` at a node by axes: the motion that displacements x = F g of the interfaces go along with. Any generalised inverse F⁻ gives the
/// same, because forces that displace no interface deflect nothing. Forces act on attachments alone.
fn carried(body: &FlexibleBody, residual: &[Vec<f64>; 3]) -> [Vec<f64>; 3] {
    let rows = residual[0].len();
    let mut carried = [(); 3].map(|()| vec![0.0; rows]);
    let Some(flexibility) = body.residual_flexibility.as_ref().filter(|_| rows > 0) else {
        return carried;
    };
    let is_loaded = |row: &usize| {
        let interface = body.rows[*row].interface;
        body.interfaces[interface].role == Role::Attachment && flexibility[(*row, *row)] > 0.0
    };
    let loaded: Vec<usize> = (0..rows).filter(is_loaded).collect();
    // Rows of lengths and of angles side by side.
    let unit: Vec<f64> = loaded
        .iter()
        .map(|row| flexibility[(*row, *row)].sqrt().recip())
        .collect();
    let scaled = Mat::from_fn(loaded.len(), loaded.len(), |i, j| {
        unit[i] * flexibility[(loaded[i], loaded[j])] * unit[j]
    });
    let Some((values, vectors)) = symmetric_eigen(symmetrized(&scaled).as_ref()) else {
        return carried;
    };
    let largest = values.last().copied().unwrap_or(0.0);
    for (of_forces, of_rows) in residual.iter().zip(&mut carried) {
        let directions = values.iter().enumerate();
        for (k, value) in directions.filter(|(_, value)| **value > NEGLIGIBLE * largest) {
            let along = vectors.col(k);
            let amount: f64 = (loaded.iter().zip(&unit).zip(along.iter()))
                .map(|((row, unit), entry)| of_forces[*row] * unit * entry)
                .sum();
            for ((row, unit), entry) in loaded.iter().zip(&unit).zip(along.iter()) {
                of_rows[*row] += amount / value * unit * entry;
            }
        }
    }
    carried
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
