//! A body of the assembly: where it is, and its coordinates.
//!
//! ```text
//! x_i = (q, y):   q rigid motions of unit kinetic energy about the centre of mass,   y the superelement's dynamic coordinates
//! M_i = 1,   K_i = diag(0, ω², σ²),   u_Γ = X R q + C y + F g
//! ```
//! with R (6, r) the rigid motions in axes of the assembly, X the rigid motions of the interface rows, C their elastic ones and F the flexibility without mass.

use dcb_formats::component::Role;
use dcb_formats::mesh::{Dimension, Direction};
use dcb_formats::scene::{Body, BodyKind, Compatibility, RigidBody};
use dcb_formats::superelement::{FrameKind, Superelement};
use dcb_superelement::{DynamicCoordinates, ResidualCoordinates};
use faer::Mat;
use nalgebra::{Matrix3, Vector3};

use crate::Error;

/// A body in its place.
pub(crate) struct Part {
    pub name: String,
    pub dimension: Dimension,
    /// Component axes to axes of the assembly: a rotation, or a rotation of a mirror image.
    pub axes: Matrix3<f64>,
    /// Reflection in component axes, the identity for a body that isn't mirrored.
    pub reflection: Matrix3<f64>,
    /// Centre of mass in the assembly.
    pub centre: Vector3<f64>,
    pub mass: f64,
    /// Inertia about the centre of mass, axes of the assembly.
    pub tensor: Matrix3<f64>,
    /// R: translation of the centre and rotation, axes of the assembly, (6, r).
    pub rigid: Mat<f64>,
    pub kind: PartKind,
}

/// What moves beside the frame.
pub(crate) enum PartKind {
    Rigid(RigidBody),
    Flexible(Box<Flexible>),
}

/// A superelement's coordinates.
pub(crate) struct Flexible {
    pub element: Superelement,
    /// K over y, (n).
    pub stiffness: Vec<f64>,
    /// Damping over y, 2 ζ ω, (n).
    pub damping: Vec<f64>,
    /// C, (n_b, n), rows in body axes.
    pub shapes: Mat<f64>,
    /// F, (n_b, n_b); `None` where all flexibility has mass.
    pub massless: Option<Mat<f64>>,
    /// Amplitudes of the file's columns, (n of the file, n).
    pub to_file: Mat<f64>,
    /// Amplitudes of the file's columns by interface forces, beyond y, (n of the file, n_b).
    pub massless_to_file: Option<Mat<f64>>,
    /// Nodes of each interface in the order of its rows; -1 for a frame.
    pub interface_nodes: Vec<Vec<i64>>,
}

impl Part {
    /// A body of the assembly; `element` is its file's content where it has one.
    ///
    /// # Errors
    /// [`Error::Body`] for a part that is held, or numbers that aren't those of a body.
    pub fn of(
        name: &str,
        body: &Body,
        reflection: Matrix3<f64>,
        dimension: Dimension,
        element: Option<Superelement>,
    ) -> Result<Self, Error> {
        let placement = body.placement();
        let rotation = placement.orientation.to_rotation_matrix().into_inner();
        let axes = rotation * reflection;
        let (kind, centre, mass, tensor) = match (&body.kind, element) {
            (BodyKind::Rigid(of), _) => {
                let tensor = of.inertia.matrix();
                let kind = PartKind::Rigid(of.clone());
                (kind, of.center(), of.mass, tensor)
            }
            (BodyKind::Superelement(_), Some(element)) => {
                if element.frame_kind == FrameKind::Given {
                    return Err(Error::body(
                        name,
                        "is a part that was reduced while held (its frame is not on mean axes); reduce it free, and hold it in the assembly by a joint with \"ground\"",
                    ));
                }
                let inertia = &element.inertia;
                let tensor = Matrix3::from_fn(|a, b| inertia.tensor[a][b]);
                let (origin, mass) = (Vector3::from(element.origin), inertia.mass);
                let flexible = Flexible::of(name, element)?;
                (PartKind::Flexible(Box::new(flexible)), origin, mass, tensor)
            }
            (BodyKind::Superelement(_), None) => {
                return Err(Error::body(name, "its superelement wasn't loaded"));
            }
        };
        let tensor = match dimension {
            Dimension::Planar => Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, tensor[(2, 2)])),
            Dimension::Spatial => axes * tensor * axes.transpose(),
        };
        let rigid = unit_motions(dimension, mass, &tensor).ok_or_else(|| {
            Error::body(
                name,
                "its inertia has no principal axes: numbers that aren't finite",
            )
        })?;
        Ok(Self {
            name: name.to_owned(),
            dimension,
            axes,
            reflection,
            centre: placement.position + axes * centre,
            mass,
            tensor,
            rigid,
            kind,
        })
    }

    pub fn flexible(&self) -> Option<&Flexible> {
        match &self.kind {
            PartKind::Flexible(of) => Some(of),
            PartKind::Rigid(_) => None,
        }
    }

    /// Coordinates q.
    pub fn rigid_count(&self) -> usize {
        self.rigid.ncols()
    }

    /// Coordinates y.
    pub fn elastic_count(&self) -> usize {
        self.flexible().map_or(0, |of| of.stiffness.len())
    }

    /// All coordinates x_i.
    pub fn count(&self) -> usize {
        self.rigid_count() + self.elastic_count()
    }

    /// A point of the component's body frame in the assembly.
    pub fn place(&self, body: [f64; 3]) -> Vector3<f64> {
        self.centre + self.axes * Vector3::from(body)
    }

    /// Axes of a frame that a component has, in the assembly: right-handed also in a mirror image.
    pub fn frame(&self, orientation: Matrix3<f64>) -> Matrix3<f64> {
        self.axes * orientation * self.reflection
    }

    /// An axial vector (rotation, moment) of the component in axes of the assembly.
    pub fn axial(&self) -> Matrix3<f64> {
        self.axes * self.axes.determinant().signum()
    }

    /// Motion of an interface row by translation of the centre and rotation in axes of the assembly; `None` for an explicit row, which doesn't say.
    pub fn rigid_row(&self, row: usize) -> Option<[f64; 6]> {
        let element = &self.flexible()?.element;
        let row = element.rows.get(row)?;
        let direction = usize::try_from(row.direction)
            .ok()
            .and_then(Direction::from_index)?;
        let mut motion = [0.0; 6];
        if direction.is_rotation() {
            let axis = self.axial().column(direction.axis()).into_owned();
            motion[3..].copy_from_slice(axis.as_slice());
        } else {
            let axis = self.axes.column(direction.axis()).into_owned();
            motion[..3].copy_from_slice(axis.as_slice());
            // a · (θ × r) = θ · (r × a)
            let arm = (self.axes * Vector3::from(row.position)).cross(&axis);
            motion[3..].copy_from_slice(arm.as_slice());
        }
        Some(motion)
    }
}

impl Flexible {
    fn of(name: &str, element: Superelement) -> Result<Self, Error> {
        let coordinates = DynamicCoordinates::of(&element, Compatibility::Strong)?;
        let to_file = coordinates.to_file();
        let modes = &element.modes;
        let (n_k, n_b) = (element.mode_count(), element.rows.len());
        let ratio = |k: usize| match k < n_k {
            true => modes.damping[k],
            false => modes.residual_damping,
        };
        let damping = (coordinates.stiffness.iter().enumerate())
            .map(|(k, square)| 2.0 * ratio(k) * square.max(0.0).sqrt())
            .collect();
        let massless_to_file = match &coordinates.residual_flexibility {
            None => None,
            Some(_) => Some(massless_amplitudes(name, &element)?),
        };
        // L_b times the file's columns: rows of output interfaces too.
        let massless = massless_to_file.as_ref().map(|amplitudes| {
            let of_attachments = element.residual.output_shapes.as_ref();
            let of_attachments = of_attachments.unwrap_or(&element.residual.flexibility);
            let mut seen = of_attachments * amplitudes.as_ref().subrows(n_k, n_b);
            if let Some(further) = &element.enrichment {
                let rest = amplitudes.nrows() - n_k - n_b;
                seen += &further.interface_shapes * amplitudes.as_ref().subrows(n_k + n_b, rest);
            }
            seen
        });
        let mut interface_nodes = vec![Vec::new(); element.interfaces.len()];
        for row in &element.rows {
            let nodes: &mut Vec<i64> = &mut interface_nodes[row.interface];
            if !nodes.contains(&row.node) {
                nodes.push(row.node);
            }
        }
        Ok(Self {
            interface_nodes,
            stiffness: coordinates.stiffness,
            damping,
            shapes: coordinates.interface_shapes,
            massless,
            to_file,
            massless_to_file,
            element,
        })
    }
}

/// Amplitudes of all columns by forces on rows, beyond the dynamic coordinates: `[1; 0] − [T; T_x] σ⁻² Sᵀ`, S the rows that the coordinates move.
fn massless_amplitudes(name: &str, element: &Superelement) -> Result<Mat<f64>, Error> {
    let coordinates =
        ResidualCoordinates::of(element).map_err(|why| Error::body(name, why.to_string()))?;
    let (n_k, n_b) = (element.mode_count(), element.rows.len());
    let loaded =
        |row: usize| element.interfaces[element.rows[row].interface].role == Role::Attachment;
    let mut carried = coordinates.seen(element);
    for row in (0..n_b).filter(|row| !loaded(*row)) {
        carried.as_mut().row_mut(row).fill(0.0);
    }
    let statics = Mat::from_fn(coordinates.stiffness.len(), n_b, |k, row| {
        match coordinates.stiffness[k] > 0.0 {
            true => carried[(row, k)] / coordinates.stiffness[k],
            false => 0.0,
        }
    });
    let of_attachments = &coordinates.attached * &statics;
    let of_further = &coordinates.further * &statics;
    let count = element.basis_count();
    Ok(Mat::from_fn(count, n_b, |i, j| {
        if !loaded(j) || i < n_k {
            0.0
        } else if i < n_k + n_b {
            f64::from(u8::from(i - n_k == j)) - of_attachments[(i - n_k, j)]
        } else {
            -of_further[(i - n_k - n_b, j)]
        }
    }))
}

/// R: motions of unit kinetic energy. None about an axis without inertia.
fn unit_motions(dimension: Dimension, mass: f64, tensor: &Matrix3<f64>) -> Option<Mat<f64>> {
    let mut motions: Vec<[f64; 6]> = Vec::new();
    for axis in 0..dimension.coordinate_count() {
        let mut motion = [0.0; 6];
        motion[axis] = 1.0 / mass.sqrt();
        motions.push(motion);
    }
    let principal = match dimension {
        Dimension::Planar => vec![(tensor[(2, 2)], Vector3::z())],
        Dimension::Spatial => {
            let eigen = tensor.symmetric_eigen();
            let pairs = eigen
                .eigenvalues
                .iter()
                .zip(eigen.eigenvectors.column_iter());
            pairs
                .map(|(moment, axis)| (*moment, axis.into_owned()))
                .collect()
        }
    };
    for (moment, axis) in principal {
        if moment > 0.0 {
            let axis = axis / moment.sqrt();
            motions.push([0.0, 0.0, 0.0, axis[0], axis[1], axis[2]]);
        }
    }
    let rigid = Mat::from_fn(6, motions.len(), |i, j| motions[j][i]);
    rigid.is_all_finite().then_some(rigid)
}
