//! Forces and moments that joints, drives, springs and loads can exert at their places, in the axes of the place.
//!
//! | coupling | force on a | moment on a | force on b | moment on b |
//! |---|---|---|---|---|
//! | fixed | all | all | all | all |
//! | revolute | all | across the axis | all | across the axis |
//! | prismatic | across the axis | all | across the axis | all |
//! | cylindrical | across the axis | across the axis | the same | the same |
//! | universal | all | across its own axis | all | across its own axis |
//! | spherical, distance, spring | all | none | all | none |
//! | planar | along the normal | across the normal | the same | the same |
//! | point on line | across the line | across the line | all | none |
//! | bushing | along its directions | across them, and all if it resists turns | all | all if it resists turns |
//!
//! Drives, gears, racks and torsion springs add the axis of the joint. What is perpendicular to an axis of a that turns with
//! a is fixed in a; seen from b it is fixed where the joint keeps the axis parallel to one of b. A force at b that is off a's
//! origin is a moment on a, too: a point on a line, a bushing. The axes of a place turn with the interface; to the order of
//! the linear theory they are those of the component.

use dcb_formats::mesh::Dimension;
use nalgebra::{Matrix3, Vector3};

use super::course::is_zero;
use super::part::{DrawnPlace, Parts};
use super::wrench_space::Span;
use dcb_formats::function::Function;
use dcb_formats::scene::{
    ActuatedCoordinate, Bushing, Characteristic, Drive, ExertedDirections, Joint, LoadFunction,
    OrientationSource, Scene, SecondAxis, Side, Spring,
};

/// Forces and moments at a place, in its axes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Transmission {
    pub(super) forces: Vec<Span>,
    pub(super) moments: Vec<Span>,
}

impl Transmission {
    fn of(force: Span, moment: Span) -> Self {
        Self {
            forces: vec![force],
            moments: vec![moment],
        }
    }

    /// Forces and moments of a joint at one of its places, drives left aside.
    pub(super) fn of_joint(scene: &Scene, parts: &Parts, joint: &Joint, side: Side) -> Self {
        let axis = axis(scene, parts, joint, side);
        let [force, moment] = joint.exerts(side).map(|which| Span::of(which, axis));
        match takes_the_body(joint) {
            true => Self::of(force, Span::Nothing),
            false => Self::of(force, moment),
        }
    }

    /// Moment that acts on the angle of a joint, at one of its places.
    pub(super) fn about_the_axis(scene: &Scene, parts: &Parts, joint: &Joint, side: Side) -> Self {
        match takes_the_body(joint) {
            true => Self::of(Span::Nothing, Span::Nothing),
            false => {
                let axis = axis(scene, parts, joint, side);
                Self::of(Span::Nothing, Span::of(ExertedDirections::Along, axis))
            }
        }
    }

    /// Force that acts on the translation or distance of a joint, at one of its places.
    pub(super) fn along_the_axis(scene: &Scene, parts: &Parts, joint: &Joint, side: Side) -> Self {
        let axis = axis(scene, parts, joint, side);
        Self::of(Span::of(ExertedDirections::Along, axis), Span::Nothing)
    }

    /// A spring between two places.
    pub(super) fn of_spring(spring: &Spring, side: Side) -> Self {
        match spring {
            Spring::Spring(spring) if acts(&spring.stiffness) || acts(&spring.damping) => {
                Self::of(Span::Everything, Span::Nothing)
            }
            Spring::Bushing(bushing) => Self::of_bushing(bushing, side),
            Spring::Spring(_) | Spring::TorsionSpring(_) => Self::of(Span::Nothing, Span::Nothing),
        }
    }

    fn of_bushing(bushing: &Bushing, side: Side) -> Self {
        let pushes: Vec<Vector3<f64>> = (0..3)
            .filter(|axis| {
                let lists = [&bushing.translation, &bushing.translation_damping];
                lists.into_iter().any(|list| acts_along(list, *axis))
            })
            .map(|axis| Vector3::ith(axis, 1.0))
            .collect();
        let lists = [&bushing.rotation, &bushing.rotation_damping];
        // Where the frames are turned against each other, a component of the rotation vector is no fixed axis in either.
        let turning = match lists.into_iter().flatten().flatten().any(acts) {
            true => Span::Everything,
            false => Span::Nothing,
        };
        let along = pushes.iter().copied().map(Span::Along);
        let across = pushes.iter().copied().map(Span::Across);
        match side {
            Side::A => Self {
                forces: along.collect(),
                moments: across.chain([turning]).collect(),
            },
            Side::B if pushes.is_empty() => Self::of(Span::Nothing, turning),
            Side::B => Self::of(Span::Everything, turning),
        }
    }
}

/// Whether the moments of a joint act on the body frames and not on the interfaces.
fn takes_the_body(joint: &Joint) -> bool {
    joint.orientation() == Some(OrientationSource::Body)
}

/// The axis of a joint that is fixed in one of its places, in its axes; `None` where it has none, or where that of b depends on an
/// interface that isn't known.
pub(super) fn axis(
    scene: &Scene,
    parts: &Parts,
    joint: &Joint,
    side: Side,
) -> Option<Vector3<f64>> {
    let axis = joint.axis()?;
    match (side, axis.b) {
        (Side::A, _) => Some(axis.a),
        (Side::B, SecondAxis::Given(axis)) => Some(axis),
        (Side::B, SecondAxis::AsDrawn) => {
            let [a, b] = joint.attachments()?;
            let a = DrawnPlace::of(scene, parts, a)?;
            let b = DrawnPlace::of(scene, parts, b)?;
            Some(b.axes.tr_mul(&(a.axes * axis.a)))
        }
        (Side::B, SecondAxis::None) => None,
    }
}

/// Whether a characteristic is more than zero.
pub(super) fn acts(characteristic: &Characteristic) -> bool {
    match characteristic {
        Characteristic::Linear(factor) => *factor != 0.0,
        Characteristic::Table(points) => points.iter().any(|[_, force]| *force != 0.0),
    }
}

/// Whether an entry of a bushing's list is more than zero.
pub(super) fn acts_along(list: &Option<Vec<Characteristic>>, index: usize) -> bool {
    let entry = list.as_ref().and_then(|list| list.get(index));
    entry.is_some_and(acts)
}

/// Drives, actuators, torsion springs, gears and racks that act on one joint: paths of keys.
pub(super) struct Driven {
    /// Those that act on its angle.
    pub(super) turned_by: Vec<String>,
    /// Those that act on its translation or distance.
    pub(super) pushed_by: Vec<String>,
}

impl Driven {
    pub(super) fn of(scene: &Scene, name: &str, joint: &Joint) -> Self {
        let (mut turned_by, mut pushed_by) = (Vec::new(), Vec::new());
        for (drive_name, drive) in &scene.drives {
            if drive.motion().joint != name {
                continue;
            }
            let by = format!("drives.{drive_name}");
            match drive {
                Drive::Angle(_) => turned_by.push(by),
                Drive::Speed(_) if joint.has_angle() => turned_by.push(by),
                Drive::Position(_) | Drive::Speed(_) => pushed_by.push(by),
            }
        }
        for (spring_name, spring) in &scene.springs {
            if let Spring::TorsionSpring(spring) = spring
                && spring.joint == name
                && (acts(&spring.stiffness) || acts(&spring.damping))
            {
                turned_by.push(format!("springs.{spring_name}"));
            }
        }
        for (actuator_name, actuator) in &scene.actuators {
            if actuator.joint() != name {
                continue;
            }
            let by = format!("actuators.{actuator_name}");
            match actuator.coordinate(joint) {
                ActuatedCoordinate::Angle => turned_by.push(by),
                ActuatedCoordinate::Position => pushed_by.push(by),
            }
        }
        for (other_name, other) in &scene.joints {
            let by = || format!("joints.{other_name}");
            match other {
                Joint::Gear(gear) if gear.first == name || gear.second == name => {
                    turned_by.push(by());
                }
                Joint::Rack(rack) if rack.rotation == name => turned_by.push(by()),
                Joint::Rack(rack) if rack.translation == name => pushed_by.push(by()),
                _ => {}
            }
        }
        Self {
            turned_by,
            pushed_by,
        }
    }
}

/// Directions of a force or torque in the axes of its components: one where all components are constant.
pub(super) fn load_directions(load: &LoadFunction, first_axis: usize) -> Vec<Vector3<f64>> {
    let mut constant = Vector3::zeros();
    let mut varying = Vec::new();
    for (index, component) in load.components.iter().enumerate() {
        let axis = Vector3::ith(first_axis + index, 1.0);
        match component {
            Function::Constant(value) => constant += axis * *value,
            other if is_zero(other) => {}
            _ => varying.push(axis),
        }
    }
    if constant.norm() > 0.0 {
        varying.push(constant);
    }
    varying
}

/// First of the three axes that a torque has components about.
pub(super) fn first_torque_axis(dimension: Dimension) -> usize {
    match dimension {
        Dimension::Planar => 2,
        Dimension::Spatial => 0,
    }
}

/// World axes to component axes as drawn, if the body keeps them but for its deflection: it is fixed to the ground, slides on
/// it, or does so on rigid bodies that do.
pub(super) fn kept_orientation(scene: &Scene, body: &str) -> Option<Matrix3<f64>> {
    let mut kept: Vec<&str> = Vec::new();
    let holds = |kept: &[&str], place: &str| {
        let on = dcb_formats::scene::Attachment::parse(place);
        on.is_some_and(|on| on.body().is_none_or(|body| kept.contains(&body)))
    };
    let is_rigid = |name: &str| {
        let kind = scene.bodies.get(name).map(|body| &body.kind);
        matches!(kind, Some(dcb_formats::scene::BodyKind::Rigid(_)))
    };
    loop {
        let mut found = None;
        for joint in scene.joints.values() {
            let (Joint::Fixed(_) | Joint::Prismatic(_), Some([a, b])) =
                (joint, joint.attachments())
            else {
                continue;
            };
            for (held, by) in [(a, b), (b, a)] {
                let own = dcb_formats::scene::Attachment::parse(held).and_then(|on| on.body());
                let Some(own) = own.filter(|own| !kept.contains(own)) else {
                    continue;
                };
                if holds(&kept, by) && (is_rigid(own) || own == body) {
                    found = Some(own);
                }
            }
        }
        match found {
            Some(own) if own == body => {
                let turn = scene.bodies.get(body)?.placement().orientation;
                return Some(turn.inverse().to_rotation_matrix().into_inner());
            }
            Some(own) => kept.push(own),
            None => return None,
        }
    }
}
