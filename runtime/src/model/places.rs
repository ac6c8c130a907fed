//! References of a scene, `body/interface` or `ground/point`, to markers.

use dcb_formats::component::Role;
use dcb_formats::description::nearest_name;
use dcb_formats::mesh::Dimension;
use nalgebra::{Matrix3, Unit, Vector3};

use super::Names;
use crate::error::Error;
use crate::system::builder::{SystemBuilder, Turning};
use dcb_formats::scene::{Attachment, OrientationSource, Scene};

/// Components of a direction below this don't count.
const NEGLIGIBLE: f64 = 1e-9;

/// A place of the scene: the ground, or an interface of a body.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Place {
    Ground {
        position: Vector3<f64>,
        axes: Matrix3<f64>,
    },
    Body {
        body: usize,
        interface: usize,
    },
}

/// Rotations of an interface that a coupling needs.
pub(super) enum RotationNeeded<'a> {
    /// None: the interface's own rotation is used where it has one, else the body's.
    None,
    /// About these directions of the place's axes.
    About(&'a [Unit<Vector3<f64>>]),
    /// All of the scene's.
    All,
}

/// Whose rotation a coupling takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Turned {
    /// The interface's; the scene can't say otherwise.
    Interface,
    /// Value of a joint's `orientation`.
    AsJointSays(Option<OrientationSource>),
}

/// Finds a place. `at` is the path of keys of the reference.
pub(super) fn find(
    scene: &Scene,
    builder: &SystemBuilder,
    names: &Names,
    at: &str,
    reference: &str,
) -> Result<Place, Error> {
    let ground = |position, axes| Ok(Place::Ground { position, axes });
    match Attachment::parse(reference) {
        Some(Attachment::Ground) => ground(Vector3::zeros(), Matrix3::identity()),
        Some(Attachment::GroundPoint(name)) => match scene.ground.points.get(name) {
            Some(point) => ground(
                point.position(),
                point.rotation().to_rotation_matrix().into_inner(),
            ),
            None => Err(Error::described(
                at,
                format!("{reference:?} is not a point of the ground"),
            )),
        },
        Some(Attachment::Body { body, point }) => {
            let Some(&index) = names.bodies.get(body) else {
                return Err(Error::described(at, format!("there is no body {body:?}")));
            };
            let flexible = &builder.system().bodies[index].flexible;
            let known = || flexible.interfaces.iter().map(|one| one.name.as_str());
            match known().position(|name| name == point) {
                Some(interface) => Ok(Place::Body {
                    body: index,
                    interface,
                }),
                None => Err(Error::described(at, unknown(body, point, known()))),
            }
        }
        None => Err(Error::described(
            at,
            format!(
                "is {reference:?}, expected \"ground\", \"ground/POINT\" or \"BODY/INTERFACE\""
            ),
        )),
    }
}

fn unknown<'a>(body: &str, point: &str, known: impl Iterator<Item = &'a str> + Clone) -> String {
    let hint = match nearest_name(point, known.clone()) {
        Some(nearest) => format!("; did you mean {nearest:?}?"),
        None if known.clone().next().is_none() => "; it has none".to_owned(),
        None => format!("; it has {}", known.collect::<Vec<_>>().join(", ")),
    };
    format!("body {body:?} has no interface {point:?}{hint}")
}

/// The marker of a place that a coupling holds on to.
pub(super) fn marker(
    builder: &mut SystemBuilder,
    at: &str,
    place: &Place,
    rotation: &RotationNeeded,
    turned: Turned,
) -> Result<usize, Error> {
    let (body, interface) = match place {
        Place::Ground { position, axes } => return Ok(builder.ground(*position, *axes)),
        Place::Body { body, interface } => (*body, *interface),
    };
    let owner = &builder.system().bodies[body];
    let (flexible, dimension) = (&owner.flexible, builder.system().dimension);
    let described = &flexible.interfaces[interface];
    let full = format!("{}/{}", owner.name, described.name);
    if described.role == Role::Output {
        return Err(Error::described(
            at,
            format!(
                "interface {full:?} is an output only; reduce the component without \"role\": \"output\" there"
            ),
        ));
    }
    let attachment = flexible
        .attachment(interface)
        .map_err(|error| Error::described(at, error.to_string()))?;
    let rigid = flexible.coordinate_count() == 0;
    let directions = match dimension {
        Dimension::Planar => 2,
        Dimension::Spatial => 3,
    };
    if !rigid && attachment.translations[..directions].contains(&false) {
        return Err(Error::described(
            at,
            format!(
                "interface {full:?} has not all translations; reduce the component with an `average` or `rigid` interface there"
            ),
        ));
    }
    if rigid || turned == Turned::AsJointSays(Some(OrientationSource::Body)) {
        return builder.marker(body, interface, Turning::Body);
    }
    let needed: Vec<Vector3<f64>> = match (rotation, dimension) {
        (RotationNeeded::None, _) => Vec::new(),
        (RotationNeeded::About(directions), _) => directions
            .iter()
            .map(|direction| attachment.axes * direction.as_ref())
            .collect(),
        (RotationNeeded::All, Dimension::Planar) => vec![Vector3::z()],
        (RotationNeeded::All, Dimension::Spatial) => vec![Vector3::x(), Vector3::y(), Vector3::z()],
    };
    let missing = needed
        .iter()
        .any(|needed| (0..3).any(|i| needed[i].abs() > NEGLIGIBLE && !attachment.rotations[i]));
    if missing {
        let remedy = match turned {
            Turned::Interface => "",
            Turned::AsJointSays(_) => {
                ", or say \"orientation\": \"body\" to use the body frame's rotation"
            }
        };
        return Err(Error::described(
            at,
            format!(
                "interface {full:?} has no rotation rows in a direction that is held or loaded; make it `average` or `rigid` in the \
                 component{remedy}"
            ),
        ));
    }
    builder.marker(body, interface, Turning::Interface)
}
