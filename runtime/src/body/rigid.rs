//! A rigid body: mass, inertia and named points.

use dcb_formats::component::{InterfaceKind, Role, Units};
use dcb_formats::mesh::Dimension;
use dcb_formats::superelement::{BoundaryRow, Inertia, InterfaceFrame, Superelement};
use faer::Mat;
use nalgebra::{Matrix3, Vector3};

use super::attachment::frame_position;
use super::{Compatibility, FlexibleBody, MadeFor};
use crate::error::Error;
use crate::frame::FrameInertia;

/// Largest part of its size by which the inertia of a rigid body may be negative about an axis and count as zero.
const INERTIA_ROUNDING: f64 = 1e-12;

/// A rigid body as a scene describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidBody {
    /// Name.
    pub name: String,
    /// Unit system.
    pub units: Units,
    /// Planar or spatial.
    pub dimension: Dimension,
    /// Mass.
    pub mass: f64,
    /// Inertia tensor about the centre of mass, component axes (planar: only (z, z) is used).
    pub tensor: Matrix3<f64>,
    /// Centre of mass, component coordinates.
    pub center: Vector3<f64>,
    /// Points for joints.
    pub points: Vec<RigidPoint>,
}

/// A named point of a rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidPoint {
    /// Unique name.
    pub name: String,
    /// Position, component coordinates.
    pub position: Vector3<f64>,
    /// Rotation matrix, point's axes to component axes: its columns are the point's axes.
    pub axes: Matrix3<f64>,
}

impl RigidBody {
    /// A superelement that doesn't deform: its mass and its interfaces. Interfaces of several nodes or explicit rows have no frame and are left out.
    pub fn locked(of: &Superelement) -> Self {
        let origin = Vector3::from(of.origin);
        let points = of.interfaces.iter().enumerate();
        let points = points.filter_map(|(index, interface)| {
            Some(RigidPoint {
                name: interface.name.clone(),
                position: origin + frame_position(index, interface, &of.rows)?,
                axes: Matrix3::from_fn(|i, j| interface.orientation[i][j]),
            })
        });
        Self {
            name: of.name.clone(),
            units: of.units.clone(),
            dimension: of.dimension,
            mass: of.inertia.mass,
            tensor: Matrix3::from_fn(|i, j| of.inertia.tensor[i][j]),
            center: origin,
            points: points.collect(),
        }
    }
}

impl FlexibleBody {
    /// A body without coordinates; its points are interfaces of kind `rigid`.
    ///
    /// # Errors
    /// [`Error::NotPositive`] if the mass isn't positive or the inertia about some axis is negative.
    pub fn rigid(body: &RigidBody) -> Result<Self, Error> {
        let refused = |quantity, required, found| {
            Err(Error::NotPositive {
                body: body.name.clone(),
                quantity,
                required,
                found,
            })
        };
        if !(body.mass.is_finite() && body.mass > 0.0) {
            return refused("the mass", "positive", body.mass);
        }
        let least = match body.dimension {
            Dimension::Planar => body.tensor[(2, 2)],
            Dimension::Spatial => body.tensor.symmetric_eigenvalues().min(),
        };
        let size = body.tensor.diagonal().amax();
        if !(body.tensor.iter().all(|entry| entry.is_finite()) && least >= -INERTIA_ROUNDING * size)
        {
            return refused("the inertia", "not negative about any axis", least);
        }
        let tensor = 0.5 * (body.tensor + body.tensor.transpose());
        let (axes, pairs) = match body.dimension {
            Dimension::Planar => (1, 0),
            Dimension::Spatial => (3, 6),
        };
        let inertia = Inertia {
            mass: body.mass,
            tensor: std::array::from_fn(|i| std::array::from_fn(|j| tensor[(i, j)])),
            l1: Mat::zeros(body.dimension.coordinate_count(), 0),
            i1: Vec::new(),
            i3: Mat::zeros(axes, 0),
            l3: vec![Mat::zeros(0, 0); axes],
            i2: vec![Mat::zeros(0, 0); pairs],
        };
        let interfaces: Vec<InterfaceFrame> = body.points.iter().map(|p| p.frame(body)).collect();
        let directions = body.dimension.frame_directions();
        let rows: Vec<BoundaryRow> = (0..interfaces.len())
            .flat_map(|interface| {
                directions
                    .iter()
                    .map(move |direction| (interface, direction))
            })
            .map(|(interface, direction)| BoundaryRow {
                interface,
                direction: *direction as i64,
                node: -1,
                position: interfaces[interface].position,
            })
            .collect();
        let none = Mat::zeros(0, 0);
        Ok(Self {
            name: body.name.clone(),
            units: body.units.clone(),
            origin: body.center.into(),
            compatibility: Compatibility::Strong,
            mode_count: 0,
            stiffness: Vec::new(),
            damping: Vec::new(),
            first_omitted_eigenvalue: f64::INFINITY,
            made_for: MadeFor::default(),
            interface_shapes: Mat::zeros(rows.len(), 0),
            attachment_transform: none.clone(),
            further_transform: none.clone(),
            interface_stiffening: Vec::new(),
            loads: Vec::new(),
            stresses: Vec::new(),
            residual_flexibility: None,
            residual_mass: None,
            growing: None,
            inertia: FrameInertia::over(&inertia, body.dimension, none.as_ref()),
            to_original: none,
            attachments: Vec::new(),
            interfaces,
            rows,
        }
        .with_attachments())
    }
}

impl RigidPoint {
    fn frame(&self, body: &RigidBody) -> InterfaceFrame {
        InterfaceFrame {
            name: self.name.clone(),
            kind: InterfaceKind::Rigid,
            role: Role::Attachment,
            position: (self.position - body.center).into(),
            orientation: std::array::from_fn(|i| std::array::from_fn(|j| self.axes[(i, j)])),
        }
    }
}
