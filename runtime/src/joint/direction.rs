//! Directions of joints: checked, and completed to a basis.

use dcb_formats::mesh::Dimension;
use nalgebra::{Unit, Vector3};

use crate::error::Error;

/// Largest component out of the plane, for a direction of a planar scene, by the direction's length: rounding.
const OUT_OF_PLANE: f64 = 1e-12;

/// A direction as given, normalised.
///
/// # Errors
/// [`Error::NoDirection`] if it is zero or not finite.
pub(super) fn direction(
    joint: &'static str,
    quantity: &'static str,
    given: &Vector3<f64>,
) -> Result<Unit<Vector3<f64>>, Error> {
    // Scaled first, so that squares neither overflow nor vanish.
    let size = given.amax();
    if given.iter().all(|entry| entry.is_finite()) && size > 0.0 {
        Ok(Unit::new_normalize(given / size))
    } else {
        Err(Error::NoDirection {
            joint,
            quantity,
            found: (*given).into(),
        })
    }
}

/// A direction along which points move: in a planar scene, in the plane.
///
/// # Errors
/// [`Error::NoDirection`], [`Error::DirectionNotInPlane`].
pub(super) fn direction_in_scene(
    joint: &'static str,
    quantity: &'static str,
    given: &Vector3<f64>,
    dimension: Dimension,
) -> Result<Unit<Vector3<f64>>, Error> {
    let unit = direction(joint, quantity, given)?;
    if dimension == Dimension::Planar && unit.z.abs() > OUT_OF_PLANE {
        return Err(Error::DirectionNotInPlane {
            joint,
            quantity,
            found: (*given).into(),
            expected: "in the plane: the last component zero",
        });
    }
    Ok(unit)
}

/// An axis to turn about: in a planar scene, z.
///
/// # Errors
/// [`Error::NoDirection`], [`Error::DirectionNotInPlane`].
pub(super) fn axis_in_scene(
    joint: &'static str,
    quantity: &'static str,
    given: &Vector3<f64>,
    dimension: Dimension,
) -> Result<Unit<Vector3<f64>>, Error> {
    let unit = direction(joint, quantity, given)?;
    let along_z = unit.z > 0.0 && unit.xy().amax() <= OUT_OF_PLANE;
    if dimension == Dimension::Planar && !along_z {
        return Err(Error::DirectionNotInPlane {
            joint,
            quantity,
            found: (*given).into(),
            expected: "[0, 0, 1]",
        });
    }
    Ok(unit)
}

/// Two directions that complete one to a right-handed basis; coordinate axes where it is one.
pub(super) fn perpendiculars(axis: &Unit<Vector3<f64>>) -> [Unit<Vector3<f64>>; 2] {
    let (least, _) = axis.abs().argmin();
    let mut first = Vector3::zeros();
    first[least] = 1.0;
    let first = Unit::new_normalize(first - axis.as_ref() * axis[least]);
    let second = Unit::new_normalize(axis.cross(first.as_ref()));
    [first, second]
}

/// The directions of the scene perpendicular to one in it: two in space, one in a plane.
pub(super) fn across(
    direction: &Unit<Vector3<f64>>,
    dimension: Dimension,
) -> Vec<Unit<Vector3<f64>>> {
    match dimension {
        Dimension::Spatial => perpendiculars(direction).into(),
        Dimension::Planar => vec![Unit::new_normalize(Vector3::z().cross(direction.as_ref()))],
    }
}

/// Axes along which points of the scene move.
pub(super) fn translation_axes(dimension: Dimension) -> Vec<Unit<Vector3<f64>>> {
    match dimension {
        Dimension::Spatial => vec![Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()],
        Dimension::Planar => vec![Vector3::x_axis(), Vector3::y_axis()],
    }
}

/// Axes about which frames of the scene turn.
pub(super) fn rotation_axes(dimension: Dimension) -> Vec<Unit<Vector3<f64>>> {
    match dimension {
        Dimension::Spatial => translation_axes(dimension),
        Dimension::Planar => vec![Vector3::z_axis()],
    }
}
