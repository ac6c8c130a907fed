//! Bodies as a scene describes them, to bodies as the dynamics has them.

use nalgebra::{Matrix3, Vector3};

use crate::body::{FlexibleBody, RigidBody, RigidPoint};
use crate::system::builder::Drawn;
use dcb_formats::scene::{self, Body, DampingOverride, ModalRatios, Point, RotaryInertia, Scene};

/// Position and motion as drawn.
pub(super) fn drawn(body: &Body) -> Drawn {
    let placement = body.placement();
    Drawn {
        position: placement.position,
        orientation: placement.orientation,
        velocity: placement.velocity,
        angular_velocity: placement.angular_velocity,
    }
}

/// A rigid body.
pub(super) fn rigid(scene: &Scene, name: &str, rigid: &scene::RigidBody) -> RigidBody {
    let point = |(name, point): (&String, &Point)| RigidPoint {
        name: name.clone(),
        // Those of a point mass are where it is, to the last digit: no force there turns it.
        position: match rigid.is_point_mass() {
            true => rigid.center(),
            false => point.position(),
        },
        axes: point.rotation().to_rotation_matrix().into_inner(),
    };
    RigidBody {
        name: name.to_owned(),
        units: scene.units.clone(),
        dimension: scene.dimension,
        mass: rigid.mass,
        tensor: match rigid.inertia {
            RotaryInertia::Planar(moment) => {
                Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, moment))
            }
            RotaryInertia::Principal(moments) => Matrix3::from_diagonal(&Vector3::from(moments)),
            RotaryInertia::Tensor(rows) => Matrix3::from_fn(|i, j| 0.5 * (rows[i][j] + rows[j][i])),
        },
        center: rigid.center(),
        points: rigid.points.iter().map(point).collect(),
    }
}

/// Replaces the damping ratios; the last of a list holds for all further coordinates, attachments included. `modes` are the places of the body's
/// modes among the `mode_count` of its file: entries of modes that are left out are nobody's.
pub(super) fn damp(
    body: &mut FlexibleBody,
    damping: &DampingOverride,
    modes: &[usize],
    mode_count: usize,
) {
    for (index, own) in body.damping.iter_mut().enumerate() {
        *own = match damping {
            DampingOverride::Rayleigh(rayleigh) => {
                // Checked with the scene. Coordinates have unit mass: 2 ζ ω = alpha + beta ω².
                let [alpha, beta] = rayleigh.factors().unwrap_or_default();
                match body.stiffness[index].sqrt() {
                    omega if omega > 0.0 => 0.5 * (alpha / omega + beta * omega),
                    _ => 0.0,
                }
            }
            DampingOverride::Modal(ModalRatios::Uniform(ratio)) => *ratio,
            DampingOverride::Modal(ModalRatios::PerMode(list)) => {
                let last = list.last().copied().unwrap_or(0.0);
                let entry = match modes.get(index) {
                    Some(mode) => *mode,
                    None => mode_count + index - modes.len(),
                };
                list.get(entry).copied().unwrap_or(last)
            }
        };
    }
}

/// The body without damping of its own.
pub(super) fn undamped(body: &FlexibleBody) -> FlexibleBody {
    let mut undamped = body.clone();
    undamped.damping.fill(0.0);
    undamped
}
