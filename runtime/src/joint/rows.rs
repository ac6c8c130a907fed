//! Rows of a joint: measures held, measures left free, and the rotations involved.

use dcb_formats::mesh::Dimension;
use nalgebra::{Unit, Vector3};

use super::direction::{rotation_axes, translation_axes};
use super::rest::RestPlacement;
use crate::measure::{Alignment, Displacement, Measure, WorldDisplacement};

/// The rows of a joint.
///
/// The rotations listed in `turned_a` and `turned_b` are those the joint loads: an interface in their place needs
/// rotational rows in these directions.
#[derive(Clone, Debug, PartialEq)]
pub struct JointRows {
    /// Measures that the joint holds at zero. Their gradients are independent wherever they are all zero.
    pub held: Vec<Measure>,
    /// The angle that the joint leaves free.
    pub rotation: Option<FreeRotation>,
    /// The translation, or distance, that the joint leaves free.
    pub translation: Option<Measure>,
    /// Directions, in a's axes, about which the joint loads a.
    pub turned_a: Vec<Unit<Vector3<f64>>>,
    /// Directions, in b's axes, about which the joint loads b.
    pub turned_b: Vec<Unit<Vector3<f64>>>,
    /// Whether directions of the joint turn with a, also where `turned_a` doesn't name a rotation: without rotational
    /// rows at a, the axes of a's body serve.
    pub uses_axes_of_a: bool,
}

/// The angle that a joint leaves free. A drive, spring or torque on it loads both frames about the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeRotation {
    /// Angle from a to b about the axis, rad.
    pub angle: Measure,
    /// In a's axes.
    pub axis_a: Unit<Vector3<f64>>,
    /// In b's axes.
    pub axis_b: Unit<Vector3<f64>>,
}

impl JointRows {
    /// Rows that load no rotation and leave no named coordinate free.
    pub(super) fn holding(held: Vec<Measure>) -> Self {
        Self {
            held,
            rotation: None,
            translation: None,
            turned_a: Vec::new(),
            turned_b: Vec::new(),
            uses_axes_of_a: false,
        }
    }

    /// Rows that hold every rotation of the scene, and possibly more.
    pub(super) fn holding_orientation(held: Vec<Measure>, dimension: Dimension) -> Self {
        Self {
            turned_a: rotation_axes(dimension),
            turned_b: rotation_axes(dimension),
            uses_axes_of_a: true,
            ..Self::holding(held)
        }
    }
}

/// b's origin stays at a's in the given directions of a.
pub(super) fn displacements(directions: Vec<Unit<Vector3<f64>>>) -> impl Iterator<Item = Measure> {
    directions
        .into_iter()
        .map(|direction| Measure::Displacement(Displacement { direction }))
}

/// b's origin stays at a's; no rotation involved.
pub(super) fn coincidence(dimension: Dimension) -> Vec<Measure> {
    translation_axes(dimension)
        .into_iter()
        .map(|direction| Measure::WorldDisplacement(WorldDisplacement { direction }))
        .collect()
}

/// b's orientation against a stays as drawn: each axis of a stays perpendicular to what was drawn along the next one.
/// A relative half turn about one of the axes satisfies the same rows; it is out of reach of a continuous motion.
pub(super) fn orientation(
    dimension: Dimension,
    rest: &RestPlacement,
) -> impl Iterator<Item = Measure> {
    let [x, y, z] = [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()];
    let pairs = match dimension {
        Dimension::Spatial => vec![(x, y), (y, z), (z, x)],
        Dimension::Planar => vec![(x, y)],
    };
    pairs.into_iter().map(|(direction_a, next)| {
        Measure::Alignment(Alignment {
            direction_a,
            direction_b: rest.seen_from_b(&next),
        })
    })
}
