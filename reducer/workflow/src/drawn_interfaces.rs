//! Interfaces of a body in a page, and what a body looks like of which nothing else is known.

use dcb_formats::superelement::InterfaceFrame;
use dcb_view::{Form, Place, Solid};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

/// Radius of rods over the reach of the places.
const ROD: f64 = 0.035;

/// An interface, body axes.
pub fn place(interface: &InterfaceFrame) -> Place {
    let rows = interface.orientation;
    let axes = Matrix3::from_fn(|i, j| rows[i][j]);
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    Place {
        name: interface.name.clone(),
        position: interface.position,
        axes: [turn.w, turn.i, turn.j, turn.k],
    }
}

/// Rods from the origin to all places, or a ball where they are all there.
pub fn rods(places: &[Place]) -> Solid {
    let mut ends = vec![[0.0; 3]];
    ends.extend(places.iter().map(|place| place.position));
    let lengths = ends.iter().map(|end| Vector3::from(*end).norm());
    let reach = lengths.fold(0.0, f64::max);
    let form = match reach > 0.0 {
        true => Form::Stick {
            ends,
            radius: ROD * reach,
        },
        // Its size is for the page to choose.
        false => Form::Sphere { radius: 0.0 },
    };
    form.unmoved()
}
