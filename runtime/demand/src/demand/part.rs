//! Properties of a component without its superelement: where its interfaces are and what of their motion it has.

use dcb_formats::description::suggestion;
use dcb_formats::superelement::Superelement;
use nalgebra::{Matrix3, Vector3};

use crate::Error;
use dcb_formats::scene::{Attachment, BodyKind, Named, Scene};
use dcb_superelement::selection::Normal;

/// An interface of a part.
#[derive(Clone, Debug, PartialEq)]
pub struct PartInterface {
    /// Name.
    pub name: String,
    /// Reference point in component coordinates, length.
    pub position: Vector3<f64>,
    /// Rotation matrix, axes of its frame to component axes: its columns are the frame's axes.
    pub orientation: Matrix3<f64>,
    /// Which of `ux uy uz rx ry rz`, along and about component axes, it has rows for.
    pub directions: [bool; 6],
}

/// Interfaces of superelements by the name of the body. Of a body that isn't in it only the names are known that the scene uses.
pub type Parts = Named<Vec<PartInterface>>;

impl PartInterface {
    /// The interfaces of a superelement, in its order. Interfaces of explicit rows have no directions.
    pub fn all_of(superelement: &Superelement) -> Vec<Self> {
        let origin = Vector3::from(superelement.origin);
        let of = |(index, interface): (usize, &dcb_formats::superelement::InterfaceFrame)| {
            let mut directions = [false; 6];
            let mut own = superelement
                .rows
                .iter()
                .filter(|row| row.interface == index);
            let first = own.clone().next();
            let slots = own
                .by_ref()
                .filter_map(|row| usize::try_from(row.direction).ok());
            for slot in slots.filter(|slot| *slot < 6) {
                directions[slot] = true;
            }
            // Rows at a node say better where they are than the interface, which may be made of several.
            let position = match first {
                Some(row) if row.node >= 0 => row.position,
                _ => interface.position,
            };
            Self {
                name: interface.name.clone(),
                position: Vector3::from(position) + origin,
                orientation: Matrix3::from_fn(|i, j| interface.orientation[i][j]),
                directions,
            }
        };
        superelement.interfaces.iter().enumerate().map(of).collect()
    }

    /// The interface of a spatial part as it is seen along a normal.
    pub fn across(&self, normal: Normal) -> Self {
        let mut directions = [false; 6];
        for (direction, _) in self.directions.iter().enumerate().filter(|(_, has)| **has) {
            if let Some(planar) = normal.planar_direction(direction) {
                directions[planar] = true;
            }
        }
        let axes: [[f64; 3]; 3] =
            std::array::from_fn(|i| std::array::from_fn(|j| self.orientation[(i, j)]));
        let axes = normal.flat_axes(&axes);
        Self {
            name: self.name.clone(),
            position: Vector3::from(normal.flat(self.position.into())),
            orientation: Matrix3::from_fn(|i, j| axes[i][j]),
            directions,
        }
    }
}

/// A place as the scene draws it, world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DrawnPlace {
    pub(super) position: Vector3<f64>,
    /// Axes of the place to world axes.
    pub(super) axes: Matrix3<f64>,
}

impl DrawnPlace {
    /// `None` where the interface of a superelement isn't known.
    pub(super) fn of(scene: &Scene, parts: &Parts, reference: &str) -> Option<Self> {
        let point = |point: &dcb_formats::scene::Point| {
            let axes = point.rotation().to_rotation_matrix().into_inner();
            (point.position(), axes)
        };
        let (body, point) = match Attachment::parse(reference)? {
            Attachment::Ground => {
                return Some(Self {
                    position: Vector3::zeros(),
                    axes: Matrix3::identity(),
                });
            }
            Attachment::GroundPoint(name) => {
                let (position, axes) = point(scene.ground.points.get(name)?);
                return Some(Self { position, axes });
            }
            Attachment::Body { body, point } => (body, point),
        };
        let owner = scene.bodies.get(body)?;
        let (position, axes) = match &owner.kind {
            BodyKind::Rigid(rigid) => self::rigid_point(rigid, point)?,
            BodyKind::Superelement(_) => {
                let known = parts.get(body)?;
                let interface = known.iter().find(|interface| interface.name == point)?;
                (interface.position, interface.orientation)
            }
        };
        let placement = owner.placement();
        Some(Self {
            position: placement.position + placement.orientation * position,
            axes: placement.orientation.to_rotation_matrix().into_inner() * axes,
        })
    }
}

fn rigid_point(
    rigid: &dcb_formats::scene::RigidBody,
    name: &str,
) -> Option<(Vector3<f64>, Matrix3<f64>)> {
    let point = rigid.points.get(name)?;
    let axes = point.rotation().to_rotation_matrix().into_inner();
    Some((point.position(), axes))
}

/// An interface of a part by the name that a scene uses.
pub(super) fn find<'a>(
    interfaces: &'a [PartInterface],
    at: &str,
    body: &str,
    name: &str,
) -> Result<&'a PartInterface, Error> {
    let mut known = interfaces.iter();
    known
        .find(|interface| interface.name == name)
        .ok_or_else(|| {
            let names = interfaces.iter().map(|interface| interface.name.as_str());
            let hint = match suggestion(name, names.clone()) {
                none if none.is_empty() => {
                    format!("; it has {}", names.collect::<Vec<_>>().join(", "))
                }
                nearest => nearest,
            };
            Error::described(at, format!("body {body:?} has no interface {name:?}{hint}"))
        })
}
