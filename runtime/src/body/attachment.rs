//! A frame of a body that joints, springs and loads act on: an interface that moves as one.

use dcb_formats::component::InterfaceKind;
use dcb_formats::superelement::{BoundaryRow, InterfaceFrame};
use faer::{Mat, MatRef};
use nalgebra::{Matrix3, Vector3};

use crate::frame::tall_products::{add_columns, add_products};

/// A frame of a body that joints, springs and loads act on.
///
/// Its origin is at `R + A (position + u)` and its axes are `A exp(skew(θ)) axes` for a body frame at R, A, with (u, θ) = S y, less
/// ½ yᵀ K y where there is geometric stiffening K for the row.
#[derive(Clone, Debug, PartialEq)]
pub struct Attachment {
    /// Name of the interface.
    pub name: String,
    /// Rest position, body frame.
    pub position: Vector3<f64>,
    /// Rest rotation matrix, frame axes to body axes: its columns are the frame's axes.
    pub axes: Matrix3<f64>,
    /// Along which body axes the displacement is known.
    pub translations: [bool; 3],
    /// About which body axes the rotation is known.
    pub rotations: [bool; 3],
    /// S_u, then S_θ, row by row, (n) each; zero where not known. 1/√mass, rotations 1/(√mass·length).
    shapes: Vec<f64>,
    /// Geometric stiffness per unit force or moment along a slot of the six, (n, n), where there is any.
    stiffening: Vec<(usize, Mat<f64>)>,
}

impl Attachment {
    /// The frame of interface `index`, or `None` if its rows don't describe one: several nodes, or explicit rows.
    pub(super) fn of_interface(
        index: usize,
        interface: &InterfaceFrame,
        rows: &[BoundaryRow],
        shapes: MatRef<'_, f64>,
        of_rows: &[Mat<f64>],
    ) -> Option<Self> {
        let own = || {
            let all = rows.iter().enumerate();
            all.filter(|(_, row)| row.interface == index)
        };
        let position = frame_position(index, interface, rows)?;
        let n = shapes.ncols();
        let mut known = [false; 6];
        let mut of_frame = vec![0.0; 6 * n];
        let mut stiffening = Vec::new();
        for (row, BoundaryRow { direction, .. }) in own() {
            let direction = usize::try_from(*direction).ok().filter(|d| *d < 6)?;
            known[direction] = true;
            for k in 0..n {
                of_frame[direction * n + k] = shapes[(row, k)];
            }
            if let Some(matrix) = of_rows.get(row).filter(|matrix| matrix.norm_max() > 0.0) {
                stiffening.push((direction, matrix.clone()));
            }
        }
        let [ux, uy, uz, rx, ry, rz] = known;
        Some(Self {
            name: interface.name.clone(),
            position,
            axes: Matrix3::from_fn(|i, j| interface.orientation[i][j]),
            translations: [ux, uy, uz],
            rotations: [rx, ry, rz],
            shapes: of_frame,
            stiffening,
        })
    }

    /// Number of dynamic coordinates of the body.
    pub fn coordinate_count(&self) -> usize {
        self.shapes.len() / 6
    }

    /// Row `axis` of S_u, (n).
    pub fn translation_shape(&self, axis: usize) -> &[f64] {
        self.shape(axis)
    }

    /// Row `axis` of S_θ, (n).
    pub fn rotation_shape(&self, axis: usize) -> &[f64] {
        self.shape(3 + axis)
    }

    /// Geometric stiffness by slots of the six, `ux uy uz rx ry rz`; what isn't there is zero.
    pub fn stiffening(&self) -> &[(usize, Mat<f64>)] {
        &self.stiffening
    }

    fn shape(&self, row: usize) -> &[f64] {
        let n = self.coordinate_count();
        &self.shapes[row * n..(row + 1) * n]
    }

    /// `(S_u y, S_θ y)`: displacement and rotation in body axes; of rates or second rates, their derivatives.
    pub fn products(&self, y: &[f64]) -> (Vector3<f64>, Vector3<f64>) {
        let mut six = [0.0; 6];
        add_products(&mut six, &self.shapes, y);
        let [ux, uy, uz, rx, ry, rz] = six;
        (Vector3::new(ux, uy, uz), Vector3::new(rx, ry, rz))
    }

    /// `forces += S_uᵀ force + S_θᵀ moment`: what a force and a moment in body axes are on the coordinates.
    pub fn add_forces(&self, force: &Vector3<f64>, moment: &Vector3<f64>, forces: &mut [f64]) {
        let six = [force.x, force.y, force.z, moment.x, moment.y, moment.z];
        add_columns(forces, &self.shapes, &six);
    }
}

/// Where the frame of interface `index` is, body frame, or `None` if its rows don't describe one: several nodes, or explicit rows.
pub(super) fn frame_position(
    index: usize,
    interface: &InterfaceFrame,
    rows: &[BoundaryRow],
) -> Option<Vector3<f64>> {
    let mut own = rows.iter().filter(|row| row.interface == index);
    let position = match interface.kind {
        InterfaceKind::Average | InterfaceKind::Rigid => interface.position,
        InterfaceKind::Nodes => {
            let first = own.next()?;
            own.all(|row| row.node == first.node)
                .then_some(first.position)?
        }
        InterfaceKind::Boundary => return None,
    };
    Some(Vector3::from(position))
}
